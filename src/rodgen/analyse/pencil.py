"""The equations linearised about a state at rest or in flight: (S0 + s S1 + s^2 S2) z = 0.

z holds a column for the angle of every moving link and two for the force in the joint before it,
in cells; the blocks are SymPy's derivatives of the equations with the joint forces as unknowns
(derivation 3), so that every matrix is block-tridiagonal and solving costs O(n).
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from scipy.linalg import block_diag
from scipy.sparse import block_array, csc_array, issparse

from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.integrate import blocks as banded
from rodgen.integrate.blocks import Matrix, places

Scales = tuple[Array, Array]
NUDGE = 2.0**-52  # of the largest entry: a rounding
ASIDE = 2.0**-45  # of the speed, to either side of straight ahead: more than a rounding
NO_DRAG = 1e-24  # of the root of stiffness times inertia: damping that is none
SMALL = 200  # unknowns up to which full matrices take less time than sparse ones
SINGULAR = "the linearised equations are singular"


@dataclass(frozen=True)
class Cells:
    """The implicit form without angular rates and accelerations: residual (cells, 3), derivatives
    by angle, rate (3, cells, 3), unknowns (3, cells, 3, 3), and by the velocities of the joints at
    the start and at the end of every link (2, cells, 3, 2). Of a rod that is anchored also by their
    positions, and how these follow the angles (cells + 1, 2, cells)."""

    residual: Array
    by_angle: Array
    by_rate: Array
    by_unknown: Array
    by_velocity: Array
    by_position: Array | None = None
    ways: Array | None = None

    @classmethod
    def at(cls, rod: SteadyRod, at: Unknowns, p: Array) -> Cells:
        """Of a rod that flies straight ahead with the speed of the system, or is at rest.

        In flight a law may have a kink, as that of external damping has: derivatives are the means
        of both of its sides.
        """
        made = cls._in(rod, rod.flying(at), at.force, p)
        if not rod.speed:
            return made
        aside = ASIDE * rod.speed
        left, right = (cls._in(rod, rod.flying(at, side), at.force, p) for side in (aside, -aside))
        names = [field.name for field in fields(cls)][1:6]
        means = {k: (getattr(left, k) + getattr(right, k)) / 2 for k in names[:4]}
        return replace(made, **means)

    @classmethod
    def across(cls, rod: SteadyRod, at: Unknowns, p: Array) -> Cells:
        """Of a free rod that moves across its axis alone, as fast as it flies."""
        y = replace(rod, speed=0.0).flying(at, rod.speed)
        return cls._in(rod, y, at.force, p)

    @classmethod
    def _in(cls, rod: SteadyRod, y: Array, force: Array, p: Array) -> Cells:
        parts = rod.model.implicit(rod.t, y, p, np.zeros(rod.cells), force)
        if not all(np.isfinite(part).all() for part in parts):
            raise AnalysisError("the linearised equations are not finite")
        return cls(*parts, *([cls._ways(rod, y, p)] if rod.anchored else []))

    @staticmethod
    def _ways(rod: SteadyRod, y: Array, p: Array) -> Array:
        """How the joints at the ends of moving links follow the angles."""
        joints = np.arange(rod.scene.held, rod.scene.rod.links + 1)
        return rod.joint_ways(y, p, joints)[..., rod.base :]

    @property
    def statics(self) -> Array:
        """Derivatives by angle and joint force, (3, cells, 3, 3)."""
        return np.concatenate((self.by_angle[..., None], self.by_unknown[..., 1:]), axis=-1)

    def solved(self, right: Array, shift: float = 0.0) -> Array:
        """Changes of angles and joint forces (cells, 3) that change the residual by so much; shift:
        times which inertia is added to the stiffness [1/s^2]."""
        blocks = self.statics + shift * Pencil.of(self).S2 if shift else self.statics
        return solve(blocks, right.ravel()).reshape(-1, 3)

    def whole(self, blocks: Matrix, by_joints: Array | None) -> Array:
        """The matrix of blocks, with what follows the joints of an anchored rod."""
        matrix: Array = _whole(blocks)
        assert by_joints is not None
        assert self.ways is not None
        for d, rows in enumerate(by_joints):
            for i, by_joint in enumerate(rows):
                matrix[3 * i : 3 * i + 3, ::3] += by_joint @ self.ways[i + d]
        return matrix

    def reduced(self) -> Dense:
        """The dense matrices of the angles alone; (K + s C + s^2 M) phi = 0."""
        pencil = Pencil.of(self)
        if self.ways is None:
            return pencil.reduced()
        K, C = self.whole(pencil.S0, self.by_position), self.whole(pencil.S1, self.by_velocity)
        forced = np.arange(len(K)) % 3 > 0
        lean = np.linalg.solve(K[np.ix_(forced, forced)].T, K[~forced][:, forced].T).T
        every = (K, C, _whole(pencil.S2))
        K, C, M = (S[~forced][:, ~forced] - lean @ S[forced][:, ~forced] for S in every)
        return Dense(K, C, M)


@dataclass(frozen=True)
class Quadratic:
    """S(s) = S0 + s S1 + s^2 S2."""

    S0: Any
    S1: Any
    S2: Any

    @property
    def parts(self) -> tuple[Any, Any, Any]:
        """S0, S1 and S2."""
        return self.S0, self.S1, self.S2

    @property
    def damping(self) -> float:
        """How strong the effect of rates is, in comparison with stiffness and inertia."""
        return _damping(*self.parts)

    @property
    def damped(self) -> bool:
        """Whether rates have an effect."""
        return self.damping > NO_DRAG

    def at(self, s: complex) -> Any:
        """S(s)."""
        return self.S0 + s * self.S1 + s * s * self.S2

    def slope(self, s: complex) -> Any:
        """S'(s)."""
        return self.S1 + 2 * s * self.S2


