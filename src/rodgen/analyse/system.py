"""A scene made ready for analysis: the instant of its loads, how a free rod flies, its module."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.errors import AnalysisError
from rodgen.integrate.catalogue import Piece
from rodgen.integrate.endings import RunError
from rodgen.integrate.simulate import simulate
from rodgen.integrate.stepper import Array
from rodgen.loading import build
from rodgen.model.term import ANCHOR
from rodgen.model.terms import TERMS
from rodgen.scene import Scene, SceneError
from rodgen.scene.errors import Missing
from rodgen.scene.expression import Expression
from rodgen.scene.overrides import with_masses_at, with_parameters, with_state
from rodgen.scene.plain import is_number, plain
from rodgen.scene.scene import check_scene

TIMES = 1001  # of the span, beside what lies between break points
ITERATIONS, STILL = 50, 1e-9  # of added states that come to rest
ROUNDING = 1e-9  # of the speed, below which a part of it is none


def instant(scene: Scene, t: float | None = None) -> float:
    """The time whose loads are taken [s]: t, by default the start of the scene's span.

    Raises SceneError for a time outside the span, where the scene says nothing of its loads, and
    where none is given of a scene whose masses change: no state of it lasts.
    """
    start, end = scene.integrate.span
    changing = scene.distribution.changing
    if t is None and changing:
        fields = " and ".join(e.field for *_, e in changing)
        verb = "changes" if len(changing) == 1 else "change"
        allowed = f"given, the time whose masses are taken: {fields} {verb} with it"
        raise SceneError("t", Missing(), allowed)
    t = start if t is None else plain(t, "t")
    if not (is_number(t) and start <= t <= end):
        raise SceneError("t", t, f"a time in the span of the scene, {start:g} to {end:g} s")
    return float(t)


def silent(scene: Scene, t: float, scaled: Collection[str] = ()) -> tuple[str, ...]:
    """Places, such as loads.follower.force, of the loads that are zero at t [s] and act at another
    time of the span; scaled: parameters that are not asked for."""
    times = _times(scene)
    return tuple(
        scene.field(name)
        for name, e in scene.timed.items()
        if name not in scaled and float(e(t)) == 0 and _acts(e, times)
    )


def in_words(scene: Scene, t: float, scaled: Collection[str] = ()) -> str:
    """What is to be said of the instant before any result: which one it is, and what it lacks."""
    masses = " and masses" * bool(scene.distribution.changing)
    words = f"loads{masses} as at t = {t:g} s"
    if t == scene.integrate.span[0]:
        words += ", the start of the span"
    quiet = silent(scene, t, scaled)
    if not quiet:
        return words
    verb = "is" if len(quiet) == 1 else "are"
    return f"{words}, where {' and '.join(quiet)} {verb} 0, but not at all times"


def _times(scene: Scene) -> Array:
    """Times of the span [s] at which no load can hide between two others."""
    start, end = scene.integrate.span
    ends = np.array([start, *scene.breaks(), end])
    peaks = [peak for _, peak, _ in scene.course.pulses()]
    return np.concatenate((np.linspace(start, end, TIMES), (ends[1:] + ends[:-1]) / 2, peaks))


def _acts(e: Expression, times: Array) -> bool:
    return bool((np.asarray(e(times)) != 0).any())


def along_and_across(velocity: Array, angle: float) -> tuple[float, float]:
    """Its part along a rod of this angle, nose first, and its part across, to the left [m/s]."""
    c, s = np.cos(angle), np.sin(angle)
    parts = -float(velocity @ [c, s]), -float(velocity @ [-s, c])
    least = ROUNDING * float(np.linalg.norm(velocity))
    along, across = (part if abs(part) > least else 0.0 for part in parts)
    return along, across


def checked_speed(scene: Scene, speed: float | None) -> float | None:
    """A speed that was asked for. Raises SceneError."""
    if speed is None:
        return None
    speed = plain(speed, "speed")
    if not (is_number(speed) and np.isfinite(speed)):
        raise SceneError("speed", speed, "a finite number")
    if not scene.hold.translates:
        raise SceneError("speed", speed, f"absent: a {scene.rod.boundary} rod does not fly")
    return float(speed)


def flown(
    scene: Scene, t: float | None, speed: float | None, after: float | None
) -> tuple[Scene, float | None]:
    """The scene that starts in the state that its run has reached after so many seconds, and that
    time; where no time is asked for, the scene itself and t. Raises SceneError, AnalysisError."""
    if after is None:
        return scene, t
    start, end = scene.integrate.span
    after = plain(after, "after")
    if not (is_number(after) and start <= after <= end):
        raise SceneError("after", after, f"a time in the span, {start:g} to {end:g} s")
    for name, value in (("t", t), ("speed", speed)):
        if value is not None:
            raise SceneError(name, value, "absent: that of the run is taken (after)")
    if after == start:
        return scene, float(after)
    table = scene.model_dump(exclude_none=True)
    given = {k: value for k, value in table["integrate"].items() if k != "t_eval"}
    given |= {"span": [start, float(after)], "output_every": float(after) - start}
    try:
        run = simulate(Scene.from_dict(table | {"integrate": given}))
    except RunError as error:
        raise AnalysisError(f"the run up to {after:g} s cannot be finished: {error}") from error
    if run.t[-1] < after:
        raise SceneError("after", after, f"before the run ends, at {run.t[-1]:g} s")
    return with_state(scene, run.y[-1]), float(after)


class Unknowns(NamedTuple):
    """Angles (cells,) [rad]; joint forces (cells, 2) over the mass of a link [m/s^2]; position of
    joint 0 (base,) [m]; added states (states,)."""

    phi: Array
    force: Array
    position: Array
    added: Array

    def moved(self, by: Unknowns, times: float = 1.0) -> Unknowns:
        """Changed by so many times a change."""
        return Unknowns(*(a + times * b for a, b in zip(self, by, strict=True)))


@dataclass(frozen=True)
class System:
    """scene: its loads are numbers, those at the time t [s]; model: its generated module; speed:
    at which a free rod moves along its axis, nose first [m/s]; across: the part of its velocity
    that is left out, since no state that moves so is steady [m/s]."""

    scene: Scene
    model: ModuleType
    t: float
    speed: float = 0.0
    across: float = 0.0

    @classmethod
    def of(cls, scene: Scene, t: float | None = None, speed: float | None = None) -> System:
        """t: at which loads are taken, see `instant`; speed: of a free rod along its axis [m/s],
        by default that of the scene's initial state. Raises SceneError.

        The module is that of the NumPy target: a few evaluations are not worth a compilation.
        """
        check_scene(scene)
        t = instant(scene, t)
        speed = checked_speed(scene, speed)
        scene = frozen(scene, t)
        system = cls(scene, build(scene, "numpy"), t)
        along, across = system._motion() if speed is None else (speed, 0.0)
        return replace(system, speed=along, across=across)

    def _motion(self) -> tuple[float, float]:
        """Velocity of a free rod along and across its axis at the start [m/s]."""
        if not self.base:
            return 0.0, 0.0
        start = Piece(self.model, self.parameters(), self.scene.initial_state())
        moving: Array = start.values("centre_velocity")
        return along_and_across(moving, float(self.straight[0]))

    @cached_property
    def anchored(self) -> bool:
        """Whether springs or dampers hold joints, so that equations follow their positions."""
        return any(TERMS[name].kind == ANCHOR for name in self.scene.structure.loads)

    @cached_property
    def steered(self) -> bool:
        """Whether loads follow the motion, or states are added."""
        return bool(self.scene.fed or self.scene.states)

    @cached_property
    def chain(self) -> bool:
        """Whether joint forces are unknowns at rest: joint 0 is held, nothing else is, and no load
        follows the motion."""
        return not (self.base or self.steered or self.anchored)

    @cached_property
    def base(self) -> int:
        """Coordinates of joint 0, before the angles."""
        return 2 * self.scene.hold.translates

    @cached_property
    def cells(self) -> int:
        """Links that move."""
        return self.scene.rod.links - self.scene.held

    @cached_property
    def given(self) -> dict[str, Any]:
        """Parameters of the scene by name."""
        return self.scene.parameters

    def parameters(self, **changes: Any) -> Array:
        """p of the module, with other values for some parameters: numbers, or arrays of several."""
        p: Array = self.model.parameters(**(self.given | changes))
        return p

    def unsettled(self, phi: Array) -> Unknowns:
        """A rod with these angles of the moving links [rad] without joint forces; joint 0 where it
        is at the start, where its place counts, else at the origin; added states as they are at
        the start."""
        counts = self.anchored or self.steered
        start = self.scene.initial_state()
        nothing, added = np.zeros((self.cells, 2)), start[2 * (self.base + self.cells) :]
        return Unknowns(phi, nothing, start[: self.base] * counts, added)

    def beside(self, phi: Array) -> Unknowns:
        """A rod with these angles, its added states where they stay beside it. Raises AnalysisError
        where they do not."""
        at = self.unsettled(phi)
        return at._replace(added=self._staying(self.at_rest(at))) if len(at.added) else at

    @cached_property
    def beside_straight(self) -> Unknowns:
        """The straight rod, its added states where they stay beside it. Raises AnalysisError."""
        return self.beside(self.straight)

    def at_rest(self, at: Unknowns) -> Array:
        """y (states,) without velocities."""
        base, half = self.base, self.base + self.cells
        y = np.zeros(2 * half + len(self.scene.states))
        y[:base], y[base:half], y[2 * half :] = at.position, at.phi, at.added
        return y

    def _staying(self, y: Array) -> Array:
        """The added states at which their rates vanish, by Newton's method from those of y. Raises
        AnalysisError where there are none."""
        first, p = 2 * (self.base + self.cells), self.parameters()
        for _ in range(ITERATIONS):
            rates = self.model.rhs(self.t, y, p)[first:]
            J = self.model.jac(self.t, y, p)[first:]
            if not (np.isfinite(rates).all() and np.isfinite(J).all()):
                break
            change = np.linalg.lstsq(J[:, first:], -rates, rcond=None)[0]
            y[first:] += change
            sizes = np.abs(J) @ np.abs(y) + np.abs(y[first:])
            if (np.abs(rates) <= STILL * sizes).all() and (np.abs(change) <= STILL).all():
                return y[first:]
        names = ", ".join(f"states.{name}" for name in self.scene.states)
        raise AnalysisError(f"{names} do not come to rest beside a rod that does not move")

    def flying(self, at: Unknowns, across: float = 0.0) -> Array:
        """y (states,) of a rod that moves along its straight axis with its speed, and across it
        [m/s]."""
        y = self.at_rest(at)
        if self.base:
            c, s = np.cos(self.straight[0]), np.sin(self.straight[0])
            half = self.base + self.cells
            y[half : half + 2] = -self.speed * c - across * s, -self.speed * s + across * c
        return y

    @property
    def clamped(self) -> bool:
        """Whether the start of the rod keeps its direction."""
        return self.scene.hold.clamped

    @cached_property
    def straight(self) -> Array:
        """Angles (cells,) of the straight rod: along the clamp, or at the mean initial angle."""
        rod, start = self.scene.rod, self.scene.initial_state()
        if self.clamped:
            return np.full(self.cells, rod.clamp_angle or 0.0)
        return np.full(self.cells, start[self.base : self.base + self.cells].mean())

    def all_links(self, phi: NDArray[Any]) -> NDArray[Any]:
        """Angles of all n links, held ones included, from those of the moving ones (..., cells)."""
        held = np.full((*phi.shape[:-1], self.scene.held), self.scene.rod.clamp_angle or 0.0)
        return np.concatenate((held, phi), axis=-1)

    def joint_ways(self, y: Array, p: Array, joints: NDArray[np.intp]) -> Array:
        """How joints of these numbers (k,) follow position and angles (k, 2, base + cells), by
        virtual work: the tail follows all links, a joint those before it."""
        work, n = self.model.generalised_force, self.scene.rod.links
        tail = np.stack([work(y, p, n - 1, 1.0, axis) for axis in ((1.0, 0.0), (0.0, 1.0))])
        before = joints[:, None] > np.arange(self.scene.held, n)
        follows = np.hstack((np.ones((len(joints), self.base)), before))
        return np.asarray(tail * follows[:, None])

    def rates(self, y: Array, p: Array) -> Array:
        """Accelerations (base + cells,) of the coordinates."""
        half = self.base + self.cells
        rates: Array = self.model.rhs(self.t, y, p)[half : 2 * half]
        return rates


def frozen(scene: Scene, t: float) -> Scene:
    """The scene with every load and mass that is a function of time as it is at t [s].

    Raises SceneError for a load that is not finite then.
    """
    changed: dict[str, Any] = {name: float(e(t)) for name, e in scene.timed.items()}
    for name, value in changed.items():
        if not np.isfinite(value):
            raise SceneError(scene.field(name), value, f"finite at t = {t:g} s")
    changed |= scene.along_at(t)
    return with_masses_at(with_parameters(scene, changed) if changed else scene, t)


def without(scene: Scene, *tables: str) -> Scene:
    """The scene without some of its tables of loads."""
    given = scene.model_dump(exclude_none=True)
    for table in tables:
        given["loads"].pop(table, None)
    return Scene.from_dict(given)
