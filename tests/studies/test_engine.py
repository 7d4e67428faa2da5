"""Who computes a study: one process where that is quick, workers where it is not."""

from __future__ import annotations

from pathlib import Path
from time import sleep
from typing import Any

import pytest

from rodgen.integrate import Solution
from rodgen.studies import here
from rodgen.studies.engine import run
from rodgen.studies.here import Here
from rodgen.studies.specification import Study
from rodgen.studies.store import read
from tests.studies.scenes import PENDULUM, scene

SHORT = scene(PENDULUM, integrate={"span": [0.0, 0.1]})
pytestmark = pytest.mark.skipif(not here.FORKS, reason="nothing is forked here")


def study(keep: Any) -> Study:
    return Study.of(SHORT, {"parameters.A": [1.0, 2.0, 3.0]}, keep=keep)


def test_a_short_study_starts_no_workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_cluster(*of: Any) -> None:
        raise AssertionError("workers are started")

    monkeypatch.setattr("rodgen.studies.cluster.Cluster", no_cluster)
    monkeypatch.setattr(here, "SOON", 600.0)  # in which a busy machine compiles, too
    monkeypatch.setattr(here, "PAYS", 600.0)
    run(study("last(phi_1)"), tmp_path / "short.zarr")
    assert (read(tmp_path / "short.zarr")["status"] == "finished").all()
    monkeypatch.setattr(here, "PAYS", 0.0)
    with pytest.raises(AssertionError, match="workers are started"):
        run(study("last(phi_1)"), tmp_path / "long.zarr")
    assert not (tmp_path / "long.zarr").exists()


def test_a_point_that_takes_long_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    def slow(run: Solution) -> float:
        sleep(60)
        return 0.0

    monkeypatch.setattr(here, "SOON", 0.2)
    with Here() as one:
        assert not one.is_enough(study(slow))
