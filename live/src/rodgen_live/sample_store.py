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

    def goes_on_from(self, before: Chunk) -> bool:
        """Whether neither a change nor a kick lies between another chunk and this one."""
        same = before.p is self.p or np.array_equal(before.p, self.p)
        return same and (before.given, before.start) == (self.given, self.start)


class _Epoch(NamedTuple):
    """Parameters and given energy [J] between two changes; of the parameters, only those are kept
    that differ from a shared set."""

    shared: Array
    places: NDArray[np.intp]
    others: Array
    given: float

    @classmethod
    def of(cls, chunk: Chunk, before: _Epoch | None) -> _Epoch:
        """Make an epoch, by the shared set of the one before where few parameters differ."""
        shared = before.shared if before is not None else chunk.p
        places = np.flatnonzero(chunk.p != shared)
        if len(places) > FEW:
            shared, places = chunk.p, places[:0]
        return cls(shared, places, chunk.p[places], chunk.given)

    @property
    def p(self) -> Array:
        """All parameters."""
        p: Array = self.shared.copy()
        p[self.places] = self.others
        return p


class SampleStore:
    """Samples of a run since its start; a full store drops every other one, and takes up only every
    other one from then on."""

    def __init__(self) -> None:
        self._rows = np.empty((0, 1))  # room is made for the first sample
        self._epoch_of = np.zeros(0, dtype=np.int64)
        self._epochs: dict[int, _Epoch] = {}
        self._number = self.count = self._seen = 0
        self._stride = 1
        self._last: Chunk | None = None  # that was added

    def truncate(self, t: float) -> Chunk:
        """Drop the samples after a time [s], except the first of all; returns the last one."""
        kept = int(np.searchsorted(self._rows[: self.count, 0], t, side="right"))
        self.count = max(kept, 1)
        self._number = last = int(self._epoch_of[self.count - 1])
        self._epochs = {number: one for number, one in self._epochs.items() if number <= last}
        self._last = found = self._chunk(self.count - 1, self.count)
        return found

    def widen(self, works: tuple[str, ...], wide: Callable[[Array], Array]) -> SampleStore:
        """Copy the store with more works, which are zero, and more parameters; wide: converts the
        parameters."""
        found = SampleStore()
        for piece in self.chunks():
            work = np.zeros((len(piece), len(works)))
            for at, name in enumerate(piece.works):
                work[:, works.index(name)] = piece.work[:, at]
            found.add(replace(piece, work=work, works=works, p=wide(piece.p)))
        return found

    def add(self, samples: Chunk) -> None:
        """Add samples, whose states and works are of the widths of those before."""
        at, count = 0, len(samples)
        if count:
            self._begin_epoch(samples)
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

    def _begin_epoch(self, samples: Chunk) -> None:
        """Begin an epoch where other parameters hold, or other energy was given, than before."""
        before, self._last = self._last, samples
        if before is None:
            width = 1 + samples.y.shape[1] + len(samples.works)
            rows = int(min(MOST, max(LEAST, ROOM // (8 * width))))
            self._rows, self._epoch_of = np.empty((rows, width)), np.zeros(rows, dtype=np.int64)
        elif samples.goes_on_from(before):
            return
        epoch = _Epoch.of(samples, self._epochs.get(self._number))
        if self.count and self._epoch_of[self.count - 1] != self._number:
            del self._epochs[self._number]  # no sample of it was kept
        self._number += 1
        self._epochs[self._number] = epoch

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
        assert self._last is not None
        y, work = np.split(rows[:, 1:].copy(), [self._last.y.shape[1]], axis=1)
        t, p = rows[:, 0].copy(), epoch.p
        return replace(self._last, t=t, y=y, work=work, p=p, given=epoch.given)


def changes_between(pieces: Sequence[Chunk]) -> Changes:
    """Changes between chunks, at every sample of them."""
    counts, width = [len(piece) for piece in pieces], len(pieces[0].p)
    what = f"the {width} parameters at every sample"
    check_memory(what, sum(counts), lambda samples: 16 * width * samples, "samples")
    p = np.repeat([piece.p for piece in pieces], counts, axis=0)
    return Changes(p, np.repeat([piece.given for piece in pieces], counts))
