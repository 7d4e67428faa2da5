"""Medians of batches that take turns: what drifts in a machine hits all contestants alike."""

from __future__ import annotations

import statistics
import timeit
from collections.abc import Callable, Mapping
from dataclasses import dataclass

Batch = Callable[[int], float]  # so many calls -> the seconds that they took together


@dataclass(frozen=True)
class Times:
    """Seconds per call of every contestant, round by round."""

    rounds: Mapping[str, list[float]]

    def median(self, name: str) -> float:
        """Median time of a call [s]."""
        return statistics.median(self.rounds[name])

    def ratio(self, name: str, other: str) -> float:
        """Median over the rounds of the time of one over that of the other."""
        pairs = zip(self.rounds[name], self.rounds[other], strict=True)
        return statistics.median(a / b for a, b in pairs)


def interleaved(
    contestants: Mapping[str, Batch], rounds: int = 41, seconds: float = 0.005
) -> Times:
    """Time a batch of each in turn, each batch about ``seconds`` long."""
    numbers = {name: _number(batch, seconds) for name, batch in contestants.items()}
    times: dict[str, list[float]] = {name: [] for name in contestants}
    for _ in range(rounds):
        for name, batch in contestants.items():
            times[name].append(batch(numbers[name]) / numbers[name])
    return Times(times)


def calls(function: Callable[[], object]) -> Batch:
    """Batches of calls from Python."""
    return timeit.Timer(function).timeit


def _number(batch: Batch, seconds: float) -> int:
    batch(1)  # caches, first-call work
    number = 1
    while (taken := batch(number)) < seconds / 4:
        number *= 4
    return max(1, round(number * seconds / taken))
