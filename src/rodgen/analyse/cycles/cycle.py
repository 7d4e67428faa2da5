"""The periodic motion of a scene at its own values, reached by a run, and its stability."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike

from rodgen.analyse.cycles import settling
from rodgen.analyse.cycles.drive import load_period
from rodgen.analyse.cycles.elimination import Complex
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.quotient import Quotient
from rodgen.analyse.cycles.settling import Return, extent, last_return, run_of
from rodgen.analyse.cycles.shooting import Orbit, Shooting, cut, multipliers
from rodgen.analyse.errors import AnalysisError, guarded
from rodgen.analyse.system import frozen
from rodgen.integrate.catalogue import Piece, loads_at_work
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import Array
from rodgen.loading import build, build_fastest
from rodgen.scene import Scene, SceneError
from rodgen.scene.overrides import with_state
from rodgen.scene.plain import is_number, plain
from rodgen.scene.scene import check_scene

SEGMENTS = 4
PARTS = ("rhs", "jac", "tangents")  # of the module
MOST_SEGMENTS = 1000
SPANS = 5  # runs, each as long as all before, until a motion has settled
FROM_RUN = 0.2, 5.0  # times its size in the run: a motion that Newton's method has not led away
STABLE = 1e-7  # by which a multiplier may exceed 1: beyond it, a cycle is unstable
MOST_TURNS = 5  # of a cycle, in what was taken for its period
CLOSED = 1e-7  # of its size: a part of the period brings it back
AT_REST = 1e-9  # of a motion [rad]: none


@dataclass(frozen=True)
class Cycle:
    """A periodic motion.

    scene: with loads as they are then, and starting on it; t: the time of y0 [s], which counts
    under loads that repeat; period [s]; y0: a state on it (states,); multipliers: Floquet
    multipliers, the largest first, of the states that count: where nothing depends on the place of
    joint 0 (and, without drag, on its velocity), these states have none; trivial: how many of them
    are 1 by symmetry (one in time, one where the rod may be turned; one for each conserved
    quantity); trivial_error: the largest difference of these from 1, a measure of the error of all;
    angle: by which the rod as a whole is turned after a period [rad]; energy: of y0 [J];
    amplitude: the largest deviation of an angle from its mean [rad]; forced: whether the period is
    that of the loads, or a whole number of them; residual: of the closing, over the size of the
    motion; iterations: of Newton's method; after: of the run that led to it [s].
    """

    scene: Scene
    t: float
    period: float
    y0: Array = field(repr=False)
    multipliers: Complex = field(repr=False)
    trivial: int
    trivial_error: float
    angle: float
    energy: float
    amplitude: float
    forced: bool
    residual: float
    iterations: int
    after: float = 0.0
    model: ModuleType | None = field(default=None, repr=False, compare=False)
    orbit: Orbit | None = field(default=None, repr=False, compare=False)

    @cached_property
    def nontrivial(self) -> Complex:
        """The multipliers that are not 1 by symmetry, the largest first."""
        return nontrivial(self.multipliers, self.trivial)

    @property
    def unstable(self) -> int:
        """How many of them are larger than 1."""
        return int((np.abs(self.nontrivial) > 1 + STABLE).sum())

    @property
    def stable(self) -> bool:
        """Whether small disturbances do not grow."""
        return self.unstable == 0

    @cached_property
    def motion(self) -> Solution:
        """The run over one period, in 128 steps of time, with the work of every load."""
        span = [self.t, self.t + self.period]
        every = self.period / 128
        table = self.scene.model_dump(exclude_none=True)
        table["integrate"] = {"span": span, "output_every": every, "rtol": 1e-10, "atol": 1e-12}
        return simulate(Scene.from_dict(table | {"events": []}), model=self.model, progress=False)

    @cached_property
    def drift(self) -> Array:
        """By how much joint 0 moves in a period (2,) [m]."""
        joints: Array = self.motion.joints[[0, -1], 0]
        moved: Array = joints[1] - joints[0]
        return moved

    @property
    def work(self) -> dict[str, float]:
        """Work of every load without potential over the period [J], by name; their sum is what the
        energy of the rod gains: 0, unless it is carried on by its thrust."""
        return {name: float(done[-1]) for name, done in self.motion.work.items()}


def nontrivial(found: Complex, trivial: int) -> Complex:
    """Multipliers without so many of those nearest to 1."""
    left = np.ones(len(found), dtype=bool)
    left[np.argsort(np.abs(found - 1), kind="stable")[:trivial]] = False
    return found[left]


@guarded
def find_cycle(
    scene: Scene,
    *,
    segments: int = SEGMENTS,
    y0: ArrayLike | None = None,
    period: float | None = None,
    target: str | None = None,
) -> Cycle:
    """The periodic motion that a scene settles on, and its Floquet multipliers.

    The scene is run from its initial state over its span, and on where it has not settled, up to 16
    spans; from where it comes back to itself Newton's method goes on by multiple shooting in so
    many segments. y0 (states,) and period [s]: a state near a cycle, stable or not, and nearly its
    period, from which Newton's method begins instead. Loads that repeat give the period, which may
    be a whole number of theirs; loads that come to rest are taken as they are at the end of the
    span. A cycle may come back moved and turned where nothing depends on that; a rod that turns
    over and over comes back turned by whole turns. Without dissipation nothing settles: then it is
    the motion of the nonlinear mode that has most of the energy of the initial state, with that
    energy (see `nonlinear_mode`). target: "c" or "numpy"; if not given, C where it can be built.

    Raises SceneError for values that cannot be used, AnalysisError where the motion comes to rest
    or does not settle, and where Newton's method finds no cycle.
    """
    check_scene(scene)
    segments = segments_of(segments)
    begun = _begun(scene, y0, period)
    search = Search.of(scene, target)
    if begun is not None:
        return search.polished(begun[0], begun[1], segments)
    if search.conservative:
        from rodgen.analyse.cycles.nonlinear_modes import of_start

        return of_start(scene, segments, target)
    return search.settled(segments)


def segments_of(segments: object) -> int:
    """How many segments were asked for. Raises SceneError."""
    made = plain(segments, "segments")
    if not (isinstance(made, int) and 1 <= made <= MOST_SEGMENTS):
        raise SceneError("segments", segments, f"a whole number from 1 to {MOST_SEGMENTS}")
    return made


def _begun(scene: Scene, y0: ArrayLike | None, period: float | None) -> tuple[Array, float] | None:
    """A state and a period that were given, checked."""
    if y0 is None and period is None:
        return None
    if y0 is None:
        raise SceneError("period", period, "given with y0, a state near the cycle")
    if period is None:
        raise SceneError("y0", y0, "given with period, nearly that of the cycle")
    made = plain(period, "period")
    if not (is_number(made) and 0 < made < np.inf):
        raise SceneError("period", period, "a time above 0 s")
    return with_state(scene, y0).initial_state(), float(made)


def _built(scene: Scene, target: str | None) -> ModuleType:
    return build(scene, target, parts=PARTS) if target else build_fastest(scene, PARTS)


@dataclass(frozen=True)
class Search:
    """A scene made ready: its loads as they stay, or as they repeat after a period (forced) [s]."""

    scene: Scene
    model: ModuleType
    p: Array
    forced: float

    @classmethod
    def of(cls, scene: Scene, target: str | None = None) -> Search:
        """Raises SceneError, AnalysisError."""
        model = _built(scene, target)
        forced = load_period(scene, model, model.parameters(**scene.parameters))
        if not forced:
            scene = frozen(scene, scene.integrate.span[1])
            model = _built(scene, target)
        return cls(scene, model, model.parameters(**scene.parameters), forced)

    @property
    def target(self) -> str:
        """Of the module."""
        return str(self.model.PROVENANCE["target"])

    def flow(self, t: float, y: Array) -> Flow:
        """About a state (states,)."""
        return Flow(self.model, self.p, Quotient.of(self.model, self.p, t, y))

    def settled(self, segments: int) -> Cycle:
        """From a run. Raises AnalysisError."""
        start, end = self.scene.integrate.span
        t, y, span = start, self.scene.initial_state(), end - start
        if self.forced:
            span = self.forced * np.ceil(span / self.forced)
        why = ""
        for _ in range(SPANS):
            every = span / settling.SAMPLES
            if self.forced:
                every = self.forced / settling.PER_PERIOD
            times, states = run_of(self.scene, y, t, span, every, self.target)
            t, y = float(times[-1]), states[-1]
            flow = self.flow(t, y)
            back = last_return(times, states[:, flow.quotient.kept], flow.quotient, self.forced)
            if extent(states[len(states) // 2 :, flow.quotient.kept], flow.quotient) < AT_REST:
                raise AnalysisError(f"no cycle: the motion has come to rest before t = {t:g} s")
            if back is None:
                why = "it does not come back to where it was"
            else:
                try:
                    return replace(self._from(flow, back, segments), after=t - start)
                except AnalysisError as error:
                    why = str(error)
            span = max(span, t - start)
        raise AnalysisError(
            f"no cycle: the motion has not settled on one in {t - start:g} s, "
            f"{2 ** (SPANS - 1)} spans of the scene ({why})"
        )

    def _from(self, flow: Flow, back: Return, segments: int) -> Cycle:
        """From where a run came back. Raises AnalysisError where that leads to another motion."""
        x = cut(flow, back.t, back.x, back.period, segments)
        orbit = Orbit(x, back.t, back.period, back.angle, back.scale)
        found = self._shortest(flow, Shooting(flow, bool(self.forced)).solved(orbit))
        grown = self._extent(flow, found) / back.scale
        if not FROM_RUN[0] < grown < FROM_RUN[1]:
            raise AnalysisError(f"Newton's method led to a motion {grown:.3g} times as large")
        return self.cycle(flow, found)

    def _shortest(self, flow: Flow, orbit: Orbit) -> Orbit:
        """The orbit with its least period, where it goes round more than once."""
        turns = round(orbit.period / self.forced) if self.forced else MOST_TURNS
        for parts in range(turns, 1, -1):
            if self.forced and turns % parts:
                continue
            period = orbit.period / parts
            angle = orbit.angle / parts
            end = flow.quotient.turned(flow.carried(orbit.t, orbit.x[0], period), -angle)
            if np.abs(end - orbit.x[0]).max() <= CLOSED * orbit.scale:
                x = cut(flow, orbit.t, orbit.x[0], period, len(orbit.x))
                fresh = replace(orbit, x=x, period=period, angle=angle, change=np.inf)
                return Shooting(flow, bool(self.forced)).solved(fresh)
        return orbit

    def polished(self, y: Array, period: float, segments: int) -> Cycle:
        """From a state and a period near a cycle. Raises AnalysisError."""
        t = self.scene.integrate.span[0]
        flow = self.flow(t, y)
        if self.forced:
            turns = period / self.forced
            if abs(turns - round(turns)) > 0.01 or round(turns) < 1:
                allowed = f"a whole number of periods of the loads, {self.forced:.12g} s"
                raise SceneError("period", period, allowed)
            period = round(turns) * self.forced
        x = flow.quotient.kept
        every = period / settling.PER_PERIOD
        _, states = run_of(self.scene, y, t, period, every, self.target)
        swing = states[:, x]
        scale = extent(swing, flow.quotient)
        if scale < AT_REST:
            raise AnalysisError("no cycle: a rod in the state that was given does not move")
        angle = self._angle(flow.quotient, swing[0], swing[-1])
        orbit = Orbit(cut(flow, t, y[x], period, segments), t, period, angle, scale)
        found = Shooting(flow, bool(self.forced)).solved(orbit)
        if self._extent(flow, found) < 1e-3 * scale:
            raise AnalysisError("no cycle: Newton's method led to a motion that is at rest")
        return self.cycle(flow, found)

    def _angle(self, quotient: Quotient, first: Array, last: Array) -> float:
        mean = float((last - first)[quotient.angles].mean()) if len(quotient.angles) else 0.0
        return mean if quotient.turns else 2 * np.pi * round(mean / (2 * np.pi))

    def _extent(self, flow: Flow, orbit: Orbit) -> float:
        """The largest deviation of a state from the middle, along a motion."""
        x = cut(flow, orbit.t, orbit.x[0], orbit.period, max(16, len(orbit.x)))
        return extent(x, flow.quotient)

    def cycle(self, flow: Flow, orbit: Orbit, trivial: int | None = None) -> Cycle:
        """What there is to say of an orbit; trivial: how many multipliers are 1, if more than
        symmetries make so."""
        mu = multipliers(orbit)
        shooting = Shooting(flow, bool(self.forced))
        trivial = shooting.trivial if trivial is None else trivial
        near = np.sort(np.abs(mu - 1))[:trivial]
        y0 = flow.quotient.lifted(orbit.x[0])
        energy = Piece(self.model, self.p, y0, np.array(orbit.t)).values("total_energy")
        states = cut(flow, orbit.t, orbit.x[0], orbit.period, 64)[:, flow.quotient.angles]
        if flow.quotient.turns or orbit.angle:
            states = states - states.mean(axis=1, keepdims=True)
        swing = (states.max(axis=0) - states.min(axis=0)).max(initial=0.0) / 2
        return Cycle(
            scene=with_state(self.scene, y0),
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
        return loads_at_work(self.scene, self.model)