class Pencil(Quadratic):
    """S0, S1, S2 as blocks (3, cells, 3, 3) by the cell before, own and after."""

    @classmethod
    def of(cls, cells: Cells) -> Pencil:
        """From the implicit form at a steady state."""
        nothing = np.zeros_like(cells.by_unknown[..., 1:])
        rate = np.concatenate((cells.by_rate[..., None], nothing), axis=-1)
        inertia = np.concatenate((cells.by_unknown[..., :1], nothing), axis=-1)
        return cls(cells.statics, rate, inertia)

    @property
    def cells(self) -> int:
        return int(self.S0.shape[1])

    def solve(self, S: Matrix, right: Matrix, transposed: bool = False) -> Matrix:
        """z of S z = right, or of its transpose; of a singular S, next to it."""
        try:
            return solve(S, right, transposed)
        except AnalysisError:
            nudged = S.copy()
            nudged[1] += NUDGE * np.abs(S).max() * np.eye(3)
            return solve(nudged, right, transposed)

    @property
    def size(self) -> int:
        """Unknowns."""
        return 3 * self.cells

    def eliminated(self, phi: Matrix) -> tuple[Array, Array, Array]:
        """K phi, C phi, M phi for angles phi (cells, k): (K + s C + s^2 M) phi = 0 is what remains
        where the joint forces follow from the angles; O(n k)."""
        joints, lean = self.S0[:, :, 1:, 1:], self.S0[:, :, :1, 1:]
        felt = [S for S in self.parts if S.any()]
        # Right sides of all three at once: solving takes longer to begin than to do.
        pulls = [product(S[:, :, 1:, :1], phi) for S in felt]
        pressed = product(lean, solve(joints, np.hstack(pulls))) if felt else phi
        pairs = zip(felt, np.hsplit(pressed, max(1, len(felt))), strict=False)
        made = iter([product(S[:, :, :1, :1], phi) - part for S, part in pairs])
        K, C, M = (next(made) if S.any() else np.zeros_like(phi) for S in self.parts)
        return K, C, M

    def reduced(self) -> Dense:
        """The dense matrices of the angles alone."""
        return Dense(*self.eliminated(np.eye(self.cells)))

    def on(self, basis: Matrix) -> Dense:
        """Of motions whose angles are the basis (cells, k) times coordinates, by virtual work."""
        K, C, M = (basis.T @ columns for columns in self.eliminated(basis))
        return Dense(K, C, M)


