"""Crossings of levels in many runs side by side, and their arrays for the loops in C."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.native.native_batch import NUMBER, WATCHED

Terms = Mapping[int, float]  # rows, and their weights in a sum


@dataclass(frozen=True)
class Crossing:
    """Crossing to look for: a number of a run passes a level between two times [s].

    direction: rising, falling or either; kept: numbers whose values there are kept, of the first
    crossings, `most` at most; stop: name of the event, if it ends the run.
    """

    number: str
    level: float
    direction: str = "either"
    kept: tuple[str, ...] = ()
    most: int = 0
    start: float = -math.inf
    end: float = math.inf
    stop: str = ""

    @property
    def width(self) -> int:
        """Length of its results for one rod: the count of crossings, and the numbers of each."""
        return 1 + self.most * (1 + len(self.kept))


class CrossingResults(NamedTuple):
    """Crossings found. counts: how many, (rods,); t: when [s], (rods, most); values: of what is
    kept of each, (rods, most, kept); not-a-number behind the last."""

    counts: NDArray[np.int64]
    t: Array
    values: Array


class WeightedSums:
    """Weighted sums of rows, stored one after the other."""

    def __init__(self) -> None:
        self._rows: list[int] = []
        self._weights: list[float] = []

    def add(self, terms: Terms) -> tuple[int, int]:
        """Add a sum, and return where it begins and how many terms it has."""
        first = len(self._rows)
        self._rows += terms
        self._weights += terms.values()
        return first, len(terms)

    def arrays(self) -> tuple[NDArray[np.int64], Array]:
        """Rows and weights of all sums."""
        return np.array(self._rows, dtype=np.int64), np.array(self._weights, dtype=float)


@dataclass(frozen=True)
class CrossingTable:
    """Crossings as arrays for the loops in C."""

    crossings: tuple[Crossing, ...]
    table: NDArray[Any]
    numbers: NDArray[Any]

    @classmethod
    def of(
        cls,
        crossings: Sequence[Crossing],
        terms: Mapping[str, Terms],
        known: int,
        sums: WeightedSums,
    ) -> CrossingTable:
        """Encode crossings. terms: of every number, by name; known: how many rows are not observed;
        sums: where the sums of the numbers are added."""
        table = np.zeros(len(crossings), WATCHED)
        numbers: list[tuple[int, int]] = []
        place = 0
        for row, one in zip(table, crossings, strict=True):
            row["rising"], row["falling"] = one.direction != "falling", one.direction != "rising"
            row["looks"] = any(at >= known for at in terms[one.number])
            row["level"], row["from"], row["to"] = one.level, one.start, one.end
            row["first"], row["terms"] = sums.add(terms[one.number])
            row["place"], row["most"] = place, one.most
            row["first_number"], row["numbers"] = len(numbers), len(one.kept)
            numbers += (sums.add(terms[name]) for name in one.kept)
            place += one.width
        stops = [at for at, one in enumerate(crossings) if one.stop]
        table["stops"][stops] = np.array(stops, dtype=np.int64) + 1
        return cls(tuple(crossings), table, np.array(numbers, dtype=NUMBER))

    @cached_property
    def width(self) -> int:
        """Length of the results of all crossings for one rod."""
        return sum(one.width for one in self.crossings)

    def decode(self, rows: Array) -> Iterator[CrossingResults]:
        """Decode the crossings of many rods from what the loops have written, (rods, width)."""
        for place, one in zip(self.table["place"].tolist(), self.crossings, strict=True):
            counts = rows[:, place].astype(np.int64)
            each = rows[:, place + 1 : place + one.width]
            made = each.reshape(len(rows), one.most, 1 + len(one.kept)).copy()
            made[np.arange(one.most) >= counts[:, None]] = np.nan
            yield CrossingResults(counts, made[..., 0], made[..., 1:])

    def stop_name(self, number: int) -> str:
        """Name of the event that has ended a run, by the number in its outcome."""
        return self.crossings[number - 1].stop
