"""Small motions about steady states: how many grow, and whether one oscillates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rodgen.analyse.eigen import Complex, all_shapes, lowest_shapes
from rodgen.analyse.family import RIGID
from rodgen.analyse.modal import DIVERGENCE, FLUTTER, MOST_DENSE, Modal, Motions
from rodgen.analyse.neutral import Neutral
from rodgen.analyse.pencil import Dense, Pencil
from rodgen.analyse.steady import Steady, linearised
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

MODES = 24  # of the rod at the start of a branch, in which its motions are counted
REAL = 1e-6  # of the modulus: an imaginary part below it is rounding


class Growing:
    """Small motions in the lowest modes of a steady state, or in all of them."""

    def __init__(self, start: Steady, every: bool = False, smooth: bool = False):
        """smooth: without what has no linear part, such as external damping of a bent rod."""
        self.start, self.smooth = start, smooth
        every = every or start.rod.cells <= MODES
        linear = self._linear(start)
        self.added = len(start.rod.scene.states)
        self.dragged = isinstance(linear, Dense)
        squares, self.basis = _modes(start, linear, every)
        rates = np.sqrt(np.abs(squares))
        elastic = rates[rates > RIGID * rates.max(initial=0.0)]
        if not len(elastic):
            raise AnalysisError("nothing holds the rod in the state at which a branch begins")
        self.lowest = float(elastic.min())
        self.frequencies = np.maximum(rates, self.lowest)
        held = self.dragged or not start.rod.base
        self.rigid = 0.0 if held else RIGID * self.lowest

    def motions(self, state: Steady) -> Motions:
        """The motions about a state; those that move or turn the whole rod do not grow."""
        linear, basis = self._linear(state), self.basis
        if isinstance(linear, Pencil) and self.start.turns_freely:
            basis = _without_turning(linear, basis)
        K, C, M = (part[None] for part in linear.on(basis).parts)
        modal = Modal(K, C, M, self.frequencies, added=self.added)
        if self.dragged:
            modal = replace(modal, neutral=Neutral.of(modal.by_rates()))
        found = modal.motions()
        s, growth = found.s[0], found.growth[0]
        return Motions(s, np.where(np.abs(s) <= self.rigid, 0.0, growth))

    def _linear(self, state: Steady) -> Pencil | Dense:
        return state.dense(smooth=True) if self.smooth else linearised(state)

    def count(self, state: Steady) -> int:
        """How many directions are unstable: one of a motion that diverges, two of one that
        flutters."""
        return len(grown(self.motions(state)))


def grown(found: Motions) -> Complex:
    """The eigenvalues that grow; of undamped motions, of which one of every pair is known, with
    their conjugates."""
    s = found.s[found.growth > 0]
    turned = s[np.abs(s.imag) > REAL * np.abs(s)]
    if (turned.imag < 0).any() or not len(turned):
        return s
    return np.concatenate((s, turned.conj()))


def instability(state: Steady) -> str | None:
    """What small motions about a steady state do: "divergence" if that which grows most does not
    oscillate, "flutter" if it does, "" if none grows. None where that was not looked at, beyond 200
    links, or is not known: external damping, which has no linear part about a bent rod, may heal or
    harm where loads can do work around a loop."""
    rod = state.rod
    if rod.cells > MOST_DENSE:
        return None
    smooth = state.kinked and not state.straight
    found = Growing(state, every=True, smooth=smooth).motions(state)
    grows = found.s[found.growth > 0]
    real = np.abs(grows.imag) <= REAL * np.abs(grows)
    # More damping heals no odd number of motions that diverge, nor harms without a loop.
    if smooth and not (real.sum() % 2 or _conservative(state.dense(smooth=True))):
        return None
    if not len(grows):
        return ""
    return DIVERGENCE if real[np.argmax(grows.real)] or smooth else FLUTTER


def _conservative(linear: Dense) -> bool:
    """Whether the forces of a linear system do no work around a loop, and none that follow rates
    add to its energy: more damping then makes nothing unstable (Thomson, Tait and Chetaev)."""
    K, C, added = linear.K, (linear.C + linear.C.T) / 2, linear.added
    if added or np.abs(K - K.T).max() > REAL * np.abs(K).max():
        return False
    return not C.any() or bool(np.linalg.eigvalsh(C).min() >= -REAL * np.abs(C).max())


def _modes(start: Steady, linear: Pencil | Dense, every: bool) -> tuple[Array, Array]:
    """Squared frequencies and shapes (coordinates, k), the slowest first."""
    if isinstance(linear, Pencil) and linear.cells > MOST_DENSE:
        return lowest_shapes(linear, MODES, start.turning if start.turns_freely else None)
    squares, found = all_shapes(linear.reduced())
    order = np.argsort(np.abs(squares), kind="stable")
    if isinstance(linear, Pencil):  # turning alone, which every load leaves as it is
        order = order[int(start.turns_freely) :]
    order = order[: None if every else MODES]
    return squares[order], found[:, order]


def _without_turning(linear: Pencil, basis: Array) -> Array:
    """Shapes whose inertia does no work on turning alone: K and C do none on it and it none on
    them, so that the others are found without it, whatever basis they are found in."""
    turning = np.ones((linear.cells, 1))
    momenta = linear.eliminated(turning)[2]
    return np.asarray(basis - turning @ (momenta.T @ basis) / momenta.sum())
