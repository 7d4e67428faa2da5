"""Who computes a study: one process where that is quick, workers where it is not."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np
import pytest

from rodgen.integrate import Solution
from rodgen.studies import local, task
from rodgen.studies.engine import run_study
from rodgen.studies.local import LocalWorker
from rodgen.studies.store import read_store
from rodgen.studies.study import Study
from tests.studies.conftest import PENDULUM, scene

SHORT = scene(PENDULUM, integrate={"span": [0.0, 0.1]})
pytestmark = pytest.mark.skipif(not local.FORKS, reason="nothing is forked here")


def study(keep: Any) -> Study:
    return Study.of(SHORT, {"parameters.A": [1.0, 2.0, 3.0]}, keep=keep)


def test_a_short_study_starts_no_workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_cluster(*of: Any) -> None:
        raise AssertionError("workers are started")

    monkeypatch.setattr("rodgen.studies.cluster.Cluster", no_cluster)
    monkeypatch.setattr(local, "SOON", 600.0)  # in which a busy machine compiles, too
    monkeypatch.setattr(local, "PAYS", 600.0)
    run_study(study("last(phi_1)"), tmp_path / "short.zarr")
    assert (read_store(tmp_path / "short.zarr")["status"] == "finished").all()
    monkeypatch.setattr(local, "PAYS", 0.0)
    with pytest.raises(AssertionError, match="workers are started"):
        run_study(study("last(phi_1)"), tmp_path / "long.zarr")
    assert not (tmp_path / "long.zarr").exists()


def test_a_point_that_takes_long_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    def slow(run: Solution) -> float:
        sleep(600)
        return 0.0

    monkeypatch.setattr(local, "SOON", 0.2)
    start = monotonic()
    with LocalWorker() as one:
        assert not one.is_enough(study(slow))
    assert monotonic() - start < 300  # of 600 s that one point takes


def test_how_long_a_point_takes_does_not_depend_on_who_shares_the_processor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Points take 10 ms of it; by the clock so many times as much, the last as they wait."""
    many = Study.of(SHORT, {"parameters.A": np.arange(24.0)}, keep="last(phi_1)")
    for beside, taken in ((1, 0.01), (10, 0.01), (100, 1.0)):
        done: list[int] = []
        monkeypatch.setattr(
            task, "compute_points", lambda study, at, done=done: done.append(len(at))
        )
        monkeypatch.setattr(task, "process_time", lambda done=done: 0.01 * sum(done))
        monkeypatch.setattr(
            task, "perf_counter", lambda done=done, beside=beside: 0.01 * sum(done) * beside
        )
        assert task.time_point(many) == pytest.approx(taken)


PROGRAM = """
import os, sys, threading, time
import rodgen
threading.Thread(target=lambda: sys.stdin.buffer.read(1), daemon=True).start()
time.sleep(0.2)  # it waits by then
scene = rodgen.Scene.example("ziegler")
vary = {"loads.follower.force": [1.0, 2.0]}
data = rodgen.study(scene, vary=vary, analysis="modes", workers=1)
print(data.sizes["loads.follower.force"], flush=True)
os._exit(0)  # the thread would hold up the end
"""


@pytest.mark.slow
def test_a_thread_that_reads_standard_input_is_not_waited_for() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            process.wait(timeout=600)
            assert process.stdout.read().strip() == "2"
        finally:
            process.kill()