@dataclass(frozen=True)
class Dense:
    """(K + s C + s^2 M) q = 0 with dense matrices (k, k); added: how many of the last rows are of
    first order, those of states that are added; terms: what the entries of K are summed from, in
    absolute values, where that is more than they are."""

    K: Matrix
    C: Matrix
    M: Matrix
    added: int = 0
    terms: Matrix | None = None

    @property
    def damping(self) -> float:
        """How strong the effect of rates is, as of other linearised equations."""
        return _damping(*self.parts)

    @property
    def damped(self) -> bool:
        """Whether rates have an effect, beyond the rounding of one that has none."""
        return self.damping > NO_DRAG

    def at(self, s: complex) -> Matrix:
        """K + s C + s^2 M."""
        return self.K + s * self.C + s * s * self.M

    @property
    def size(self) -> int:
        """Unknowns."""
        return len(self.K)

    @property
    def parts(self) -> tuple[Matrix, Matrix, Matrix]:
        """K, C and M."""
        return self.K, self.C, self.M

    def reduced(self) -> Dense:
        """Itself, as it has the least unknowns."""
        return self

    def on(self, basis: Matrix) -> Dense:
        """Of motions q = basis times coordinates, by virtual work."""
        whole = block_diag(basis, np.eye(self.added)) if self.added else basis
        K, C, M = (whole.T @ matrix @ whole for matrix in self.parts)
        return Dense(K, C, M, self.added)


def first_order(K: Matrix, C: Matrix, M: Matrix, added: int) -> Matrix:
    """The matrices (..., 2 k + added) of the rates of (q, q', z), z the added states."""
    k = K.shape[-1] - added
    upper = [np.linalg.solve(M[..., :k, :k], -part) for part in (K[..., :k, :], C[..., :k, :k])]
    zero = np.zeros((*K.shape[:-2], k, k))
    top = np.concatenate((zero, zero + np.eye(k), np.zeros((*K.shape[:-2], k, added))), axis=-1)
    middle = np.concatenate((upper[0][..., :k], upper[1], upper[0][..., k:]), axis=-1)
    rows = slice(k, None)
    last = -np.concatenate((K[..., rows, :k], C[..., rows, :k], K[..., rows, k:]), axis=-1)
    return np.concatenate((top, middle, last), axis=-2)


@dataclass(frozen=True)
class Parts(Quadratic):
    """S0, S1 and S2 as matrices, dense or sparse; terms: as of Dense, of S0."""

    terms: Any = None

    @classmethod
    def of(cls, linear: Linear) -> Parts:
        """From the linearised equations."""
        if isinstance(linear, Parts):
            return linear
        if isinstance(linear, Pencil):
            return cls(*map(_whole if linear.size <= SMALL else sparse, linear.parts))
        return cls(*linear.parts, linear.terms)

    @classmethod
    def without_turning(cls, pencil: Pencil, turning: Array) -> Parts:
        """Of a rod that turns freely, its rigid rotation with eigenvalue zero taken away: the first
        angle is held, and a moment that only turns the rod as a whole makes up for it. turning:
        columns (3 cells,) of the rigid rotation."""
        S0, S1, S2 = map(sparse, pencil.parts)
        first = csc_array(([1.0], ([0], [0])), shape=(1, len(turning)))
        moment = csc_array((S2 @ turning)[:, None])
        nothing = csc_array((1, 1))
        return cls(
            csc_array(block_array([[S0, moment], [first, None]])),
            *(csc_array(block_array([[S, None], [None, nothing]])) for S in (S1, S2)),
        )

    def at_square(self, square: float) -> Any:
        """S0 + s^2 S2, real: without damping."""
        return self.S0 + square * self.S2

    @property
    def sizes(self) -> Parts:
        """Absolute values, which rounding goes with; of S0 those of its terms, where they are
        known: roundings of many terms are as often up as down."""
        stiffness = abs(self.S0) if self.terms is None else self.terms / len(self.terms)
        return Parts(stiffness, abs(self.S1), abs(self.S2))

    def plus(self, other: Parts, times: float = 1.0) -> Parts:
        """The sum with so many times others."""
        pairs = zip(self.parts, other.parts, strict=True)
        return Parts(*(one + times * two for one, two in pairs))

    def times(self, factor: float) -> Parts:
        """So many times these."""
        return Parts(*(factor * part for part in self.parts))

    def scales(self, rate: float) -> Scales:
        """Factors of rows and columns that make the largest entry of each about one."""
        sizes = abs(self.S0) + rate**2 * abs(self.S2) + rate * abs(self.S1)
        rows = 1 / _largest(sizes, 1)
        return rows, 1 / _largest(_scaled(sizes, (rows, np.ones(len(rows)))), 0)

    def scaled(self, scales: Scales) -> Parts:
        """With rows and columns times their factors."""
        terms = None if self.terms is None else _scaled(self.terms, scales)
        S0, S1, S2 = (_scaled(part, scales) for part in self.parts)
        return Parts(S0, S1, S2, terms)


