"""Where along a range of loads motions begin or cease to grow, roughly: counted on a grid."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.family import Family
from rodgen.analyse.modal import Motions, arising
from rodgen.analyse.onset import Onset
from rodgen.arrays import Array
from rodgen.progress import tell

FINE, COARSE = 0.5, 0.01  # step of the search: EI/L^2, and of the force
LEAST = 200  # forces at which a range is searched
BLOCK = 16  # forces whose matrices are made together
CLOSE, NEXT = 1e-6, 1e-3  # width to which an event is narrowed: of the load; of the least step
NEARER = 0.4  # of that width: how far to either side of a guess is looked


@dataclass(frozen=True)
class Event:
    """low, high: loads between which the number of growing motions changes, these numbers, and the
    motions under both loads."""

    low: float
    high: float
    before: int
    after: int
    ends: tuple[Motions, Motions]


@dataclass(frozen=True)
class Search:
    """family: of linearised scenes; forces: loads that are looked at, ascending; modes: in how
    many; elastic: without those of the rod as a whole."""

    family: Family
    forces: Array
    modes: int
    elastic: bool

    def counts(self, forces: Array) -> NDArray[np.int_]:
        """How many motions grow under every load."""
        return self.family.motions(forces, self.modes, self.elastic).count

    @cached_property
    def first(self) -> Motions:
        """The motions under the first load."""
        return self.family.motions(self.forces[:1], self.modes, self.elastic)

    def events(self) -> Iterator[Event]:
        """Every change of the number of growing motions along the grid."""
        low, (last,) = float(self.forces[0]), self.first.each()
        before = int(last.count)
        for block in np.array_split(self.forces[1:], max(1, len(self.forces) // BLOCK)):
            for high, found in zip(block.tolist(), self._looked(block), strict=True):
                tell(f"{high:.6g}")
                after = int(found.count)
                if after != before:
                    yield Event(low, high, before, after, (last, found))
                low, before, last = high, after, found

    def begins(self) -> Iterator[Event]:
        """Where another motion begins to grow."""
        return (event for event in self.events() if event.after > event.before)

    def borders(self) -> Iterator[Event]:
        """Ends of windows of stability."""
        return (event for event in self.events() if (event.after == 0) != (event.before == 0))

    def near(self, event: Event) -> Onset:
        """An event, roughly, with the eigenvalue that crosses the axis there: by bisection, and by
        secants of its real part, which with damping is smooth there."""
        rises, (low, high) = event.after > event.before, (event.low, event.high)
        least, turn = NEXT * FINE * self.family.unit, 0
        ends = list(event.ends)
        while high - low > CLOSE * max(abs(low), abs(high), least):
            near = NEARER * CLOSE * max(abs(low), abs(high), least)
            looked, turn = np.array([(low + high) / 2]), turn + 1
            if self.family.damped and turn % 3:
                share = _crossing(ends[0], ends[1], min(event.before, event.after))
                at = min(max(low + share * (high - low), low + near), high - near)
                looked = np.array([at - near, at + near])
            for force, found in zip(looked.tolist(), self._looked(looked), strict=True):
                count = int(found.count)
                beyond = count > event.before if rises else count < event.before
                if beyond and force < high:
                    high, ends[1] = force, found
                elif not beyond and force > low:
                    low, ends[0] = force, found
        grown, other = (one.s[one.growth > 0] for one in (ends[rises], ends[not rises]))
        return Onset(high, arising(grown, other), high - low)

    def _looked(self, forces: Array) -> Iterator[Motions]:
        """The motions under every load, one after the other."""
        return self.family.each(forces, self.modes, self.elastic)


def _crossing(low: Motions, high: Motions, rank: int) -> float:
    """The share of the way at which a real part of this rank would be zero along a line."""
    a, b = (
        float(np.sort(np.nan_to_num(one.s.real, nan=-np.inf))[::-1][rank]) for one in (low, high)
    )
    return a / (a - b) if a * b < 0 else 0.5


@lru_cache(maxsize=64)
def grid(lowest: float, highest: float, unit: float) -> Array:
    """Forces from lowest to highest, closer together where they are small; not to be written to."""
    most = (highest - lowest) / LEAST
    forces = [lowest]
    while forces[-1] < highest:
        forces.append(forces[-1] + min(most, max(FINE * unit, COARSE * abs(forces[-1]))))
    made = np.array([*forces[:-1], highest])
    made.setflags(write=False)
    return made
