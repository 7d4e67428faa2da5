"""Samples of a run: in memory, or in a file block by block."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from rodgen.arrays import Array

if TYPE_CHECKING:
    from rodgen.integrate.files.stream import Stream

BLOCK = 2**22  # bytes of samples between two writes to a file


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
