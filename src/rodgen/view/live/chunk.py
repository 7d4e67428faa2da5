"""Samples of a live run between two changes of its parameters."""

from __future__ import annotations

from dataclasses import dataclass

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

    def last(self) -> Chunk:
        """The last sample alone."""
        return Chunk(
            self.t[-1:], self.y[-1:], self.work[-1:], self.works, self.p, self.given, self.start
        )
