"""Linear equations of multiple shooting, and Floquet multipliers, without any product of segments.

    G_i d_i - d_{i+1} + B_i e = r_i,    i = 0 .. m-1,    d_m = d_0

Inner unknowns are eliminated by orthogonal transformations, so that A d_0 - B d_m + C e = c is
left, whose pencil A - mu B has the multipliers. That is backward stable for any number of segments
and any spread of the multipliers, where the product G_{m-1} .. G_0 loses the small ones in the
rounding of the large (Fairgrieve and Jepson, SIAM J. Numer. Anal. 28 (1991) 1446).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import AnalysisError

Complex = NDArray[np.complex128]
Top = tuple[Array, Array, Array, Array, Array]
LARGER = 0.3  # of the largest: multipliers whose differences count


@dataclass(frozen=True)
class CondensedSystem:
    """Equations A d_0 - B d_m + C e = c, with A, B (N, N), C (N, k), c (N,); tops: rows for the
    back substitution of the inner unknowns."""

    A: Array
    B: Array
    C: Array
    c: Array
    tops: tuple[Top, ...] = field(default=(), repr=False)

    @classmethod
    def of(
        cls, G: Sequence[Array], borders: Sequence[Array] = (), right: Sequence[Array] = ()
    ) -> CondensedSystem:
        """Eliminate inner unknowns of segments G (N, N), columns B (N, k), right sides r (N,)."""
        size = len(G[0])
        columns = borders or [np.zeros((size, 0))] * len(G)
        values = right or [np.zeros(size)] * len(G)
        A, B, C, c = G[0], np.eye(size), columns[0], values[0]
        tops = list[Top]()
        for segment, column, value in zip(G[1:], columns[1:], values[1:], strict=True):
            Q, R = scipy.linalg.qr(np.vstack((-B, segment)), check_finite=False)
            Q = Q.T
            left, after = Q[:, :size], Q[:, size:]
            A, C, c = left @ A, left @ C + after @ column, left @ c + after @ value
            tops.append((A[:size], R[:size], -after[:size], C[:size], c[:size]))
            A, B, C, c = A[size:], after[size:], C[size:], c[size:]
        return cls(A, B, C, c, tuple(tops))

    def solve(self, rows: Array, values: Array) -> tuple[Array, Array]:
        """Solve for d (m, N) and e (k,) with k more conditions: rows (k, N + k) on d_0 and e, and
        their values (k,). Raises AnalysisError for a singular system."""
        size = len(self.A)
        matrix = np.vstack((np.hstack((self.A - self.B, self.C)), rows))
        scale = 1 / np.maximum(np.abs(matrix).max(axis=1), 1e-300)
        try:
            found = np.linalg.solve(scale[:, None] * matrix, scale * np.append(self.c, values))
        except np.linalg.LinAlgError:
            raise AnalysisError("the equations of shooting are singular") from None
        first, more = found[:size], found[size:]
        inner = [first]
        after = first
        for A, R, B, C, c in reversed(self.tops):
            right = c - A @ first - B @ after - C @ more
            after = scipy.linalg.solve_triangular(R, right, check_finite=False)
            inner.append(after)
        return np.array([first, *inner[:0:-1]]), more

    @property
    def multipliers(self) -> Complex:
        """All mu with A v = mu B v (N,), the largest first; infinite where B v = 0."""
        return self.eigenpairs[0]

    @cached_property
    def eigenpairs(self) -> tuple[Complex, Complex]:
        """Multipliers, the largest first, and eigenvectors (N, N) at the start, in columns."""
        mu, vectors = scipy.linalg.eig(self.A, self.B, check_finite=False)
        order = np.argsort(-np.abs(mu), kind="stable")
        return np.asarray(mu[order]), np.asarray(vectors[:, order])


def multiplier_difference(finer: Complex, coarser: Complex) -> float:
    """Largest difference between the larger multipliers, relative to the largest one."""
    largest = float(np.abs(finer[0]))
    larger = finer[np.abs(finer) >= LARGER * largest]
    return float(max(np.abs(coarser - one).min() for one in larger)) / max(largest, 1e-300)
