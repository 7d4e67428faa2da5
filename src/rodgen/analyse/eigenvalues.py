"""Eigenvalues of quadratic pencils: all of them, dense; the lowest, sparse, in O(n)."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from rodgen.analyse.pencil import (
    BlockPencil,
    DensePencil,
    MatrixPencil,
    product,
)
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

NOTHING = 1e-30  # of the largest entry of every row: a column that is zero but for rounding
ZERO = 3e-4  # of a slow rate: zero, of rigid motions in a row a fourth root of rounding
FASTEST = 1e-16  # of the square of the longest period: that of what has no inertia but rounding
MOST_SINGULAR = 1e12  # condition of a matrix that is regular
SPARE = 8  # eigenvalues beyond those asked for
MOST_DENSE = 500  # links of which all eigenvalues are computed where that is the last resort
ENOUGH = 1e-9  # of the inverse of what is sought: its error where a sign is asked for
SETTLED = 1e-14  # of |s|: a correction that is rounding
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class EigenSolution:
    """Eigenvalues and eigenvectors of a pencil. s: [1/s] (k,), of every conjugate pair and, without
    damping, of every pair of opposites the one with imaginary part >= 0 (else with the positive
    real part), without those of rigid motions; vectors (coordinates, k)."""

    s: Complex
    vectors: Complex


def all_eigenvalues(
    pencil: BlockPencil | DensePencil, turns: bool = False, zeros: int | None = None
) -> EigenSolution:
    """Compute every eigenvalue, in O(n^3). turns: the rod turns freely, with eigenvalue zero;
    zeros: how many of a damped dense pencil are zero, if that is known."""
    dense = pencil.to_dense()
    if isinstance(pencil, DensePencil) or not turns:
        return _solve_dense(dense, zeros)
    # Virtual work on turning is s^2 (M turn) a: motions orthogonal to M turn are without it.
    turn = np.ones(pencil.n_moving)
    basis = scipy.linalg.null_space((dense.S2 @ turn)[None])
    found = _solve_dense(dense.project(basis))
    angles, s = basis @ found.vectors, found.s
    pulls = [turn @ part @ angles for part in dense.parts]  # by K, C and M, on every motion
    pull = pulls[0] + s * pulls[1] + s * s * pulls[2]
    return EigenSolution(s, angles - pull / (s * s * (turn @ dense.S2 @ turn)))


def _solve_dense(dense: DensePencil, zeros: int | None = None) -> EigenSolution:
    """Solve a dense pencil by its inverse, in which slow motions keep their digits beside fast
    ones: that of the stiffness or, where rigid motions make this singular, of the pencil at a slow
    rate; rigid motions are left out then."""
    if not dense.size:
        return EigenSolution(np.zeros(0, dtype=complex), np.zeros((0, 0), dtype=complex))
    shift = 0.0 if is_regular(dense.S0) else slow_rate(dense)
    own = dense.size - dense.added
    if not (dense.is_damped or dense.added):
        z, vectors = np.linalg.eig(np.linalg.solve(dense.at(shift), -dense.S2))
        found = EigenSolution(square_roots(shift**2 + 1 / z), vectors.astype(complex))
        return _drop_zeros(found, shift)
    z, vectors = _companion(dense.at(shift), dense.derivative(shift), dense.S2)
    finite = np.argsort(np.abs(z))[dense.added :]  # an added state has no inertia
    if zeros:
        slow = np.argsort(np.abs(shift + 1 / z[finite]))[zeros:]
        return _upper_half_plane(shift + 1 / z[finite[slow]], vectors[:own, finite[slow]])
    return _drop_zeros(_upper_half_plane(shift + 1 / z[finite], vectors[:own, finite]), shift)


def is_regular(S: Array) -> bool:
    """Whether a matrix is regular, apart from the sizes of its rows and columns."""
    rows = np.abs(S).max(axis=1, keepdims=True)
    if not rows.all():
        return False
    columns = np.abs(S / rows).max(axis=0)
    return bool(columns.min() > NOTHING and np.linalg.cond(S / rows / columns) < MOST_SINGULAR)


def slow_rate(dense: DensePencil) -> float:
    """Rate of a slow motion [1/s]: that of a rod which bends evenly or, where nothing resists that,
    of the matrices."""
    own = dense.size - dense.added
    K, M = dense.S0[:own, :own], dense.S2[:own, :own]
    bend = np.linspace(0.0, 1.0, own) if dense.bend is None else dense.bend
    found = abs(bend @ K @ bend) / (bend @ M @ bend) or np.linalg.norm(K) / np.linalg.norm(M)
    return float(np.sqrt(found)) or 1.0


def _companion(last: Array, middle: Array, first: Array) -> tuple[Complex, Complex]:
    """Eigenvalues z and vectors of z^2 last + z middle + first, by the companion matrix."""
    size = len(last)
    A, B = (np.linalg.solve(last, -matrix) for matrix in (first, middle))
    zero, one = np.zeros((size, size)), np.eye(size)
    values, columns = np.linalg.eig(np.block([[zero, one], [A, B]]))
    return values.astype(complex), columns[:size].astype(complex)


def _upper_half_plane(s: Complex, vectors: Complex) -> EigenSolution:
    here = s.imag >= 0
    return EigenSolution(s[here], vectors[:, here])


def refine_eigenvalues(pencil: BlockPencil, found: EigenSolution, wanted: Array) -> EigenSolution:
    """Correct the eigenvalues numbered in ``wanted`` by Newton's method on det S(s) = 0 with the
    banded S; those that would move towards others are left."""
    s = found.s.copy()
    for at in wanted:
        others = np.abs(np.delete(found.s, at) - found.s[at])
        s[at] = _refine_eigenvalue(pencil, complex(s[at]), float(others.min(initial=np.inf)) / 10)
    return EigenSolution(s, found.vectors)


def _refine_eigenvalue(pencil: BlockPencil, start: complex, farthest: float) -> complex:
    s, start_vector = start, np.cos(np.arange(pencil.size) ** 2 / 7.0)
    x = y = start_vector.astype(complex)
    for _ in range(6):
        S = pencil.at(s).astype(complex)
        x, y = pencil.solve(S, x), pencil.solve(S, y, transposed=True)
        x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
        slope = y @ product(pencil.derivative(s), x)
        change = -(y @ product(pencil.at(s), x)) / slope if slope else 0.0
        s += change
        if not abs(s - start) <= farthest:
            return start
        if abs(change) <= SETTLED * abs(s):
            break
    return s


def lowest_eigenvalues(pencil: BlockPencil, count: int, turning: Array | None) -> EigenSolution:
    """Compute the eigenvalues of smallest modulus, by ARPACK on the inverse.

    turning: the rigid rotation of a rod that turns freely, whose eigenvalue zero is removed. Raises
    AnalysisError.
    """
    linear = MatrixPencil.without_rotation(pencil, turning)
    S0, S1, S2 = linear.parts
    size, factors = S0.shape[0], _factorise(S0)

    def undamped_operator(z: Array) -> Array:
        return -np.asarray(factors.solve(S2 @ z))

    def damped_operator(z: Array) -> Array:
        return np.concatenate((-factors.solve(S1 @ z[:size] + S2 @ z[size:]), z[:size]))

    times, order = (damped_operator, 2 * size) if pencil.is_damped else (undamped_operator, size)
    wanted = min((2 * count if pencil.is_damped else count) + SPARE, order - 2)
    start = np.cos(np.arange(order) ** 2 / 7.0)  # no symmetry; the same on every run
    operator = scipy.sparse.linalg.LinearOperator(
        (order, order), matvec=lambda z: times(np.ravel(z)), dtype=float
    )
    try:
        inverse, vectors = scipy.sparse.linalg.eigs(
            operator, k=wanted, v0=start, ncv=min(2 * wanted + 20, order)
        )
    except scipy.sparse.linalg.ArpackError as error:
        raise AnalysisError(f"the lowest eigenvalues were not found: {error}") from None
    there = np.abs(inverse) > 0
    values, vectors = 1 / inverse[there], vectors[:, there]
    angles = vectors[0 : 3 * pencil.n_moving : 3]
    if turning is not None:  # rotation by the moment, added to every link
        angles = angles + vectors[size - 1] / (values**2 if pencil.is_damped else values)
    return _upper_half_plane(values if pencil.is_damped else square_roots(values), angles)


def nearest_eigenvalues(
    pencil: BlockPencil, shift: complex, count: int, turning: Array | None
) -> Complex:
    """Compute the eigenvalues nearest to a number, by ARPACK with shift and invert. turning: the
    rigid rotation of a rod that turns freely. Raises AnalysisError."""
    linear = MatrixPencil.without_rotation(pencil, turning)
    S0, S1, S2 = linear.parts
    size, factors = S0.shape[0], _factorise(linear.at(complex(shift)))

    def shifted_operator(z: Complex) -> Complex:
        x, rate = z[:size], z[size:]
        moved = -factors.solve(S1 @ x + S2 @ (shift * x + rate))
        return np.concatenate((moved, x + shift * moved))

    start = np.cos(np.arange(2 * size) ** 2 / 7.0).astype(complex)
    shape = (2 * size, 2 * size)
    operator = scipy.sparse.linalg.LinearOperator(
        shape, matvec=lambda z: shifted_operator(z.ravel()), dtype=complex
    )
    try:
        found = scipy.sparse.linalg.eigs(
            operator, k=count, v0=start, tol=ENOUGH, return_eigenvectors=False
        )
    except scipy.sparse.linalg.ArpackError:
        raise AnalysisError(f"the eigenvalues next to {shift:.3g} were not found") from None
    return np.asarray(shift + 1 / found)


def _factorise(S: Any) -> Any:
    try:
        return scipy.sparse.linalg.splu(scipy.sparse.csc_array(S))
    except RuntimeError:
        raise AnalysisError(
            "the linearised equations are singular: a static equilibrium is about to lose its "
            "stability, or the rod is free to move in a way that was not expected"
        ) from None


def lowest_shapes(pencil: BlockPencil, count: int, turning: Array | None) -> tuple[Array, Array]:
    """Compute squared frequencies [1/s^2] and shapes (coordinates, count) of the slowest undamped
    motions, scaled to a largest angle of 1.

    turning: the rigid rotation of a rod that turns freely; shapes are orthogonal to it in the mass
    matrix. Raises AnalysisError.
    """
    bare = BlockPencil(pencil.S0, np.zeros_like(pencil.S1), pencil.S2)
    found = lowest_eigenvalues(bare, count, turning)
    first = np.argsort(np.abs(found.s))[:count]
    shapes = found.vectors[:, first].real
    if turning is not None:
        turn = np.ones((len(shapes), 1))
        pull = bare.eliminate_forces(turn)[2].T
        shapes = shapes - turn @ (pull @ shapes) / (pull @ turn)
    return -(found.s[first] ** 2).real, shapes / np.abs(shapes).max(axis=0)


def all_shapes(dense: DensePencil, light: bool = False) -> tuple[Array, Array]:
    """Compute squared frequencies [1/s^2], rising, and shapes (coordinates, k) of all motions
    without damping and without added states. light: the mass matrix is nearly singular."""
    own = dense.size - dense.added
    K, M = ((matrix + matrix.T)[:own, :own] / 2 for matrix in (dense.S0, dense.S2))
    if light:
        shift = slow_rate(dense) ** 2
        with suppress(np.linalg.LinAlgError):  # of a stiffness that is far from positive
            inverse, found = scipy.linalg.eigh(M, K + shift * M)
            inverse, found = inverse[::-1], found[:, ::-1]
            inverse = np.maximum(inverse, FASTEST * inverse[0])
            return 1 / inverse - shift, found / np.sqrt(inverse)
    squares, found = scipy.linalg.eigh(K, M)
    return squares, found


def _drop_zeros(found: EigenSolution, rate: float) -> EigenSolution:
    """Drop eigenvalues that are zero but for rounding, beside a slow rate [1/s]; none beside 0."""
    here = np.abs(found.s) > ZERO * rate
    return EigenSolution(found.s[here], found.vectors[:, here])


def square_roots(squares: NDArray[Any]) -> Complex:
    """Square roots with imaginary part >= 0: of a pair that flutters, one grows and one decays."""
    s = np.sqrt(squares.astype(complex))
    return np.asarray(np.where(s.imag < 0, -s, s))
