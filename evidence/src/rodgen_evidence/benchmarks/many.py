"""Times of many runs at once, each beside the runs one by one.

python -m rodgen_evidence.benchmarks.many
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType
from typing import Any

import numpy as np

import rodgen
from rodgen.native import native_batch as native
from rodgen.system import System
from rodgen_evidence.benchmarks import Times
from rodgen_evidence.report.costs.cost_rows import VALUES, Array, scene

SPAN, RTOL = 0.5, 1e-6
SETTINGS: dict[str, Any] = {"span": [0.0, SPAN], "rtol": RTOL, "method": "dop853"}
FEW = 100  # runs that are made one by one
CLOCKS = time.process_time, time.perf_counter  # of this process on one core; on several


def best(times: int, work: Callable[[], object], clock: Callable[[], float] = CLOCKS[0]) -> float:
    """The shortest of so many times [s]: what others do on the machine only adds to it."""
    taken = []
    for _ in range(times):
        start = clock()
        work()
        taken.append(clock() - start)
    return min(taken)


def one_by_one(model: ModuleType, p: Array, y0: Array, t: Array) -> None:
    """Runs of a C module with samples, one after the other, by its own class."""
    end = t[-1]
    for of_rod in p:
        run = model.Run("dop853", 0.0, y0, of_rod, 0.0, RTOL, 1e-10)
        run.begin(end)
        run.advance(10**7, t, np.empty((len(t), len(run.state))))


@contextmanager
def inside() -> Iterator[list[float]]:
    """Processor times of this process in the step loops of C, call by call [s]."""
    taken: list[float] = []
    work = native.RunBatch.run

    def time_work(self: native.RunBatch, take: Any) -> bool:
        start = time.process_time()
        done = work(self, take)
        taken.append(time.process_time() - start)
        return done

    native.RunBatch.run = time_work  # type: ignore[method-assign]  # is timed, as it is
    try:
        yield taken
    finally:
        native.RunBatch.run = work  # type: ignore[method-assign]  # as it was


def run_costs(model: ModuleType, p: Array, y0: Array, keep: Sequence[str]) -> tuple[float, float]:
    """Time that one run takes in Python beside that in C, and that in C."""
    beside = []
    with inside() as taken:
        for _ in range(100):
            start = time.process_time()
            rodgen.simulate_many(model, p, y0, keep=keep, **SETTINGS)
            beside.append(time.process_time() - start - taken[-1])
    return min(beside), min(taken)


def measure(times: Times, links: int, rods: int, rounds: int) -> None:
    """Add the times for so many links."""
    of = scene(links).with_integrate(**SETTINGS)
    system = System(of)
    model = rodgen.build(of, "c", parts=("rhs", "flow", "power", "lanes"))
    y0, t = of.initial_state(), of.integrate.sample_times
    p = np.tile(model.parameters(**of.parameters), (rods, 1))
    thrusts = np.linspace(0.5, 1.5, rods) * VALUES["follower_force"]
    p[:, model.PARAMETERS.index("follower_force")] = thrusts
    keep = [f"max(phi_{links - 1})", "max(tip_x)"]
    every = max(1, rods // FEW)
    few = p[::every]

    def together(workers: int = 1) -> rodgen.Ensemble:
        return rodgen.simulate_many(model, p, y0, keep=keep, workers=workers, **SETTINGS)

    def loop() -> None:
        for thrust in thrusts[::every]:
            rodgen.simulate(system.at({"loads.follower.force": float(thrust)}), model=model)

    together()
    beside = best(rounds, together) / rods
    single = best(rounds, lambda: one_by_one(model, few, y0, t)) / len(few)
    times.add(f"n={links}: a run side by side", beside, "the C module run by run", single)
    python = best(rounds, loop) / len(few)
    times.add(f"n={links}: a run side by side", beside, "rodgen.simulate in a loop", python)
    both = best(rounds, lambda: together(2), CLOCKS[1]) / rods
    times.add(f"n={links}: by two workers", both, "rodgen.simulate in a loop", python)
    extra, inside = run_costs(model, p[:1], y0, keep)
    times.add(f"n={links}: one run, Python's part", extra, "C's", inside)


def many(sizes: Sequence[int] = (20, 50), rods: int = 2000, rounds: int = 3) -> Times:
    """Runs of a free rod under a thrust that differs from run to run: two maxima are kept."""
    times = Times("many runs")
    for links in sizes:
        measure(times, links, rods, rounds)
    return times


if __name__ == "__main__":
    many().show()
