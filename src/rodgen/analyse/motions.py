"""Which small motions grow: eigenvalues of many small pencils, and how far they can be trusted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.stepper import Array

Complex = NDArray[np.complex128]

WEAK = 1e-6  # share of critical damping below which its effect is of first order
ROUNDING = 2.0**-52
CRUDE, SAFE = 64.0, 32.0  # roundings of the whole matrix: before, after eigenvectors are known
GROWS = 1e-6  # of the lowest frequency: less growth without damping is rounding
MET = 1e-8  # of |s|: less growth without damping is the square root of rounding
CANCELLED = 64 * ROUNDING  # of the terms of a sum


@dataclass(frozen=True)
class Motions:
    """s: eigenvalues [1/s] (forces, k), of undamped motions one of each pair of opposites, with
    imaginary part >= 0; growth: their real parts where these are more than rounding, else what is
    not above zero."""

    s: Complex
    growth: Array

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
    singular: bool  # the stiffness, under any force

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
        damping = self.damping
        if not damping:
            return self._undamped()
        return self._weak() if damping < WEAK else self._strong()

    def _undamped(self) -> Motions:
        s = _roots(np.linalg.eigvals(np.linalg.solve(self.M, -self.K)))
        return Motions(s, self._certain(s))

    def _certain(self, s: Complex) -> Array:
        limit = GROWS * self.frequencies.min() + MET * np.abs(s)
        return np.where(s.real > limit, s.real, 0.0)

    def _weak(self) -> Motions:
        """s = +-s0 - (y C x)/(2 y M x), with s0, x, y of the rod without damping."""
        squares, x = np.linalg.eig(np.linalg.solve(self.M, -self.K))
        y, drag = np.linalg.inv(x), np.linalg.solve(self.M, self.C)
        change = -np.einsum("fki,fij,fjk->fk", y, drag, x) / 2
        terms = np.einsum("fki,fij,fjk->fk", np.abs(y), np.abs(drag), np.abs(x)) / 2
        s = _roots(squares)
        grown = self._certain(s)
        small = np.where(change.real > CANCELLED * terms, change.real, 0.0)
        shrunk = np.where(grown > 0, -grown, small)
        pairs = np.concatenate((s + change, -s + change), axis=-1)
        return Motions(pairs, np.concatenate((np.where(grown > 0, grown, small), shrunk), axis=-1))

    def _strong(self) -> Motions:
        A = self._by_rates() if self.singular else self._by_inverse()
        size = np.linalg.norm(A, axis=(-2, -1))[..., None]
        z: Complex = np.linalg.eigvals(A).astype(np.complex128)
        growth = np.where(z.real > CRUDE * ROUNDING * size, z.real, 0.0)
        doubtful = np.flatnonzero(growth.any(axis=-1))
        if len(doubtful):
            z[doubtful], x = np.linalg.eig(A[doubtful])
            y = _inverse(x)
            condition = np.linalg.norm(x, axis=-2) * np.linalg.norm(y, axis=-1)
            limit = SAFE * ROUNDING * size[doubtful] * condition
            growth[doubtful] = np.where(z[doubtful].real > limit, z[doubtful].real, 0.0)
        if self.singular:
            return Motions(z, growth)
        s = 1 / z
        return Motions(s, np.where(growth > 0, s.real, 0.0))

    def _scaled(self) -> tuple[Array, Array, Array]:
        """W and W^-1 K W^-1, W^-1 C W^-1 over the masses, W the frequencies."""
        w = self.frequencies
        scale = w[:, None] * w[None, :]
        return w, np.linalg.solve(self.M, self.K) / scale, np.linalg.solve(self.M, self.C) / scale

    def _by_rates(self) -> Array:
        """s of (W q, q')."""
        w, K, C = self._scaled()
        nothing = np.zeros_like(K)
        lower = (-w[:, None] * K, -w[:, None] * C * w)
        return np.block([[nothing, nothing + np.diag(w)], [*lower]])

    def _by_inverse(self) -> Array:
        """1/s of the same."""
        w, K, C = self._scaled()
        nothing = np.zeros_like(K)
        inverse = _inverse(K)
        return np.block([[nothing, nothing + np.diag(1 / w)], [-inverse / w, -inverse @ C]])


def _inverse(stack: NDArray[Any]) -> NDArray[Any]:
    """The inverse of every matrix; of one that is singular to the last bit, next to it."""
    try:
        return np.linalg.inv(stack)
    except np.linalg.LinAlgError:  # the very force of a divergence
        return np.linalg.inv(stack + ROUNDING * np.abs(stack).max() * np.eye(stack.shape[-1]))


def _roots(squares: NDArray[Any]) -> Complex:
    s = np.sqrt(squares.astype(complex))
    return np.asarray(np.where(s.imag < 0, -s, s))
