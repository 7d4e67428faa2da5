"""Times of studies beside the runs that they consist of.

python -m rodgen_evidence.benchmarks.study_engine [RUNS] [TASKS]

Processor times of all processes, as ratios; blocks of points that do nothing tell what a task and a
chunk cost. RUNS: of about 5 ms each, in a study by two workers, by default 2000; TASKS: how many
empty blocks, by default 500.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import psutil

from rodgen.studies import task
from rodgen.studies.engine import BLOCK, block_size, run_study
from rodgen.studies.sampling import points_at
from rodgen.studies.store import StudyStore, read_store
from rodgen.studies.study import Study
from rodgen.studies.task import evaluate
from rodgen_evidence.benchmarks import Times
from rodgen_evidence.benchmarks.clusters import (
    FORCE,
    KEEP,
    MASS,
    Empty,
    peak,
    processor_time,
    spent,
    study_of,
    workers,
)
from rodgen_evidence.benchmarks.many import inside

RUN = 5e-3  # s of processor time
WORKERS = 2


def span_of(seconds: float = RUN, some: int = 64) -> float:
    """Length of runs that take so many seconds of a processor, side by side [s]."""
    span = 5.0
    for _ in range(2):
        study = study_of(some, span)
        given = points_at(study, range(some))
        evaluate(study, given[:8])
        start = time.process_time()
        evaluate(study, given)
        span *= seconds * some / (time.process_time() - start)
    return span


def in_c(study: Study) -> float:
    """Processor time of the runs of a study in the step loops of C, of some made all [s]."""
    some = min(study.count, 400)
    given = points_at(study, np.linspace(0, study.count - 1, some, dtype=int).tolist())
    evaluate(study, given[:8])
    with inside() as taken:
        evaluate(study, given)
    return sum(taken) * study.count / some


def chosen(times: Times, folder: Path, count: int, span: float, turns: int = 3) -> None:
    """A whole study, in as many processes as it chooses, beside its runs in C."""
    study, owns, wholes = study_of(count, span), [], []
    for turn in range(turns):
        owns.append(in_c(study))
        start = processor_time()
        run_study(study, folder / f"chosen{turn}.zarr")
        wholes.append(processor_time() - start)
    times.add(f"{count} runs as a study", min(wholes), "in C", min(owns))


def whole(times: Times, folder: Path, count: int, span: float) -> None:
    """A whole study by workers that are started and ended, beside its runs in C; and of all this
    the share that the engine and the store take."""
    study, path = study_of(count, span), folder / f"whole{count}.zarr"
    own, start = in_c(study), processor_time()
    run_study(study, path, workers=WORKERS)
    taken = processor_time() - start
    points_own = float(read_store(path)["seconds"].sum())
    times.add(f"{count} runs as a study, {WORKERS} workers, from start to end", taken, "in C", own)
    times.add(f"of it {WORKERS} workers started, engine, store", taken - points_own, "all", taken)
    with workers(WORKERS) as address:
        run_study(study_of(20, span), folder / f"warm{count}.zarr", scheduler=address)
        start = spent()
        run_study(study, path.with_suffix(".again"), scheduler=address)
        taken = spent() - start
    points_own = float(read_store(path.with_suffix(".again"))["seconds"].sum())
    times.add(f"{count} runs: engine and store, workers there", taken - points_own, "all", taken)


def tasks(times: Times, folder: Path, count: int) -> None:
    """Blocks that do nothing: what a task and its chunks cost, in all processes."""
    study = study_of(count)
    with workers(WORKERS, Empty()) as address:
        store = folder / "tasks.zarr"
        StudyStore.create(store, study, 1)
        run_study(study_of(20), folder / "few.zarr", scheduler=address)
        start = spent()
        run_study(study, store, scheduler=address, resume=True)
        each = (spent() - start) / count
    start = time.process_time()
    made, arrays = (
        StudyStore.create(folder / "chunks.zarr", study, 1),
        task.compute_points(study, [0]),
    )
    for block in range(min(100, count)):
        made.write_block(block, points_at(study, [block]), arrays)
    chunks = (time.process_time() - start) / min(100, count)
    times.add("a task and its chunks, all processes", each, "a block", BLOCK)
    times.add("chunks of a block", chunks, "the task with them", each)


def memory(count: int, axes: int) -> tuple[float, float]:
    """The most memory of client and of worker in a study of empty points that count as 0.1 ms
    each [MB]; axes: along one or two of which they lie. To be called in a process of its own."""
    side = round(count ** (1 / axes))
    ends = {MASS: (10, 20), FORCE: (1, 10)}
    some = [*ends][:axes]
    vary = {name: {"bounds": ends[name], "count": side} for name in some}
    study = Study.of(study_of(1).system, vary, keep=KEEP)
    with tempfile.TemporaryDirectory() as made, workers(WORKERS, Empty()) as address:
        path = Path(made, "memory.zarr")
        StudyStore.create(path, study, block_size(study, 1e-4, WORKERS))
        run_study(study, path, scheduler=address, resume=True)
        this = psutil.Process()
        return peak(this.pid), max(peak(one.pid) for one in this.children(recursive=True))


def memories(counts: Sequence[int] = (10**4, 10**6), along: Sequence[int] = (1, 2)) -> None:
    """Print the memory of studies of so many points along so many axes."""
    for axes in along:
        for count in counts:
            with ProcessPoolExecutor(1, get_context("spawn")) as pool:
                client, worker = pool.submit(memory, count, axes).result()
            what = f"{count:.0e} points along {axes} axes"
            print(f"{what}: client {client:.0f} MB, worker {worker:.0f} MB", flush=True)


def study_engine(runs: int = 2000, count: int = 500) -> Times:
    """Whole studies beside their runs in C, and what tasks and chunks cost."""
    times = Times("Studies: processor times")
    span = span_of()
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        chosen(times, folder, runs, span)
        whole(times, folder, runs, span)
        tasks(times, folder, count)
    return times


if __name__ == "__main__":
    study_engine(*map(int, sys.argv[1:])).show()
    memories()
