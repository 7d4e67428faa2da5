"""What studies cost beside the runs that they consist of.

python -m rodgen_evidence.benchmarks.study_engine [TASKS]

Processor times of all processes, as ratios; blocks of points that do nothing tell what a task and a
chunk cost. TASKS: how many of them, by default 500.
"""

from __future__ import annotations

import logging
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import dask
import distributed
import numpy as np
import psutil

from rodgen.studies import task
from rodgen.studies.block import Block, evaluate
from rodgen.studies.cluster import SETTINGS
from rodgen.studies.engine import BLOCK, run, size_of
from rodgen.studies.keep import variables
from rodgen.studies.made import Made
from rodgen.studies.points import points
from rodgen.studies.specification import Study
from rodgen.studies.store import Store
from rodgen_evidence.benchmarks import Times
from rodgen_evidence.report.costs.rod import scene

KEEP = ["last(tip_x)", "max(phi_19)", "max(omega_19)"]
RUNS = 400  # of about 5 ms
WORKERS = 2


class Nothing(distributed.WorkerPlugin):  # type: ignore[misc]
    """Points that cost nothing."""

    def setup(self, worker: Any) -> None:
        vars(task)["evaluate"] = nothing


def nothing(
    study: Study, points: Sequence[Mapping[str, Any]], indices: Sequence[int] = ()
) -> Block:
    """Points that are all finished, without a run."""
    made = Made(variables(study), len(points))
    made.arrays["status"][:] = "finished"
    return Block({name: np.asarray(values) for name, values in made.arrays.items()})


def study_of(count: int, span: float) -> Study:
    """So many runs of a free rod of 20 links."""
    base = scene(20).with_integrate(span=[0.0, span], method="dop853", rtol=1e-6)
    return Study.of(base, {"rod.mass": {"from": 10, "to": 20, "count": count}}, keep=KEEP)


@contextmanager
def workers(count: int = WORKERS) -> Iterator[distributed.LocalCluster]:
    """A cluster as studies start it."""
    with (
        dask.config.set(SETTINGS),
        distributed.LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            dashboard_address=None,
            silence_logs=logging.CRITICAL + 1,
        ) as cluster,
    ):
        yield cluster


def processes() -> list[psutil.Process]:
    """This one and its workers."""
    this = psutil.Process()
    return [this, *this.children(recursive=True)]


def spent() -> float:
    """Processor time of all of them until now [s]."""
    return float(sum(sum(one.cpu_times()[:2]) for one in processes()))


def largest() -> float:
    """Memory of the largest of them [MB]."""
    return float(max(one.memory_info().rss for one in processes())) / 1e6


def alone(times: Times, folder: Path) -> None:
    """A whole study in this process, beside its points in one go."""
    study = study_of(RUNS, 5.0)
    given = points(study, range(RUNS))
    evaluate(study, given[:8])
    owns, wholes = [], []
    for turn in range(3):
        start = time.process_time()
        evaluate(study, given)
        owns.append(time.process_time() - start)
        start = time.process_time()
        run(study, folder / f"alone{turn}.zarr", workers=1)
        wholes.append(time.process_time() - start)
    times.add(f"{RUNS} runs as a study, one process", min(wholes), "in one go", min(owns))


def tasks(times: Times, folder: Path, count: int) -> None:
    """Blocks that do nothing: what a task and its chunks cost, in all processes."""
    study = study_of(count, 0.1)
    with workers() as cluster:
        client = distributed.Client(cluster)
        client.register_plugin(Nothing())
        store = folder / "tasks.zarr"
        Store.make(store, study, 1)
        few = folder / "few.zarr"
        run(study_of(20, 0.1), few, scheduler=cluster.scheduler_address)
        start = spent()
        run(study, store, scheduler=cluster.scheduler_address, resume=True)
        each = (spent() - start) / count
        client.close()
    start = time.process_time()
    made, arrays = Store.make(folder / "chunks.zarr", study, 1), task.computed(study, [0])
    for block in range(100):
        made.write(block, points(study, [block]), arrays)
    chunks = (time.process_time() - start) / 100
    times.add("a task and its chunks, all processes", each, "a block", BLOCK)
    times.add("chunks of a block", chunks, "the task with them", each)


def shared(times: Times, folder: Path) -> None:
    """The same blocks by one worker and by two, by the clock."""
    study = study_of(RUNS, 5.0)
    taken = []
    for count in (1, 2):
        with workers(count) as cluster:
            path = folder / f"shared{count}.zarr"
            Store.make(path, study, RUNS // 20)
            address = cluster.scheduler_address
            run(study_of(20, 5.0), folder / f"warm{count}.zarr", scheduler=address)
            start = time.perf_counter()
            run(study, path, scheduler=address, resume=True)
            taken.append(time.perf_counter() - start)
    times.add("one worker, by the clock", taken[0], "two", taken[1])


def memory(folder: Path) -> None:
    """The largest process of studies of 1e4 and 1e6 points of 0.1 ms."""
    found = []
    for count in (10**4, 10**6):
        side = round(count**0.5)
        axes = {"rod.mass": (10, 20), "loads.follower.force": (1, 10)}
        vary = {name: {"from": a, "to": b, "count": side} for name, (a, b) in axes.items()}
        study = Study.of(study_of(1, 0.1).base, vary, keep=KEEP)
        with workers() as cluster:
            client = distributed.Client(cluster)
            client.register_plugin(Nothing())
            path = folder / f"memory{count}.zarr"
            Store.make(path, study, size_of(study, 1e-4, WORKERS))
            run(study, path, scheduler=cluster.scheduler_address, resume=True)
            found.append(largest())
            client.close()
    print("largest process, 1e4 and 1e6 points: " + ", ".join(f"{mb:.0f} MB" for mb in found))


def main() -> None:
    """Measure and print."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    times = Times("Studies: processor times")
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        alone(times, folder)
        shared(times, folder)
        tasks(times, folder, count)
        memory(folder)
    times.show()


if __name__ == "__main__":
    main()
