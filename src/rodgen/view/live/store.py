"""Samples of a live run, from its start to now, in memory that does not grow."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rodgen.integrate.live import Samples
from rodgen.integrate.stepper import Array
from rodgen.view.live.chunk import Chunk

ROOM = 2**25  # bytes of states
MOST, LEAST = 20_000, 500  # samples, whatever they weigh


@dataclass(frozen=True)
class Epoch:
    """What holds between two changes: parameters, and the energy [J] given up to now."""

    p: Array
    given: float


class Store:
    """All samples since the start; when it is full, every other one is dropped, and from then on
    only every other one is taken up."""

    def __init__(self, states: int, works: tuple[str, ...], start: float):
        """start: total energy at the start [J]."""
        self.works, self._energy, self._states = works, start, states
        width = 1 + states + len(works)
        rows = int(min(MOST, max(LEAST, ROOM // (8 * width))))
        self._rows = np.empty((rows, width))
        self._epoch_of = np.zeros(rows, dtype=np.int64)
        self._epochs: dict[int, Epoch] = {}
        self._number = self.count = self._seen = 0
        self._stride = 1

    def change(self, p: Array, given: float) -> None:
        """From the next sample on, other parameters hold."""
        if not (self.count and self._epoch_of[self.count - 1] == self._number):
            self._epochs.pop(self._number, None)  # no sample of it was kept
        self._number += 1
        self._epochs[self._number] = Epoch(p.copy(), given)

    def add(self, samples: Samples) -> Chunk:
        """Take up samples; gives them back with what holds of them."""
        at, count = 0, len(samples.t)
        while at < count:
            wanted = np.arange(at + -(self._seen + at) % self._stride, count, self._stride)
            room = len(self._rows) - self.count
            self._take(samples, wanted[:room])
            if len(wanted) <= room:
                break
            at = int(wanted[room])
            self._thin()
        self._seen += count
        here = self._epochs[self._number]
        return Chunk(
            samples.t, samples.y, samples.work, self.works, here.p, here.given, self._energy
        )

    def _take(self, samples: Samples, which: np.ndarray) -> None:
        rows = self._rows[self.count : self.count + len(which)]
        rows[:, 0] = samples.t[which]
        rows[:, 1 : 1 + self._states] = samples.y[which]
        rows[:, 1 + self._states :] = samples.work[which]
        self._epoch_of[self.count : self.count + len(which)] = self._number
        self.count += len(which)

    def _thin(self) -> None:
        """Every other sample, and the epochs that still have one."""
        kept = (self.count + 1) // 2
        self._rows[:kept] = self._rows[: self.count : 2]
        self._epoch_of[:kept] = self._epoch_of[: self.count : 2]
        self.count, self._stride = kept, 2 * self._stride
        used = {self._number, *np.unique(self._epoch_of[:kept]).tolist()}
        self._epochs = {number: self._epochs[number] for number in used}

    def chunks(self) -> Iterator[Chunk]:
        """Everything that is kept, cut where parameters changed."""
        numbers = self._epoch_of[: self.count]
        edges = [0, *(np.flatnonzero(np.diff(numbers)) + 1), self.count]
        for first, last in itertools.pairwise(edges):
            if first == last:
                continue
            epoch, rows = self._epochs[int(numbers[first])], self._rows[first:last]
            y, work = np.split(rows[:, 1:], [self._states], axis=1)
            yield Chunk(
                rows[:, 0].copy(),
                y.copy(),
                work.copy(),
                self.works,
                epoch.p,
                epoch.given,
                self._energy,
            )
