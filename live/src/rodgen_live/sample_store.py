"""Samples of a live run: in chunks between changes, in bounded memory."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.trajectory import Changes
from rodgen.memory import check_memory
from rodgen_live.grid_recorder import Samples

ROOM = 2**25  # bytes of states
MOST, LEAST = 20_000, 500  # samples, whatever they weigh
FEW = 16  # parameters: if no more differ from an earlier set, these alone are kept


@dataclass(frozen=True)
class Chunk:
    """Samples with the same parameters. t: times [s], (K,); y: states, (K, states); work: work of
    each load without potential since the start [J], (K, works), in the order of `works`; p:
    parameters; given: energy [J] that changes and kicks have put in since the start; start: total
    energy at the start [J]; raised: that in gravity alone."""

    t: Array
    y: Array
    work: Array
    works: tuple[str, ...]
    p: Array
    given: float = 0.0
    start: float = 0.0
    raised: float = 0.0

    def __len__(self) -> int:
        return len(self.t)

    def select(self, which: slice) -> Chunk:
        """Select samples by a slice."""
        return replace(self, t=self.t[which], y=self.y[which], work=self.work[which])

    def last(self) -> Chunk:
        """The last sample alone."""
        return self.select(slice(-1, None))


class _Epoch(NamedTuple):
    """Parameters and given energy [J] between two changes; of the parameters, only those are kept
    that differ from a shared set."""

    shared: Array
    places: NDArray[np.intp]
    others: Array
    given: float

    @classmethod
    def of(cls, p: Array, given: float, before: _Epoch | None) -> _Epoch:
        """Make an epoch, by the shared set of the one before where few parameters differ."""
        if before is not None:
            places = np.flatnonzero(p != before.shared)
            if len(places) <= FEW:
                return cls(before.shared, places, p[places], given)
        return cls(p.copy(), np.empty(0, dtype=np.intp), np.empty(0), given)

    @property
    def p(self) -> Array:
        """All parameters."""
        p: Array = self.shared.copy()
        p[self.places] = self.others
        return p


class SampleStore:
    """Samples of a run since its start; a full store drops every other one, and takes up only every
    other one from then on."""

    def __init__(self, states: int, works: tuple[str, ...], start: float, raised: float = 0.0):
        """Make an empty store; start, raised: energy at the start [J] (see Chunk)."""
        self._states = states
        nothing = np.empty(0)  # what holds from now on, without samples
        self._here = Chunk(nothing, nothing, nothing, works, nothing, 0.0, start, raised)
        width = 1 + states + len(works)
        rows = int(min(MOST, max(LEAST, ROOM // (8 * width))))
        self._rows = np.empty((rows, width))
        self._epoch_of = np.zeros(rows, dtype=np.int64)
        self._epochs: dict[int, _Epoch] = {}
        self._number = self.count = self._seen = 0
        self._stride = 1

    def set_parameters(self, p: Array, given: float) -> None:
        """Set the parameters and the given energy [J] that hold from the next sample on."""
        before = self._epochs.get(self._number)
        if not (self.count and self._epoch_of[self.count - 1] == self._number):
            self._epochs.pop(self._number, None)  # no sample of it was kept
        self._number += 1
        self._epochs[self._number] = _Epoch.of(p, given, before)
        self._here = replace(self._here, p=p.copy(), given=given)

    def truncate(self, t: float) -> Chunk:
        """Drop the samples after a time [s], except the first of all; returns the last one.
        `set_parameters` is to set what holds from there on."""
        kept = int(np.searchsorted(self._rows[: self.count, 0], t, side="right"))
        self.count = max(kept, 1)
        last = self._epoch_of[self.count - 1]
        self._epochs = {number: one for number, one in self._epochs.items() if number <= last}
        return self._chunk(self.count - 1, self.count)

    def widen(self, works: tuple[str, ...], wide: Callable[[Array], Array]) -> SampleStore:
        """Copy the store with more works, which are zero, and more parameters; wide: converts the
        parameters."""
        found = SampleStore(self._states, works, self._here.start, self._here.raised)
        for piece in self.chunks():
            found.set_parameters(wide(piece.p), piece.given)
            work = np.zeros((len(piece), len(works)))
            for at, name in enumerate(piece.works):
                work[:, works.index(name)] = piece.work[:, at]
            found.add(Samples(piece.t, piece.y, work))
        return found

    def add(self, samples: Samples) -> Chunk:
        """Add samples; returns them as a chunk, with what holds for them."""
        at, count = 0, len(samples.t)
        while at < count:
            wanted = np.arange(at + -(self._seen + at) % self._stride, count, self._stride)
            room = len(self._rows) - self.count
            which, end = wanted[:room], self.count + len(wanted[:room])
            columns = samples.t[which, None], samples.y[which], samples.work[which]
            self._rows[self.count : end] = np.concatenate(columns, axis=1)
            self._epoch_of[self.count : end] = self._number
            self.count = end
            if len(wanted) <= room:
                break
            at = int(wanted[room])
            self._thin()
        self._seen += count
        return replace(self._here, t=samples.t, y=samples.y, work=samples.work)

    def _thin(self) -> None:
        """Keep every other sample, and the epochs that still have one."""
        kept = (self.count + 1) // 2
        self._rows[:kept] = self._rows[: self.count : 2]
        self._epoch_of[:kept] = self._epoch_of[: self.count : 2]
        self.count, self._stride = kept, 2 * self._stride
        used = {self._number, *np.unique(self._epoch_of[:kept]).tolist()}
        self._epochs = {number: self._epochs[number] for number in used}

    def chunks(self, since: float = -np.inf, until: float = np.inf) -> Iterator[Chunk]:
        """Samples that are kept between two times [s], by default all, in chunks cut where
        parameters changed."""
        times = self._rows[: self.count, 0]
        first, end = np.searchsorted(times, since), np.searchsorted(times, until, side="right")
        numbers = self._epoch_of[first:end]
        edges = [first, *(first + np.flatnonzero(np.diff(numbers)) + 1), end]
        for first, last in itertools.pairwise(edges):
            if first < last:
                yield self._chunk(first, last)

    @property
    def span(self) -> tuple[float, float]:
        """Times of the first and the last sample that is kept [s]; there must be one."""
        return float(self._rows[0, 0]), float(self._rows[self.count - 1, 0])

    def nearest(self, t: float, by: int = 0) -> Chunk:
        """Sample nearest to a time [s], or the one `by` samples after it, as far as there are any;
        there must be one."""
        times = self._rows[: self.count, 0]
        after = min(int(np.searchsorted(times, t)), self.count - 1)
        closer = after and t - times[after - 1] < times[after] - t
        found = min(max(after - bool(closer) + by, 0), self.count - 1)
        return self._chunk(found, found + 1)

    def _chunk(self, first: int, last: int) -> Chunk:
        """Samples as a chunk, by their numbers; no change lies between them."""
        epoch, rows = self._epochs[int(self._epoch_of[first])], self._rows[first:last]
        y, work = np.split(rows[:, 1:], [self._states], axis=1)
        found = replace(self._here, t=rows[:, 0].copy(), y=y.copy(), work=work.copy())
        return replace(found, p=epoch.p, given=epoch.given)


def changes_between(pieces: Sequence[Chunk]) -> Changes:
    """Changes between chunks, at every sample of them."""
    counts, width = [len(piece) for piece in pieces], len(pieces[0].p)
    what = f"the {width} parameters at every sample"
    check_memory(what, sum(counts), lambda samples: 16 * width * samples, "samples")
    p = np.repeat([piece.p for piece in pieces], counts, axis=0)
    return Changes(p, np.repeat([piece.given for piece in pieces], counts))
