"""Equations linearised about a state at rest or in flight: (S0 + s S1 + s^2 S2) z = 0.

z holds a column for the angle of every moving link and two for the force in the joint before it, in
cells; the blocks are SymPy's derivatives of the equations with the joint forces as unknowns
(derivation 3), so that every matrix is block-tridiagonal and solving costs O(n).
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import scipy

from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.integrate import constraint_forces as banded
from rodgen.integrate.constraint_forces import Matrix, block_entries

Scales = tuple[Array, Array]
NUDGE = 2.0**-52  # of the largest entry: a rounding
ASIDE = 2.0**-45  # of the speed, to either side of straight ahead: more than a rounding
NO_DRAG = 1e-24  # of the root of stiffness times inertia: damping that is none
SMALL = 200  # unknowns up to which full matrices take less time than sparse ones
SINGULAR = "the linearised equations are singular"


@dataclass(frozen=True)
class ImplicitBlocks:
    """Implicit equations at zero angular rates and accelerations: residual (n_moving, 3),
    derivatives by angle, rate (3, n_moving, 3), unknowns (3, n_moving, 3, 3), and by the velocities
    of the joints at the start and at the end of every link (2, n_moving, 3, 2)."""

    residual: Array
    by_angle: Array
    by_rate: Array
    by_unknown: Array
    by_velocity: Array

    @classmethod
    def at(cls, rod: SteadyRod, at: Unknowns, p: Array) -> ImplicitBlocks:
        """Evaluate for a rod that flies straight ahead with the speed of the system, or is at rest.

        In flight a law may have a kink, as that of external damping has: derivatives are the means
        of both of its sides.
        """
        made = cls._evaluate(rod, rod.state_in_flight(at), at.force, p)
        if not rod.speed:
            return made
        aside = ASIDE * rod.speed
        left, right = (
            cls._evaluate(rod, rod.state_in_flight(at, side), at.force, p)
            for side in (aside, -aside)
        )
        names = [field.name for field in fields(cls)][1:]
        return replace(made, **{k: (getattr(left, k) + getattr(right, k)) / 2 for k in names})

    @classmethod
    def in_sideways_flight(cls, rod: SteadyRod, at: Unknowns, p: Array) -> ImplicitBlocks:
        """Evaluate for a free rod that moves only across its axis, as fast as it flies."""
        y = replace(rod, speed=0.0).state_in_flight(at, rod.speed)
        return cls._evaluate(rod, y, at.force, p)

    @classmethod
    def _evaluate(cls, rod: SteadyRod, y: Array, force: Array, p: Array) -> ImplicitBlocks:
        parts = rod.model.implicit(rod.t, y, p, np.zeros(rod.n_moving), force)
        if not all(np.isfinite(part).all() for part in parts):
            raise AnalysisError("the linearised equations are not finite")
        return cls(*parts[:5])  # whose positions count is balanced in generalised forces

    @property
    def statics(self) -> Array:
        """Derivatives by angle and joint force, (3, n_moving, 3, 3)."""
        return np.concatenate((self.by_angle[..., None], self.by_unknown[..., 1:]), axis=-1)

    def solve(self, right: Array, shift: float = 0.0) -> Array:
        """Solve for changes of angles and joint forces (n_moving, 3) that change the residual by
        `right`; shift: factor of the inertia added to the stiffness [1/s^2]."""
        blocks = self.statics + shift * BlockPencil.of(self).S2 if shift else self.statics
        return solve(blocks, right.ravel()).reshape(-1, 3)

    def to_dense(self) -> DensePencil:
        """Dense pencil of the angles alone: (K + s C + s^2 M) phi = 0."""
        return BlockPencil.of(self).to_dense()


@dataclass(frozen=True)
class QuadraticPencil:
    """Quadratic pencil S(s) = S0 + s S1 + s^2 S2."""

    S0: Any
    S1: Any
    S2: Any

    @property
    def parts(self) -> tuple[Any, Any, Any]:
        """S0, S1 and S2."""
        return self.S0, self.S1, self.S2

    @property
    def damping(self) -> float:
        """Largest entry of S1 over the geometric mean of those of S0 and S2."""
        if not self.S1.size or not (most := float(abs(self.S1).max())):
            return 0.0
        usual = float(np.sqrt(abs(self.S0).max() * abs(self.S2).max()))
        return most / usual if usual else np.inf

    @property
    def is_damped(self) -> bool:
        """Whether forces depend on rates, beyond rounding."""
        return self.damping > NO_DRAG

    def at(self, s: complex) -> Any:
        """Value S(s)."""
        return self.S0 + s * self.S1 + s * s * self.S2

    def derivative(self, s: complex) -> Any:
        """Derivative S'(s)."""
        return self.S1 + 2 * s * self.S2


