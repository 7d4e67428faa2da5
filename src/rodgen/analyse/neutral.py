"""Motions of a rod that nothing resists nor drives under any load: eigenvalues that are zero by the
symmetry of the whole, and not by the load."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgeqp3, dorgqr

from rodgen.arrays import Array

NOTHING = 1e-11  # of the largest singular value: zero but for rounding


@dataclass(frozen=True)
class Neutral:
    """steps: how many directions a matrix takes to zero, then how many directions what is left of
    it without these, and so on, until none are left."""

    steps: tuple[int, ...] = ()

    @classmethod
    def of(cls, matrices: Iterable[Array]) -> Neutral:
        """What all these matrices have in common, of a rod under different loads."""
        steps, left = list[int](), list(matrices)
        while left and left[0].size and (least := min(map(_nullity, left))):
            steps.append(least)
            left = [_quotient(A, least) for A in left]
        return cls(tuple(steps))

    def without(self, A: Array) -> Array:
        """A smaller matrix that has the other eigenvalues."""
        for count in self.steps:
            A = _quotient(A, count)
        return A


NONE = Neutral()


def _nullity(A: Array) -> int:
    sizes = np.linalg.svd(A, compute_uv=False)
    return int((sizes <= NOTHING * sizes.max(initial=0.0)).sum())


def _quotient(A: Array, count: int) -> Array:
    """A matrix on what is across so many directions, which it takes to zero or next to it."""
    factors, _, tau, _, _ = dgeqp3(A.T)  # SciPy's qr takes as long to look at small matrices
    across = dorgqr(factors, tau)[0][:, : len(A) - count]
    return np.asarray(across.T @ A @ across)
