"""Medians of batches that take turns: what drifts in a machine hits all contestants alike."""

from __future__ import annotations

import os
import statistics
import subprocess
import time
import timeit
from collections.abc import Callable, Mapping, Sequence

Batch = Callable[[int], float]  # so many calls -> the seconds that they took together


def time_in_turns(
    contestants: Mapping[str, Batch], rounds: int = 41, seconds: float = 0.005
) -> dict[str, float]:
    """Time batches in turns, each about ``seconds`` long; return median seconds of their calls."""
    numbers = {name: _number(batch, seconds) for name, batch in contestants.items()}
    times: dict[str, list[float]] = {name: [] for name in contestants}
    for _ in range(rounds):
        for name, batch in contestants.items():
            times[name].append(batch(numbers[name]) / numbers[name])
    return {name: statistics.median(several) for name, several in times.items()}


def calls(function: Callable[[], object]) -> Batch:
    """Batches of calls from Python."""
    return timeit.Timer(function).timeit


def _number(batch: Batch, seconds: float) -> int:
    batch(1)  # caches, first-call work
    number = 1
    while (taken := batch(number)) < seconds / 4:
        number *= 4
    return max(1, round(number * seconds / taken))


def process(command: Sequence[str], **environment: str) -> float:
    """Seconds of a whole process; RuntimeError with what it says last if it fails."""
    start = time.perf_counter()
    made = subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, **environment}
    )
    taken = time.perf_counter() - start
    if made.returncode:
        raise RuntimeError((made.stderr.splitlines() or [f"exit status {made.returncode}"])[-1])
    return taken
