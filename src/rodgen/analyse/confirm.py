"""Verdicts of stability held against eigenvalues of the linearised equations themselves, in which
no basis of modes, no neutral motions taken out and no work of a weak damping has a part."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from rodgen.analyse.eigen import Complex, nearest_values, roots
from rodgen.analyse.family import Family
from rodgen.analyse.modal import MOST_DENSE, ROUNDING, Modal, Motions, conditions, slight
from rodgen.analyse.onset import Onset
from rodgen.analyse.pencil import Dense, Pencil
from rodgen.analyse.search import Search
from rodgen.arrays import Array

ALIKE = 2.0  # times: growths by two routes that differ by less are one
NOISE = 1024 * ROUNDING  # of a matrix: roundings of what it was made of
ASIDE = 1e-3, 1e-4, 1e-2  # of an onset, to either side of it: the next where one tells nothing
NEXT = 1e-6  # of EI/L^2: no closer than that
BESIDE = 1e-3  # of the lowest frequency: away from what is singular
MANY = 40  # links beyond which eigenvalues next to a rate cost less than all of them
NEAREST = 4  # eigenvalues next to an onset, of a rod of many links


@dataclass(frozen=True)
class Eigenvalues:
    """s [1/s] (k,), of undamped motions one of each pair of opposites; growth (k,): their real
    parts where these are more than rounding, else 0; matrix: of which they, or squared their
    squares, are eigenvalues, if it was made."""

    s: Complex
    growth: Array
    squared: bool = False
    matrix: Array | None = None

    @classmethod
    def of(cls, dense: Dense, lowest: float) -> Eigenvalues:
        """All; lowest: the lowest frequency of the rod [rad/s]."""
        own = len(dense.K) - dense.added
        squares = np.linalg.solve(dense.M[:own, :own], -dense.K[:own, :own])
        if not (dense.damped or dense.added):
            return cls.of_matrix(squares, lowest, squared=True)
        scale = np.full(own, np.sqrt(np.linalg.norm(squares)) or 1.0)
        K, C, M = (part[None] for part in dense.parts)
        return cls.of_matrix(Modal(K, C, M, scale, added=dense.added).by_rates()[0], lowest)

    @classmethod
    def of_matrix(cls, matrix: Array, lowest: float = 0.0, squared: bool = False) -> Eigenvalues:
        """All of a matrix, or those whose squares it has."""
        z = np.linalg.eigvals(matrix).astype(complex)
        s = roots(z) if squared else z
        growth = _visible(s, lowest)
        grows = np.flatnonzero(growth)
        if len(grows):
            across = np.where(z.real < 0, np.abs(z.imag), np.abs(z)) if squared else z.real
            sure = across[grows] > _errors(matrix, z[grows])
            growth[grows[~sure]] = 0.0
        return cls(s, growth, squared, matrix)

    @classmethod
    def beside(cls, family: Family, load: float, s: complex) -> Eigenvalues:
        """Those nearest to a rate, of a rod of many links."""
        linear, state = family.at(load), family.state(load)
        assert isinstance(linear, Pencil)
        turning = state.turning if state.turns_freely else None
        found = nearest_values(linear, s, NEAREST, turning)
        return cls(found, _visible(found, family.lowest))

    @property
    def count(self) -> int:
        """How many grow."""
        return int((self.growth > 0).sum())

    def most(self, s: complex) -> float:
        """The growth that the eigenvalue next to a rate may have."""
        near = self.s[[np.argmin(np.abs(self.s - s))]]
        if self.matrix is None:
            return float(near[0].real)
        error = float(_errors(self.matrix, near**2 if self.squared else near)[0])
        if self.squared:
            error /= 2 * max(abs(near[0]), np.sqrt(error))
        return float(near[0].real) + error


def _visible(s: Complex, lowest: float) -> Array:
    return np.where(s.real > ALIKE * slight(s, lowest), s.real, 0.0)


def _errors(matrix: Array, z: Complex) -> Array:
    """How far off eigenvalues of a matrix may be."""
    return NOISE * float(np.linalg.norm(matrix)) * conditions(matrix, z.real + 1j * np.abs(z.imag))


def eigenvalues(family: Family, load: float, near: complex | None = None) -> Eigenvalues:
    """Of the linearised equations under a load; of many links those next to a rate, which is zero
    where none is given."""
    most = MOST_DENSE if near is None else MANY
    if family.rod.cells > most and isinstance(family.at(load), Pencil):
        return Eigenvalues.beside(family, load, near or 0j)
    return Eigenvalues.of(family.equations(load), family.lowest)


def contradiction(search: Search, loads: Iterable[float]) -> str:
    """Why what grows under some loads is not what a search counts, "" where it is."""
    for load in loads:
        said = next(search.family.each(np.array([load]), search.modes))
        found = eigenvalues(search.family, load)
        if contradicts(found, said, search.family.lowest):
            return (
                f"what grows under {load:.6g} is not known: {int(said.count)} motions in modes, "
                f"{found.count} by the eigenvalues of the whole"
            )
    return ""


def contradicts(found: Eigenvalues, said: Motions, lowest: float) -> bool:
    """Whether more grows than by the motions in modes, or what grows most by those does not."""
    if found.count > said.count:
        return True
    at = int(np.argmax(said.growth))
    told, s = float(said.growth[at]), complex(said.s[at])
    if told <= ALIKE * float(slight(s, lowest)) or told <= ALIKE * found.s.real.max(initial=0.0):
        return False
    return told > ALIKE * found.most(s)


def onset_contradiction(search: Search, onset: Onset, begins: bool) -> str:
    """Why a motion does not begin to grow at an onset, or does not cease to; "" if it does, and
    where all damping is too weak to tell."""
    family, low, s = search.family, float(search.forces[0]), onset.s
    most, beside = -np.inf, s + BESIDE * family.lowest
    for aside in ASIDE:
        away = max(aside * abs(onset.force), NEXT * family.unit, 10 * onset.error)
        sides = max(onset.force - away, low), onset.force + away
        calm, grown = (
            eigenvalues(family, load, beside) for load in (sides if begins else sides[::-1])
        )
        if grown.count > calm.count:
            return ""
        most = grown.most(s)
    least = float(slight(s, family.lowest))  # less growth is not seen
    if most > (-least if family.damped else ALIKE * least):
        return ""
    return f"no motion grows beside {onset.force:.6g} by the eigenvalues of the whole"
