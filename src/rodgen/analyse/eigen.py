"""Eigenvalues of quadratic pencils: all of them, dense; the lowest, sparse, in O(n); and of many
small pencils which motions grow, and how far that can be trusted."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, null_space
from scipy.linalg.lapack import dgeev
from scipy.sparse import csc_array
from scipy.sparse.linalg import ArpackError, LinearOperator, eigs, splu

from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.neutral import NONE, Neutral
from rodgen.analyse.pencil import Dense, Parts, Pencil, first_order, product
from rodgen.integrate.stepper import Array

ZERO = 1e-7  # of the largest frequency: zero, and the square root of rounding
LEAST = 1e-13  # of the largest |s|
SPARE = 8  # eigenvalues beyond those asked for
MOST_DENSE = 500  # links of which all eigenvalues are computed where that is the last resort
SETTLED = 1e-14  # of |s|: a correction that is rounding
Complex = NDArray[np.complex128]
WEAK = 1e-6  # share of critical damping below which its effect is of first order
ROUNDING = 2.0**-52
CRUDE, SAFE = 64.0, 32.0  # roundings of the whole matrix: before, after eigenvectors are known
GROWS = 1e-6  # of the lowest frequency: less growth without damping is rounding
MET = 1e-8  # of |s|: less growth without damping is the square root of rounding
SUSPECT = 1e8  # of the time that the slowest mode takes: the stiffness may be singular
CANCELLED = 64 * ROUNDING  # of the terms of a sum


@dataclass(frozen=True)
class Values:
    """s: eigenvalues [1/s] (k,), of every conjugate pair and, without damping, of every pair of
    opposites the one with imaginary part >= 0 (else with the positive real part), those of rigid
    motions left out; vectors (coordinates, k)."""

    s: Complex
    vectors: Complex


def all_values(pencil: Pencil | Dense, turns: bool = False) -> Values:
    """Every eigenvalue: O(n^3). turns: the rod turns freely, which has the eigenvalue zero."""
    dense = pencil.reduced()
    if dense.added:
        s, vectors = np.linalg.eig(first_order(*dense.parts, dense.added))
        own = len(dense.K) - dense.added
        return _without_zeros(_upper(s.astype(complex), vectors[:own].astype(complex)))
    if isinstance(pencil, Dense):  # external damping, which leaves zeros of rigid motions
        return _without_zeros(_solved(dense, singular=True))
    if not turns:
        return _solved(dense)
    # Virtual work on turning is s^2 (M turn) a: motions orthogonal to M turn are without it.
    turn = np.ones(pencil.cells)
    basis = null_space((dense.M @ turn)[None])
    found = _solved(dense.on(basis))
    angles = basis @ found.vectors
    for at, s in enumerate(found.s):
        pull = turn @ dense.at(s) @ angles[:, at]
        angles[:, at] -= pull / (s * s * (turn @ dense.M @ turn))
    return Values(found.s, angles)


def _solved(dense: Dense, singular: bool = False) -> Values:
    """By the inverse, in which slow motions keep their digits, where K is not singular."""
    if not len(dense.K):
        return Values(np.zeros(0, dtype=complex), np.zeros((0, 0), dtype=complex))
    if not dense.damped:
        squares, columns = np.linalg.eig(np.linalg.solve(dense.M, -dense.K))
        return Values(roots(squares), columns.astype(complex))
    if not singular:
        with suppress(np.linalg.LinAlgError):
            inverse, vectors = _companion(dense.K, dense.C, dense.M)
            return _upper(1 / inverse, vectors)
    return _upper(*_companion(dense.M, dense.C, dense.K))


def _companion(last: Array, middle: Array, first: Array) -> tuple[Complex, Complex]:
    """Eigenvalues z of z^2 last + z middle + first, and their vectors."""
    size = len(last)
    A, B = (np.linalg.solve(last, -matrix) for matrix in (first, middle))
    zero, one = np.zeros((size, size)), np.eye(size)
    values, columns = np.linalg.eig(np.block([[zero, one], [A, B]]))
    return values.astype(complex), columns[:size].astype(complex)


def _upper(s: Complex, vectors: Complex) -> Values:
    here = s.imag >= 0
    return Values(s[here], vectors[:, here])


def refined(pencil: Pencil, found: Values, wanted: Array) -> Values:
    """Eigenvalues of which those numbered in ``wanted`` are corrected by Newton's method on
    det S(s) = 0 with the banded S; those next to others are left."""
    s = found.s.copy()
    for at in wanted:
        others = np.abs(np.delete(found.s, at) - found.s[at])
        s[at] = _newton(pencil, complex(s[at]), float(others.min(initial=np.inf)) / 10)
    return Values(s, found.vectors)


def _newton(pencil: Pencil, start: complex, farthest: float) -> complex:
    s, start_vector = start, np.cos(np.arange(pencil.size) ** 2 / 7.0)
    x = y = start_vector.astype(complex)
    for _ in range(6):
        S = pencil.at(s).astype(complex)
        x, y = pencil.solve(S, x), pencil.solve(S, y, transposed=True)
        x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
        slope = y @ product(pencil.slope(s), x)
        change = -(y @ product(pencil.at(s), x)) / slope if slope else 0.0
        s += change
        if not abs(s - start) <= farthest:
            return start
        if abs(change) <= SETTLED * abs(s):
            break
    return s


def lowest_values(pencil: Pencil, count: int, turning: Array | None) -> Values:
    """The eigenvalues of smallest modulus, by ARPACK on the inverse.

    turning: the rigid rotation of a rod that turns freely, whose eigenvalue zero is taken away.
    Raises AnalysisError.
    """
    linear = Parts.of(pencil) if turning is None else Parts.without_turning(pencil, turning)
    S0, S1, S2 = linear.parts
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

    times, order = (first_order, 2 * size) if pencil.damped else (square, size)
    wanted = min((2 * count if pencil.damped else count) + SPARE, order - 2)
    start = np.cos(np.arange(order) ** 2 / 7.0)  # no symmetry; the same on every run
    operator = LinearOperator((order, order), matvec=lambda z: times(np.ravel(z)), dtype=float)
    try:
        inverse, vectors = eigs(operator, k=wanted, v0=start, ncv=min(2 * wanted + 20, order))
    except ArpackError as error:
        raise AnalysisError(f"the lowest eigenvalues were not found: {error}") from None
    there = np.abs(inverse) > 0
    values, vectors = 1 / inverse[there], vectors[:, there]
    angles = vectors[0 : 3 * pencil.cells : 3]
    if turning is not None:  # what the moment has turned, given back to every link
        angles = angles + vectors[size - 1] / (values**2 if pencil.damped else values)
    return _upper(values if pencil.damped else roots(values), angles)


def lowest_shapes(pencil: Pencil, count: int, turning: Array | None) -> tuple[Array, Array]:
    """Squared frequencies [1/s^2] and shapes (coordinates, count) of the slowest motions without
    damping, their largest angle 1.

    turning: the rigid rotation of a rod that turns freely, on which the others do no virtual work.
    Raises AnalysisError.
    """
    bare = Pencil(pencil.S0, np.zeros_like(pencil.S1), pencil.S2)
    found = lowest_values(bare, count, turning)
    first = np.argsort(np.abs(found.s))[:count]
    shapes = found.vectors[:, first].real
    if turning is not None:
        turn = np.ones((len(shapes), 1))
        pull = bare.eliminated(turn)[2].T
        shapes = shapes - turn @ (pull @ shapes) / (pull @ turn)
    return -(found.s[first] ** 2).real, shapes / np.abs(shapes).max(axis=0)


def all_shapes(dense: Dense) -> tuple[Array, Array]:
    """Squared frequencies [1/s^2] and shapes (coordinates, k) of all motions without damping and
    without added states, in rising order of the squares."""
    own = len(dense.K) - dense.added
    K, M = ((matrix + matrix.T)[:own, :own] / 2 for matrix in (dense.K, dense.M))
    squares, found = eigh(K, M)
    return squares, found


def _without_zeros(found: Values) -> Values:
    size = np.abs(found.s)
    least = ZERO * np.abs(found.s.imag).max(initial=0.0) + LEAST * size.max(initial=0.0)
    here = size > least
    return Values(found.s[here], found.vectors[:, here])


@dataclass(frozen=True)
class Motions:
    """s: eigenvalues [1/s] (forces, k), of undamped motions one of each pair of opposites, with
    imaginary part >= 0; growth: their real parts where these are more than rounding, else what is
    not above zero."""

    s: Complex
    growth: Array

    def each(self) -> Iterator[Motions]:
        """The motions under every force, one after the other."""
        return map(Motions, self.s, self.growth)

    def padded(self, count: int) -> Motions:
        """With motions that have no rate, as nan, up to so many."""
        none = np.zeros(count - len(self.s))
        return Motions(np.append(self.s, none + np.nan), np.append(self.growth, none))

    @property
    def count(self) -> NDArray[np.int_]:
        """How many grow under every force, one that oscillates counted twice."""
        return np.asarray((self.growth > 0).sum(axis=-1))


@dataclass(frozen=True)
class Modal:
    """(K + s C + s^2 M) q = 0 in modes of the unloaded rod: stacks (forces, k, k); frequencies of
    these modes (k,) [rad/s], of motions of the whole rod that of the lowest."""

    K: Array
    C: Array
    M: Array
    frequencies: Array
    neutral: Neutral = NONE  # what has no rate under any force
    added: int = 0  # states of first order, the last rows

    @property
    def damping(self) -> float:
        """The largest share of critical damping of a mode, or coupling of two by damping."""
        if not self.C.any():
            return 0.0
        masses = np.sqrt(np.abs(np.diagonal(self.M, axis1=-2, axis2=-1)) * self.frequencies)
        shares = np.abs(self.C) / (masses[..., :, None] * masses[..., None, :])
        return float(shares.max()) / 2

    def motions(self) -> Motions:
        """All of them. Undamped ones by s^2; a weak damping by its work on them, since what it
        does is lost in the rounding of a frequency; a strong one by the inverse, in which slow
        motions keep their digits beside fast ones."""
        every = list(self.each())
        return Motions(np.stack([one.s for one in every]), np.stack([one.growth for one in every]))

    def each(self) -> Iterator[Motions]:
        """The motions under every force, one after the other; damped ones are found where they are
        asked for."""
        if self.added or self.neutral.steps:
            every = self.by_rates()
            found = map(_judged, map(self.neutral.without, every))
            return (one.padded(every.shape[-1]) for one in found)
        damping = self.damping
        if not damping:
            return self._undamped().each()
        if damping < WEAK:
            return self._weak().each()
        return self._strong()

    def _undamped(self) -> Motions:
        s = roots(np.linalg.eigvals(np.linalg.solve(self.M, -self.K)))
        return Motions(s, self._certain(s))

    def _certain(self, s: Complex) -> Array:
        limit = GROWS * self.frequencies.min() + MET * np.abs(s)
        return np.where(s.real > limit, s.real, 0.0)

    def _weak(self) -> Motions:
        """s = +-s0 - (y C x)/(2 y M x), with s0, x, y of the rod without damping."""
        squares, x = np.linalg.eig(np.linalg.solve(self.M, -self.K))
        y, drag = _inverse(x), np.linalg.solve(self.M, self.C)
        change = -np.einsum("fki,fij,fjk->fk", y, drag, x) / 2
        terms = np.einsum("fki,fij,fjk->fk", np.abs(y), np.abs(drag), np.abs(x)) / 2
        s = roots(squares)
        grown = self._certain(s)
        small = np.where(change.real > CANCELLED * terms, change.real, 0.0)
        shrunk = np.where(grown > 0, -grown, small)
        pairs = np.concatenate((s + change, -s + change), axis=-1)
        return Motions(pairs, np.concatenate((np.where(grown > 0, grown, small), shrunk), axis=-1))

    def _strong(self) -> Iterator[Motions]:
        """By the inverse; under a force that leaves no stiffness to some motion, which others do
        not, by the rates without it."""
        stiff = self.K / (self.frequencies[:, None] * self.frequencies)
        for at, A in enumerate(self._by_inverse()):
            suspect = np.linalg.norm(A) * self.frequencies.min() > SUSPECT
            if suspect and np.linalg.cond(stiff[at]) * CRUDE * ROUNDING > 1:
                alone = replace(self, K=self.K[at], C=self.C[at], M=self.M[at]).by_rates()
                yield _judged(Neutral.of([alone]).without(alone)).padded(len(A))
                continue
            yield _judged(A, inverse=True)

    def by_rates(self) -> Array:
        """Matrices whose eigenvalues are s, of (W q, q', z), W the frequencies, z the added
        states."""
        w, k = self.frequencies, len(self.frequencies)
        A = first_order(self.K, self.C, self.M, self.added)
        A[..., :k] /= w
        A[..., :k, :] *= w[:, None]
        return A

    def _by_inverse(self) -> Array:
        """A matrix whose eigenvalues are 1/s, of (W q, q')."""
        w = self.frequencies
        scale = w[:, None] * w
        right = np.concatenate((self.M / w[:, None], self.C / scale), axis=-1)
        K, k = self.K / scale, len(w)
        try:
            made = np.linalg.solve(K, right)
        except np.linalg.LinAlgError:
            made = _inverse(K) @ right
        return self._rows(1 / w, -made[..., :k], -made[..., k:])

    @staticmethod
    def _rows(top: Array, left: NDArray[Any], right: NDArray[Any]) -> Array:
        """Matrices of a diagonal above and two matrices below, beside each other."""
        k = len(top)
        made = np.zeros((*left.shape[:-2], 2 * k, 2 * k))
        made[..., range(k), range(k, 2 * k)] = top
        made[..., k:, :k], made[..., k:, k:] = left, right
        return made


def _judged(A: Array, inverse: bool = False) -> Motions:
    """Of a matrix whose eigenvalues are s, or 1/s."""
    size = float(np.linalg.norm(A))
    z = _values_of(A, size)
    s = 1 / z if inverse else z
    growth = np.zeros(len(z))
    grows = np.flatnonzero(z.real > CRUDE * ROUNDING * size)
    if len(grows):
        limit = SAFE * ROUNDING * size * _conditions(A, z[grows])
        grows = grows[z[grows].real > limit]
        growth[grows] = s[grows].real
    return Motions(s, growth)


def _values_of(A: Array, size: float) -> Complex:
    """The eigenvalues of a matrix of some norm, by what numpy.linalg.eigvals calls: of a small
    matrix it looks for a tenth of the time at what it is given. Raises LinAlgError as that does."""
    if not np.isfinite(size):
        raise np.linalg.LinAlgError("the matrix is not finite")
    real, imaginary, _, _, failed = dgeev(A, compute_vl=0, compute_vr=0)
    if failed:
        raise np.linalg.LinAlgError("the eigenvalues did not converge")
    return np.asarray(real + 1j * imaginary, dtype=np.complex128)


def _conditions(A: Array, z: Complex) -> Array:
    """How many times its size a small change of a matrix can move each of some eigenvalues: by
    their left and right vectors, from two steps of inverse iteration; those of a conjugate pair,
    one behind the other, alike."""
    first = z.imag >= 0
    if not first.all():
        return np.asarray(_conditions(A, z[first])[np.cumsum(first) - 1])
    beside = z + 4 * ROUNDING * np.abs(z)
    inverse = _inverse(A - beside[:, None, None] * np.eye(len(A)))
    x = y = np.tile(np.cos(np.arange(len(A)) ** 2 / 7.0), (len(z), 1))
    for _ in range(2):
        x, y = np.einsum("fij,fj->fi", inverse, x), np.einsum("fji,fj->fi", inverse, y)
        x, y = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (x, y))
    return np.asarray(1 / np.abs((x * y).sum(axis=-1)))


def _inverse(stack: NDArray[Any]) -> NDArray[Any]:
    """The inverse of every matrix; of one that is singular to the last bit, next to it."""
    try:
        return np.linalg.inv(stack)
    except np.linalg.LinAlgError:  # the very force of a divergence, or at which two motions meet
        size = stack.shape[-1]
        aside = ROUNDING * np.abs(stack).max() * np.diag(2 + np.cos(np.arange(size) ** 2))
        return np.linalg.inv(stack + aside)


def roots(squares: NDArray[Any]) -> Complex:
    """s of s^2, with imaginary part >= 0: of a pair that flutters, one grows and one decays."""
    s = np.sqrt(squares.astype(complex))
    return np.asarray(np.where(s.imag < 0, -s, s))
