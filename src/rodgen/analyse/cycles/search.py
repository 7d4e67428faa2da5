"""The search for the periodic motion of a scene at its own values: from a run, or from nearby."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline

from rodgen.analyse.curves.twice import cycle_notes, twice
from rodgen.analyse.cycles import settling
from rodgen.analyse.cycles.closing import Closing, Lap, O, Orbit
from rodgen.analyse.cycles.collocation import Collocation
from rodgen.analyse.cycles.cycle import Cycle
from rodgen.analyse.cycles.drive import load_period
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.picard import LEADING, Picard
from rodgen.analyse.cycles.quotient import Quotient
from rodgen.analyse.cycles.settling import Return, extent, last_return, run_of
from rodgen.analyse.cycles.shooting import SEGMENTS, Shooting
from rodgen.analyse.errors import AnalysisError, guarded
from rodgen.analyse.sizes import CYCLE, check_size
from rodgen.analyse.system import frozen
from rodgen.integrate.catalogue import Piece, loads_at_work
from rodgen.integrate.stepper import Array
from rodgen.loading import build, build_fastest
from rodgen.scene import Scene, SceneError
from rodgen.scene.overrides import with_state
from rodgen.scene.plain import is_number, plain

COLLOCATION, SHOOTING, PICARD = "collocation", "shooting", "picard"
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


@guarded
def find_cycle(
    scene: Scene,
    *,
    by: str | None = None,
    segments: int | None = None,
    multipliers: int | None = None,
    y0: ArrayLike | None = None,
    period: float | None = None,
    target: str | None = None,
    check_mesh: bool = False,
) -> Cycle:
    """Return the periodic motion that a scene settles on, with its Floquet multipliers.

    The scene runs from its initial state over its span, or up to 16 spans until it settles. When
    the motion comes back to itself, Newton's method takes over. Loads that repeat give the period,
    or a whole multiple of it. Loads that come to rest are taken as they are at the end of the span.
    A cycle may come back in another place and direction if nothing depends on these; a rod that
    turns over and over comes back turned by whole turns. Without dissipation no motion settles. The
    result is then the nonlinear mode that has most of the energy of the initial state, at that
    energy (see `nonlinear_mode`).

    Parameters
    ----------
    scene
        The scene.
    by
        "collocation": on a mesh of the period, refined until nothing changes. "shooting": in equal
        segments. "picard": Newton's method in the directions of the leading multipliers, Picard's
        iteration for the rest. By default, the method to which ``segments`` or ``multipliers``
        belong, else collocation up to 100 states that count, and "picard" beyond.
    segments
        Number of equal parts of the period, for "shooting".
    multipliers
        Number of leading multipliers, for "picard". The default is 10.
    y0, period
        A state (states,) near a cycle, stable or not, and its approximate period [s]. Newton's
        method then begins there, without a run.
    target
        "c" or "numpy"; if not given, C where it can be built.
    check_mesh
        Also find the cycle of twice as many links, and say in the notes what changes by more
        than 1 %.

    Returns
    -------
    Cycle
        Period [s], a state on it, multipliers with the error of those that are 1.

    Raises
    ------
    SceneError
        For values that cannot be used.
    AnalysisError
        If the motion comes to rest or does not settle, or if Newton's method finds no cycle.

    Examples
    --------
    >>> import rodgen
    >>> cycle = rodgen.find_cycle(rodgen.Scene.example("beck_after_flutter"))
    >>> round(cycle.period, 4), cycle.stable, cycle.trivial_error < 1e-6
    (0.8395, True, True)
    """
    check_size(CYCLE, scene)
    if check_mesh:
        if y0 is not None:
            raise SceneError("check_mesh", True, "absent beside y0")
        given: dict[str, Any] = {"by": by, "segments": segments, "multipliers": multipliers}
        found_twice = partial(find_cycle, twice(scene), **given, target=target)
        found = find_cycle(scene, **given, target=target)
        return replace(found, notes=cycle_notes(found, scene.rod.links, found_twice))
    if by not in (None, *WAYS.values()):
        raise SceneError("by", by, " or ".join(map(repr, WAYS.values())))
    for name, value, way in (
        ("segments", segments, SHOOTING),
        ("multipliers", multipliers, PICARD),
    ):
        if value is not None and (by not in (None, way) or (segments and multipliers)):
            raise SceneError(name, value, f"given with by = {way!r} alone")
    segments = None if segments is None else segments_of(segments)
    multipliers = None if multipliers is None else segments_of(multipliers, "multipliers")
    begun = _begun(scene, y0, period)
    search = replace(Search.of(scene, target), by=by, segments=segments, leading=multipliers)
    if begun is not None:
        return search.polished(*begun)
    if search.conservative:
        from rodgen.analyse.cycles.nonlinear_modes import of_start

        return of_start(scene, segments or SEGMENTS, target)
    return search.settled()


def segments_of(number: object, name: str = "segments") -> int:
    """How many segments, or multipliers, were asked for. Raises SceneError."""
    made = plain(number, name)
    if not (isinstance(made, int) and 1 <= made <= MOST_SEGMENTS):
        raise SceneError(name, number, f"a whole number from 1 to {MOST_SEGMENTS}")
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
    """A scene made ready: its loads as they stay, or as they repeat after a period (forced) [s];
    by, segments, leading: how cycles are looked for, as `find_cycle` has them."""

    scene: Scene
    model: ModuleType
    p: Array
    forced: float
    by: str | None = None
    segments: int | None = None
    leading: int | None = None

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

    def settled(self) -> Cycle:
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
            _, states = run_of(self.scene, y, like.t, like.period, times[1], self.target)
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
        t = self.scene.integrate.span[0]
        flow = self.flow(t, y)
        if self.forced:
            turns = period / self.forced
            if abs(turns - round(turns)) > 0.01 or round(turns) < 1:
                allowed = f"a whole number of periods of the loads, {self.forced:.12g} s"
                raise SceneError("period", period, allowed)
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
