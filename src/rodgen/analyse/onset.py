"""Onset of instability: the search for changes of the number of growing motions on a grid of loads;
and, to the last digits, Newton's method on the equations of a crossing, or, of a rod with neutral
motions, the eigenvalue that goes through zero beside theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy

from rodgen.analyse.crossing import Border, CrossingEquations, crossing_kind
from rodgen.analyse.load_family import LoadFamily
from rodgen.analyse.modal import ROUNDING, ModalMotions, growing_eigenvalue
from rodgen.analyse.pencil import DensePencil, Linear, MatrixPencil
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.progress import report_stage

# Of the search.
FINE, COARSE = 0.5, 0.01  # step of the search: EI/L^2, and of the force
LEAST = 200  # forces at which a range is searched
BLOCK = 16  # forces whose matrices are made together
NARROWED, NEXT = 1e-6, 1e-3  # width to which an event is narrowed: of the load; of the least step
NEARER = 0.4  # of that width: how far to either side of a guess is looked

# Of the refinement.
At = Callable[[float], Linear]  # the equations linearised at a load
DIFFERENCE = 1e-4  # relative, of derivatives by the load: exact where S is linear in it
ITERATIONS = 30
SMALL = 1e-7  # relative change below which one that no longer shrinks is rounding
ROUNDED = 8.0  # times what rounding makes, within which a change that no longer shrinks is rounding
APART = 0.05  # by which an estimate may be wrong
ENTRY = 16 * ROUNDING  # of an entry of the matrices, which a few operations make

WIDER = 4.0  # times the way to either side in which an onset is looked for
CLOSE = 1e-13  # of a load: rounding


@dataclass(frozen=True)
class Onset:
    """Load and eigenvalue at an onset of instability. force [N]; s [1/s]: zero for divergence, on
    the imaginary axis for flutter; error: of the force, by rounding of the matrices, or the last
    step of Newton's method if that is more; rate_error: the same of abs(s)."""

    force: float
    s: complex
    error: float = 0.0
    rate_error: float = 0.0


@dataclass(frozen=True)
class StabilityChange:
    """A change of the number of growing motions: low, high: loads between which it lies; before,
    after: the numbers; ends: the motions under both loads."""

    low: float
    high: float
    before: int
    after: int
    ends: tuple[ModalMotions, ModalMotions]


