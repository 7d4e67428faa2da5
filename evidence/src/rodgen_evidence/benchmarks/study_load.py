"""Load of Dask's scheduler by tasks of a study that do nothing and write nothing.

python -m rodgen_evidence.benchmarks.study_load [TASKS] [WORKERS] [SECONDS]

The scheduler, the workers and the client are processes of their own, as on a cluster. Printed are
tasks done, the time by the clock, the processor time that each of a task takes and the most memory
that it had. TASKS: how many, by default 1e6; WORKERS: by default 2; SECONDS: after which no more
are begun, by default an hour.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import dask
import distributed
import psutil

from rodgen.studies import task
from rodgen.studies.cluster import SETTINGS, Cluster
from rodgen.studies.store import StudyStore
from rodgen_evidence.benchmarks.clusters import peak, study_of

MARKS = 20  # lines that are printed, and one at each power of ten
FIRST = 100  # tasks before what is measured: connections, imports


class Idle(distributed.WorkerPlugin):  # type: ignore[misc]  # Dask has no types
    """Blocks that are done without a look at them."""

    def setup(self, worker: Any) -> None:
        vars(task)["compute_block"] = lambda store, block, compute: (block, 0)


@contextmanager
def processes(count: int, folder: Path) -> Iterator[tuple[str, list[int]]]:
    """Address of a scheduler with so many workers, and the numbers of their processes, that of the
    scheduler first."""
    told = folder / "scheduler.json"
    settings = dask.config.serialize(SETTINGS | {"distributed.worker.memory.terminate": False})
    environment = {**os.environ, "DASK_INTERNAL_INHERIT_CONFIG": settings}
    where = ["--scheduler-file", str(told)]
    by = [*where, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory"]
    scheduler = [*where, "--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    commands = [
        ["scheduler", *scheduler],
        *(["worker", *by, str(folder / str(n))] for n in range(count)),
    ]
    started: list[subprocess.Popen[bytes]] = []
    try:
        for command in commands:
            line = [sys.executable, "-m", "dask", *command]
            quiet: Any = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            started.append(subprocess.Popen(line, env=environment, **quiet))
            while not told.exists():
                if started[0].poll() is not None:
                    raise RuntimeError("the scheduler did not start")
                time.sleep(0.1)
        with distributed.Client(scheduler_file=str(told)) as client:
            client.wait_for_workers(count, timeout=120)
            client.register_plugin(Idle())
            address = client.scheduler.address
        yield address, [one.pid for one in started]
    finally:
        for one in started:
            one.kill()
            one.wait()


def used(of: list[int]) -> list[float]:
    """Processor times of processes until now [s]."""
    return [sum(psutil.Process(pid).cpu_times()[:2]) for pid in of]


def _of_three(values: list[float], join: Callable[[list[float]], float]) -> list[float]:
    """Join the values of the workers, between those of the scheduler and the client."""
    return [values[0], join(values[1:-1]), values[-1]]


def study_load(count: int = 10**6, workers: int = 2, seconds: float = 3600.0) -> list[float]:
    """Print how tasks go on; processor times of scheduler, workers together, and client, a task."""
    print("    tasks   seconds  tasks/s   a task [ms]: scheduler, workers, client      peak [MB]")
    each: list[float] = []
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        store = StudyStore.create(folder / "study.zarr", study_of(1), 1)
        with processes(workers, folder) as (address, pids), Cluster(workers, address) as cluster:
            of = [*pids, os.getpid()]
            marks = {10**n for n in range(2, 9)} | {count * n // MARKS for n in range(1, MARKS + 1)}
            work = cluster.compute(store, iter(range(FIRST + count)), {})
            deque(islice(work, FIRST), maxlen=0)
            begun, before = time.monotonic(), used(of)
            for done, _ in enumerate(work, 1):
                if done not in marks:
                    continue
                clock = time.monotonic() - begun
                times = [(b - a) / done for a, b in zip(before, used(of), strict=True)]
                each = _of_three(times, sum)
                shown = " ".join(f"{1e3 * one:10.3f}" for one in each)
                most = " ".join(f"{mb:5.0f}" for mb in _of_three([peak(pid) for pid in of], max))
                print(f"{done:9d} {clock:9.1f} {done / clock:8.1f} {shown} {most}", flush=True)
                if clock > seconds:
                    break
    return each


if __name__ == "__main__":
    given = [float(one) for one in sys.argv[1:]]
    study_load(*(int(one) for one in given[:2]), *given[2:])
