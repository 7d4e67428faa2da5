"""The state about which a scene is linearised: at rest, or straight and steadily accelerating,
with the speed that a free rod has along its axis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rodgen.analyse.branch import Rest
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.pencil import Cells, Dense, Pencil, forces
from rodgen.analyse.statics import settle
from rodgen.analyse.system import System
from rodgen.integrate.stepper import Array

STEADY = 1e-9  # of the accelerations that the joint forces would cause: rounding
STRAIGHT = 1e-12  # rad
ASKEW = 5.0  # degrees between the velocity and the axis, up to which a rod flies along it


@dataclass(frozen=True)
class Steady:
    """A state in which no angle changes. phi: of the moving links (cells,) [rad]; force: in the
    joints before them over the mass of a link (cells, 2) [m/s^2]; p: parameters of the module."""

    system: System
    phi: Array
    force: Array
    p: Array

    @property
    def straight(self) -> bool:
        """Whether all links have the direction of the clamp, or one and the same."""
        return bool(np.abs(self.phi - self.system.straight).max() <= STRAIGHT)

    @property
    def words(self) -> str:
        """What the state is, for a reader."""
        if not self.system.scene.hold.translates:
            return "straight, at rest" if self.straight else "static equilibrium"
        _, force = forces(replace(self.system, speed=0.0), self.phi, self.p)
        pushed, speed = np.abs(force).max(initial=0.0) > 0, self.system.speed
        if not speed:
            return f"straight, {'steadily accelerating' if pushed else 'at rest or falling freely'}"
        flies = f"flying at {abs(speed):.6g} m/s{' tail first' * (speed < 0)}"
        return f"straight, {flies}{' and accelerating' * bool(pushed)}"

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader has to know of the speed, where it counts: nothing for a rod that is held,
        and where no load depends on it."""
        system = self.system
        if not (has_drag(system) and system.scene.hold.translates):
            return ()
        if not (system.speed or system.across):
            return (
                "linearised about a rod at rest, where external damping brakes small motions "
                "across it; of one that moves along its axis it brakes none (give a speed)",
            )
        angle = np.degrees(np.arctan2(abs(system.across), abs(system.speed)))
        if angle <= ASKEW:
            return ()
        return (
            f"the rod moves {angle:.3g} degrees away from its axis, which is no steady state: "
            "linearised as though it moved along its axis alone",
        )

    @property
    def turns_freely(self) -> bool:
        """Whether turning the whole rod makes no moment: a rigid-body motion of frequency zero.
        Its loads turn with it, or there are none."""
        here = self._cells
        # Row by row, for a soft spring counts beside a hard one.
        angles = np.abs(here.by_angle).sum(axis=0)
        pulls = np.abs(here.by_unknown[..., 1:]).sum(axis=(0, 3))
        sizes = angles + pulls * np.abs(self.force).max(initial=0.0)
        sizes += np.abs(self._drag_across).sum(axis=(0, 3)) * abs(self.system.speed)
        made = Pencil.of(here).product(0.0, self.turning).reshape(sizes.shape)
        return bool((np.abs(made) <= STEADY * sizes).all())

    @property
    def turning(self) -> Array:
        """Columns of a pencil (3 cells,) for turning the whole rod, joint forces with it."""
        across = self.force @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        return np.column_stack((np.ones(len(self.phi)), across)).ravel()

    @cached_property
    def _cells(self) -> Cells:
        return Cells.at(self.system, self.phi, self.force, self.p)

    def pencil(self) -> Pencil:
        """The equations linearised here, without what follows the velocities of the joints."""
        return Pencil.of(self._cells)

    @cached_property
    def _drag_across(self) -> Array:
        """How drag follows the velocities of the joints (2, cells, 3, 2) where the rod moves across
        itself as fast as it flies: a measure of what is small."""
        return Cells.across(self.system, self.phi, self.force, self.p).by_velocity

    @property
    def follows_velocity(self) -> bool:
        """Whether drag answers a small velocity of a joint, to first order, by more than a force
        along the straight rod, which does not act on small motions across it."""
        system = self.system
        if not (has_drag(system) and system.speed):
            return has_drag(system)
        c, s = np.cos(self.phi[0]), np.sin(self.phi[0])
        felt, all_of_it = (
            np.stack((D[..., 0, :], D[..., 2, :] * c - D[..., 1, :] * s))
            for D in (self._cells.by_velocity, self._drag_across)
        )
        sizes = np.abs(all_of_it).max(axis=(1, 2, 3), keepdims=True)
        return bool((np.abs(felt) > STEADY * sizes).any())

    def dense(self) -> Dense:
        """The equations linearised here, external damping with them.

        The drag on a joint is -c_ext s a m v with a the share of v across the rod: at rest it is
        linear for motions across the rod, where a = 1, while along a bent rod it has no linear
        part. Coordinates: the displacement of joint 0 across the rod, where it is free, and the
        angles. Raises AnalysisError for a bent rod.
        """
        system = self.system
        if not self.straight:
            raise AnalysisError(
                "external damping has no linear part about a bent state (its force depends on the "
                "share of the velocity across the rod): leave out loads.external_damping"
            )
        y = system.flying(self.phi)
        half = len(y) // 2
        across = np.zeros((half, half - system.base // 2))
        across[system.base :, system.base // 2 :] = np.eye(system.cells)
        moving = y.copy()
        if system.base:
            across[:2, 0] = -np.sin(self.phi[0]), np.cos(self.phi[0])
        if not system.speed:
            # At any speed across the rod drag has the same derivative by the velocities.
            moving[half:] = across[:, 0] if system.base else 1.0
        by_state = system.model.jac(0.0, y, self.p)[half:, :half]
        by_rate = system.model.jac(0.0, moving, self.p)[half:, half:]
        mass = system.model.mass_matrix(y, self.p)
        return Dense(*(across.T @ m @ across for m in (-mass @ by_state, -mass @ by_rate, mass)))


def steady(system: System, start: Steady | None = None, **changes: float) -> Steady:
    """The steady state with other values for some parameters; start: one under similar loads.

    Raises AnalysisError where there is none.
    """
    given = system.given | changes
    p = system.parameters(**changes)
    turning, force = forces(system, system.straight, p)
    scale = np.abs(force).max(initial=0.0) * system.scene.rod.links / system.scene.rod.length
    if np.abs(turning).max() <= STEADY * scale:
        return Steady(system, system.straight, force, p)
    if system.scene.hold.translates:
        raise AnalysisError(
            "the free rod has no steady state to linearise about: straight and at rest, its links "
            f"turn with {np.abs(turning).max():.3g} rad/s^2 (a load along the rod, or gravity "
            "alone, leaves it straight)"
        )
    rest, _ = settle(system, given, Rest(start.phi, start.force) if start else None)
    return Steady(system, rest.phi, rest.force, p)


def has_drag(system: System) -> bool:
    """Whether external damping is among the terms."""
    return "external_damping" in system.scene.structure.terms


def linearised(state: Steady) -> Pencil | Dense:
    """The equations linearised about a steady state, in O(n) where no velocity of a joint counts:
    without external damping, and in flight."""
    return state.dense() if state.follows_velocity else state.pencil()
