"""Where along a range of loads motions begin or cease to grow, roughly: counted on a grid."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.family import Family
from rodgen.analyse.onset import Onset
from rodgen.integrate.stepper import Array

FINE, COARSE = 0.5, 0.01  # step of the search: EI/L^2, and of the force
LEAST = 200  # forces at which a range is searched
BLOCK = 64  # forces that are looked at together
CLOSE, NEXT = 1e-6, 1e-3  # width to which an event is bisected: of the load; of the least step


@dataclass(frozen=True)
class Event:
    """low, high: loads between which the number of growing motions changes, and these numbers."""

    low: float
    high: float
    before: int
    after: int


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

    def events(self) -> Iterator[Event]:
        """Every change of the number of growing motions along the grid."""
        low = float(self.forces[0])
        before = int(self.counts(self.forces[:1])[0])
        for block in np.array_split(self.forces[1:], max(1, len(self.forces) // BLOCK)):
            for high, after in zip(block.tolist(), self.counts(block).tolist(), strict=True):
                if after != before:
                    yield Event(low, high, before, after)
                low, before = high, after

    def begins(self) -> Iterator[Event]:
        """Where another motion begins to grow."""
        return (event for event in self.events() if event.after > event.before)

    def borders(self) -> Iterator[Event]:
        """Ends of windows of stability."""
        return (event for event in self.events() if (event.after == 0) != (event.before == 0))

    def near(self, event: Event) -> Onset:
        """An event by bisection, with the eigenvalue that crosses the axis there."""
        rises, low, high = event.after > event.before, event.low, event.high
        least = NEXT * FINE * self.family.unit
        while high - low > CLOSE * max(abs(low), abs(high), least):
            middle = (low + high) / 2
            count = int(self.counts(np.array([middle]))[0])
            if count > event.before if rises else count < event.before:
                high = middle
            else:
                low = middle
        grown, other = (high, low) if rises else (low, high)
        return Onset(high, self._crosses(grown, other), high - low)

    def _crosses(self, grown: float, other: float) -> complex:
        """The eigenvalue that grows under one load and not under the other: zero or imaginary."""
        found = self.family.motions(np.array([other, grown]), self.modes, self.elastic)
        here = found.s[1][found.growth[1] > 0]
        there = found.s[0][found.growth[0] > 0]
        if not len(here):
            return 0j
        near = np.abs(here[:, None] - there[None, :]).min(axis=1, initial=np.inf)
        s = here[np.argmax(near / np.abs(here))]
        # Just beyond divergence a rate is real; with damping flutter has an imaginary part.
        return 0j if abs(s.imag) <= abs(s.real) else complex(1j * abs(s.imag))


def grid(lowest: float, highest: float, unit: float) -> Array:
    """Forces from lowest to highest, closer together where they are small."""
    most = (highest - lowest) / LEAST
    forces = [lowest]
    while forces[-1] < highest:
        forces.append(forces[-1] + min(most, max(FINE * unit, COARSE * abs(forces[-1]))))
    return np.array([*forces[:-1], highest])
