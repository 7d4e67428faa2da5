"""What the text panel is about: the present of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from rodgen.integrate.stepper import Array, Counts
from rodgen.view.live.chunk import Chunk


class Row(NamedTuple):
    """A row of the text panel: its key, what it is in words, its unit; without words it is a row of
    text alone, and not there while that is empty."""

    key: str
    label: str
    unit: str


@dataclass(frozen=True)
class Present:
    """chunk: its last sample is the present; counts and seconds: cost of the run so far, computing
    time [s]; ratio: simulated seconds in one second of late, None where it is not known; method:
    in use, where the scene leaves it open; critical: critical follower force [N], or in words why
    there is none ("computing"), or None."""

    chunk: Chunk
    counts: Counts
    seconds: float
    ratio: float | None = None
    method: str | None = None
    critical: float | str | None = None

    @property
    def t(self) -> float:
        """The present time [s]."""
        return float(self.chunk.t[-1])

    @property
    def y(self) -> Array:
        """The present state, (states,)."""
        y: Array = self.chunk.y[-1]
        return y

    @property
    def p(self) -> Array:
        """The parameters that hold."""
        return self.chunk.p
