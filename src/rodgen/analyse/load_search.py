"""Search for changes of the number of growing motions along a range of loads, on a grid."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.load_family import LoadFamily
from rodgen.analyse.modal import ModalMotions, growing_eigenvalue
from rodgen.analyse.onset import Onset
from rodgen.arrays import Array
from rodgen.progress import report_stage

FINE, COARSE = 0.5, 0.01  # step of the search: EI/L^2, and of the force
LEAST = 200  # forces at which a range is searched
BLOCK = 16  # forces whose matrices are made together
CLOSE, NEXT = 1e-6, 1e-3  # width to which an event is narrowed: of the load; of the least step
NEARER = 0.4  # of that width: how far to either side of a guess is looked


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

    def count_growing(self, forces: Array) -> NDArray[np.int_]:
        """Number of growing motions under every load."""
        return self.family.motions(forces, self.modes, self.elastic).n_growing

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
        while high - low > CLOSE * max(abs(low), abs(high), least):
            near = NEARER * CLOSE * max(abs(low), abs(high), least)
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
