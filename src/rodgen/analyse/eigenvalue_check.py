"""Checks of stability verdicts by eigenvalues of the full linearised equations: in no basis of
modes, with neutral motions, and without the approximation for weak damping."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from rodgen.analyse.eigenvalues import Complex, nearest_eigenvalues, square_roots
from rodgen.analyse.load_family import LoadFamily
from rodgen.analyse.modal import (
    MOST_DENSE,
    ROUNDING,
    ModalEquations,
    ModalMotions,
    condition_numbers,
    growth_beyond_rounding,
    rounding_growth,
)
from rodgen.analyse.onset import LoadSearch, Onset
from rodgen.analyse.pencil import BlockPencil, DensePencil
from rodgen.arrays import Array

ALIKE = 2.0  # times: growths by two routes that differ by less are one
NOISE = 1024 * ROUNDING  # of a matrix: roundings of what it was made of
ASIDE = 1e-3, 1e-4, 1e-2  # of an onset, to either side of it: the next where one tells nothing
NEXT = 1e-6  # of EI/L^2: no closer than that
BESIDE = 1e-3  # of the lowest frequency: away from what is singular
MANY = 40  # links beyond which eigenvalues next to a rate cost less than all of them
NEAREST = 4  # eigenvalues next to an onset, of a rod of many links


@dataclass(frozen=True)
class FullSpectrum(ModalMotions):
    """Small motions by eigenvalues of the full equations. matrix: which has the eigenvalues s, or
    s^2 if `squared`, if it was formed."""

    squared: bool = False
    matrix: Array | None = None

    @classmethod
    def of(cls, dense: DensePencil, lowest: float) -> FullSpectrum:
        """Compute all eigenvalues; lowest: the lowest frequency of the rod [rad/s]."""
        own = dense.size - dense.added
        squares = np.linalg.solve(dense.S2[:own, :own], -dense.S0[:own, :own])
        if not (dense.is_damped or dense.added):
            return cls.of_matrix(squares, lowest, squared=True)
        scale = np.full(own, np.sqrt(np.linalg.norm(squares)) or 1.0)
        K, C, M = (part[None] for part in dense.parts)
        return cls.of_matrix(
            ModalEquations(K, C, M, scale, added=dense.added).first_order_matrices()[0], lowest
        )

    @classmethod
    def of_matrix(cls, matrix: Array, lowest: float = 0.0, squared: bool = False) -> FullSpectrum:
        """Compute all eigenvalues of a matrix; squared: those of the matrix are s^2."""
        z = np.linalg.eigvals(matrix).astype(complex)
        s = square_roots(z) if squared else z
        growth = growth_beyond_rounding(s, lowest, ALIKE)
        grows = np.flatnonzero(growth)
        if len(grows):
            across = np.where(z.real < 0, np.abs(z.imag), np.abs(z)) if squared else z.real
            sure = across[grows] > _error_bounds(matrix, z[grows])
            growth[grows[~sure]] = 0.0
        return cls(s, growth, squared, matrix)

    @classmethod
    def nearest(cls, family: LoadFamily, load: float, s: complex) -> FullSpectrum:
        """Compute the eigenvalues nearest to s, of a rod of many links."""
        linear, state = family.linearise(load), family.steady_state(load)
        assert isinstance(linear, BlockPencil)
        found = nearest_eigenvalues(linear, s, NEAREST, state.free_rotation)
        return cls(found, growth_beyond_rounding(found, family.lowest_frequency, ALIKE))

    def growth_bound(self, s: complex) -> float:
        """Largest growth of the eigenvalue nearest to s that rounding errors allow."""
        near = self.s[[np.argmin(np.abs(self.s - s))]]
        if self.matrix is None:
            return float(near[0].real)
        error = float(_error_bounds(self.matrix, near**2 if self.squared else near)[0])
        if self.squared:
            error /= 2 * max(abs(near[0]), np.sqrt(error))
        return float(near[0].real) + error


def _error_bounds(matrix: Array, z: Complex) -> Array:
    """Bounds of the rounding errors of eigenvalues of a matrix."""
    return (
        NOISE
        * float(np.linalg.norm(matrix))
        * condition_numbers(matrix, z.real + 1j * np.abs(z.imag))
    )


def full_spectrum(family: LoadFamily, load: float, near: complex | None = None) -> FullSpectrum:
    """Compute the eigenvalues of the linearised equations under a load; of many links only those
    nearest to ``near``, by default to zero."""
    if family.rod.is_light:  # by the inverse, in which slow motions keep their digits
        found = family.motions(np.array([load]), family.n_modes)
        return FullSpectrum(found.s[0], found.growth[0])
    most = MOST_DENSE if near is None else MANY
    if family.rod.n_moving > most and isinstance(family.linearise(load), BlockPencil):
        return FullSpectrum.nearest(family, load, near or 0j)
    return FullSpectrum.of(family.dense_pencil(load), family.lowest_frequency)


def find_contradiction(search: LoadSearch, loads: Iterable[float]) -> str:
    """Describe where eigenvalues contradict the growing motions of a search, "" if they do not."""
    for load in loads:
        said = next(search.family.iterate_motions(np.array([load]), search.modes))
        found = full_spectrum(search.family, load)
        if is_contradiction(found, said, search.family.lowest_frequency):
            return (
                f"what grows under {load:.6g} is not known: {int(said.n_growing)} motions in "
                f"modes, {found.n_growing} by the eigenvalues of the whole"
            )
    return ""


def is_contradiction(found: FullSpectrum, said: ModalMotions, lowest: float) -> bool:
    """Whether more motions grow than were found in modes, or the fastest of those does not grow."""
    if found.n_growing > said.n_growing:
        return True
    at = int(np.argmax(said.growth))
    told, s = float(said.growth[at]), complex(said.s[at])
    if told <= ALIKE * float(rounding_growth(s, lowest)) or told <= ALIKE * found.s.real.max(
        initial=0.0
    ):
        return False
    return told > ALIKE * found.growth_bound(s)


def find_onset_contradiction(search: LoadSearch, onset: Onset, begins: bool) -> str:
    """Describe why no motion begins to grow at an onset, or ceases to; "" if one does, and where
    all damping is too weak to tell."""
    family, low, s = search.family, float(search.forces[0]), onset.s
    most, beside = -np.inf, s + BESIDE * family.lowest_frequency
    for aside in ASIDE:
        away = max(aside * abs(onset.force), NEXT * family.unit, 10 * onset.error)
        sides = max(onset.force - away, low), onset.force + away
        calm, grown = (
            full_spectrum(family, load, beside) for load in (sides if begins else sides[::-1])
        )
        if grown.n_growing > calm.n_growing:
            return ""
        most = grown.growth_bound(s)
    least = float(rounding_growth(s, family.lowest_frequency))  # less growth is not seen
    if most > (-least if family.is_damped else ALIKE * least):
        return ""
    return f"no motion grows beside {onset.force:.6g} by the eigenvalues of the whole"