@dataclass(frozen=True)
class LoadSearch:
    """A grid of loads to be searched. family: the linearised scene; forces: the loads, ascending;
    modes: size of the basis; elastic: leave out motions of the rod as a whole."""

    family: LoadFamily
    forces: Array
    modes: int
    elastic: bool

    @cached_property
    def first_motions(self) -> ModalMotions:
        """Motions under the first load."""
        return self.family.motions(self.forces[:1], self.modes, self.elastic)

    def events(self) -> Iterator[StabilityChange]:
        """Yield every change of the number of growing motions along the grid."""
        low, (last,) = float(self.forces[0]), self.first_motions.split()
        before = int(last.n_growing)
        for block in np.array_split(self.forces[1:], max(1, len(self.forces) // BLOCK)):
            for high, found in zip(block.tolist(), self._iterate_motions(block), strict=True):
                report_stage(f"{high:.6g}")
                after = int(found.n_growing)
                if after != before:
                    yield StabilityChange(low, high, before, after, (last, found))
                low, before, last = high, after, found

    def onsets(self) -> Iterator[StabilityChange]:
        """Events at which another motion begins to grow."""
        return (event for event in self.events() if event.after > event.before)

    def stability_borders(self) -> Iterator[StabilityChange]:
        """Events at the ends of windows of stability."""
        return (event for event in self.events() if (event.after == 0) != (event.before == 0))

    def locate(self, event: StabilityChange) -> Onset:
        """Narrow an event to a rough onset, with the eigenvalue that crosses the axis there: by
        bisection, and by secants of its real part, which with damping is smooth there."""
        rises, (low, high) = event.after > event.before, (event.low, event.high)
        least, turn = NEXT * FINE * self.family.unit, 0
        ends = list(event.ends)
        while high - low > NARROWED * max(abs(low), abs(high), least):
            near = NEARER * NARROWED * max(abs(low), abs(high), least)
            looked, turn = np.array([(low + high) / 2]), turn + 1
            if self.family.is_damped and turn % 3:
                share = _secant_share(ends[0], ends[1], min(event.before, event.after))
                at = min(max(low + share * (high - low), low + near), high - near)
                looked = np.array([at - near, at + near])
            for force, found in zip(looked.tolist(), self._iterate_motions(looked), strict=True):
                count = int(found.n_growing)
                beyond = count > event.before if rises else count < event.before
                if beyond and force < high:
                    high, ends[1] = force, found
                elif not beyond and force > low:
                    low, ends[0] = force, found
        grown, other = (one.s[one.growth > 0] for one in (ends[rises], ends[not rises]))
        if np.isinf(grown).sum() != np.isinf(other).sum():  # links without mass buckle
            return Onset(high, complex(np.inf), high - low)
        return Onset(high, growing_eigenvalue(grown, other), high - low)

    def _iterate_motions(self, forces: Array) -> Iterator[ModalMotions]:
        """Yield the motions under each load in turn."""
        return self.family.iterate_motions(forces, self.modes, self.elastic)


def _secant_share(low: ModalMotions, high: ModalMotions, rank: int) -> float:
    """Share of the way at which a secant of the real parts of this rank is zero, else a half."""
    a, b = (
        float(np.sort(np.nan_to_num(one.s.real, nan=-np.inf))[::-1][rank]) for one in (low, high)
    )
    return a / (a - b) if a * b < 0 else 0.5


@lru_cache(maxsize=64)
def load_grid(lowest: float, highest: float, unit: float) -> Array:
    """Forces from lowest to highest, closer together where they are small, as a read-only array."""
    most = (highest - lowest) / LEAST
    forces = [lowest]
    while forces[-1] < highest:
        forces.append(forces[-1] + min(most, max(FINE * unit, COARSE * abs(forces[-1]))))
    made = np.array([*forces[:-1], highest])
    made.setflags(write=False)
    return made


def solve_onset(at: At, near: Onset, unit: float, linear: bool = False) -> Onset:
    """Solve for the onset next to an estimate, as closely as the matrices allow; unit: a typical
    size of the load; linear: whether S is linear in the load. Raises AnalysisError."""
    values, errors = _OnsetSolver(at, near, unit, linear).solve()
    if not near.s:
        return Onset(values[0], 0j, errors[0])
    return Onset(values[0], 1j * values[1], *errors)


def no_onset_message(force: float) -> str:
    return f"Newton's method found no onset of instability within {APART:.0%} of {force:.9g} N"


class _OnsetSolver:
    """Newton's method for an onset, with scales and a border taken at the estimate."""

    def __init__(self, at: At, near: Onset, unit: float, linear: bool):
        self.at, self.near, self.linear = at, near, linear
        self._by_force: MatrixPencil | None = None
        self.size, omega = max(abs(near.force), unit), abs(near.s)
        whole = at(near.force)
        self.kind = crossing_kind(bool(omega), bool(omega) and whole.is_damped)
        # Entries of full matrices are sums of as many rounded terms.
        self.entry = ENTRY * (whole.size if isinstance(whole, DensePencil) else 1)
        here = MatrixPencil.of(whole)
        self.scales = here.equilibration(omega)
        self.border = Border.of(self.kind.singular_matrix(here.scale(self.scales), omega))

    def solve(self) -> tuple[list[float], list[float]]:
        """Solve for the load, and for omega of what oscillates; return both with their errors."""
        start = np.array([self.near.force, *([abs(self.near.s)] if self.near.s else [])])
        x, before = start, np.inf
        scale = np.concatenate(([self.size], np.abs(start[1:])))
        for _ in range(ITERATIONS):
            made, rounding = self._evaluate(x[0], float(x[-1]))
            slopes = np.hstack((made.by_numbers, made.by_omega)) * scale
            rows = np.abs(slopes).max(axis=1)
            inverse = np.linalg.inv(slopes / rows[:, None]) / rows
            change = -inverse @ made.residual
            x = x + change * scale
            moved = float(np.abs(change).max())
            if not abs(x[0] - start[0]) < APART * self.size:
                break
            noise = np.abs(inverse) @ rounding + self.entry
            if (np.abs(made.residual) <= rounding).all():
                return x.tolist(), (noise * scale).tolist()
            rounded = (np.abs(change) <= ROUNDED * noise).all()
            if (moved < SMALL or rounded) and moved >= before / 4:
                return x.tolist(), (np.maximum(noise, np.abs(change)) * scale).tolist()
            before = moved
        raise AnalysisError(no_onset_message(self.near.force))

    def _evaluate(self, force: float, omega: float) -> tuple[CrossingEquations, Array]:
        """Evaluate the equations under a load, with the roundings of their residual."""
        here = self._scaled_pencil(force)
        if self._by_force is None or not self.linear:
            step = DIFFERENCE * self.size
            up, down = self._scaled_pencil(force + step), self._scaled_pencil(force - step)
            self._by_force = up.add(down, -1.0).multiply(0.5 / step)
        made = self.kind.equations(here, [self._by_force], self.border, omega)
        sizes = here.rounding_sizes.add(self._by_force.rounding_sizes, abs(force))
        return made, self.entry * np.array(self.kind.term_sums(made.near, sizes, omega))

    def _scaled_pencil(self, force: float) -> MatrixPencil:
        return MatrixPencil.of(self.at(float(force))).scale(self.scales)


def solve_zero_onset(matrix: Callable[[float], Array], near: Onset, unit: float) -> Onset:
    """Find the onset next to an estimate; its error is rounding of the determinant. matrix: of
    first order under a load, without the neutral motions; unit: a typical size of the load. Raises
    AnalysisError."""
    beyond = float(np.linalg.slogdet(matrix(near.force))[1])

    def eigenvalue_product(force: float) -> float:
        """Product of all eigenvalues, over that at the estimate."""
        sign, size = np.linalg.slogdet(matrix(force))
        return float(sign * np.exp(size - beyond))

    size = max(abs(near.force), unit)
    apart = max(near.error, CLOSE * size)
    while apart < APART * size:
        low, high = near.force - apart, near.force + apart
        ends = eigenvalue_product(low), eigenvalue_product(high)
        if ends[0] * ends[1] < 0:
            force = float(scipy.optimize.brentq(eigenvalue_product, low, high, xtol=CLOSE * size))
            slope = abs(ends[1] - ends[0]) / (high - low)
            error = len(matrix(force)) * ROUNDING * max(map(abs, ends)) / slope
            return Onset(force, 0j, max(error, CLOSE * abs(force)))
        apart *= WIDER
    raise AnalysisError(no_onset_message(near.force))
