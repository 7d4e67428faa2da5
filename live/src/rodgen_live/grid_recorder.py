"""Samples of an open-ended run, on an endless grid of times, until they are taken."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.recorder import Recorder

ROOM = 256  # samples that there is room for at first
FARTHEST = 2**53  # beyond which neighbouring whole numbers are no doubles


class GridRecorder(Recorder):
    """Recorder at the times start + k every [s], k = 0, 1, ..., that keeps samples until taken.

    count: k of the next one; until: only samples before this k are asked for, None: all.
    """

    def __init__(self, start: float, every: float, states: int, works: Sequence[str]):
        super().__init__(np.empty(0), states, works)
        self.start, self.every = start, every
        self.until: int | None = 0
        self._rows = np.empty((ROOM, states + len(works)))

    @property
    def next_index(self) -> int:
        """Index k of the next sample to be taken."""
        return self._first

    def time(self, k: int) -> float:
        """Time of sample k [s]."""
        return self.start + self.every * k

    def _times(self, first: int, end: int) -> Array:
        times: Array = self.start + self.every * np.arange(first, end).astype(np.float64)
        return times

    def count_until(self, t: float) -> int:
        """Number of samples up to a time [s]."""
        share = max(-1.0, (t - self.start) / self.every)
        if share >= FARTHEST:
            return FARTHEST
        k = math.floor(share) + 1
        # The division may be a rounding beside the times.
        return k - 1 if k and self.time(k - 1) > t else k + 1 if self.time(k) <= t else k

    def free_rows(self) -> tuple[Array, Array]:
        at = self.count - self._first
        if at == len(self._rows):
            self._rows = np.concatenate((self._rows, np.empty_like(self._rows)))
        end = self.count + len(self._rows) - at
        if self.until is not None:
            end = max(self.count, min(end, self.until))
        times = self._times(self.count, end)
        return times, self._rows[at : at + len(times)]

    def take(self, until: int) -> tuple[Array, Array, Array]:
        """Take the samples before this k that are there and were not taken yet: times [s], states
        and works [J]."""
        many = max(0, min(self.count, until) - self._first)
        t = self._times(self._first, self._first + many)
        y, work = (part.copy() for part in np.split(self._rows[:many], [self.states], axis=1))
        left = self._rows[many : self.count - self._first].copy()
        self._rows[: len(left)] = left
        self._first += many
        return t, y, work

    def skip(self, t: float) -> None:
        """Skip the samples up to a time [s], and drop those that were not taken."""
        self.count = self._first = self.count_until(t)
