"""Samples of a live run between two changes of its parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rodgen.integrate.stepper import Array


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
