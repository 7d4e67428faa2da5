"""Search for the cycles of a scene: from a run, or from a state nearby."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from rodgen.analyse.analysis_guard import check_whole_number
from rodgen.analyse.cycles import transient
from rodgen.analyse.cycles.cycle_result import PICARD, Cycle
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.orbit_collocation import OrbitCollocation
from rodgen.analyse.cycles.periodicity import Lap, O, Orbit, OrbitSolver
from rodgen.analyse.cycles.shooting import LEADING, SEGMENTS, NewtonPicard, Shooting
from rodgen.analyse.cycles.symmetry import SymmetryReduction, load_period
from rodgen.analyse.cycles.transient import Return, extent, last_return, run_from
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.quantity_formulas import MotionSlice, loads_at_work
from rodgen.scene import Scene
from rodgen.system import System

COLLOCATION, SHOOTING = "collocation", "shooting"
WAYS: dict[type[OrbitSolver[Any]], str] = {
    OrbitCollocation: COLLOCATION,
    Shooting: SHOOTING,
    NewtonPicard: PICARD,
}
MOST_COLLOCATED = 100  # states: blocks of collocation are dense
PATH = 64  # states of a period by which its size is seen
PARTS = ("rhs", "jac", "tangents")  # of the module
MOST_SEGMENTS = 1000
SPANS = 5  # runs, each as long as all before, until a motion has settled
FROM_RUN = 0.2, 5.0  # times its size in the run: a motion that Newton's method has not led away
MOST_TURNS = 5  # of a cycle, in what was taken for its period
SUDDEN = 5.0  # times the largest rates of a motion: at its start some of it decays at once
CLOSED = 1e-7  # of its size: a part of the period brings it back
AT_REST = 1e-9  # of a motion [rad]: none


def check_segments(number: object, name: str = "segments") -> int:
    """Check a number of segments, or of multipliers. Raises InputError."""
    return check_whole_number(number, name, 1, MOST_SEGMENTS)


@dataclass(frozen=True)
class CycleSearch:
    """Search for cycles of a system whose loads are constant, or repeat after a period (forced)
    [s]; method, segments, leading: method, segments and multipliers as in `find_cycle`; given: the
    scene that was asked for."""

    system: System
    model: ModuleType
    forced: float
    given: Scene
    method: str | None = None
    segments: int | None = None
    leading: int | None = None

    @classmethod
    def of(cls, system: System, target: str | None = None) -> CycleSearch:
        """Set up the search of a system. Raises InputError, AnalysisError."""
        model = system.model(target, PARTS)
        forced = load_period(system, model)
        given = system
        if not forced and system.t is None:
            system = system.steady(system.settings.span[1])
            model = system.model(target, PARTS)
        return cls(system, model, forced, given.scene)

    @property
    def p(self) -> Array:
        """Parameters of the module."""
        return self.system.p

    @cached_property
    def _plain_system(self) -> System:
        """The system for runs, without its events, its limit of steps and its output times."""
        return self.system.at({"events": [], "integrate.max_steps": None, "integrate.t_eval": None})

    def period_at(self, system: System) -> float:
        """The period of the loads [s] of a system that differs in a number, 0 where they do not
        change. Raises AnalysisError."""
        return load_period(system, self.model) if self.forced else 0.0

    @property
    def target(self) -> str:
        """Target of the module."""
        return str(self.model.PROVENANCE["target"])

    def flow(self, t: float, y: Array) -> Flow:
        """Flow about a state (states,)."""
        return Flow(self.model, self.p, SymmetryReduction.of(self.model, self.p, t, y))

    def find_by_run(self) -> Cycle:
        """Find the cycle on which a run settles. Raises AnalysisError."""
        start, end = self.system.settings.span
        t, y, span = start, self.system.y0, end - start
        if self.forced:
            span = self.forced * np.ceil(span / self.forced)
        why = ""
        for _ in range(SPANS):
            every = span / transient.SAMPLES
            if self.forced:
                every = self.forced / transient.PER_PERIOD
            times, states = run_from(self._plain_system, y, t, span, every, self.target)
            t, y = float(times[-1]), states[-1]
            flow = self.flow(t, y)
            back = last_return(times, states[:, flow.quotient.kept], flow.quotient, self.forced)
            if extent(states[len(states) // 2 :, flow.quotient.kept], flow.quotient) < AT_REST:
                raise AnalysisError(f"no cycle: the motion has come to rest before t = {t:g} s")
            if back is None:
                why = "it does not come back to where it was"
            else:
                try:
                    return replace(self._find_near_return(flow, back), after=t - start)
                except AnalysisError as error:
                    why = str(error)
            span = max(span, t - start)
        raise AnalysisError(
            f"no cycle: the motion has not settled on one in {t - start:g} s, "
            f"{2 ** (SPANS - 1)} spans of the scene ({why})"
        )

    def _choose_solver(self, flow: Flow) -> OrbitSolver[Any]:
        """Choose the method for the periodic motions of a flow."""
        forced, method = bool(self.forced), self.method
        if method is None and self.segments is None:
            large = flow.quotient.size > MOST_COLLOCATED
            method = PICARD if large or self.leading is not None else COLLOCATION
        if method == COLLOCATION:
            return OrbitCollocation(flow, forced)
        if method == PICARD:
            return NewtonPicard(flow, forced, self.leading or LEADING)
        return Shooting(flow, forced, self.segments or SEGMENTS)

    def _run_lap(self, flow: Flow, y: Array, like: Orbit) -> Lap:
        """Run the system from a state (states,), at the time and for the period of an orbit near
        it; if that begins with a sudden decay, run it once more from the end."""
        times = np.linspace(0.0, like.period, transient.LAP + 1)
        for _ in range(2):
            _, states = run_from(self._plain_system, y, like.t, like.period, times[1], self.target)
            x = states[:, flow.quotient.kept]
            rates = np.array([flow.rates(like.t + t, one) for t, one in zip(times, x, strict=True)])
            size = np.abs(rates).max(axis=1)
            if size[0] <= SUDDEN * size[transient.LAP // 2 :].max():
                break
            y = states[-1]
        way = CubicHermiteSpline(times, x, rates)
        return Lap(like.t, like.period, like.angle, like.scale, way)

    def _find_near_return(self, flow: Flow, back: Return) -> Cycle:
        """Find the cycle near a return of a run. Raises AnalysisError if that leads elsewhere."""
        like = Orbit(back.x[None], back.t, back.period, back.angle, back.scale)
        lap = self._run_lap(flow, flow.quotient.lift(back.x), like)
        closing = self._choose_solver(flow)
        orbit = self._reduce_period(closing, closing.find_orbit(lap))
        grown = extent(closing.path(orbit, PATH), flow.quotient) / back.scale
        if not FROM_RUN[0] < grown < FROM_RUN[1]:
            raise AnalysisError(f"Newton's method led to a motion {grown:.3g} times as large")
        return self.make_cycle(closing, orbit)

    def _reduce_period(self, closing: OrbitSolver[O], orbit: O) -> O:
        """Reduce an orbit to its least period, where it goes round more than once."""
        flow = closing.flow
        turns = round(orbit.period / self.forced) if self.forced else MOST_TURNS
        for parts in range(turns, 1, -1):
            if self.forced and turns % parts:
                continue
            part = replace(orbit, period=orbit.period / parts, angle=orbit.angle / parts)
            end = flow.quotient.rotate(closing.path(orbit, parts)[1], -part.angle)
            if np.abs(end - orbit.x[0]).max() <= CLOSED * orbit.scale:
                return closing.find_orbit(self._run_lap(flow, flow.quotient.lift(orbit.x[0]), part))
        return orbit

    def find_near(self, y: Array, period: float) -> Cycle:
        """Find the cycle near a state and a period. Raises AnalysisError."""
        t = self.system.settings.span[0]
        flow = self.flow(t, y)
        if self.forced:
            turns = period / self.forced
            if abs(turns - round(turns)) > 0.01 or round(turns) < 1:
                allowed = f"a whole number of periods of the loads, {self.forced:.12g} s"
                raise InputError("period", period, allowed)
            period = round(turns) * self.forced
        lap = self._run_lap(flow, y, Orbit(y[None, flow.quotient.kept], t, period, 0.0, 1.0))
        swing = lap.states(np.linspace(0.0, 1.0, PATH + 1))
        scale = extent(swing, flow.quotient)
        if scale < AT_REST:
            raise AnalysisError("no cycle: a rod in the state that was given does not move")
        lap = replace(lap, angle=self._angle(flow.quotient, swing[0], swing[-1]), scale=scale)
        closing = self._choose_solver(flow)
        orbit = closing.find_orbit(lap)
        if extent(closing.path(orbit, PATH), flow.quotient) < 1e-3 * scale:
            raise AnalysisError("no cycle: Newton's method led to a motion that is at rest")
        return self.make_cycle(closing, orbit)

    def _angle(self, quotient: SymmetryReduction, first: Array, last: Array) -> float:
        mean = float((last - first)[quotient.angles].mean()) if len(quotient.angles) else 0.0
        return mean if quotient.turns else 2 * np.pi * round(mean / (2 * np.pi))

    def make_cycle(
        self, closing: OrbitSolver[Any], orbit: Orbit, trivial: int | None = None
    ) -> Cycle:
        """Make the result for an orbit; trivial: number of multipliers that are 1, if more than
        symmetries make so."""
        mu, quotient = orbit.multipliers, closing.flow.quotient
        trivial = closing.trivial if trivial is None else trivial
        near = np.sort(np.abs(mu - 1))[:trivial]
        y0 = quotient.lift(orbit.x[0])
        energy = MotionSlice(self.model, self.p, y0, np.array(orbit.t)).values("total_energy")
        states = closing.path(orbit, PATH)[:, quotient.angles]
        if quotient.turns or orbit.angle:
            states = states - states.mean(axis=1, keepdims=True)
        swing = (states.max(axis=0) - states.min(axis=0)).max(initial=0.0) / 2
        return Cycle(
            system=self.system.at(y0=y0),
            t=orbit.t,
            period=orbit.period,
            y0=y0,
            multipliers=mu,
            trivial=trivial,
            trivial_error=float(near.max(initial=0.0)),
            angle=orbit.angle,
            energy=float(energy),
            amplitude=float(swing),
            forced=bool(self.forced),
            residual=orbit.residual,
            iterations=orbit.iterations,
            method=WAYS[type(closing)],
            error=orbit.error,
            model=self.model,
            orbit=orbit,
        )

    @cached_property
    def is_conservative(self) -> bool:
        """Whether no load does work, so that the energy stays what it is."""
        return not (self.forced or self.working_loads)

    @cached_property
    def working_loads(self) -> tuple[str, ...]:
        """Names of the loads without potential."""
        return loads_at_work(self.model)
