"""Studies by more and more workers: how much sooner they are done, and whether the bits are equal.

python -m rodgen_evidence.benchmarks.study_workers [BLOCKS] [WORKERS ...]

BLOCKS: how many, of a second each, by default 32; WORKERS: by default 1 2 4 8 16. Blocks that wait
for a second in place of computing tell what the engine takes of the gain, on any machine, with any
number of processors; blocks that compute for a second tell it of the processors that are there.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import dask.system
import distributed
import xarray as xr

from rodgen.studies import task
from rodgen.studies.engine import BLOCK, run_study
from rodgen.studies.store import StudyStore, read_store
from rodgen.studies.study import Study
from rodgen.studies.task import Arrays
from rodgen_evidence.benchmarks.clusters import nothing, same, study_of, workers
from rodgen_evidence.benchmarks.study_engine import span_of

COUNTS = (1, 2, 4, 8, 16)
POINTS = 200  # of a block that computes


class Waiting(distributed.WorkerPlugin):  # type: ignore[misc]  # Dask has no types
    """Blocks that wait; seconds: how long."""

    def __init__(self, seconds: float):
        self.seconds = seconds

    def setup(self, worker: Any) -> None:
        def wait(study: Study, points: Sequence[Mapping[str, Any]]) -> Arrays:
            time.sleep(self.seconds)
            return nothing(study, points)

        vars(task)["evaluate"] = wait


def taken(study: Study, size: int, count: int, seconds: float | None = None) -> float:
    """Time of a study by the clock, from the first task on [s]; seconds: that its blocks wait in
    place of computing."""
    plugin = None if seconds is None else Waiting(seconds)
    with tempfile.TemporaryDirectory() as made, workers(count, plugin) as address:
        path = Path(made, "study.zarr")
        StudyStore.create(path, study, size)
        run_study(study_of(4 * count), Path(made, "warm.zarr"), scheduler=address)
        start = time.perf_counter()
        run_study(study, path, scheduler=address, resume=True)
        return time.perf_counter() - start


def waiting(blocks: int, counts: Sequence[int] = COUNTS, seconds: float = BLOCK) -> list[float]:
    """Speed-up of blocks that wait, by so many workers, over one after the other in no time but
    their own."""
    study = study_of(blocks)
    return [blocks * seconds / taken(study, 1, count, seconds) for count in counts]


def computing(blocks: int, counts: Sequence[int]) -> list[float]:
    """Speed-up of blocks that compute, over the first of these numbers of workers."""
    span = span_of(BLOCK / POINTS)
    found = [taken(study_of(blocks * POINTS, span), POINTS, count) for count in counts]
    return [found[0] / one for one in found]


def bits(
    points: int, counts: Sequence[int] = (1, 2, 16), sizes: Sequence[int] = (1, 7, 100)
) -> list[tuple[int, int, bool]]:
    """Whether a study by so many workers in blocks of so many points is that of one process in one
    go, bit for bit."""
    study, found = study_of(points, 0.5), []
    with tempfile.TemporaryDirectory() as made:
        expected = _read(study, Path(made, "alone.zarr"), points, workers=1)
        for count in counts:
            with workers(count) as address:
                for size in sizes:
                    path = Path(made, f"{count}_{size}.zarr")
                    data = _read(study, path, size, scheduler=address)
                    found.append((count, size, same(data, expected)))
    return found


def _read(study: Study, path: Path, size: int, **how: Any) -> xr.Dataset:
    StudyStore.create(path, study, size)
    run_study(study, path, resume=True, **how)
    return read_store(path)


def main() -> None:
    """Measure and print."""
    blocks = int(sys.argv[1]) if len(sys.argv) > 1 else 32
    counts = tuple(map(int, sys.argv[2:])) or COUNTS
    print("workers, times sooner than one block after the other (blocks wait a second):")
    for count, times in zip(counts, waiting(blocks, counts), strict=True):
        print(f"{count:6d} {times:8.3f}", flush=True)
    few = tuple(count for count in counts if count <= dask.system.CPU_COUNT)
    print(f"workers, times sooner than {few[0]} (blocks compute for a second):")
    for count, times in zip(few, computing(blocks, few), strict=True):
        print(f"{count:6d} {times:8.3f}", flush=True)
    for count, size, equal in bits(500, (1, 2, max(counts))):
        print(f"{count} workers, blocks of {size}: same bits = {equal}", flush=True)


if __name__ == "__main__":
    main()
