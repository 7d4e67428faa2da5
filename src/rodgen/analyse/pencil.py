"""The equations linearised about a state at rest or in flight: (S0 + s S1 + s^2 S2) z = 0.

z holds a column for the angle of every moving link and two for the force in the joint before it,
in cells; the blocks are SymPy's derivatives of the equations with the joint forces as unknowns
(derivation 3), so that every matrix is block-tridiagonal and solving costs O(n).
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded
from scipy.sparse import block_array, csc_array, eye_array
from scipy.sparse.linalg import splu

from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.system import System
from rodgen.integrate.stepper import Array

Matrix = NDArray[Any]
NUDGE = 2.0**-52  # of the largest entry: a rounding
ASIDE = 2.0**-45  # of the speed, to either side of straight ahead: more than a rounding
SINGULAR = "the linearised equations are singular"


@dataclass(frozen=True)
class Cells:
    """The implicit form without angular rates and accelerations: residual (cells, 3), derivatives
    by angle, rate (3, cells, 3), unknowns (3, cells, 3, 3), and by the velocities of the joints at
    the start and at the end of every link (2, cells, 3, 2)."""

    residual: Array
    by_angle: Array
    by_rate: Array
    by_unknown: Array
    by_velocity: Array

    @classmethod
    def at(cls, system: System, phi: Array, force: Array, p: Array) -> Cells:
        """Of a rod that flies straight ahead with the speed of the system, or is at rest.

        phi (cells,); force (cells, 2) over the mass of a link [m/s^2]. In flight a law may have a
        kink, as that of external damping has: derivatives are the means of both of its sides.
        """
        made = cls._in(system, system.flying(phi), force, p)
        if not system.speed:
            return made
        aside = ASIDE * system.speed
        left, right = (
            cls._in(system, system.flying(phi, side), force, p) for side in (aside, -aside)
        )
        names = [field.name for field in fields(cls)][1:]
        return cls(made.residual, *((getattr(left, k) + getattr(right, k)) / 2 for k in names))

    @classmethod
    def across(cls, system: System, phi: Array, force: Array, p: Array) -> Cells:
        """Of a free rod that moves across its axis alone, as fast as it flies."""
        y = replace(system, speed=0.0).flying(phi, system.speed)
        return cls._in(system, y, force, p)

    @classmethod
    def _in(cls, system: System, y: Array, force: Array, p: Array) -> Cells:
        parts = system.model.implicit(0.0, y, p, np.zeros(system.cells), force)
        if not all(np.isfinite(part).all() for part in parts):
            raise AnalysisError("the linearised equations are not finite")
        return cls(*parts)

    @property
    def statics(self) -> Array:
        """Derivatives by angle and joint force, (3, cells, 3, 3)."""
        return np.concatenate((self.by_angle[..., None], self.by_unknown[..., 1:]), axis=-1)


@dataclass(frozen=True)
class Pencil:
    """S0, S1, S2 as blocks (3, cells, 3, 3) by the cell before, own and after."""

    S0: Matrix
    S1: Matrix
    S2: Matrix

    @classmethod
    def of(cls, cells: Cells) -> Pencil:
        """From the implicit form at a steady state."""
        nothing = np.zeros_like(cells.by_unknown[..., 1:])
        rate = np.concatenate((cells.by_rate[..., None], nothing), axis=-1)
        inertia = np.concatenate((cells.by_unknown[..., :1], nothing), axis=-1)
        return cls(cells.statics, rate, inertia)

    @property
    def damped(self) -> bool:
        """Whether rates have an effect."""
        return bool(self.S1.any())

    @property
    def parts(self) -> tuple[Matrix, Matrix, Matrix]:
        """S0, S1 and S2."""
        return self.S0, self.S1, self.S2

    @property
    def cells(self) -> int:
        return int(self.S0.shape[1])

    def at(self, s: complex) -> Matrix:
        """Blocks of S0 + s S1 + s^2 S2."""
        return self.S0 + s * self.S1 + s * s * self.S2

    def at_square(self, square: float) -> Matrix:
        """Blocks of S0 + s^2 S2, real: without damping."""
        return self.S0 + square * self.S2

    def solve(self, S: Matrix, right: Matrix, transposed: bool = False) -> Matrix:
        """z of S z = right, or of its transpose; of a singular S, next to it."""
        try:
            return solve(S, right, transposed)
        except AnalysisError:
            nudged = S.copy()
            nudged[1] += NUDGE * np.abs(S).max() * np.eye(3)
            return solve(nudged, right, transposed)

    def inertia(self, z: Matrix) -> Matrix:
        """S2 z."""
        return _times(self.S2, z)

    def product(self, s: complex, z: Matrix) -> Matrix:
        """S(s) z."""
        return _times(self.at(s), z)

    def slope(self, s: complex, z: Matrix) -> Matrix:
        """S'(s) z."""
        return _times(self.S1 + 2 * s * self.S2, z)

    @property
    def size(self) -> int:
        """Unknowns."""
        return 3 * self.cells

    def eliminated(self, phi: Matrix) -> tuple[Array, Array, Array]:
        """K phi, C phi, M phi for angles phi (cells, k): (K + s C + s^2 M) phi = 0 is what remains
        where the joint forces follow from the angles; O(n k)."""
        joints, lean = self.S0[:, :, 1:, 1:], self.S0[:, :, :1, 1:]

        def felt(S: Matrix) -> Array:
            if not S.any():
                return np.zeros_like(phi)
            forces = solve(joints, _times(S[:, :, 1:, :1], phi))
            return np.asarray(_times(S[:, :, :1, :1], phi) - _times(lean, forces))

        return felt(self.S0), felt(self.S1), felt(self.S2)

    def reduced(self) -> Dense:
        """The dense matrices of the angles alone."""
        return Dense(*self.eliminated(np.eye(self.cells)))


