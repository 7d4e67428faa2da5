"""A rod under the loads of one time, the unknowns of its steady states, and the base of results
about these.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import RunError
from rodgen.model.rod import CENTRE_ALONG, CLAMP_ANGLE, LINK_MASS, SPREAD_ALONG
from rodgen.model.terms import BASE_ANGLE, TERMS
from rodgen.result import Result, Row, omit_from_tables
from rodgen.scene import Scene
from rodgen.scene.distribution import shape_without_load
from rodgen.scene.plain_tables import is_number, to_plain
from rodgen.system import System
from rodgen.system.link_inertia import is_light

STRAIGHT = 1e-12  # rad
ITERATIONS, STILL = 50, 1e-9  # of added states that come to rest
ROUNDING = 1e-9  # of the speed, below which a part of it is none

TIMES = 1001  # of the span, beside what lies between break points
TIME = (
    Row("t", "time", "s", text=lambda found: found._instant_text),
    Row("inactive_loads", "loads that are zero then", text=omit_from_tables),
)


def split_velocity(velocity: Array, angle: float) -> tuple[float, float]:
    """Split a velocity into its parts along a rod, nose first, and across it, to the left [m/s]."""
    c, s = np.cos(angle), np.sin(angle)
    parts = -float(velocity @ [c, s]), -float(velocity @ [-s, c])
    least = ROUNDING * float(np.linalg.norm(velocity))
    along, across = (part if abs(part) > least else 0.0 for part in parts)
    return along, across


def check_speed(system: System, speed: float | None) -> float | None:
    """Check a speed and return it. Raises InputError."""
    if speed is None:
        return None
    speed = to_plain(speed, "speed")
    if not (is_number(speed) and np.isfinite(speed)):
        raise InputError("speed", speed, "a finite number")
    if not system.boundary_condition.translates:
        boundary = system.structure.boundary
        raise InputError("speed", speed, f"absent: a {boundary} rod does not fly")
    return float(speed)


def state_after(
    system: System, t: float | None, speed: float | None, after: float | None
) -> tuple[System, float | None]:
    """Run a system up to the time ``after``; return it with the state there as its start, and that
    time. Without ``after``, return the system itself and t. Raises InputError, AnalysisError."""
    if after is None:
        return system, t
    start, end = system.settings.span
    after = to_plain(after, "after")
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
    """Unknowns of a steady state: angles (n_moving,) [rad]; joint forces over the mass of a link
    (n_moving, 2) [m/s^2]; position of joint 0 (base,) [m]; added states (states,)."""

    phi: Array
    force: Array
    position: Array
    added: Array

    def add(self, by: Unknowns, times: float = 1.0) -> Unknowns:
        """Add ``times`` times a change."""
        return Unknowns(*(a + times * b for a, b in zip(self, by, strict=True)))


class HasInstant:
    """Mixin for what has a system whose loads are those of one time."""

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
class SteadyRod(HasInstant):
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
        """Set up the rod of a scene. t: see `System.steady`; speed: of a free rod along its axis
        [m/s], by default that of the scene's initial state. Raises InputError."""
        system = System.of(given).steady(t)
        speed = check_speed(system, speed)
        rod = cls(system)
        along, across = rod._initial_velocity() if speed is None else (speed, 0.0)
        return replace(rod, speed=along, across=across)

    @cached_property
    def model(self) -> ModuleType:
        """Module of the NumPy target: a few evaluations are not worth a compilation."""
        return self.system.model("numpy", parts=("balance",))

    def _initial_velocity(self) -> tuple[float, float]:
        """Velocity of a free rod along and across its axis at the start [m/s]."""
        if not self.n_base:
            return 0.0, 0.0
        start = MotionSlice(self.model, self.system.p, self.system.y0)
        moving: Array = start.values("centre_velocity")
        return split_velocity(moving, float(self.unloaded_angles[0]))

    @cached_property
    def has_supports(self) -> bool:
        """Whether supports, stops or walls hold joints, so that the equations depend on their
        positions."""
        return any(TERMS[name].holds_joints for name in self.system.structure.loads)

    @cached_property
    def has_feedback(self) -> bool:
        """Whether loads depend on the motion, or states are added."""
        return self.system.structure.has_feedback or bool(self.n_added_states)

    @cached_property
    def is_light(self) -> bool:
        """Whether links have no mass, or so little that joint forces over it lose their digits."""
        return is_light(self.system)

    @cached_property
    def has_joint_force_unknowns(self) -> bool:
        """Whether joint forces are unknowns at rest: joint 0 is held, nothing else is, no load
        depends on the motion, and all links have a mass."""
        return not (self.n_base or self.has_feedback or self.has_supports or self.is_light)

    @cached_property
    def n_base(self) -> int:
        """Number of coordinates of a free joint 0, before the angles."""
        return 2 * self.system.boundary_condition.translates

    @cached_property
    def n_moving(self) -> int:
        """Number of moving links."""
        return self.system.structure.n_links - self.system.boundary_condition.first

    @cached_property
    def n_added_states(self) -> int:
        """Number of added states, whose equations of first order are the last rows."""
        return len(self.system.structure.state_names)

    def start_unknowns(self, phi: Array) -> Unknowns:
        """Unknowns for angles of the moving links [rad], without joint forces; joint 0 where it is
        at the start, if its place counts, else at the origin; added states as they are at the
        start."""
        counts = self.has_supports or self.has_feedback
        start = self.system.y0
        nothing, added = np.zeros((self.n_moving, 2)), start[2 * (self.n_base + self.n_moving) :]
        return Unknowns(phi, nothing, start[: self.n_base] * counts, added)

    def unknowns_at_rest(self, phi: Array, strict: bool = True) -> Unknowns:
        """Unknowns for these angles, with added states at rest. Where these do not come to rest,
        they are as at the start; strict: raise AnalysisError instead."""
        at = self.start_unknowns(phi)
        if not len(at.added):
            return at
        try:
            return at._replace(added=self._solve_added_states(self.state_at_rest(at)))
        except AnalysisError:
            if strict:
                raise
            return at

    @cached_property
    def unloaded_unknowns(self) -> Unknowns:
        """Unknowns of the rod in its shape without load, with added states at rest. Raises
        AnalysisError."""
        return self.unknowns_at_rest(self.unloaded_angles)

    def state_at_rest(self, at: Unknowns) -> Array:
        """State y (states,) without velocities."""
        base, half = self.n_base, self.n_base + self.n_moving
        y = np.zeros(2 * half + self.n_added_states)
        y[:base], y[base:half], y[2 * half :] = at.position, at.phi, at.added
        return y

    def _solve_added_states(self, y: Array) -> Array:
        """Added states at rest beside the positions of y, by Newton's method from those of y.
        Raises AnalysisError where there are none."""
        first, p = 2 * (self.n_base + self.n_moving), self.system.p
        for _ in range(ITERATIONS):
            try:
                rates, J = (part[first // 2 :] for part in self.balance(y, p))
            except AnalysisError:
                break
            change = np.linalg.lstsq(J[:, first:], -rates, rcond=None)[0]
            y[first:] += change
            sizes = np.abs(J) @ np.abs(y) + np.abs(y[first:])
            if (np.abs(rates) <= STILL * sizes).all() and (np.abs(change) <= STILL).all():
                return y[first:]
        names = ", ".join(f"states.{name}" for name in self.system.structure.state_names)
        raise AnalysisError(f"{names} do not come to rest beside a rod that does not move")

    def state_in_flight(self, at: Unknowns, across: float = 0.0) -> Array:
        """State y (states,) of a rod that moves along its axis, that of its first link, with its
        speed, and across it [m/s]."""
        y = self.state_at_rest(at)
        if self.n_base:
            c, s = np.cos(self.unloaded_angles[0]), np.sin(self.unloaded_angles[0])
            half = self.n_base + self.n_moving
            y[half : half + 2] = -self.speed * c - across * s, -self.speed * s + across * c
        return y

    @property
    def is_clamped(self) -> bool:
        """Whether the start of the rod keeps its direction."""
        return self.system.boundary_condition.is_clamped

    @cached_property
    def unloaded_angles(self) -> Array:
        """Angles (n_moving,) of the rod without load, which is straight or as it is bent at rest:
        from the clamp on, or with the mean of the initial angles."""
        shape = self._rest_shape
        if self.is_clamped:
            return shape + self._clamp_angle
        mean: float = (self.system.y0[self.n_base : self.n_base + self.n_moving] - shape).mean()
        return shape + mean

    @property
    def _rest_shape(self) -> Array:
        """Angles (n_moving,) of the rod without load over that at its start."""
        return shape_without_load(self.system.structure, self.system.p)

    @cached_property
    def is_straight(self) -> bool:
        """Whether the rod without load is straight."""
        return bool(np.ptp(self._rest_shape) <= STRAIGHT)

    @property
    def _clamp_angle(self) -> float:
        known = self.system.structure.slices
        angles = (name for name in (CLAMP_ANGLE.name, BASE_ANGLE) if name in known)
        return sum(map(self.system.parameter, angles)) if self.is_clamped else 0.0

    def all_angles(self, phi: NDArray[Any]) -> NDArray[Any]:
        """Angles of all n links, fixed ones included, from those of moving ones (..., n_moving)."""
        held = np.full((*phi.shape[:-1], self.system.boundary_condition.first), self._clamp_angle)
        return np.concatenate((held, phi), axis=-1)

    def joint_derivatives(self, y: Array, p: Array, joints: NDArray[np.intp]) -> Array:
        """Derivatives of joints (k,) by position and angles (k, 2, base + n_moving), from virtual
        work: the tail depends on all links, a joint on those before it."""
        work, n = self.model.generalised_force, self.system.structure.n_links
        tail = np.stack([work(y, p, n - 1, 1.0, axis) for axis in ((1.0, 0.0), (0.0, 1.0))])
        before = joints[:, None] > np.arange(self.system.boundary_condition.first, n)
        follows = np.hstack((np.ones((len(joints), self.n_base)), before))
        return np.asarray(tail * follows[:, None])

    def balance(self, y: Array, p: Array, acceleration: Array | None = None) -> tuple[Array, Array]:
        """Generalised forces on the rod at rest and rates of added states, (coordinates + added,),
        and their derivatives by the state; acceleration: of the frame of a free joint 0 (2,)
        [m/s^2]. Raises AnalysisError where they are not finite."""
        frame = () if acceleration is None else (acceleration,)
        force, slope = self.model.balance(self.t, y, p, *frame)
        if not (np.isfinite(force).all() and np.isfinite(slope).all()):
            raise AnalysisError("the equations of rest are not finite")
        return force, slope

    def with_even_mass(self, p: Array) -> Array:
        """Parameters of the same rod with its mass spread evenly over the links."""
        made, places = p.copy(), self.system.structure.slices
        total = p[places[LINK_MASS.name]].sum()
        even = {LINK_MASS.name: total / self.system.structure.n_links, CENTRE_ALONG.name: 0.5}
        for name, value in (even | {SPREAD_ALONG.name: 1 / 12}).items():
            if name in places:
                made[places[name]] = value
        return made

    def start_acceleration(self, y: Array, p: Array) -> Array:
        """Acceleration (2,) of a free joint 0 by the loads, where no link turns [m/s^2]."""
        force, total = self.balance(y, p)[0], self.model.mass_matrix(y, p)[0, 0]
        return np.asarray(force[: self.n_base] / total)

    def accelerations(self, y: Array, p: Array) -> Array:
        """Accelerations (base + n_moving,) of the coordinates."""
        half = self.n_base + self.n_moving
        rates: Array = self.model.rhs(self.t, y, p)[half : 2 * half]
        return rates


class StateResult(HasInstant, Result):
    """Base of results about a steady state. system: the rod, with the loads of one time."""

    @property
    def _scaled_parameters(self) -> Collection[str]:
        """Parameters of the scaled load, whose size in the scene is not used."""
        return ()

    @cached_property
    def inactive_loads(self) -> tuple[str, ...]:
        """Keys of the loads that are zero at t, but not at another time of the span."""
        scene = self.system.source
        times = _sample_times(scene)
        return tuple(
            scene.key_of(name)
            for name, e in scene.time_dependent_loads.items()
            if name in scene.loads.parameters
            and name not in self._scaled_parameters
            and float(e(self.t)) == 0
            and np.any(np.asarray(e(times)) != 0)
        )

    @property
    def _instant_text(self) -> str:
        scene, quiet = self.system.source, self.inactive_loads
        masses = " and masses" * bool(scene.distribution.changing_masses)
        words = f"loads{masses} as at t = {self.t:g} s"
        if self.t == scene.integrate.span[0]:
            words += ", the start of the span"
        if scene.structure.has_moving_base:
            words += "; of the base its place and the acceleration of joint 0 then, not its speed"
        if not quiet:
            return words
        verb = "is" if len(quiet) == 1 else "are"
        return f"{words}, where {' and '.join(quiet)} {verb} 0, but not at all times"


def _sample_times(scene: Scene) -> Array:
    """Times of the span [s], dense enough that no load acts between two of them alone."""
    start, end = scene.integrate.span
    ends = np.array([start, *scene.breaks(), end])
    peaks = [peak for _, peak, _ in scene.time_laws.pulses()]
    return np.concatenate((np.linspace(start, end, TIMES), (ends[1:] + ends[:-1]) / 2, peaks))
