"""The state about which a scene is linearised: at rest, or straight and steadily accelerating."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodgen.analyse.branch import Rest
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.pencil import Cells, Dense, Pencil, forces
from rodgen.analyse.statics import settle
from rodgen.analyse.system import System
from rodgen.integrate.stepper import Array

STEADY = 1e-9  # of the accelerations that the joint forces would cause: rounding
STRAIGHT = 1e-12  # rad


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
        pushed = np.abs(self.force).max(initial=0.0) > 0
        return f"straight, {'steadily accelerating' if pushed else 'at rest or falling freely'}"

    @property
    def turns_freely(self) -> bool:
        """Whether turning the whole rod makes no moment: a rigid-body motion of frequency zero.
        Its loads turn with it, or there are none."""
        turned = Cells.at(self.system, self.phi + 1.0, _turned(self.force, 1.0), self.p)
        # Row by row, for a soft spring counts beside a hard one.
        angles = np.abs(turned.by_angle).sum(axis=0)
        pulls = np.abs(turned.by_unknown[..., 1:]).sum(axis=(0, 3))
        sizes = angles + pulls * np.abs(self.force).max(initial=0.0)
        return bool((np.abs(turned.residual) <= STEADY * sizes).all())

    @property
    def turning(self) -> Array:
        """Columns of a pencil (3 cells,) for turning the whole rod, joint forces with it."""
        across = self.force @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        return np.column_stack((np.ones(len(self.phi)), across)).ravel()

    def pencil(self) -> Pencil:
        """The equations linearised here, external damping left out."""
        return Pencil.of(Cells.at(self.system, self.phi, self.force, self.p))

    def dense(self) -> Dense:
        """The equations linearised here, external damping as it is for motions across the rod.

        The drag on a joint is -c_ext s a m v with a the share of v across the rod: for motions
        across it, a = 1 and the drag is linear, while along a bent rod it has no linear part.
        Coordinates: the displacement of joint 0 across the rod, where it is free, and the angles.
        Raises AnalysisError for a bent rod.
        """
        system = self.system
        if not self.straight:
            raise AnalysisError(
                "external damping has no linear part about a bent state (its force depends on the "
                "share of the velocity across the rod): leave out loads.external_damping"
            )
        y = system.at_rest(self.phi)
        half = len(y) // 2
        across = np.zeros((half, half - system.base // 2))
        across[system.base :, system.base // 2 :] = np.eye(system.cells)
        moving = y.copy()
        if system.base:
            angle = self.phi[0]
            across[:2, 0] = moving[half : half + 2] = -np.sin(angle), np.cos(angle)
        else:
            moving[half:] = 1.0
        by_state = system.model.jac(0.0, y, self.p)[half:, :half]
        # At any speed across the rod drag has the same derivative by the velocities.
        by_rate = system.model.jac(0.0, moving, self.p)[half:, half:]
        mass = system.model.mass_matrix(y, self.p)
        return Dense(*(across.T @ m @ across for m in (-mass @ by_state, -mass @ by_rate, mass)))


def _turned(force: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    turned: Array = force @ np.array([[c, s], [-s, c]])
    return turned


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
    """The equations linearised about a steady state, in O(n) where there is no external damping."""
    return state.dense() if has_drag(state.system) else state.pencil()