class BlockPencil(QuadraticPencil):
    """Block-tridiagonal pencil: blocks (3, n_moving, 3, 3) by the cell before, own and after."""

    @classmethod
    def of(cls, blocks: ImplicitBlocks) -> BlockPencil:
        """Form the pencil from the implicit equations at a steady state."""
        nothing = np.zeros_like(blocks.by_unknown[..., 1:])
        rate = np.concatenate((blocks.by_rate[..., None], nothing), axis=-1)
        inertia = np.concatenate((blocks.by_unknown[..., :1], nothing), axis=-1)
        return cls(blocks.statics, rate, inertia)

    @property
    def n_moving(self) -> int:
        return int(self.S0.shape[1])

    def solve(self, S: Matrix, right: Matrix, transposed: bool = False) -> Matrix:
        """Solve S z = right, or with the transpose of S; a singular S is perturbed by rounding."""
        try:
            return solve(S, right, transposed)
        except AnalysisError:
            nudged = S.copy()
            nudged[1] += NUDGE * np.abs(S).max() * np.eye(3)
            return solve(nudged, right, transposed)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return 3 * self.n_moving

    def eliminate_forces(self, phi: Matrix) -> tuple[Array, Array, Array]:
        """Eliminate the joint forces: K phi, C phi, M phi of (K + s C + s^2 M) phi = 0, for angles
        phi (n_moving, k), in O(n k)."""
        joints, lean = self.S0[:, :, 1:, 1:], self.S0[:, :, :1, 1:]
        felt = [S for S in self.parts if S.any()]
        # Right sides of all three at once: solving takes longer to begin than to do.
        pulls = [product(S[:, :, 1:, :1], phi) for S in felt]
        pressed = product(lean, solve(joints, np.hstack(pulls))) if felt else phi
        pairs = zip(felt, np.hsplit(pressed, max(1, len(felt))), strict=False)
        made = iter([product(S[:, :, :1, :1], phi) - part for S, part in pairs])
        K, C, M = (next(made) if S.any() else np.zeros_like(phi) for S in self.parts)
        return K, C, M

    def to_dense(self) -> DensePencil:
        """Dense pencil of the angles alone."""
        return DensePencil(*self.eliminate_forces(np.eye(self.n_moving)))

    def project(self, basis: Matrix) -> DensePencil:
        """Project on motions whose angles are the basis (n_moving, k) times coordinates."""
        K, C, M = (basis.T @ columns for columns in self.eliminate_forces(basis))
        return DensePencil(K, C, M)


def first_order_matrix(K: Matrix, C: Matrix, M: Matrix, added: int) -> Matrix:
    """Assemble the matrices (..., 2 k + added) of the rates of (q, q', z), with added states z."""
    k = K.shape[-1] - added
    upper = [np.linalg.solve(M[..., :k, :k], -part) for part in (K[..., :k, :], C[..., :k, :k])]
    zero = np.zeros((*K.shape[:-2], k, k))
    top = np.concatenate((zero, zero + np.eye(k), np.zeros((*K.shape[:-2], k, added))), axis=-1)
    middle = np.concatenate((upper[0][..., :k], upper[1], upper[0][..., k:]), axis=-1)
    rows = slice(k, None)
    last = -np.concatenate((K[..., rows, :k], C[..., rows, :k], K[..., rows, k:]), axis=-1)
    return np.concatenate((top, middle, last), axis=-2)


@dataclass(frozen=True)
class MatrixPencil(QuadraticPencil):
    """Pencil of matrices S0, S1 and S2, dense or sparse."""

    @classmethod
    def of(cls, linear: Linear) -> MatrixPencil:
        """Convert linearised equations of any kind."""
        if isinstance(linear, MatrixPencil):
            return linear
        return cls(*map(_to_full if linear.size <= SMALL else to_sparse, linear.parts))

    @classmethod
    def without_rotation(cls, pencil: BlockPencil, turning: Array | None) -> MatrixPencil:
        """Remove the eigenvalue zero of the rigid rotation of a rod that turns freely: the first
        angle is held, and a moment that only turns the rod as a whole makes up for it. turning:
        columns (3 n_moving,) of the rigid rotation, None where it is not free."""
        if turning is None:
            return cls.of(pencil)
        S0, S1, S2 = map(to_sparse, pencil.parts)
        first = scipy.sparse.csc_array(([1.0], ([0], [0])), shape=(1, len(turning)))
        moment = scipy.sparse.csc_array((S2 @ turning)[:, None])
        nothing = scipy.sparse.csc_array((1, 1))
        return cls(
            scipy.sparse.csc_array(scipy.sparse.block_array([[S0, moment], [first, None]])),
            *(
                scipy.sparse.csc_array(scipy.sparse.block_array([[S, None], [None, nothing]]))
                for S in (S1, S2)
            ),
        )

    def at_square(self, square: float) -> Any:
        """Undamped value S0 + s^2 S2, real for a real s^2 (``square``)."""
        return self.S0 + square * self.S2

    @property
    def rounding_sizes(self) -> MatrixPencil:
        """Absolute entries, to which rounding errors are proportional."""
        return MatrixPencil(*map(abs, self.parts))

    def add(self, other: MatrixPencil, times: float = 1.0) -> MatrixPencil:
        """Add ``times`` times another pencil."""
        pairs = zip(self.parts, other.parts, strict=True)
        return MatrixPencil(*(one + times * two for one, two in pairs))

    def multiply(self, factor: float) -> MatrixPencil:
        """Multiply all three matrices by a factor."""
        return MatrixPencil(*(factor * part for part in self.parts))

    def equilibration(self, rate: float) -> Scales:
        """Factors of rows and columns that make the largest entry of each about one."""
        sizes = abs(self.S0) + rate**2 * abs(self.S2) + rate * abs(self.S1)
        rows = 1 / _largest_entries(sizes, 1)
        return rows, 1 / _largest_entries(_scale_matrix(sizes, (rows, np.ones(len(rows)))), 0)

    def scale(self, scales: Scales) -> MatrixPencil:
        """Multiply rows and columns by their factors."""
        return MatrixPencil(*(_scale_matrix(part, scales) for part in self.parts))