Linear = Pencil | Dense | Parts


def _damping(stiff: Any, drag: Any, inertia: Any) -> float:
    """The largest entry of the second over the mean of those of the others."""
    if not drag.size or not (most := float(abs(drag).max())):
        return 0.0
    usual = float(np.sqrt(abs(stiff).max() * abs(inertia).max()))
    return most / usual if usual else np.inf


def _scaled(part: Any, scales: Scales) -> Any:
    rows, columns = scales
    if issparse(part):
        return csc_array(part.multiply(rows[:, None]).multiply(columns[None, :]))
    return rows[:, None] * part * columns


def _largest(sizes: Any, axis: int) -> Array:
    most = sizes.max(axis=axis)
    return np.asarray(most.toarray() if issparse(most) else most).ravel()


def sparse(blocks: Matrix) -> csc_array:
    """The matrix of blocks (3, cells, rows, columns)."""
    _, cells, *shape = blocks.shape
    there, rows, columns = places(cells, *shape)
    size = (shape[0] * cells, shape[1] * cells)
    return csc_array((blocks[there], (rows, columns)), shape=size)


def _whole(blocks: Matrix) -> Matrix:
    """The matrix of blocks with all of its zeros."""
    _, cells, *shape = blocks.shape
    there, rows, columns = places(cells, *shape)
    matrix = np.zeros((shape[0] * cells, shape[1] * cells), dtype=blocks.dtype)
    matrix[rows, columns] = blocks[there]
    return matrix


def product(blocks: Matrix, right: Matrix) -> Matrix:
    """The matrix of blocks times a vector, or vectors (size, k)."""
    made = _whole if max(blocks.shape[2:]) * blocks.shape[1] <= SMALL else sparse
    return np.asarray(made(blocks) @ right)


def solve(blocks: Matrix, right: Matrix, transposed: bool = False) -> Matrix:
    """As blocks.solve; raises AnalysisError for a singular matrix."""
    try:
        return banded.solve(blocks, right, transposed)
    except np.linalg.LinAlgError:
        raise AnalysisError(SINGULAR) from None


def forces(rod: SteadyRod, at: Unknowns, p: Array) -> tuple[Array, Array]:
    """Angular accelerations (cells,) [rad/s^2] and joint forces over the mass of a link (cells, 2)
    [m/s^2] of the rod at rest, or in flight: the implicit form is linear in both."""
    cells = Cells.at(rod, at._replace(force=np.zeros((rod.cells, 2))), p)
    unknowns = solve(cells.by_unknown, -cells.residual.ravel()).reshape(-1, 3)
    return unknowns[:, 0], unknowns[:, 1:]
