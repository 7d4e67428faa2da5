"""Studies and clusters that the benchmarks of studies measure, and how their processes are seen."""

from __future__ import annotations

import logging
import resource
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import dask
import distributed
import numpy as np
import psutil
import xarray as xr

from rodgen.studies import task
from rodgen.studies.cluster import SETTINGS
from rodgen.studies.kept_quantities import variables
from rodgen.studies.point_arrays import PointArrays
from rodgen.studies.study import Study
from rodgen.studies.task import Arrays
from rodgen_evidence.report.costs.cost_rows import scene

KEEP = ["last(tip_x)", "max(phi_19)", "max(omega_19)"]
MASS, FORCE = "rod.mass", "loads.follower.force"


def study_of(count: int, span: float = 0.1) -> Study:
    """Create a study of `count` runs of a free rod of 20 links; span: of a run [s]."""
    base = scene(20).with_integrate(span=[0.0, span], method="dop853", rtol=1e-6)
    return Study.of(base, {MASS: {"bounds": (10, 20), "count": count}}, keep=KEEP)


@contextmanager
def workers(count: int, plugin: distributed.WorkerPlugin | None = None) -> Iterator[str]:
    """The address of a cluster as studies start it, whose workers have a plugin."""
    with (
        dask.config.set(SETTINGS),
        distributed.LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            dashboard_address=None,
            silence_logs=logging.CRITICAL + 1,
        ) as cluster,
    ):
        if plugin is not None:
            with distributed.Client(cluster) as client:
                client.register_plugin(plugin)
        yield cluster.scheduler_address


class Empty(distributed.WorkerPlugin):  # type: ignore[misc]  # Dask has no types
    """Points that cost nothing."""

    def setup(self, worker: Any) -> None:
        vars(task)["evaluate"] = nothing


def nothing(study: Study, points: Sequence[Mapping[str, Any]]) -> Arrays:
    """Points that are all finished, without a run."""
    made = PointArrays(variables(study), len(points))
    made.arrays["status"][:] = "finished"
    return made.arrays


def same(a: xr.Dataset, b: xr.Dataset) -> bool:
    """Whether two studies have the same bits, but for the time that points took."""
    names = {*a.variables} - {"seconds"}
    return names == {*b.variables} - {"seconds"} and all(_same(a[n], b[n]) for n in names)


def _same(a: xr.DataArray, b: xr.DataArray) -> bool:
    x, y = np.asarray(a), np.asarray(b)
    if x.dtype.kind == "f":
        return x.shape == y.shape and x.tobytes() == y.tobytes()
    return bool(np.array_equal(x, y))


def processes() -> list[psutil.Process]:
    """This one and all that it has started."""
    this = psutil.Process()
    return [this, *this.children(recursive=True)]


def spent() -> float:
    """Processor time of all of them until now [s]."""
    return float(sum(sum(one.cpu_times()[:2]) for one in processes()))


def processor_time() -> float:
    """Processor time of this process and of those of its own that have ended [s]."""
    times = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in times)


def peak(process: int) -> float:
    """The most memory that a process had [MB]."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1e3
