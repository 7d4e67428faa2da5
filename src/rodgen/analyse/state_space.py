"""Linear equations x' = A x + B u + rates, y = C x + D u + values, and smaller ones that behave
alike."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from rodgen.arrays import Array
from rodgen.errors import AnalysisError

ALIKE = 1e-6  # of a modulus: two eigenvalues that are not told apart
UNSEEN = 1e-10  # of the matrices: a direction that is not reached but by rounding
NOTHING = 4 * float(np.finfo(float).eps) ** 0.5  # of the norm: a double zero moved by rounding
NEGLIGIBLE = 1e-12  # of the largest element of A, where states are scaled
CANCELLED = 1e-9  # of its terms: a sum that is zero but for rounding


class StateSpace(NamedTuple):
    """Matrices A (states, states), B (states, inputs), C (outputs, states), D (outputs, inputs),
    and what is constant: rates (states,), values (outputs,)."""

    A: Array
    B: Array
    C: Array
    D: Array
    rates: Array
    values: Array

    def project(self, left: Array, right: Array) -> StateSpace:
        """Equations of z with x = right z (states, k) and z = left x (k, states)."""
        A, B, C = left @ self.A @ right, left @ self.B, self.C @ right
        return StateSpace(A, B, C, self.D, left @ self.rates, self.values)

    def equilibrate(self) -> tuple[StateSpace, Array]:
        """Scale the states by powers of two, so that rows and columns of A are alike; return the
        factors (states,), of the states in place of the scaled ones, too."""
        # Of states that do not act on each other the scales would have no bound.
        sizes = np.abs(self.A)
        sizes += NEGLIGIBLE * sizes.max(initial=0.0)
        _, (scale, _) = scipy.linalg.matrix_balance(sizes, permute=False, separate=True)
        return self.project(np.diag(1 / scale), np.diag(scale)), scale


def slow_part(of: StateSpace, count: int) -> tuple[StateSpace, Array]:
    """Part of at least ``count`` eigenvalues, those of smallest modulus, and x over its states
    (states, k). Those that are zero but for rounding, or alike, stay together. All that is faster
    follows at once, so that the static gain is kept: D and the values have its part.

    By an ordered Schur form and a Sylvester equation (G. H. Golub and C. F. Van Loan, Matrix
    Computations, 4th ed., 7.6), which need no eigenvectors: rigid motions have too few. Raises
    AnalysisError where the parts cannot be separated.
    """
    scaled, scale = of.equilibrate()
    sizes = np.sort(np.abs(np.linalg.eigvals(scaled.A)))
    nothing = _rounding(scaled.A)
    while count < len(sizes) and sizes[count] <= max(sizes[count - 1] * (1 + ALIKE), nothing):
        count += 1
    if count >= len(sizes):
        return of, np.eye(len(sizes))
    cut = np.sqrt(sizes[count - 1] * sizes[count]) or sizes[count] / 2
    T, Z, kept = scipy.linalg.schur(scaled.A, sort=lambda re, im: np.hypot(re, im) <= cut)
    try:
        mixed = scipy.linalg.solve_sylvester(T[:kept, :kept], -T[kept:, kept:], -T[:kept, kept:])
        ahead = np.linalg.inv(T[kept:, kept:])
    except np.linalg.LinAlgError:
        kept = 0
    if kept != count:
        raise AnalysisError(f"{count} eigenvalues cannot be told from the next ones")
    slow, rest = Z[:, :kept], Z[:, kept:]
    own, turned = _settle(T[:kept, :kept], nothing)
    made = scaled.project(turned.T @ (slow.T - mixed @ rest.T), slow @ turned)
    made = made._replace(A=own, C=_product(scaled.C, slow @ turned))
    fast = scaled.project(rest.T, slow @ mixed + rest)
    at_once = -fast.C @ ahead
    made = made._replace(D=of.D + at_once @ fast.B, values=of.values + at_once @ fast.rates)
    return made, scale[:, None] * (slow @ turned)


def static_gain(of: StateSpace) -> Array:
    """Outputs over inputs that do not change (outputs, inputs); not-a-number where an output sees a
    state that the input sets going on by itself."""
    sizes = np.sort(np.abs(np.linalg.eigvals(of.A)))
    lasting = int((sizes <= _rounding(of.equilibrate()[0].A)).sum())
    if lasting == 0:
        return of.D - of.C @ np.linalg.solve(of.A, of.B)
    slow, basis = slow_part(of, lasting)
    # C A^j B / s^(j + 1), of what goes on, where the slowest other motion has its frequency.
    s = float(sizes[lasting]) if lasting < len(sizes) else 1.0
    moved, seen, size = slow.B, [], []
    for _ in range(len(slow.A)):
        moved = moved / s
        seen.append(np.abs(of.C @ basis @ moved))
        size.append(np.abs(of.C) @ np.abs(basis @ moved))
        moved = slow.A @ moved
    unseen = np.max(seen, axis=0) <= CANCELLED * np.maximum(np.abs(slow.D), np.max(size, axis=0))
    return np.where(unseen, slow.D, np.nan)


def _rounding(A: Array) -> float:
    """Modulus up to which an eigenvalue is zero but for rounding."""
    return float(NOTHING * np.linalg.norm(A, 2))


def _settle(A: Array, nothing: float) -> tuple[Array, Array]:
    """Schur form of A whose first eigenvalues, those of at most a modulus, are made zero, and its
    vectors: nothing tells of a smaller model how large its rounding was."""
    T, Z, zeros = scipy.linalg.schur(A, sort=lambda re, im: np.hypot(re, im) <= nothing)
    for k in range(zeros - 1):
        if abs(T[k + 1, k]) > abs(T[k, k + 1]):  # what is left is the larger one
            order = [k + 1, k]
            T[:, k : k + 2], Z[:, k : k + 2] = T[:, order], Z[:, order]
            T[k : k + 2] = T[order]
    T[:zeros, :zeros] = np.triu(T[:zeros, :zeros], 1)
    return T, Z


def _product(left: Array, right: Array) -> Array:
    """The product of two matrices, with zero for what is rounding of its terms."""
    made = left @ right
    return np.where(np.abs(made) <= CANCELLED * (np.abs(left) @ np.abs(right)), 0.0, made)


def minimal_part(of: StateSpace) -> tuple[StateSpace, Array]:
    """Part that inputs, or constant rates, reach and outputs see, and x over its states (states,
    k), by orthogonal bases (the staircase algorithm: C. C. Paige, IEEE Trans. Autom. Control 26
    (1981) 130-138)."""
    scaled, scale = of.equilibrate()
    reached = _reachable(scaled.A, np.column_stack((scaled.B, scaled.rates)))
    made = scaled.project(reached.T, reached)
    seen = _reachable(made.A.T, made.C.T)
    made = made.project(seen.T, seen)
    own, turned = _settle(made.A, _rounding(scaled.A))
    made = made.project(turned.T, turned)._replace(A=own, C=_product(made.C, turned))
    return made, scale[:, None] * (reached @ seen @ turned)


def _reachable(A: Array, B: Array) -> Array:
    """Orthonormal basis (states, k) of what the columns of B and the powers of A reach."""
    basis = np.zeros((len(A), 0))
    sizes = np.linalg.norm(B, axis=0)
    new, size = B[:, sizes > 0] / sizes[sizes > 0], 1.0
    while new.size and basis.shape[1] < len(A):
        for _ in range(2):  # the second time for what the first has left by rounding
            new = new - basis @ (basis.T @ new)
        vectors, values, _ = np.linalg.svd(new, full_matrices=False)
        vectors = vectors[:, values > UNSEEN * size]
        basis = np.column_stack((basis, vectors))
        new, size = A @ vectors, float(np.linalg.norm(A, 2))
    return basis
