"""Linearised equations of rods with motions that have no inertia, as equations whose mass matrix is
regular: what has no inertia and no damping follows statically, what has damping alone becomes a
state of first order. Eigenvalues that are infinite are left out by that, all others stay.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodgen.analyse.eigenvalues import Complex
from rodgen.analyse.pencil import DensePencil
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

NOTHING = 1e-13  # of the largest singular value: zero but for rounding
SOME_MASS = "give its links some mass, which may be little"
LOOSE = "what has no mass is held by nothing: the linearised equations have no solution, or many"


@dataclass(frozen=True)
class RegularPencil:
    """A pencil with a regular mass matrix, and its coordinates in those of the whole.

    pencil: in coordinates with inertia and, as added states, those with damping alone and those of
    the whole; whole: with all coordinates; heavy, light: bases of the former and of the others, in
    columns (coordinates, k); n_buckled: motions without inertia and damping that the stiffness
    drives away from equilibrium.
    """

    pencil: DensePencil
    whole: DensePencil
    heavy: Array
    light: Array
    n_buckled: int = 0

    def expand(self, s: Complex, vectors: Complex) -> Complex:
        """Coordinates of the whole (coordinates, k) of motions with eigenvalues s (k,), from those
        with inertia."""
        moved = self.heavy @ vectors
        for at, rate in enumerate(s):
            S = self.whole.at(complex(rate))
            pull = self.light.T @ (S @ moved[:, at])
            moved[:, at] -= self.light @ np.linalg.solve(self.light.T @ S @ self.light, pull)
        return np.asarray(moved[: self.whole.size - self.whole.added])


def regular_pencil(whole: DensePencil, inertia: float = 0.0) -> RegularPencil:
    """Reduce a dense pencil to one with a regular mass matrix; inertia: a size of that of the rod,
    if it is not in the matrix. Raises AnalysisError where motions without inertia meet no
    resistance."""
    own = whole.size - whole.added
    heavy, light = _split(whole.S2[:own, :own], inertia)
    if not heavy.shape[1]:
        raise AnalysisError(f"no motion has inertia but those of the rod as a whole; {SOME_MASS}")
    still, slow = _split_light(whole, light)
    driven = np.linalg.eigvals(still.T @ whole.S0[:own, :own] @ still)
    states = np.eye(whole.size)[:, own:]
    heavy, still, slow = (
        np.pad(basis, ((0, whole.added), (0, 0))) for basis in (heavy, still, slow)
    )
    kept, size = np.hstack((heavy, slow, states)), heavy.shape[1]
    K, C = _without_still(whole, kept, still)
    K, C = _solve_first_order(K, C, size)
    M = np.zeros_like(K)
    M[:size, :size] = heavy.T @ whole.S2 @ heavy
    bend = np.linspace(0.0, 1.0, own) if whole.bend is None else whole.bend
    bend = np.pad(bend, (0, whole.added)) @ heavy
    reduced = DensePencil(K, C, M, len(K) - size, bend)
    light = np.hstack((still, slow, states))
    return RegularPencil(reduced, whole, heavy, light, int((driven.real < 0).sum()))


def _split(matrix: Array, size: float) -> tuple[Array, Array]:
    """Bases, in columns, of what a matrix acts on and of what it takes to zero."""
    _, sizes, ways = np.linalg.svd(matrix)
    rank = int((sizes > NOTHING * sizes.max(initial=size)).sum())
    return ways[:rank].T, ways[rank:].T


def _split_light(whole: DensePencil, light: Array) -> tuple[Array, Array]:
    """Bases of motions without inertia: of those without damping, and of the others."""
    C = whole.S1[: len(light), : len(light)]
    felt = np.vstack((C @ light, C.T @ light))
    if not felt.any():
        return light, light[:, :0]
    _, sizes, ways = np.linalg.svd(felt / np.abs(C).max())
    rank = int((sizes > NOTHING).sum())
    return light @ ways[rank:].T, light @ ways[:rank].T


def _without_still(whole: DensePencil, kept: Array, still: Array) -> tuple[Array, Array]:
    """Stiffness and damping in the coordinates that are kept, with the others in equilibrium."""
    K, C = (kept.T @ part @ kept for part in (whole.S0, whole.S1))
    if not still.shape[1]:
        return K, C
    own = still.T @ whole.S0 @ still
    if np.linalg.cond(own) > 1 / NOTHING:
        raise AnalysisError(LOOSE)
    lean = np.linalg.solve(own, still.T @ whole.S0 @ kept)
    left = (kept.T @ part @ still @ lean for part in (whole.S0, whole.S1))
    K, C = (part - moved for part, moved in zip((K, C), left, strict=True))
    return K, C


def _solve_first_order(K: Array, C: Array, size: int) -> tuple[Array, Array]:
    """Stiffness and damping with the rates of what has no inertia, behind ``size`` coordinates that
    have, solved for in their own rows and put into the others."""
    if len(K) == size:
        return K, C
    if np.linalg.cond(C[size:, size:]) > 1 / NOTHING:
        raise AnalysisError(LOOSE)
    by_place, by_rate = (np.linalg.solve(C[size:, size:], part[size:]) for part in (K, C))
    K = np.vstack((K[:size] - C[:size, size:] @ by_place, by_place))
    C = np.vstack((C[:size] - C[:size, size:] @ by_rate, by_rate))
    C[size:, size:] = np.eye(len(C) - size)
    C[:size, size:] = 0.0
    return K, C
