"""Samples of a run: in memory, in a file block by block, or on an endless grid of times."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rodgen.arrays import Array

if TYPE_CHECKING:
    from rodgen.integrate.files.stream import Stream

BLOCK = 2**22  # bytes of samples between two writes to a file
ROOM = 256  # samples that a GridRecorder has room for at first
FARTHEST = 2**53  # beyond which neighbouring whole numbers are no doubles


class Recorder:
    """Recorder of states and works (T, states + works) at the output times (T,).

    done: samples that the stream has already. The count moves last: an interrupt at any moment
    leaves only samples that are whole.
    """

    def __init__(
        self,
        times: Array,
        states: int,
        works: Sequence[str],
        stream: Stream | None = None,
        done: int = 0,
    ):
        self.times, self.states, self.works = times, states, tuple(works)
        self.count = self._first = done
        self._stream = stream
        width = states + len(self.works)
        rows = len(times)
        if stream is not None:
            rows = min(rows - done, max(1, BLOCK // (8 * width)))
        self._rows = np.empty((rows, width))
        self.before_writing: Callable[[], None] = lambda: None

    def begin(self, y: Array) -> None:
        """Record the first sample, the state at the start."""
        self._rows[0] = 0.0
        self._rows[0, : self.states] = y
        self.commit(1)

    def free_rows(self) -> tuple[Array, Array]:
        """Output times that come next, and the rows for their samples."""
        at = self.count - self._first
        rows = self._rows[at:]
        return self.times[self.count : self.count + len(rows)], rows

    def row(self, sample: int) -> Array:
        """Row of a sample that is not written yet."""
        values: Array = self._rows[sample - self._first]
        return values

    def commit(self, samples: int) -> None:
        """Count so many more rows as filled; write them to the stream once all are."""
        self.count += samples
        if self._stream is not None and self.count - self._first == len(self._rows):
            self.write()

    def end_at(self, t: float, row: Array) -> None:
        """End the samples at a time [s], with this row there if it is after the last of them."""
        if self.count == 0 or self.times[self.count - 1] < t:
            self.times = np.append(self.times[: self.count], t)
            _, rows = self.free_rows()
            rows[0] = row
            self.commit(1)
        self.times = self.times[: self.count]

    def write(self) -> None:
        """Write all whole samples to the file."""
        self.before_writing()
        if self._stream is not None and self.count > self._first:
            y, work = self._parts(self.count - self._first)
            self._stream.append(self.times[self._first : self.count], y, work)
            self._first = self._stream.count

    def in_memory(self) -> tuple[Array, Array, dict[str, Array]]:
        """Times (T,), states (T, states) and works, each (T,), of the samples in memory."""
        self.before_writing()
        y, work = self._parts(self.count - self._first)
        return self.times[self._first : self.count], y, work

    def _parts(self, rows: int) -> tuple[Array, dict[str, Array]]:
        y, work = np.split(self._rows[:rows], [self.states], axis=1)
        return y, {term: work[:, at] for at, term in enumerate(self.works)}


class Samples(NamedTuple):
    """Samples of a run. t: times [s], (K,); y: states, (K, states); work: work done by each load
    without potential since the start [J], (K, works)."""

    t: Array
    y: Array
    work: Array


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

    def begin(self, y: Array) -> None:
        """Record the first sample, the state at the start."""
        self._rows[0] = 0.0
        self._rows[0, : self.states] = y
        self.commit(1)

    def free_rows(self) -> tuple[Array, Array]:
        at = self.count - self._first
        if at == len(self._rows):
            self._rows = np.concatenate((self._rows, np.empty_like(self._rows)))
        end = self.count + len(self._rows) - at
        if self.until is not None:
            end = max(self.count, min(end, self.until))
        times = self._times(self.count, end)
        return times, self._rows[at : at + len(times)]

    def take(self, until: int) -> Samples:
        """Take the samples before this k that are there and were not taken yet."""
        many = max(0, min(self.count, until) - self._first)
        t = self._times(self._first, self._first + many)
        y, work = (part.copy() for part in np.split(self._rows[:many], [self.states], axis=1))
        self._move_to_front(self._rows[many : self.count - self._first])
        self._first += many
        return Samples(t, y, work)

    def _move_to_front(self, rows: Array) -> None:
        """Move these rows to the front of the buffer, and shrink it where it has become large."""
        if len(rows) <= ROOM // 2 and len(self._rows) > ROOM:
            self._rows = np.concatenate((rows, np.empty((ROOM - len(rows), rows.shape[1]))))
        elif len(rows):
            self._rows[: len(rows)] = rows.copy()

    def skip(self, t: float) -> None:
        """Skip the samples up to a time [s], and drop those that were not taken."""
        self.count = self._first = self.count_until(t)
        self._move_to_front(self._rows[:0])
