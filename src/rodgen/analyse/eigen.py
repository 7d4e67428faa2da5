"""Eigenvalues of quadratic pencils: all of them, dense; the lowest, sparse, in O(n)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import ArpackError, LinearOperator, eigs, splu

from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.pencil import Dense, Held, Pencil, sparse
from rodgen.integrate.stepper import Array

Complex = NDArray[np.complex128]

ZERO = 1e-7  # of the largest |s|: zero, and the square root of rounding
MOST_DENSE = 500  # links of which all eigenvalues are computed where that is the last resort
SPARE = 8  # eigenvalues beyond those asked for


@dataclass(frozen=True)
class Values:
    """s: eigenvalues [1/s] (k,), of every conjugate pair and, without damping, of every pair of
    opposites the one with imaginary part >= 0 (else with the positive real part), zero ones left
    out; vectors (coordinates, k)."""

    s: Complex
    vectors: Complex


def all_values(pencil: Pencil | Dense) -> Values:
    """Every eigenvalue: O(n^3)."""
    dense = pencil.reduced() if isinstance(pencil, Pencil) else pencil
    A, B = (np.linalg.solve(dense.M, -matrix) for matrix in (dense.K, dense.C))
    if not dense.damped:
        squares, vectors = np.linalg.eig(A)
        return _kept(_roots(squares), vectors)
    size = len(A)
    first_order = np.block([[np.zeros_like(A), np.eye(size)], [A, B]])
    s, vectors = np.linalg.eig(first_order)
    return _kept(s, vectors[:size])


def lowest_values(pencil: Pencil, count: int, turning: Array | None) -> Values:
    """The eigenvalues of smallest modulus, by ARPACK on the inverse.

    turning: the rigid rotation of a rod that turns freely, whose eigenvalue zero is taken away.
    Raises AnalysisError.
    """
    if turning is None:
        S0, S1, S2 = (sparse(blocks) for blocks in (pencil.S0, pencil.S1, pencil.S2))
    else:
        held = Held.of(pencil, turning)
        S0, S1, S2 = held.S0, held.S1, held.S2
    size = S0.shape[0]
    try:
        factors = splu(csc_array(S0))
    except RuntimeError:
        raise AnalysisError(
            "the linearised equations are singular: a static equilibrium is about to lose its "
            "stability, or the rod is free to move in a way that was not expected"
        ) from None

    def square(z: Array) -> Array:
        return -np.asarray(factors.solve(S2 @ z))

    def first_order(z: Array) -> Array:
        return np.concatenate((-factors.solve(S1 @ z[:size] + S2 @ z[size:]), z[:size]))

    product, order = (first_order, 2 * size) if pencil.damped else (square, size)
    wanted = min((2 * count if pencil.damped else count) + SPARE, order - 2)
    start = np.cos(np.arange(order) ** 2 / 7.0)  # no symmetry; the same on every run
    operator = LinearOperator((order, order), matvec=lambda z: product(np.ravel(z)), dtype=float)
    try:
        inverse, vectors = eigs(operator, k=wanted, v0=start, ncv=min(2 * wanted + 20, order))
    except ArpackError as error:
        if pencil.cells <= MOST_DENSE:  # overdamped motions crowd together: all of them, then
            return all_values(pencil)
        raise AnalysisError(f"the lowest eigenvalues were not found: {error}") from None
    there = np.abs(inverse) > 0
    values, vectors = 1 / inverse[there], vectors[:, there]
    angles = vectors[0 : 3 * pencil.cells : 3]
    if turning is not None:  # what the moment has turned, given back to every link
        angles = angles + vectors[size - 1] / (values**2 if pencil.damped else values)
    return _kept(values if pencil.damped else _roots(values), angles)


def _roots(squares: Complex) -> Complex:
    """s of s^2, with imaginary part >= 0: of a pair that flutters, one grows and one decays."""
    s = np.sqrt(squares.astype(complex))
    return np.asarray(np.where(s.imag < 0, -s, s))


def _kept(s: Complex, vectors: Complex) -> Values:
    here = (np.abs(s) > ZERO * np.abs(s).max(initial=0.0)) & (s.imag >= 0)
    return Values(s[here], vectors[:, here])
