"""A rod under loads that do not change: what steady states are states of."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.catalogue import Piece
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import RunError
from rodgen.model.rod import CLAMP_ANGLE
from rodgen.model.term import ANCHOR
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.scene.plain import is_number, plain
from rodgen.system import System

ITERATIONS, STILL = 50, 1e-9  # of added states that come to rest
ROUNDING = 1e-9  # of the speed, below which a part of it is none


def along_and_across(velocity: Array, angle: float) -> tuple[float, float]:
    """Its part along a rod of this angle, nose first, and its part across, to the left [m/s]."""
    c, s = np.cos(angle), np.sin(angle)
    parts = -float(velocity @ [c, s]), -float(velocity @ [-s, c])
    least = ROUNDING * float(np.linalg.norm(velocity))
    along, across = (part if abs(part) > least else 0.0 for part in parts)
    return along, across


def checked_speed(system: System, speed: float | None) -> float | None:
    """A speed that was asked for. Raises InputError."""
    if speed is None:
        return None
    speed = plain(speed, "speed")
    if not (is_number(speed) and np.isfinite(speed)):
        raise InputError("speed", speed, "a finite number")
    if not system.hold.translates:
        boundary = system.structure.boundary
        raise InputError("speed", speed, f"absent: a {boundary} rod does not fly")
    return float(speed)


def state_after(
    system: System, t: float | None, speed: float | None, after: float | None
) -> tuple[System, float | None]:
    """The system that starts in the state which its run has reached after so many seconds, and that
    time; where no time is asked for, the system itself and t. Raises InputError, AnalysisError."""
    if after is None:
        return system, t
    start, end = system.settings.span
    after = plain(after, "after")
    if not (is_number(after) and start <= after <= end):
        raise InputError("after", after, f"a time in the span, {start:g} to {end:g} s")
    if system.t is not None:
        allowed = f"absent: the loads of this system are those of t = {system.t:g} s at all times"
        raise InputError("after", after, allowed)
    for name, value in (("t", t), ("speed", speed)):
        if value is not None:
            raise InputError(name, value, "absent: that of the run is taken (after)")
    if after == start:
        return system, float(after)
    span, every = [start, float(after)], float(after) - start
    try:
        run = simulate(system.with_settings(span=span, output_every=every))
    except RunError as error:
        raise AnalysisError(f"the run up to {after:g} s cannot be finished: {error}") from error
    if run.t[-1] < after:
        raise InputError("after", after, f"before the run ends, at {run.t[-1]:g} s")
    return system.at(y0=run.y[-1]), float(after)


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


class AtOneTime:
    """What has a system whose loads are those of one time."""

    system: System

    @property
    def scene(self) -> Scene:
        """The scene, with the loads of that time."""
        return self.system.scene

    @property
    def t(self) -> float:
        """Time at which the loads are taken [s]."""
        assert self.system.t is not None
        return self.system.t


@dataclass(frozen=True)
class SteadyRod(AtOneTime):
    """A rod whose loads are those of one time, its module, and how it flies.

    system: its loads are numbers, those at the time t [s]; speed: at which a free rod moves along
    its axis, nose first [m/s]; across: the part of its velocity that is left out, since no state
    that moves so is steady [m/s].
    """

    system: System
    speed: float = 0.0
    across: float = 0.0

    @classmethod
    def of(
        cls, given: System | Scene, t: float | None = None, speed: float | None = None
    ) -> SteadyRod:
        """t: at which loads are taken, see `System.steady`; speed: of a free rod along its axis
        [m/s], by default that of the scene's initial state. Raises InputError."""
        system = System.of(given).steady(t)
        speed = checked_speed(system, speed)
        rod = cls(system)
        along, across = rod._motion() if speed is None else (speed, 0.0)
        return replace(rod, speed=along, across=across)

    @cached_property
    def model(self) -> ModuleType:
        """Its module, of the NumPy target: a few evaluations are not worth a compilation."""
        return self.system.model("numpy")

    def _motion(self) -> tuple[float, float]:
        """Velocity of a free rod along and across its axis at the start [m/s]."""
        if not self.base:
            return 0.0, 0.0
        start = Piece(self.model, self.system.p, self.system.y0)
        moving: Array = start.values("centre_velocity")
        return along_and_across(moving, float(self.straight[0]))

    @cached_property
    def anchored(self) -> bool:
        """Whether springs or dampers hold joints, so that equations follow their positions."""
        return any(TERMS[name].kind == ANCHOR for name in self.system.structure.loads)

    @cached_property
    def steered(self) -> bool:
        """Whether loads follow the motion, or states are added."""
        return self.system.structure.follows or bool(self.system.added)

    @cached_property
    def chain(self) -> bool:
        """Whether joint forces are unknowns at rest: joint 0 is held, nothing else is, and no load
        follows the motion."""
        return not (self.base or self.steered or self.anchored)

    @cached_property
    def base(self) -> int:
        """Coordinates of joint 0, before the angles."""
        return 2 * self.system.hold.translates

    @cached_property
    def cells(self) -> int:
        """Links that move."""
        return self.system.structure.links - self.system.hold.first

    def unsettled(self, phi: Array) -> Unknowns:
        """A rod with these angles of the moving links [rad] without joint forces; joint 0 where it
        is at the start, where its place counts, else at the origin; added states as they are at
        the start."""
        counts = self.anchored or self.steered
        start = self.system.y0
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
        y = np.zeros(2 * half + len(self.system.added))
        y[:base], y[base:half], y[2 * half :] = at.position, at.phi, at.added
        return y

    def _staying(self, y: Array) -> Array:
        """The added states at which their rates vanish, by Newton's method from those of y. Raises
        AnalysisError where there are none."""
        first, p = 2 * (self.base + self.cells), self.system.p
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
        names = ", ".join(f"states.{name}" for name in self.system.added)
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
        return self.system.hold.clamped

    @cached_property
    def straight(self) -> Array:
        """Angles (cells,) of the straight rod: along the clamp, or at the mean initial angle."""
        if self.clamped:
            return np.full(self.cells, self._clamp_angle)
        return np.full(self.cells, self.system.y0[self.base : self.base + self.cells].mean())

    @property
    def _clamp_angle(self) -> float:
        return self.system.values(CLAMP_ANGLE.name) if self.clamped else 0.0

    def all_links(self, phi: NDArray[Any]) -> NDArray[Any]:
        """Angles of all n links, held ones included, from those of the moving ones (..., cells)."""
        held = np.full((*phi.shape[:-1], self.system.hold.first), self._clamp_angle)
        return np.concatenate((held, phi), axis=-1)

    def joint_ways(self, y: Array, p: Array, joints: NDArray[np.intp]) -> Array:
        """How joints of these numbers (k,) follow position and angles (k, 2, base + cells), by
        virtual work: the tail follows all links, a joint those before it."""
        work, n = self.model.generalised_force, self.system.structure.links
        tail = np.stack([work(y, p, n - 1, 1.0, axis) for axis in ((1.0, 0.0), (0.0, 1.0))])
        before = joints[:, None] > np.arange(self.system.hold.first, n)
        follows = np.hstack((np.ones((len(joints), self.base)), before))
        return np.asarray(tail * follows[:, None])

    def rates(self, y: Array, p: Array) -> Array:
        """Accelerations (base + cells,) of the coordinates."""
        half = self.base + self.cells
        rates: Array = self.model.rhs(self.t, y, p)[half : 2 * half]
        return rates
