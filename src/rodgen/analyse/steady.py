"""The state about which a scene is linearised: at rest, or straight and steadily accelerating,
with the speed that a free rod has along its axis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from rodgen.analyse.balance import free_ways
from rodgen.analyse.pencil import Cells, Dense, Pencil, forces, product
from rodgen.analyse.settle import settle
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.model.term import DRAG
from rodgen.model.terms import TERMS
from rodgen.result import Note, doubt, remarks

STEADY = 1e-9  # of the accelerations that the joint forces would cause: rounding
STRAIGHT = 1e-12  # rad
AT_REST = 2.0**-100  # m/s; a power of 2 rounds nothing
TURNS = "phi", "omega"  # sensors of a link, not of a place
ASKEW = 5.0  # degrees between the velocity and the axis, up to which a rod flies along it


@dataclass(frozen=True)
class Steady:
    """A state in which no angle changes; p: parameters of the module."""

    rod: SteadyRod
    at: Unknowns
    p: Array

    @property
    def y(self) -> Array:
        """The state (states,), without velocities."""
        return self.rod.at_rest(self.at)

    @property
    def phi(self) -> Array:
        """Angles of the moving links (cells,) [rad]."""
        return self.at.phi

    @property
    def force(self) -> Array:
        """In the joints before them over the mass of a link (cells, 2) [m/s^2]."""
        return self.at.force

    @property
    def straight(self) -> bool:
        """Whether all links have the direction of the clamp, or one and the same."""
        return bool(np.abs(self.phi - self.rod.straight).max() <= STRAIGHT)

    @property
    def kinked(self) -> bool:
        """Whether a load that acts has no linear part about a rest that is bent."""
        places = self.rod.scene.structure.places
        for term in map(TERMS.__getitem__, self.rod.scene.loads.terms):
            place = places.get(term.parameters[0].name) if term.kinked else slice(0)
            if place is None or self.p[place].any():  # a law has no place in p
                return True
        return False

    @property
    def words(self) -> str:
        """What the state is, for a reader."""
        if self.rod.anchored or not self.rod.base:
            if self._driven:
                return "straight, steadily accelerating"
            return "straight, at rest" if self.straight else "static equilibrium"
        _, force = forces(replace(self.rod, speed=0.0), self.at, self.p)
        pushed, speed = np.abs(force).max(initial=0.0) > 0, self.rod.speed
        if not speed:
            return f"straight, {'steadily accelerating' if pushed else 'at rest or falling freely'}"
        flies = f"flying at {abs(speed):.6g} m/s{' tail first' * (speed < 0)}"
        return f"straight, {flies}{' and accelerating' * bool(pushed)}"

    @property
    def _driven(self) -> bool:
        """Whether loads accelerate an anchored rod in a direction in which nothing holds it."""
        if not self.rod.base:
            return False
        free = free_ways(self.rod, self.at, self.p)
        gained = np.abs(free @ self.rod.rates(self.y, self.p)[:2]).max(initial=0.0)
        return bool(gained > STEADY * np.abs(self.force).max(initial=0.0))

    @property
    def notes(self) -> tuple[Note, ...]:
        """What a reader has to know of the speed, where it counts: nothing for a rod that is held,
        and where no load depends on it."""
        rod = self.rod
        if not (has_drag(rod) and rod.scene.hold.translates):
            return ()
        if self.kinked and not (rod.speed or rod.across):
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

    @cached_property
    def turns_freely(self) -> bool:
        """Whether turning the whole rod makes no moment: a rigid-body motion of frequency zero.
        Its loads turn with it, or there are none."""
        if self.rod.anchored or self.rod.steered:
            return False
        here = self.cells
        # Row by row, for a soft spring counts beside a hard one.
        angles = np.abs(here.by_angle).sum(axis=0)
        pulls = np.abs(here.by_unknown[..., 1:]).sum(axis=(0, 3))
        sizes = angles + pulls * np.abs(self.force).max(initial=0.0)
        if self.rod.speed:
            sizes += np.abs(self._drag_across).sum(axis=(0, 3)) * abs(self.rod.speed)
        made = product(Pencil.of(here).S0, self.turning).reshape(sizes.shape)
        return bool((np.abs(made) <= STEADY * sizes).all())

    @property
    def turning(self) -> Array:
        """Columns of a pencil (3 cells,) for turning the whole rod, joint forces with it."""
        across = self.force @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        return np.column_stack((np.ones(len(self.phi)), across)).ravel()

    @cached_property
    def cells(self) -> Cells:
        return Cells.at(self.rod, self.at, self.p)

    def pencil(self) -> Pencil:
        """The equations linearised here, without what follows the velocities of the joints."""
        return Pencil.of(self.cells)

    @cached_property
    def _drag_across(self) -> Array:
        """How drag follows the velocities of the joints (2, cells, 3, 2) where the rod moves across
        itself as fast as it flies: a measure of what is small."""
        return Cells.across(self.rod, self.at, self.p).by_velocity

    @property
    def follows_velocity(self) -> bool:
        """Whether drag answers a small velocity of a joint, to first order, by more than a force
        along the straight rod, which does not act on small motions across it."""
        rod = self.rod
        if is_kinked(rod) and not rod.speed:
            return True
        if not (has_drag(rod) and rod.speed):
            return bool(self.cells.by_velocity.any())
        c, s = np.cos(self.phi[0]), np.sin(self.phi[0])
        felt, all_of_it = (
            np.stack((D[..., 0, :], D[..., 2, :] * c - D[..., 1, :] * s))
            for D in (self.cells.by_velocity, self._drag_across)
        )
        sizes = np.abs(all_of_it).max(axis=(1, 2, 3), keepdims=True)
        return bool((np.abs(felt) > STEADY * sizes).any())

    def dense(self, whole: bool = False, smooth: bool = False) -> Dense:
        """The equations linearised here, with external damping, with what loads follow of the
        motion, and with added states.

        External damping of a joint is -c_ext s a m v with a the share of v across the rod: at rest
        it is linear for motions across the rod, where a = 1, while along a bent rod it has no
        linear part. Coordinates: the displacement of joint 0 across the rod, where it is free, and
        the angles; of a rod without drag whose loads follow the motion the angles alone where
        nothing follows joint 0, else, of one that springs hold, and where it is asked for (whole)
        x0 and y0 as well; then the added states. Raises AnalysisError for a bent rod with external
        damping, unless this is left out (smooth).
        """
        rod, y = self.rod, self.rod.flying(self.at)
        if self.kinked and not self.straight and not smooth:
            raise AnalysisError(
                "external damping has no linear part about a bent state (its force depends on the "
                "share of the velocity across the rod): leave out loads.external_damping"
            )
        base, half = rod.base, rod.base + rod.cells
        J, mass = rod.model.jac(rod.t, y, self.p), rod.model.mass_matrix(y, self.p)
        ways = np.eye(half)
        across = ways[:, base // 2 :].copy()
        if base:
            across[:2, 0] = -np.sin(self.phi[0]), np.cos(self.phi[0])
        if self.kinked and not (rod.speed or smooth):
            # At any speed across the rod, however small, that has the same derivative.
            moving = y.copy()
            moving[half : 2 * half] = AT_REST * (across[:, 0] if base else 1.0)
            J[:, half : 2 * half] = rod.model.jac(rod.t, moving, self.p)[:, half : 2 * half]
            if base:  # along the straight rod the share is none
                axis = np.array([np.cos(self.phi[0]), np.sin(self.phi[0])])
                moving[half : 2 * half] = 0.0
                moving[half : half + 2] = AT_REST * axis
                along = rod.model.jac(rod.t, moving, self.p)[:, half : half + 2] @ axis
                J[:, half : half + 2] += np.outer(along - J[:, half : half + 2] @ axis, axis)
        whole = whole or rod.anchored
        if not rod.anchored and (has_drag(rod) or not rod.steered):
            ways = across
        elif base and not (whole or self._follows_joint):
            inner = mass[base:, :base] @ np.linalg.solve(mass[:base, :base], mass[:base, base:])
            mass, ways = mass.copy(), ways[:, base:]
            mass[base:, base:] -= inner
            J[half : half + base] = 0.0
        return _closed(J, mass, ways)

    @property
    def _follows_joint(self) -> bool:
        """Whether loads or added states follow the place or the velocity of a joint, however large
        the loads are."""
        return any(one.what not in TURNS for one in self.rod.scene.structure.sensors)


def _closed(J: Array, mass: Array, ways: Array) -> Dense:
    """The equations of motions along ways (positions, k) with the Jacobian of all rates."""
    half = len(mass)
    rod, own = J[half : 2 * half], J[2 * half :]
    K, C, by_added = (
        -ways.T @ mass @ part
        for part in (rod[:, :half] @ ways, rod[:, half : 2 * half] @ ways, rod[:, 2 * half :])
    )
    M, added = ways.T @ mass @ ways, len(own)
    terms = np.abs(ways.T) @ np.abs(mass) @ np.abs(rod[:, :half] @ ways)
    if not added:
        return Dense(K, C, M, terms=terms)
    lower = -own[:, :half] @ ways, -own[:, half : 2 * half] @ ways
    return Dense(
        np.block([[K, by_added], [lower[0], -own[:, 2 * half :]]]),
        np.block([[C, np.zeros_like(by_added)], [lower[1], np.eye(added)]]),
        block_diag(M, np.zeros((added, added))),
        added,
        np.block([[terms, np.abs(by_added)], [np.abs(lower[0]), np.abs(own[:, 2 * half :])]]),
    )


def steady(rod: SteadyRod, start: Steady | None = None, p: Array | None = None) -> Steady:
    """The steady state; start: one under similar loads; p: parameters, by default those of the rod.

    Raises AnalysisError where there is none.
    """
    p = rod.system.p if p is None else p
    found, turning = straight_state(rod, p)
    if found is not None:
        return found
    if rod.scene.hold.translates and not rod.anchored:
        raise AnalysisError(
            "the free rod has no steady state to linearise about: straight and at rest, its links "
            f"turn with {turning:.3g} rad/s^2 (a load along the rod, or gravity "
            "alone, leaves it straight)"
        )
    rest, _ = settle(rod, p, start.at if start else None)
    return Steady(rod, rest.at, p)


def straight_state(rod: SteadyRod, p: Array) -> tuple[Steady | None, float]:
    """The straight rod under parameters p, None where it does not stay straight, and how fast its
    links begin to turn [rad/s^2]."""
    at = rod.beside_straight
    turning, force = forces(rod, at, p)
    scale = np.abs(force).max(initial=0.0) * rod.scene.rod.links / rod.scene.rod.length
    largest = float(np.abs(turning).max())
    if largest <= STEADY * scale and _settled(rod, at, p):
        return Steady(rod, at._replace(force=force), p), largest
    return None, largest


def _settled(rod: SteadyRod, at: Unknowns, p: Array) -> bool:
    """Whether joint 0 of a straight rod does not begin to move where springs hold it, in comparison
    with one that is a length away; where nothing does, the rod may be driven along itself."""
    if not (rod.base and rod.anchored):
        return True
    y = rod.at_rest(at)
    away = y.copy()
    away[:2] += rod.scene.rod.length
    free = free_ways(rod, at, p)
    held = np.eye(2) - free.T @ free
    here, there = (np.abs(held @ rod.rates(one, p)[:2]).max() for one in (y, away))
    return bool(here <= STEADY * there)


def has_drag(rod: SteadyRod) -> bool:
    """Whether a load follows the velocities of the joints."""
    return any(TERMS[term].kind == DRAG for term in rod.scene.loads.terms)


def is_kinked(rod: SteadyRod) -> bool:
    """Whether one of them has no linear part about a rest that is bent."""
    return any(TERMS[term].kinked for term in rod.scene.loads.terms)


def linearised(state: Steady) -> Pencil | Dense:
    """The equations linearised about a steady state, in O(n) where no velocity of a joint counts:
    without external damping, and in flight."""
    within = not (state.rod.base or has_drag(state.rod) or state.rod.steered)
    if state.rod.anchored and within:
        return Cells.at(state.rod, state.at, state.p).reduced()
    if state.rod.anchored or state.rod.steered:
        return state.dense()
    return state.dense() if state.follows_velocity else state.pencil()