@dataclass(frozen=True)
class Dense:
    """(K + s C + s^2 M) q = 0 with dense matrices (k, k)."""

    K: Matrix
    C: Matrix
    M: Matrix

    @property
    def damped(self) -> bool:
        """Whether rates have an effect."""
        return bool(self.C.any())

    def at(self, s: complex) -> Matrix:
        """K + s C + s^2 M."""
        return self.K + s * self.C + s * s * self.M

    def at_square(self, square: float) -> Matrix:
        """K + s^2 M, real: without damping."""
        return self.K + square * self.M

    def solve(self, S: Matrix, right: Matrix, transposed: bool = False) -> Matrix:
        """z of S z = right, or of its transpose; of a singular S, next to it."""
        try:
            return np.asarray(np.linalg.solve(S.T if transposed else S, right))
        except np.linalg.LinAlgError:
            nudged = S + NUDGE * np.abs(S).max() * np.eye(len(S))
            return np.asarray(np.linalg.solve(nudged.T if transposed else nudged, right))

    def inertia(self, z: Matrix) -> Matrix:
        """M z."""
        return np.asarray(self.M @ z)

    @property
    def size(self) -> int:
        """Unknowns."""
        return len(self.K)

    @property
    def parts(self) -> tuple[Matrix, Matrix, Matrix]:
        """K, C and M."""
        return self.K, self.C, self.M

    def on(self, basis: Matrix) -> Dense:
        """The same for motions q = basis times coordinates, by virtual work."""
        return Dense(*(basis.T @ matrix @ basis for matrix in (self.K, self.C, self.M)))


@dataclass(frozen=True)
class Held:
    """The pencil of a rod that turns freely, its rigid rotation with eigenvalue zero taken away:
    the first angle is held, and a moment that only turns the rod as a whole makes up for it."""

    S0: csc_array
    S1: csc_array
    S2: csc_array

    @property
    def damped(self) -> bool:
        """Whether rates have an effect."""
        return bool(self.S1.nnz and abs(self.S1).max())

    @classmethod
    def of(cls, pencil: Pencil, turning: Array) -> Held:
        """turning: columns (3 cells,) of the rigid rotation."""
        S0, S1, S2 = (sparse(blocks) for blocks in (pencil.S0, pencil.S1, pencil.S2))
        first = csc_array(([1.0], ([0], [0])), shape=(1, len(turning)))
        moment = csc_array((S2 @ turning)[:, None])
        nothing = csc_array((1, 1))
        return cls(
            csc_array(block_array([[S0, moment], [first, None]])),
            *(csc_array(block_array([[S, None], [None, nothing]])) for S in (S1, S2)),
        )

    @property
    def size(self) -> int:
        """Unknowns."""
        return int(self.S0.shape[0])

    def at(self, s: complex) -> csc_array:
        """S0 + s S1 + s^2 S2."""
        return self.S0 + s * self.S1 + s * s * self.S2

    def at_square(self, square: float) -> csc_array:
        """S0 + s^2 S2, real."""
        return self.S0 + square * self.S2

    def solve(self, S: csc_array, right: Matrix, transposed: bool = False) -> Matrix:
        """z of S z = right, or of its transpose; of a singular S, next to it."""
        try:
            factors = splu(csc_array(S))
        except RuntimeError:
            factors = splu(csc_array(S + NUDGE * abs(S).max() * eye_array(self.size)))
        return np.asarray(factors.solve(right.astype(S.dtype), "T" if transposed else "N"))

    def inertia(self, z: Matrix) -> Matrix:
        """S2 z."""
        return np.asarray(self.S2 @ z)


@lru_cache(maxsize=32)
def _places(cells: int, rows: int, columns: int) -> tuple[Matrix, Matrix, Matrix]:
    """Which entries of blocks exist, and their rows and columns in the matrix."""
    offset, cell, row, column = np.indices((3, cells, rows, columns))
    other = cell + offset - 1
    there = (other >= 0) & (other < cells)
    return there, (rows * cell + row)[there], (columns * other + column)[there]


def sparse(blocks: Matrix) -> csc_array:
    """The matrix of blocks (3, cells, rows, columns)."""
    _, cells, *shape = blocks.shape
    there, rows, columns = _places(cells, *shape)
    size = (shape[0] * cells, shape[1] * cells)
    return csc_array((blocks[there], (rows, columns)), shape=size)


def _times(blocks: Matrix, right: Matrix) -> Matrix:
    return np.asarray(sparse(blocks) @ right)


def solve(blocks: Matrix, right: Matrix, transposed: bool = False) -> Matrix:
    """z of (matrix of square blocks) z = right, (size,) or (size, k); O(n). Raises
    AnalysisError."""
    _, cells, size, _ = blocks.shape
    there, rows, columns = _places(cells, size, size)
    if transposed:
        rows, columns = columns, rows
    width = 2 * size - 1
    band = np.zeros((2 * width + 1, size * cells), dtype=blocks.dtype)
    band[width + rows - columns, columns] = blocks[there]
    try:
        found = solve_banded((width, width), band, right, check_finite=False)
    except np.linalg.LinAlgError:
        raise AnalysisError(SINGULAR) from None
    return np.asarray(found)


def forces(system: System, phi: Array, p: Array) -> tuple[Array, Array]:
    """Angular accelerations (cells,) [rad/s^2] and joint forces over the mass of a link (cells, 2)
    [m/s^2] of the rod at rest, or in flight: the implicit form is linear in both."""
    cells = Cells.at(system, phi, np.zeros((system.cells, 2)), p)
    unknowns = solve(cells.by_unknown, -cells.residual.ravel()).reshape(-1, 3)
    return unknowns[:, 0], unknowns[:, 1:]
