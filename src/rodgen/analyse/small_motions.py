"""Small motions about steady states: how many grow, and whether one oscillates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rodgen.analyse.eigenvalues import Complex, all_shapes, lowest_shapes
from rodgen.analyse.light_motions import light_motions, lowest_light_rate
from rodgen.analyse.load_family import RIGID
from rodgen.analyse.massless import regular_pencil
from rodgen.analyse.modal import (
    DIVERGENCE,
    FLUTTER,
    MOST_DENSE,
    ModalEquations,
    ModalMotions,
    NeutralMotions,
)
from rodgen.analyse.pencil import BlockPencil, DensePencil
from rodgen.analyse.steady_state import SteadyState, pencil_about
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

MODES = 24  # of the rod at the start of a branch, in which its motions are counted
REAL = 1e-6  # of the modulus: an imaginary part below it is rounding


class SmallMotions:
    """Small motions in a basis of the lowest modes of a steady state, or of all."""

    def __init__(self, start: SteadyState, every: bool = False, smooth: bool = False):
        """smooth: leave out what has no linear part, such as external damping of a bent rod."""
        self.start, self.smooth = start, smooth
        if start.rod.is_light:
            self.lowest = lowest_light_rate(self._linearise(start).to_dense(), start.inertia)
            return
        every = every or start.rod.n_moving <= MODES
        linear = self._linearise(start)
        self.added = start.rod.n_added_states
        self.dragged = isinstance(linear, DensePencil)
        squares, self.basis = _modes(start, linear, every)
        rates = np.sqrt(np.abs(squares))
        elastic = rates[rates > RIGID * rates.max(initial=0.0)]
        if not len(elastic):
            raise AnalysisError("nothing holds the rod in the state at which a branch begins")
        self.lowest = float(elastic.min())
        self.frequencies = np.maximum(rates, self.lowest)
        held = self.dragged or not start.rod.n_base
        self.rigid = 0.0 if held else RIGID * self.lowest

    def motions(self, state: SteadyState) -> ModalMotions:
        """Compute the motions about a state; those that move or turn the whole rod do not grow."""
        if state.rod.is_light:
            whole = self._linearise(state).to_dense()
            return light_motions(regular_pencil(whole, state.inertia), self.lowest)
        linear, basis = self._linearise(state), self.basis
        if isinstance(linear, BlockPencil) and self.start.has_free_rotation:
            basis = _without_turning(linear, basis)
        K, C, M = (part[None] for part in linear.project(basis).parts)
        modal = ModalEquations(K, C, M, self.frequencies, added=self.added)
        if self.dragged:
            modal = replace(modal, neutral=NeutralMotions.of(modal.first_order_matrices()))
        found = modal.motions()
        s, growth = found.s[0], found.growth[0]
        return ModalMotions(s, np.where(np.abs(s) <= self.rigid, 0.0, growth))

    def _linearise(self, state: SteadyState) -> BlockPencil | DensePencil:
        return pencil_about(state, self.smooth)

    def count_unstable(self, state: SteadyState) -> int:
        """Number of unstable directions: one of a motion that diverges, two of one that
        flutters."""
        return len(growing_eigenvalues(self.motions(state)))


def growing_eigenvalues(found: ModalMotions) -> Complex:
    """Eigenvalues that grow; with their conjugates for undamped motions, of which one of every pair
    is known."""
    s = found.s[found.growth > 0]
    turned = s[np.abs(s.imag) > REAL * np.abs(s)]
    if (turned.imag < 0).any() or not len(turned):
        return s
    return np.concatenate((s, turned.conj()))


def instability(state: SteadyState) -> str | None:
    """Kind of instability of a steady state: "divergence" if the motion that grows most does not
    oscillate, "flutter" if it does, "" if none grows. None where that was not looked at, beyond 200
    links, or is not known: external damping, which has no linear part about a bent rod, may
    stabilise or destabilise where loads can do work around a loop."""
    rod = state.rod
    if rod.n_moving > MOST_DENSE:
        return None
    smooth = state.has_kink and not state.is_straight
    found = SmallMotions(state, every=True, smooth=smooth).motions(state)
    grows = found.s[found.growth > 0]
    real = np.abs(grows.imag) <= REAL * np.abs(grows)
    # More damping stabilises no odd number of divergent motions, nor harms without a loop.
    if smooth and not (real.sum() % 2 or _is_conservative(state.dense_pencil(smooth=True))):
        return None
    if not len(grows):
        return ""
    return DIVERGENCE if real[np.argmax(grows.real)] or smooth else FLUTTER


def _is_conservative(linear: DensePencil) -> bool:
    """Whether the forces of a linear system do no work around a loop, and those that depend on
    rates add no energy: more damping then makes nothing unstable (Thomson, Tait and Chetaev)."""
    K, C, added = linear.S0, (linear.S1 + linear.S1.T) / 2, linear.added
    if added or np.abs(K - K.T).max() > REAL * np.abs(K).max():
        return False
    return not C.any() or bool(np.linalg.eigvalsh(C).min() >= -REAL * np.abs(C).max())


def _modes(
    start: SteadyState, linear: BlockPencil | DensePencil, every: bool
) -> tuple[Array, Array]:
    """Squared frequencies and shapes (coordinates, k), the slowest first."""
    if isinstance(linear, BlockPencil) and linear.n_moving > MOST_DENSE:
        return lowest_shapes(linear, MODES, start.free_rotation)
    squares, found = all_shapes(linear.to_dense())
    order = np.argsort(np.abs(squares), kind="stable")
    if isinstance(linear, BlockPencil):  # turning alone, which every load leaves as it is
        order = order[int(start.has_free_rotation) :]
    order = order[: None if every else MODES]
    return squares[order], found[:, order]


def _without_turning(linear: BlockPencil, basis: Array) -> Array:
    """Make shapes orthogonal to rigid rotation in the mass matrix. K and C do no work on it and it
    none on them, so that the other motions are found without it, in any basis."""
    turning = np.ones((linear.n_moving, 1))
    momenta = linear.eliminate_forces(turning)[2]
    return np.asarray(basis - turning @ (momenta.T @ basis) / momenta.sum())
