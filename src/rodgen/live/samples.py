"""Samples of a live run: in pieces between changes, in bounded memory, and as a Solution."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import InitVar, dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.live import Samples
from rodgen.integrate.solution import Solution
from rodgen.integrate.trajectory import Changes
from rodgen.memory import check_memory

ROOM = 2**25  # bytes of states
MOST, LEAST = 20_000, 500  # samples, whatever they weigh
FEW = 16  # parameters: where no more are other than in a set before, these alone are kept


@dataclass(frozen=True)
class Chunk:
    """t: times [s], (K,); y: states, (K, states); work: work of each load without potential since
    the start [J], (K, works), in the order of `works`; p: parameters that held at all of them;
    given: energy [J] that changes and kicks have put in since the start; start: total energy at
    the start [J]."""

    t: Array
    y: Array
    work: Array
    works: tuple[str, ...]
    p: Array
    given: float = 0.0
    start: float = 0.0

    def __len__(self) -> int:
        return len(self.t)

    def some(self, which: slice) -> Chunk:
        """Some of the samples."""
        return replace(self, t=self.t[which], y=self.y[which], work=self.work[which])

    def last(self) -> Chunk:
        """The last sample alone."""
        return self.some(slice(-1, None))


class _Epoch(NamedTuple):
    """What holds between two changes: parameters, those at some places other than in a set that is
    shared, and the energy given [J]."""

    shared: Array
    places: NDArray[np.intp]
    others: Array
    given: float

    @classmethod
    def of(cls, p: Array, given: float, before: _Epoch | None) -> _Epoch:
        """By the set of the epoch before, where few parameters differ from that."""
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


class Store:
    """All samples since the start; when it is full, every other one is dropped, and from then on
    only every other one is taken up."""

    def __init__(self, states: int, works: tuple[str, ...], start: float):
        """start: total energy at the start [J]."""
        self._states = states
        nothing = np.empty(0)
        self._blank = Chunk(nothing, nothing, nothing, works, nothing, start=start)
        width = 1 + states + len(works)
        rows = int(min(MOST, max(LEAST, ROOM // (8 * width))))
        self._rows = np.empty((rows, width))
        self._epoch_of = np.zeros(rows, dtype=np.int64)
        self._epochs: dict[int, _Epoch] = {}
        self._here = self._blank  # what holds from now on, without samples
        self._number = self.count = self._seen = 0
        self._stride = 1

    def change(self, p: Array, given: float) -> None:
        """Let other parameters hold from the next sample on."""
        before = self._epochs.get(self._number)
        if not (self.count and self._epoch_of[self.count - 1] == self._number):
            self._epochs.pop(self._number, None)  # no sample of it was kept
        self._number += 1
        self._epochs[self._number] = _Epoch.of(p, given, before)
        self._here = replace(self._blank, p=p.copy(), given=given)

    def back_to(self, t: float) -> Chunk:
        """Drop the samples after a time [s], but for the first of all; gives back the last one.
        What holds from there on is to be said by `change`."""
        kept = int(np.searchsorted(self._rows[: self.count, 0], t, side="right"))
        self.count = max(kept, 1)
        last = self._epoch_of[self.count - 1]
        self._epochs = {number: one for number, one in self._epochs.items() if number <= last}
        return self._piece(self.count - 1, self.count)

    def widened(self, works: tuple[str, ...], wide: Callable[[Array], Array]) -> Store:
        """A store of the same samples, with more works, that were zero, and more parameters; wide:
        makes them of those that there were."""
        found = Store(self._states, works, self._blank.start)
        for piece in self.chunks():
            found.change(wide(piece.p), piece.given)
            work = np.zeros((len(piece), len(works)))
            for at, name in enumerate(piece.works):
                work[:, works.index(name)] = piece.work[:, at]
            found.add(Samples(piece.t, piece.y, work))
        return found

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
        return replace(self._here, t=samples.t, y=samples.y, work=samples.work)

    def _take(self, samples: Samples, which: np.ndarray) -> None:
        rows = self._rows[self.count : self.count + len(which)]
        rows[:, 0] = samples.t[which]
        rows[:, 1 : 1 + self._states] = samples.y[which]
        rows[:, 1 + self._states :] = samples.work[which]
        self._epoch_of[self.count : self.count + len(which)] = self._number
        self.count += len(which)

    def _thin(self) -> None:
        """Keep every other sample, and the epochs that still have one."""
        kept = (self.count + 1) // 2
        self._rows[:kept] = self._rows[: self.count : 2]
        self._epoch_of[:kept] = self._epoch_of[: self.count : 2]
        self.count, self._stride = kept, 2 * self._stride
        used = {self._number, *np.unique(self._epoch_of[:kept]).tolist()}
        self._epochs = {number: self._epochs[number] for number in used}

    def chunks(self, since: float = -np.inf, until: float = np.inf) -> Iterator[Chunk]:
        """The samples that are kept between two times [s], by default all, in chunks cut where
        parameters changed."""
        times = self._rows[: self.count, 0]
        first, end = np.searchsorted(times, since), np.searchsorted(times, until, side="right")
        numbers = self._epoch_of[first:end]
        edges = [first, *(first + np.flatnonzero(np.diff(numbers)) + 1), end]
        for first, last in itertools.pairwise(edges):
            if first < last:
                yield self._piece(first, last)

    @property
    def span(self) -> tuple[float, float]:
        """Times of the first and the last sample that is kept [s]; there must be one."""
        return float(self._rows[0, 0]), float(self._rows[self.count - 1, 0])

    def near(self, t: float, by: int = 0) -> Chunk:
        """The sample nearest to a time [s], or so many samples from it, as far as there are any;
        there must be one."""
        times = self._rows[: self.count, 0]
        after = min(int(np.searchsorted(times, t)), self.count - 1)
        closer = after and t - times[after - 1] < times[after] - t
        found = min(max(after - bool(closer) + by, 0), self.count - 1)
        return self._piece(found, found + 1)

    def _piece(self, first: int, last: int) -> Chunk:
        """Samples between two changes, by their numbers."""
        epoch, rows = self._epochs[int(self._epoch_of[first])], self._rows[first:last]
        y, work = np.split(rows[:, 1:], [self._states], axis=1)
        found = replace(self._blank, t=rows[:, 0].copy(), y=y.copy(), work=work.copy())
        return replace(found, p=epoch.p, given=epoch.given)


@dataclass(repr=False)
class Recorded(Solution):
    """A Solution whose changes are those between the pieces that it is made from."""

    pieces: InitVar[tuple[Chunk, ...]] = ()

    def __post_init__(self, pieces: tuple[Chunk, ...]) -> None:
        if pieces:  # else it has some samples of another's, with their changes
            counts = [len(piece) for piece in pieces]
            width = len(pieces[0].p)
            what = f"the {width} parameters at every sample"
            check_memory(what, sum(counts), lambda samples: 16 * width * samples, "samples")
            p = np.repeat([piece.p for piece in pieces], counts, axis=0)
            self.changes = Changes(p, np.repeat([piece.given for piece in pieces], counts))
