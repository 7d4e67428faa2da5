"""Which small motions grow under each of many loads, in a basis of modes, and how far that can be
trusted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgeev

from rodgen.analyse.eigen import Complex, roots
from rodgen.analyse.neutral import NONE, Neutral
from rodgen.analyse.pencil import first_order
from rodgen.arrays import Array

FLUTTER, DIVERGENCE = "flutter", "divergence"  # growing with a frequency, and without one
MOST_DENSE = 200  # links up to which all motions are looked at
WEAK = 1e-6  # share of critical damping below which its effect is of first order
ROUNDING = 2.0**-52
CRUDE, SAFE = 64.0, 32.0  # roundings of the whole matrix: before, after eigenvectors are known
GROWS = 1e-6  # of the lowest frequency: less growth without damping is rounding
MET = 1e-8  # of |s|: less growth without damping is the square root of rounding
SUSPECT = 1e8  # of the time that the slowest mode takes: the stiffness may be singular
CANCELLED = 64 * ROUNDING  # of the terms of a sum


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
            found = map(judged, map(self.neutral.without, every))
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
        return np.where(s.real > slight(s, self.frequencies.min()), s.real, 0.0)

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
                yield judged(Neutral.of([alone]).without(alone)).padded(len(A))
                continue
            yield judged(A, inverse=True)

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


def judged(A: Array, inverse: bool = False) -> Motions:
    """Of a matrix whose eigenvalues are s, or 1/s."""
    size = float(np.linalg.norm(A))
    z = _values_of(A, size)
    s = 1 / z if inverse else z
    growth = np.zeros(len(z))
    grows = np.flatnonzero(z.real > CRUDE * ROUNDING * size)
    if len(grows):
        limit = SAFE * ROUNDING * size * conditions(A, z[grows])
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


def conditions(A: Array, z: Complex) -> Array:
    """How many times its size a small change of a matrix can move each of some eigenvalues: by
    their left and right vectors, from two steps of inverse iteration; those of a conjugate pair,
    one behind the other, alike."""
    first = z.imag >= 0
    if not first.all():
        return np.asarray(conditions(A, z[first])[np.cumsum(first) - 1])
    beside = z + 4 * ROUNDING * np.abs(z)
    inverse = _inverse(A - beside[:, None, None] * np.eye(len(A)))
    x = y = np.tile(np.cos(np.arange(len(A)) ** 2 / 7.0), (len(z), 1))
    for _ in range(2):
        x, y = np.einsum("fij,fj->fi", inverse, x), np.einsum("fji,fj->fi", inverse, y)
        x, y = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (x, y))
    return np.asarray(1 / np.abs((x * y).sum(axis=-1)))


def _inverse(stack: NDArray[Any]) -> NDArray[Any]:
    """The inverse of every matrix; of one that is singular to the last bit, next to it."""
    size, aside = stack.shape[-1], 0.0
    for _ in range(8):
        try:
            return np.linalg.inv(stack + aside)
        except (
            np.linalg.LinAlgError
        ):  # the very force of a divergence, or at which two motions meet
            nudge = ROUNDING * np.abs(stack).max() * np.diag(2 + np.cos(np.arange(size) ** 2))
            aside = 2 * aside + nudge
    raise np.linalg.LinAlgError("Singular matrix")


def slight(s: Complex | complex, lowest: float) -> Array:
    """Growth [1/s] of eigenvalues that may be rounding; lowest: the lowest frequency [rad/s]."""
    return np.asarray(GROWS * lowest + MET * np.abs(s))


def arising(grown: Complex, other: Complex) -> complex:
    """Of the eigenvalues that grow at one place and those that do at another, the one that does at
    the first alone: zero, or imaginary where it has a frequency."""
    if not len(grown):
        return 0j
    near = np.abs(grown[:, None] - other[None, :]).min(axis=1, initial=np.inf)
    s = grown[np.argmax(near / np.abs(grown))]
    # Just beyond divergence a rate is real; with damping flutter has an imaginary part.
    return 0j if abs(s.imag) <= abs(s.real) else complex(1j * abs(s.imag))