@dataclass(frozen=True)
class DensePencil(MatrixPencil):
    """Pencil of stiffness K, damping C and mass M, (K + s C + s^2 M) q = 0, with matrices (k, k).
    added: number of the last rows, of first order, for added states; bend: coordinates of a rod
    that bends evenly (k - added,), if they are not its angles."""

    added: int = 0
    bend: Array | None = None

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.S0)

    def to_dense(self) -> DensePencil:
        """The pencil itself: there are no joint forces to eliminate."""
        return self

    @property
    def without_damping(self) -> DensePencil:
        """The pencil without damping and without added states."""
        own = self.size - self.added
        K, M = (part[:own, :own] for part in (self.S0, self.S2))
        return DensePencil(K, np.zeros_like(K), M, bend=self.bend)

    def project(self, basis: Matrix) -> DensePencil:
        """Project on motions q = basis times coordinates."""
        whole = scipy.linalg.block_diag(basis, np.eye(self.added)) if self.added else basis
        K, C, M = (whole.T @ matrix @ whole for matrix in self.parts)
        return DensePencil(K, C, M, added=self.added)


Linear = BlockPencil | MatrixPencil


def _scale_matrix(part: Any, scales: Scales) -> Any:
    rows, columns = scales
    if scipy.sparse.issparse(part):
        return scipy.sparse.csc_array(part.multiply(rows[:, None]).multiply(columns[None, :]))
    return rows[:, None] * part * columns


def _largest_entries(sizes: Any, axis: int) -> Array:
    most = sizes.max(axis=axis)
    return np.asarray(most.toarray() if scipy.sparse.issparse(most) else most).ravel()


def to_sparse(blocks: Matrix) -> scipy.sparse.csc_array:
    """Assemble a sparse matrix from blocks (3, n_moving, rows, columns)."""
    _, n_moving, *shape = blocks.shape
    there, rows, columns = block_entries(n_moving, *shape)
    size = (shape[0] * n_moving, shape[1] * n_moving)
    return scipy.sparse.csc_array((blocks[there], (rows, columns)), shape=size)


def _to_full(blocks: Matrix) -> Matrix:
    """Assemble a full matrix from blocks (3, n_moving, rows, columns)."""
    _, n_moving, *shape = blocks.shape
    there, rows, columns = block_entries(n_moving, *shape)
    matrix = np.zeros((shape[0] * n_moving, shape[1] * n_moving), dtype=blocks.dtype)
    matrix[rows, columns] = blocks[there]
    return matrix


def product(blocks: Matrix, right: Matrix) -> Matrix:
    """Multiply the matrix of blocks by a vector, or by vectors (size, k)."""
    made = _to_full if max(blocks.shape[2:]) * blocks.shape[1] <= SMALL else to_sparse
    return np.asarray(made(blocks) @ right)


def solve(blocks: Matrix, right: Matrix, transposed: bool = False) -> Matrix:
    """Solve a block-tridiagonal system. Raises AnalysisError for a singular matrix."""
    try:
        return banded.solve_blocks(blocks, right, transposed)
    except np.linalg.LinAlgError:
        raise AnalysisError(SINGULAR) from None


def joint_forces(rod: SteadyRod, at: Unknowns, p: Array) -> tuple[Array, Array]:
    """Angular accelerations (n_moving,) [rad/s^2], joint forces over the mass of a link
    (n_moving, 2) [m/s^2] of the rod at rest, or in flight: the implicit form is linear in both."""
    blocks = ImplicitBlocks.at(rod, at._replace(force=np.zeros((rod.n_moving, 2))), p)
    unknowns = solve(blocks.by_unknown, -blocks.residual.ravel()).reshape(-1, 3)
    return unknowns[:, 0], unknowns[:, 1:]
