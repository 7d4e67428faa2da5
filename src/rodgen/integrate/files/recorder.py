"""Samples of a run: kept in memory, or written to a file block by block."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from rodgen.integrate.files.stream import Stream
from rodgen.integrate.stepper import Array

BLOCK = 2**22  # bytes of samples between two writes to a file


class Recorder:
    """States and works (T, states + works) at the output times (T,).

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

    def room(self) -> tuple[Array, Array]:
        """Times that come next, and rows for their samples."""
        at = self.count - self._first
        rows = self._rows[at:]
        return self.times[self.count : self.count + len(rows)], rows

    def row(self, sample: int) -> Array:
        """The row of a sample that is not written yet."""
        values: Array = self._rows[sample - self._first]
        return values

    def took(self, samples: int) -> None:
        """So many rows of the room are filled."""
        self.count += samples
        if self._stream is not None and self.count - self._first == len(self._rows):
            self.write()

    def end_at(self, t: float, row: Array) -> None:
        """The run ends at a time [s] that need not be one of the output times."""
        if self.count == 0 or self.times[self.count - 1] < t:
            self.times = np.append(self.times[: self.count], t)
            _, rows = self.room()
            rows[0] = row
            self.took(1)
        self.times = self.times[: self.count]

    def write(self) -> None:
        """All whole samples to the file."""
        self.before_writing()
        if self._stream is not None and self.count > self._first:
            y, work = self._parts(self.count - self._first)
            self._stream.append(self.times[self._first : self.count], y, work)
            self._first = self._stream.count

    def kept(self) -> tuple[Array, Array, dict[str, Array]]:
        """Times (T,), states (T, states) and works, each (T,), that are in memory."""
        self.before_writing()
        y, work = self._parts(self.count - self._first)
        return self.times[self._first : self.count], y, work

    def _parts(self, rows: int) -> tuple[Array, dict[str, Array]]:
        y, work = np.split(self._rows[:rows], [self.states], axis=1)
        return y, {term: work[:, at] for at, term in enumerate(self.works)}
