"""Steady states, about which a scene is linearised: at rest, or straight and steadily accelerating,
with the speed that a free rod has along its axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from rodgen.analyse.equilibrium_equations import DenseBalance, free_directions
from rodgen.analyse.equilibrium_search import find_equilibrium
from rodgen.analyse.pencil import BlockPencil, DensePencil, ImplicitBlocks, joint_forces, product
from rodgen.analyse.steady_rod import STRAIGHT, SteadyRod, Unknowns
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.integrate.air_doubts import air_doubts
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.weights import falls_of
from rodgen.model.terms import TERMS
from rodgen.result import Note, doubt, remarks
from rodgen.system import System

STEADY = 1e-9  # of the accelerations that the joint forces would cause: rounding
ROUNDING = 2.0**-48  # of angles, relative to them: that of a shape at rest
AT_REST = 2.0**-100  # m/s; a power of 2 rounds nothing
TURNS = "phi", "omega"  # sensors of a link, not of a place
ASKEW = 5.0  # degrees between the velocity and the axis, up to which a rod flies along it


@dataclass(frozen=True)
class SteadyState:
    """A state in which no angle changes; p: parameters of the module."""

    rod: SteadyRod
    at: Unknowns
    p: Array

    @property
    def y(self) -> Array:
        """State (states,), without velocities."""
        return self.rod.state_at_rest(self.at)

    @property
    def phi(self) -> Array:
        """Angles of the moving links (n_moving,) [rad]."""
        return self.at.phi

    @property
    def joint_forces(self) -> Array:
        """Forces in joints before moving links, over the mass of a link (n_moving, 2) [m/s^2]."""
        return self.at.force

    @property
    def is_straight(self) -> bool:
        """Whether all links have the direction of the clamp, or one and the same."""
        return self.rod.is_straight and self.has_rest_shape

    @property
    def has_rest_shape(self) -> bool:
        """Whether the rod has the shape that it has without load."""
        return bool(np.abs(self.phi - self.rod.unloaded_angles).max() <= STRAIGHT)

    @property
    def has_kink(self) -> bool:
        """Whether a load that acts has no linear part about a bent state at rest."""
        return any(kinked_loads(self.rod.system, self.p))

    @property
    def description(self) -> str:
        """Description of the state for a reader."""
        if self.rod.has_supports or not self.rod.n_base:
            if self._is_driven:
                return f"{self._shape}, steadily accelerating"
            return f"{self._shape}, at rest" if self.has_rest_shape else "static equilibrium"
        pushed, speed = self._is_pushed, self.rod.speed
        if not speed:
            moves = "steadily accelerating" if pushed else "at rest or falling freely"
            return f"{self._shape}, {moves}"
        flies = f"flying at {abs(speed):.6g} m/s{' tail first' * (speed < 0)}"
        return f"{self._shape}, {flies}{' and accelerating' * bool(pushed)}"

    @property
    def _is_pushed(self) -> bool:
        """Whether loads push a free rod, other than its weight."""
        if self.rod.is_light:
            forces = self.rod.model.forces(self.rod.t, self.y, self.p).values()
            return any(force.any() for force in forces)
        _, force = joint_forces(replace(self.rod, speed=0.0), self.at, self.p)
        return bool(np.abs(force).max(initial=0.0) > 0)

    @property
    def _shape(self) -> str:
        return "straight" if self.rod.is_straight else "bent as without load"

    @property
    def _is_driven(self) -> bool:
        """Whether loads accelerate an anchored rod in a direction in which nothing holds it."""
        if not self.rod.n_base:
            return False
        free = free_directions(self.rod, self.at, self.p)
        gained = np.abs(free @ self.rod.start_acceleration(self.y, self.p)).max(initial=0.0)
        return bool(gained > STEADY * np.abs(self.joint_forces).max(initial=0.0))

    @property
    def notes(self) -> tuple[Note, ...]:
        """Notes about the speed; none for a rod that is held, and where no load depends on the
        speed."""
        rod, own = self.rod, tuple[Note, ...]()
        if has_drag(rod) and rod.scene.boundary_condition.translates:
            own = self._velocity_notes
        return (*own, *air_doubts(rod.scene, self._motion))

    @property
    def _motion(self) -> MotionSlice:
        """The rod as it flies, or stands still."""
        y, t = self.rod.state_in_flight(self.at), np.asarray(self.rod.t)
        if self.rod.n_base:
            y[:2] = self.rod.system.y0[:2]
        return MotionSlice(self.rod.model, self.p, y, t)

    @cached_property
    def airspeed(self) -> float:
        """Speed along the axis, nose first, against the medium whose loads depend on it [m/s]."""
        rows = (row for row in self.rod.scene.structure.load_rows.values() if row.follows_velocity)
        winds = ([one for one in row.parameters if one.key == "wind"] for row in rows)
        first = next((wind for wind in winds if wind), [])
        axis = np.cos(self.phi[0]), np.sin(self.phi[0])
        blown = (self._motion.values(one.name) * axis[one.part or 0] for one in first)
        return self.rod.speed + float(sum(blown))

    @property
    def _velocity_notes(self) -> tuple[Note, ...]:
        """Notes about the direction of the speed."""
        rod = self.rod
        if self.has_kink and not (rod.speed or rod.across):
            text = (
                "linearised about a rod at rest, where external damping brakes small motions "
                "across it; of one that moves along its axis it brakes none (give a speed)"
            )
            return remarks((text,))
        angle = np.degrees(np.arctan2(abs(rod.across), abs(rod.speed)))
        if angle <= ASKEW:
            return ()
        text = (
            f"the rod moves {angle:.3g} degrees away from its axis, which is no steady state: "
            "linearised as though it moved along its axis alone"
        )
        return (doubt(text, degrees=float(angle)),)

    @property
    def inertia(self) -> float:
        """Largest entry of the mass matrix [kg, kg m, kg m^2]."""
        return float(np.abs(self.rod.model.mass_matrix(self.y, self.p)).max())

    @cached_property
    def has_free_rotation(self) -> bool:
        """Whether no moment resists rotation of the whole rod, a rigid-body motion of frequency
        zero. Its loads turn with it, or there are none."""
        if self.rod.has_supports or self.rod.has_feedback:
            return False
        if self.rod.is_light:
            return self._light_rod_turns
        here = self.implicit_blocks
        # Row by row, for a soft spring counts beside a hard one.
        angles = np.abs(here.by_angle).sum(axis=0)
        pulls = np.abs(here.by_unknown[..., 1:]).sum(axis=(0, 3))
        sizes = angles + pulls * np.abs(self.joint_forces).max(initial=0.0)
        if self.rod.speed:
            sizes += np.abs(self._sideways_drag).sum(axis=(0, 3)) * abs(self.rod.speed)
        made = product(BlockPencil.of(here).S0, self.rigid_rotation).reshape(sizes.shape)
        return bool((np.abs(made) <= STEADY * sizes).all())

    @property
    def _light_rod_turns(self) -> bool:
        """Whether turning all links by one angle changes no force, in the frame of joint 0."""
        rod, slope = self.rod, self._slope(self.rod.state_in_flight(self.at))
        base, half = rod.n_base, rod.n_base + rod.n_moving
        by_angle = slope[:half, base:half]
        rows = by_angle[base:]
        if base:  # all of the rod moves along
            mass = rod.model.mass_matrix(self.y, self.p)
            rows = rows - mass[base:, :base] @ by_angle[:base] / mass[0, 0]
        return bool(np.abs(rows.sum(axis=1)).max() <= STEADY * np.abs(rows).sum(axis=1).max())

    @property
    def free_rotation(self) -> Array | None:
        """Rigid rotation, where it is free; else None."""
        return self.rigid_rotation if self.has_free_rotation else None

    @property
    def rigid_rotation(self) -> Array:
        """Rigid rotation as a vector of a pencil (3 n_moving,), with joint forces turned too."""
        across = self.joint_forces @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        return np.column_stack((np.ones(len(self.phi)), across)).ravel()

    @cached_property
    def implicit_blocks(self) -> ImplicitBlocks:
        return ImplicitBlocks.at(self.rod, self.at, self.p)

    def pencil(self) -> BlockPencil:
        """Linearised equations, without terms of the velocities of the joints."""
        return BlockPencil.of(self.implicit_blocks)

    @cached_property
    def _sideways_drag(self) -> Array:
        """Derivatives of drag by velocities of the joints (2, n_moving, 3, 2) where the rod moves
        sideways as fast as it flies: a measure of what is small."""
        return ImplicitBlocks.in_sideways_flight(self.rod, self.at, self.p).by_velocity

    @property
    def has_velocity_terms(self) -> bool:
        """Whether drag depends on small velocities of the joints to first order, by more than a
        force along the straight rod, which does not act on small motions across it."""
        rod = self.rod
        if any(TERMS[term].kinked for term in rod.scene.loads.terms) and not rod.speed:
            return True
        if not (has_drag(rod) and rod.speed):
            return bool(self.implicit_blocks.by_velocity.any())
        c, s = np.cos(self.phi[0]), np.sin(self.phi[0])
        felt, all_of_it = (
            np.stack((D[..., 0, :], D[..., 2, :] * c - D[..., 1, :] * s))
            for D in (self.implicit_blocks.by_velocity, self._sideways_drag)
        )
        sizes = np.abs(all_of_it).max(axis=(1, 2, 3), keepdims=True)
        return bool((np.abs(felt) > STEADY * sizes).any())

    def dense_pencil(
        self, whole: bool = False, smooth: bool = False, angles: bool = False
    ) -> DensePencil:
        """Dense linearised equations, with external damping, with loads that depend on the motion,
        and with added states.

        External damping of a joint is -c_ext s a m v with a the share of v across the rod: at rest
        it is linear for motions across the rod, where a = 1, while along a bent rod it has no
        linear part. Coordinates: the displacement of a free joint 0 across the rod, the angles, the
        added states. With supports, or loads that depend on the motion and no drag, joint 0 has x0
        and y0 if something depends on it or they are asked for (whole), and else none. Raises
        AnalysisError for a bent rod with external damping, unless this is left out (smooth).
        """
        rod, y = self.rod, self.rod.state_in_flight(self.at)
        if self.has_kink and not self.is_straight and not smooth:
            raise AnalysisError(
                "external damping has no linear part about a bent state (its force depends on the "
                "share of the velocity across the rod): leave out loads.external_damping"
            )
        base, half = rod.n_base, rod.n_base + rod.n_moving
        slope, mass = self._slope(y), rod.model.mass_matrix(y, self.p)
        ways = np.eye(half)
        across = ways[:, base // 2 :].copy()
        if base:
            across[:2, 0] = -np.sin(self.phi[0]), np.cos(self.phi[0])
        if self.has_kink and not (rod.speed or smooth):
            # At any speed across the rod, however small, that has the same derivative.
            moving = y.copy()
            moving[half : 2 * half] = AT_REST * (across[:, 0] if base else 1.0)
            slope[:, half : 2 * half] = self._slope(moving)[:, half : 2 * half]
            if base:  # along the straight rod the share is none
                axis = np.array([np.cos(self.phi[0]), np.sin(self.phi[0])])
                moving[half : 2 * half] = 0.0
                moving[half : half + 2] = AT_REST * axis
                along = self._slope(moving)[:, half : half + 2] @ axis
                slope[:, half : half + 2] += np.outer(
                    along - slope[:, half : half + 2] @ axis, axis
                )
        bent = has_drag(rod) and not self.is_straight
        whole = whole or rod.has_supports or bent
        flying = has_drag(rod) or not (rod.has_feedback or angles)
        if not (rod.has_supports or bent) and flying:
            ways = across
        elif base and not (whole or self._has_joint_sensors):
            lean = np.linalg.solve(mass[:base, :base], mass[:base, base:]).T
            mass, ways = mass.copy(), ways[:, base:]
            mass[base:, base:] -= lean @ mass[:base, base:]
            slope[base:half] -= lean @ slope[:base]
        if base and has_drag(rod) and ways is across and self.airspeed:
            # Of a rod that gets faster in its direction of flight, the centre does across, too.
            moved = mass[:, :2] @ mass[:2] / mass[0, 0]
            slope[:half, half : 2 * half] -= self.speed_growth * moved
        return _project_forces(slope, mass, ways)

    @property
    def turns_with_path(self) -> bool:
        """Whether a straight rod in flight that is turned together with its path is left so, by
        loads that depend on its speed."""
        rod = self.rod
        held = not rod.n_base or rod.has_supports
        if held or not (has_drag(rod) and self.is_straight and self.airspeed):
            return False
        linear = self.dense_pencil()
        angles, moves = slice(1, linear.size - linear.added), linear.S1[:, 0] * self.airspeed
        turned, sizes = linear.S0[:, angles], np.abs(linear.S0[:, angles]).sum(axis=1)
        off = np.abs(turned.sum(axis=1) - moves) + np.abs(linear.S0[:, 0]) * rod.scene.rod.length
        return bool((off <= STEADY * (sizes + np.abs(moves))).all())

    @property
    def speed_growth(self) -> float:
        """Growth of the airspeed by the loads, without what falls freely, over itself [1/s]."""
        falls = falls_of(self._motion, self.rod.scene.structure.terms).values()
        felt = self._common_acceleration - sum(falls, np.zeros(2))
        return float(-felt @ (np.cos(self.phi[0]), np.sin(self.phi[0]))) / self.airspeed

    def _slope(self, y: Array) -> Array:
        """Derivatives by the state of generalised forces and rates of added states, in the frame in
        which joint 0 rests."""
        rod = self.rod
        if not rod.n_base:
            return rod.balance(y, self.p)[1]
        return rod.balance(y, self.p, self._common_acceleration)[1]

    @cached_property
    def _common_acceleration(self) -> Array:
        """Acceleration (2,) of all of a rod with free joint 0, as no link turns [m/s^2]."""
        return self.rod.start_acceleration(self.rod.state_in_flight(self.at), self.p)

    @property
    def _has_joint_sensors(self) -> bool:
        """Whether loads or added states depend on the place or the velocity of a joint, however
        large the loads are."""
        return any(one.what not in TURNS for one in self.rod.scene.structure.sensors)


def _project_forces(slope: Array, mass: Array, ways: Array) -> DensePencil:
    """Project derivatives of generalised forces and rates of added states on motions along ways
    (positions, k): a dense pencil."""
    half = len(mass)
    rod, own = slope[:half], slope[half:]
    K, C, by_added = (
        -ways.T @ part
        for part in (rod[:, :half] @ ways, rod[:, half : 2 * half] @ ways, rod[:, 2 * half :])
    )
    M, added = ways.T @ mass @ ways, len(own)
    if not added:
        return DensePencil(K, C, M)
    lower = -own[:, :half] @ ways, -own[:, half : 2 * half] @ ways
    return DensePencil(
        np.block([[K, by_added], [lower[0], -own[:, 2 * half :]]]),
        np.block([[C, np.zeros_like(by_added)], [lower[1], np.eye(added)]]),
        scipy.linalg.block_diag(M, np.zeros((added, added))),
        added,
    )


def find_steady_state(
    rod: SteadyRod, start: SteadyState | None = None, p: Array | None = None
) -> SteadyState:
    """Find the steady state; start: one under similar loads; p: parameters, by default the rod's.

    Raises AnalysisError where there is none.
    """
    p = rod.system.p if p is None else p
    found, turning = unloaded_state(rod, p)
    if found is not None:
        return found
    if rod.scene.boundary_condition.translates and not rod.has_supports:
        raise AnalysisError(
            "the free rod has no steady state to linearise about: in its shape without load, its "
            f"links turn with {turning:.3g} rad/s^2 (a load along a straight rod, or gravity "
            f"alone, leaves it so{_hint_of_wind(rod)})"
        )
    rest, _ = find_equilibrium(rod, p, start.at if start else None)
    return SteadyState(rod, rest.at, p)


def _hint_of_wind(rod: SteadyRod) -> str:
    """Words on a wind that blows on a rod; none without one."""
    if rod.scene.air is None or rod.scene.air.wind is None:
        return ""
    return "; a wind across it does not: leave out air.wind"


def unloaded_state(rod: SteadyRod, p: Array) -> tuple[SteadyState | None, float]:
    """Return the steady state under parameters p in the shape without load, None where the rod does
    not keep that, and the largest angular acceleration of its links [rad/s^2]."""
    at = rod.unloaded_unknowns
    if rod.is_light:
        return _unloaded_light_state(rod, at, p)
    turning, force = joint_forces(rod, at, p)
    shortest = float(rod.scene.mesh.lengths(rod.scene.rod.length).min())
    scale = np.abs(force).max(initial=0.0) / shortest
    largest = float(np.abs(turning).max())
    most = STEADY * scale + _turning_by_rounding(rod, at, p)
    if largest <= most and _is_joint_at_rest(rod, at, p):
        return SteadyState(rod, at._replace(force=force), p), largest
    return None, largest


def _unloaded_light_state(
    rod: SteadyRod, at: Unknowns, p: Array
) -> tuple[SteadyState | None, float]:
    """Do that by generalised forces, for a rod without mass: they turn no link by more than a
    straight one may be bent."""
    state = SteadyState(rod, at, p)
    frame = (state._common_acceleration,) if rod.n_base and not rod.has_supports else ()
    force, slope = rod.balance(rod.state_in_flight(at), p, *frame)
    base, half = rod.n_base, rod.n_base + rod.n_moving
    largest = float(np.abs(force[base:half]).max())
    resisted = float(np.abs(slope[base:half, base:half]).sum(axis=1).max())
    still = largest <= STRAIGHT * resisted + _turning_by_rounding(rod, at, p)
    return (state if still and _is_joint_at_rest(rod, at, p) else None), largest


def _turning_by_rounding(rod: SteadyRod, at: Unknowns, p: Array) -> float:
    """Angular acceleration by what is rounded of the angles of springs that are bent at rest
    [rad/s^2]; springs of a straight rod have none."""
    if rod.is_straight:
        return 0.0
    if rod.is_light:
        slope = rod.balance(rod.state_at_rest(at), p)[1]
        return float(ROUNDING * np.abs(slope).max() * np.abs(at.phi).max())
    resisting = np.abs(ImplicitBlocks.at(rod, at, p).by_angle[..., 0]).sum(axis=0).max()
    return float(ROUNDING * resisting * np.abs(at.phi).max())


def _is_joint_at_rest(rod: SteadyRod, at: Unknowns, p: Array) -> bool:
    """Whether springs hold joint 0 of a straight rod at rest, in comparison with one that is a
    length away; in directions in which nothing holds it, the rod may accelerate."""
    if not (rod.n_base and rod.has_supports):
        return True
    y = rod.state_at_rest(at)
    away = y.copy()
    away[:2] += rod.scene.rod.length
    free = free_directions(rod, at, p)
    held = np.eye(2) - free.T @ free
    here, there = (np.abs(held @ rod.start_acceleration(one, p)).max() for one in (y, away))
    return bool(here <= STEADY * there)


def kinked_loads(system: System, p: Array) -> Iterator[str]:
    """Yield the names of the loads that act and have no linear part about a state at rest."""
    places = system.structure.slices
    for term in map(TERMS.__getitem__, system.load_terms):
        place = places.get(term.parameters[0].name) if term.kinked else slice(0)
        if place is None or p[place].any():  # a law has no place in p
            yield term.name


def has_drag(rod: SteadyRod) -> bool:
    """Whether a load depends on the velocities of joints or points."""
    return any(TERMS[term].follows_velocity for term in rod.scene.loads.terms)


def _light_pencil(state: SteadyState, smooth: bool) -> DensePencil:
    """Dense pencil of a rod with links without mass; where it flies or turns as a whole, without
    these motions."""
    rod = state.rod
    if rod.n_base and rod.has_supports and not state.has_kink:
        return DenseBalance(rod, state.y, state.p, 0.0).dense_pencil(damped=True)
    if rod.has_supports or rod.has_feedback or has_drag(rod):
        return state.dense_pencil(smooth=smooth)
    dense = state.dense_pencil(smooth=smooth, angles=True)
    if not state.has_free_rotation:
        return dense
    # Motions orthogonal to M turn are without turning, of a rod that turns freely.
    basis = scipy.linalg.null_space((dense.S2 @ np.ones(dense.size))[None])
    return replace(dense.project(basis), bend=basis.T @ np.linspace(0.0, 1.0, dense.size))


def pencil_about(state: SteadyState, smooth: bool = False) -> BlockPencil | DensePencil:
    """Linearise about a steady state; in O(n) where no velocity of a joint counts, as without
    external damping. With links without mass the equations are dense, with a singular mass
    matrix."""
    if state.rod.is_light:
        return _light_pencil(state, smooth)
    if smooth or state.rod.has_supports or state.rod.has_feedback:
        return state.dense_pencil(smooth=smooth)
    return state.dense_pencil() if state.has_velocity_terms else state.pencil()
