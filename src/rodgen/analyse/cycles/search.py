"""A scene made ready for the search for its cycles: from a run, or from nearby."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from rodgen.analyse.cycles import settling
from rodgen.analyse.cycles.closing import Closing, Lap, O, Orbit
from rodgen.analyse.cycles.collocation import Collocation
from rodgen.analyse.cycles.cycle import PICARD, Cycle
from rodgen.analyse.cycles.drive import load_period
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.picard import LEADING, Picard
from rodgen.analyse.cycles.quotient import Quotient
from rodgen.analyse.cycles.settling import Return, extent, last_return, run_of
from rodgen.analyse.cycles.shooting import SEGMENTS, Shooting
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.catalogue import Piece, loads_at_work
from rodgen.scene import Scene
from rodgen.scene.plain import plain
from rodgen.system import System

COLLOCATION, SHOOTING = "collocation", "shooting"
WAYS: dict[type[Closing[Any]], str] = {
    Collocation: COLLOCATION,
    Shooting: SHOOTING,
    Picard: PICARD,
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


def segments_of(number: object, name: str = "segments") -> int:
    """How many segments, or multipliers, were asked for. Raises InputError."""
    made = plain(number, name)
    if not (isinstance(made, int) and 1 <= made <= MOST_SEGMENTS):
        raise InputError(name, number, f"a whole number from 1 to {MOST_SEGMENTS}")
    return made


@dataclass(frozen=True)
class Search:
    """Where cycles are looked for: a system whose loads stay what they are, or repeat after a
    period (forced) [s]; by, segments, leading: how, as `find_cycle` has them; given: the scene that
    was asked for."""

    system: System
    model: ModuleType
    forced: float
    given: Scene
    by: str | None = None
    segments: int | None = None
    leading: int | None = None

    @classmethod
    def of(cls, system: System, target: str | None = None) -> Search:
        """Raises InputError, AnalysisError."""
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
    def _runs(self) -> System:
        """The system whose runs are looked at."""
        return settling.without_events(self.system)

    def period_at(self, system: System) -> float:
        """The period of the loads [s] of a system that differs in a number, 0 where they do not
        change. Raises AnalysisError."""
        return load_period(system, self.model) if self.forced else 0.0

    @property
    def target(self) -> str:
        """Of the module."""
        return str(self.model.PROVENANCE["target"])

    def flow(self, t: float, y: Array) -> Flow:
        """About a state (states,)."""
        return Flow(self.model, self.p, Quotient.of(self.model, self.p, t, y))

    def settled(self) -> Cycle:
        """From a run. Raises AnalysisError."""
        start, end = self.system.settings.span
        t, y, span = start, self.system.y0, end - start
        if self.forced:
            span = self.forced * np.ceil(span / self.forced)
        why = ""
        for _ in range(SPANS):
            every = span / settling.SAMPLES
            if self.forced:
                every = self.forced / settling.PER_PERIOD
            times, states = run_of(self._runs, y, t, span, every, self.target)
            t, y = float(times[-1]), states[-1]
            flow = self.flow(t, y)
            back = last_return(times, states[:, flow.quotient.kept], flow.quotient, self.forced)
            if extent(states[len(states) // 2 :, flow.quotient.kept], flow.quotient) < AT_REST:
                raise AnalysisError(f"no cycle: the motion has come to rest before t = {t:g} s")
            if back is None:
                why = "it does not come back to where it was"
            else:
                try:
                    return replace(self._from(flow, back), after=t - start)
                except AnalysisError as error:
                    why = str(error)
            span = max(span, t - start)
        raise AnalysisError(
            f"no cycle: the motion has not settled on one in {t - start:g} s, "
            f"{2 ** (SPANS - 1)} spans of the scene ({why})"
        )

    def _closing(self, flow: Flow) -> Closing[Any]:
        """The way to close motions of a flow."""
        forced, by = bool(self.forced), self.by
        if by is None and self.segments is None:
            large = flow.quotient.size > MOST_COLLOCATED
            by = PICARD if large or self.leading is not None else COLLOCATION
        if by == COLLOCATION:
            return Collocation(flow, forced)
        if by == PICARD:
            return Picard(flow, forced, self.leading or LEADING)
        return Shooting(flow, forced, self.segments or SEGMENTS)

    def _lap(self, flow: Flow, y: Array, like: Orbit) -> Lap:
        """Of a run from a state (states,), with the time and the period of an orbit near it; where
        that begins with what decays at once, of a run from its end."""
        times = np.linspace(0.0, like.period, settling.LAP + 1)
        for _ in range(2):
            _, states = run_of(self._runs, y, like.t, like.period, times[1], self.target)
            x = states[:, flow.quotient.kept]
            rates = np.array([flow.rates(like.t + t, one) for t, one in zip(times, x, strict=True)])
            size = np.abs(rates).max(axis=1)
            if size[0] <= SUDDEN * size[settling.LAP // 2 :].max():
                break
            y = states[-1]
        way = CubicHermiteSpline(times, x, rates)
        return Lap(like.t, like.period, like.angle, like.scale, way)

    def _from(self, flow: Flow, back: Return) -> Cycle:
        """From where a run came back. Raises AnalysisError where that leads to another motion."""
        like = Orbit(back.x[None], back.t, back.period, back.angle, back.scale)
        lap = self._lap(flow, flow.quotient.lifted(back.x), like)
        closing = self._closing(flow)
        orbit = self._shortest(closing, closing.found(lap))
        grown = extent(closing.path(orbit, PATH), flow.quotient) / back.scale
        if not FROM_RUN[0] < grown < FROM_RUN[1]:
            raise AnalysisError(f"Newton's method led to a motion {grown:.3g} times as large")
        return self.cycle(closing, orbit)

    def _shortest(self, closing: Closing[O], orbit: O) -> O:
        """The orbit with its least period, where it goes round more than once."""
        flow = closing.flow
        turns = round(orbit.period / self.forced) if self.forced else MOST_TURNS
        for parts in range(turns, 1, -1):
            if self.forced and turns % parts:
                continue
            part = replace(orbit, period=orbit.period / parts, angle=orbit.angle / parts)
            end = flow.quotient.turned(closing.path(orbit, parts)[1], -part.angle)
            if np.abs(end - orbit.x[0]).max() <= CLOSED * orbit.scale:
                return closing.found(self._lap(flow, flow.quotient.lifted(orbit.x[0]), part))
        return orbit

    def polished(self, y: Array, period: float) -> Cycle:
        """From a state and a period near a cycle. Raises AnalysisError."""
        t = self.system.settings.span[0]
        flow = self.flow(t, y)
        if self.forced:
            turns = period / self.forced
            if abs(turns - round(turns)) > 0.01 or round(turns) < 1:
                allowed = f"a whole number of periods of the loads, {self.forced:.12g} s"
                raise InputError("period", period, allowed)
            period = round(turns) * self.forced
        lap = self._lap(flow, y, Orbit(y[None, flow.quotient.kept], t, period, 0.0, 1.0))
        swing = lap.at(np.linspace(0.0, 1.0, PATH + 1))
        scale = extent(swing, flow.quotient)
        if scale < AT_REST:
            raise AnalysisError("no cycle: a rod in the state that was given does not move")
        lap = replace(lap, angle=self._angle(flow.quotient, swing[0], swing[-1]), scale=scale)
        closing = self._closing(flow)
        orbit = closing.found(lap)
        if extent(closing.path(orbit, PATH), flow.quotient) < 1e-3 * scale:
            raise AnalysisError("no cycle: Newton's method led to a motion that is at rest")
        return self.cycle(closing, orbit)

    def _angle(self, quotient: Quotient, first: Array, last: Array) -> float:
        mean = float((last - first)[quotient.angles].mean()) if len(quotient.angles) else 0.0
        return mean if quotient.turns else 2 * np.pi * round(mean / (2 * np.pi))

    def cycle(self, closing: Closing[Any], orbit: Orbit, trivial: int | None = None) -> Cycle:
        """What there is to say of an orbit; trivial: how many multipliers are 1, if more than
        symmetries make so."""
        mu, quotient = orbit.multipliers, closing.flow.quotient
        trivial = closing.trivial if trivial is None else trivial
        near = np.sort(np.abs(mu - 1))[:trivial]
        y0 = quotient.lifted(orbit.x[0])
        energy = Piece(self.model, self.p, y0, np.array(orbit.t)).values("total_energy")
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
            by=WAYS[type(closing)],
            error=orbit.error,
            model=self.model,
            orbit=orbit,
        )

    @cached_property
    def conservative(self) -> bool:
        """Whether no load does work, so that the energy stays what it is."""
        return not (self.forced or self.at_work)

    @cached_property
    def at_work(self) -> tuple[str, ...]:
        """Names of the loads without potential."""
        return loads_at_work(self.model)
