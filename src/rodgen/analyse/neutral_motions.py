"""Neutral motions of a rod: eigenvalues that are zero under every load, by symmetry."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgeqp3, dorgqr

from rodgen.arrays import Array

NOTHING = 1e-11  # of the largest singular value: zero but for rounding


@dataclass(frozen=True)
class NeutralMotions:
    """Dimensions of the neutral motions. steps: how many directions a matrix takes to zero, then
    how many its quotient by these does, and so on, until none are left."""

    steps: tuple[int, ...] = ()

    @classmethod
    def of(cls, matrices: Iterable[Array]) -> NeutralMotions:
        """Find the neutral motions common to the matrices of a rod under different loads."""
        steps, left = list[int](), list(matrices)
        while left and left[0].size and (least := min(map(_nullity, left))):
            steps.append(least)
            left = [_quotient(A, least) for A in left]
        return cls(tuple(steps))

    def reduce(self, A: Array) -> Array:
        """Reduce a matrix to its other eigenvalues."""
        for count in self.steps:
            A = _quotient(A, count)
        return A


NONE = NeutralMotions()


def _nullity(A: Array) -> int:
    sizes = np.linalg.svd(A, compute_uv=False)
    return int((sizes <= NOTHING * sizes.max(initial=0.0)).sum())


def _quotient(A: Array, count: int) -> Array:
    """Restrict a matrix to the complement of ``count`` directions that it takes to about zero."""
    factors, _, tau, _, _ = dgeqp3(A.T)  # SciPy's qr takes as long to look at small matrices
    across = dorgqr(factors, tau)[0][:, : len(A) - count]
    return np.asarray(across.T @ A @ across)
