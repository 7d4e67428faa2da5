"""Small motions under each of many loads, in a basis of modes: their growth beyond rounding, and
those that are neutral, with eigenvalues that are zero under every load, by symmetry.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from rodgen.analyse.eigenvalues import Complex, square_roots
from rodgen.analyse.pencil import first_order_matrix
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
    lapack = scipy.linalg.lapack  # SciPy's qr takes as long to look at small matrices
    factors, _, tau, _, _ = lapack.dgeqp3(A.T)
    across = lapack.dorgqr(factors, tau)[0][:, : len(A) - count]
    return np.asarray(across.T @ A @ across)


@dataclass(frozen=True)
class ModalMotions:
    """Small motions under one or many forces. s: eigenvalues [1/s] (forces, k), of undamped motions
    one of each pair of opposites, with imaginary part >= 0; growth: real parts where these are more
    than rounding, else not above zero."""

    s: Complex
    growth: Array

    def split(self) -> Iterator[ModalMotions]:
        """Yield the motions under each force in turn."""
        return map(ModalMotions, self.s, self.growth)

    def pad(self, count: int) -> ModalMotions:
        """Append motions with s nan and growth zero, up to ``count``."""
        none = np.zeros(count - len(self.s))
        return ModalMotions(np.append(self.s, none + np.nan), np.append(self.growth, none))

    @property
    def n_growing(self) -> NDArray[np.int_]:
        """Number of growing eigenvalues under every force."""
        return np.asarray((self.growth > 0).sum(axis=-1))


@dataclass(frozen=True)
class ModalEquations:
    """Linearised equations (K + s C + s^2 M) q = 0 in modes of the unloaded rod, under many forces:
    stacks (forces, k, k). frequencies (k,) [rad/s]: of the modes, of rigid motions the lowest."""

    K: Array
    C: Array
    M: Array
    frequencies: Array
    neutral: NeutralMotions = NONE  # what has no rate under any force
    added: int = 0  # states of first order, the last rows
    by_inverse: bool = False  # of which the mass matrix is nearly singular

    @property
    def damping_ratio(self) -> float:
        """Largest damping ratio of a mode, or of the coupling of two."""
        if not self.C.any():
            return 0.0
        masses = np.sqrt(np.abs(np.diagonal(self.M, axis1=-2, axis2=-1)) * self.frequencies)
        shares = np.abs(self.C) / (masses[..., :, None] * masses[..., None, :])
        return float(shares.max()) / 2

    def motions(self) -> ModalMotions:
        """Compute all motions. Undamped ones by s^2; weak damping by its work on undamped motions,
        since its effect is lost in the rounding of a frequency; strong damping by the inverse, in
        which slow motions keep their digits beside fast ones."""
        every = list(self.iterate_motions())
        return ModalMotions(
            np.stack([one.s for one in every]), np.stack([one.growth for one in every])
        )

    def iterate_motions(self) -> Iterator[ModalMotions]:
        """Yield the motions under each force in turn; damped ones are computed on demand."""
        if self.by_inverse and self.added and not self.neutral.steps:
            return map(self._motions_by_inverse, range(len(self.K)))
        if self.added or self.neutral.steps:
            every = self.first_order_matrices()
            found = map(motions_of_matrix, map(self.neutral.reduce, every))
            return (one.pad(every.shape[-1]) for one in found)
        if not self.C.any():
            return self._undamped_motions().split()
        if not self.by_inverse and self.damping_ratio < WEAK:
            return self._weakly_damped_motions().split()
        return self._strongly_damped_motions()

    def _undamped_motions(self) -> ModalMotions:
        lowest = self.frequencies.min()
        if not self.by_inverse:
            s = square_roots(np.linalg.eigvals(np.linalg.solve(self.M, -self.K)))
            return ModalMotions(s, growth_beyond_rounding(s, lowest))
        K, M = (part / self.frequencies[:, None] / self.frequencies for part in (self.K, self.M))
        z = np.linalg.eigvals(np.linalg.solve(K, -M))
        s = square_roots(1 / z)
        noise = CRUDE * ROUNDING * len(self.frequencies) / (lowest**2 * np.abs(z))
        growth = growth_beyond_rounding(s, lowest)
        return ModalMotions(s, np.where(growth > noise * np.abs(s), growth, 0.0))

    def _motions_by_inverse(self, at: int) -> ModalMotions:
        """Motions under a force with added states, which have no inertia: as many eigenvalues are
        infinite."""
        w = np.append(self.frequencies, np.ones(self.added))
        K, C, M = (part[at] / w[:, None] / w for part in (self.K, self.C, self.M))
        right = np.linalg.solve(K, np.hstack((M, C)))
        zero, size = np.zeros_like(K), len(K)
        A = np.block([[zero, np.eye(size)], [-right[:, :size], -right[:, size:]]])
        found = motions_of_matrix(A, inverse=True)
        kept = np.argsort(np.abs(found.s))[: 2 * size - self.added]
        return ModalMotions(found.s[kept], found.growth[kept])

    def _weakly_damped_motions(self) -> ModalMotions:
        """First-order effect of damping: s = +-s0 - (y C x)/(2 y M x), with undamped s0, x, y."""
        squares, x = np.linalg.eig(np.linalg.solve(self.M, -self.K))
        y, drag = _invert(x), np.linalg.solve(self.M, self.C)
        change = -np.einsum("fki,fij,fjk->fk", y, drag, x) / 2
        terms = np.einsum("fki,fij,fjk->fk", np.abs(y), np.abs(drag), np.abs(x)) / 2
        s = square_roots(squares)
        grown = growth_beyond_rounding(s, self.frequencies.min())
        small = np.where(change.real > CANCELLED * terms, change.real, 0.0)
        shrunk = np.where(grown > 0, -grown, small)
        pairs = np.concatenate((s + change, -s + change), axis=-1)
        return ModalMotions(
            pairs, np.concatenate((np.where(grown > 0, grown, small), shrunk), axis=-1)
        )

    def _strongly_damped_motions(self) -> Iterator[ModalMotions]:
        """Yield the motions by the inverse; by first-order matrices without neutral motions under a
        force at which the stiffness is singular."""
        stiff = self.K / (self.frequencies[:, None] * self.frequencies)
        for at, A in enumerate(self._inverse_matrices()):
            suspect = np.linalg.norm(A) * self.frequencies.min() > SUSPECT
            if suspect and np.linalg.cond(stiff[at]) * CRUDE * ROUNDING > 1:
                alone = replace(
                    self, K=self.K[at], C=self.C[at], M=self.M[at]
                ).first_order_matrices()
                yield motions_of_matrix(NeutralMotions.of([alone]).reduce(alone)).pad(len(A))
                continue
            yield motions_of_matrix(A, inverse=True)

    def first_order_matrices(self) -> Array:
        """First-order matrices with eigenvalues s, of (W q, q', z): W the frequencies, z the added
        states."""
        w, k = self.frequencies, len(self.frequencies)
        A = first_order_matrix(self.K, self.C, self.M, self.added)
        A[..., :k] /= w
        A[..., :k, :] *= w[:, None]
        return A

    def _inverse_matrices(self) -> Array:
        """Matrices with eigenvalues 1/s, of (W q, q')."""
        w = self.frequencies
        scale = w[:, None] * w
        right = np.concatenate((self.M / w[:, None], self.C / scale), axis=-1)
        K, k = self.K / scale, len(w)
        try:
            made = np.linalg.solve(K, right)
        except np.linalg.LinAlgError:
            made = _invert(K) @ right
        return self._assemble_blocks(1 / w, -made[..., :k], -made[..., k:])

    @staticmethod
    def _assemble_blocks(top: Array, left: NDArray[Any], right: NDArray[Any]) -> Array:
        """Assemble block matrices [[0, diag(top)], [left, right]]."""
        k = len(top)
        made = np.zeros((*left.shape[:-2], 2 * k, 2 * k))
        made[..., range(k), range(k, 2 * k)] = top
        made[..., k:, :k], made[..., k:, k:] = left, right
        return made


def motions_of_matrix(A: Array, inverse: bool = False) -> ModalMotions:
    """Motions of a matrix with eigenvalues s, or 1/s, and their growth beyond rounding."""
    size = float(np.linalg.norm(A))
    z = _eigenvalues(A, size)
    s = 1 / z if inverse else z
    growth = np.zeros(len(z))
    grows = np.flatnonzero(z.real > CRUDE * ROUNDING * size)
    if len(grows):
        limit = SAFE * ROUNDING * size * condition_numbers(A, z[grows])
        grows = grows[z[grows].real > limit]
        growth[grows] = s[grows].real
    return ModalMotions(s, growth)


def _eigenvalues(A: Array, size: float) -> Complex:
    """Eigenvalues of a matrix of norm ``size``, by the LAPACK function that numpy.linalg.eigvals
    calls, without its checks, which take a tenth of the time. Raises LinAlgError as that does."""
    if not np.isfinite(size):
        raise np.linalg.LinAlgError("the matrix is not finite")
    real, imaginary, _, _, failed = scipy.linalg.lapack.dgeev(A, compute_vl=0, compute_vr=0)
    if failed:
        raise np.linalg.LinAlgError("the eigenvalues did not converge")
    return np.asarray(real + 1j * imaginary, dtype=np.complex128)


def condition_numbers(A: Array, z: Complex) -> Array:
    """Condition numbers of eigenvalues: how far a small change of the matrix can move each, over
    its size. By left and right vectors, from two steps of inverse iteration; those of a conjugate
    pair, one behind the other, are alike."""
    first = z.imag >= 0
    if not first.all():
        return np.asarray(condition_numbers(A, z[first])[np.cumsum(first) - 1])
    beside = z + 4 * ROUNDING * np.abs(z)
    inverse = _invert(A - beside[:, None, None] * np.eye(len(A)))
    x = y = np.tile(np.cos(np.arange(len(A)) ** 2 / 7.0), (len(z), 1))
    for _ in range(2):
        x, y = np.einsum("fij,fj->fi", inverse, x), np.einsum("fji,fj->fi", inverse, y)
        x, y = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (x, y))
    return np.asarray(1 / np.abs((x * y).sum(axis=-1)))


def _invert(stack: NDArray[Any]) -> NDArray[Any]:
    """Invert every matrix of a stack; one that is exactly singular after a nudge."""
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


def rounding_growth(s: Complex | complex, lowest: float) -> Array:
    """Growth [1/s] that may be rounding, of eigenvalues s; lowest: the lowest frequency [rad/s]."""
    return np.asarray(GROWS * lowest + MET * np.abs(s))


def growth_beyond_rounding(s: Complex, lowest: float, times: float = 1.0) -> Array:
    """Real parts of eigenvalues s that are more than so many times rounding, else 0."""
    return np.where(s.real > times * rounding_growth(s, lowest), s.real, 0.0)


def growing_eigenvalue(grown: Complex, other: Complex) -> complex:
    """Eigenvalue that begins to grow: the one of ``grown`` farthest from all of ``other``, as zero,
    or as i omega where it oscillates."""
    if not len(grown):
        return 0j
    near = np.abs(grown[:, None] - other[None, :]).min(axis=1, initial=np.inf)
    s = grown[np.argmax(near / np.abs(grown))]
    # Just beyond divergence a rate is real; with damping flutter has an imaginary part.
    return 0j if abs(s.imag) <= abs(s.real) else complex(1j * abs(s.imag))
