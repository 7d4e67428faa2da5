"""Points of a study that take longer than they may: they have a status of their own, and the others
are computed."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Study
from rodgen.studies import point_runs, time_limit
from rodgen.studies.counts import count_points
from rodgen.studies.engine import run_study
from rodgen.studies.store import read_store
from rodgen.studies.time_limit import TimeLimitExceeded
from rodgen.system import System
from tests.studies.conftest import PENDULUM
from tests.told import refused

SCENE = rodgen.Scene.from_dict(PENDULUM)
LIMIT = 2.0  # s: a hundred times what a point takes
HANGS = 3.0


@pytest.fixture(autouse=True)
def _modules_are_made_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time_limit, "MAKING", 4.0)


def _hang(seconds: float) -> None:
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        time.sleep(1e-3)


def patient(solution: Any) -> float:
    """The number of a point, one of which never ends."""
    a = float(solution.scene.numbers["A"])
    if a == HANGS:
        _hang(600.0)
    return a


def _study(keep: Any, limit: float | None = LIMIT) -> Study:
    vary = {"parameters.A": [1.0, 2.0, HANGS, 4.0]}
    return Study.of(SCENE, vary, keep=keep, time_limit=limit, name="limited")


def test_a_point_that_never_ends_is_left(tmp_path: Path) -> None:
    """And is counted, and not computed again by --resume."""
    study, path = _study(patient), tmp_path / "a.zarr"
    run_study(study, path, workers=1)
    found = read_store(path).load()
    assert found.status.values.tolist() == ["finished", "finished", "too long", "finished"]
    np.testing.assert_array_equal(found["patient"], [1.0, 2.0, np.nan, 4.0])
    assert f"{LIMIT:g} s" in found.message.values[2]
    counted = count_points(path)
    assert (counted.computed, counted.failed, counted.too_long) == (4, 0, 1)
    begin = time.perf_counter()
    run_study(study, path, workers=1, resume=True)
    assert time.perf_counter() - begin < LIMIT


@pytest.mark.slow
def test_an_analysis_that_never_ends_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    analysed = rodgen.studies.task.analyse

    def slow(what: str, system: System, *given: Any) -> Any:
        if system.value_of("parameters.A") == HANGS:
            _hang(600.0)
        return analysed(what, system, *given)

    monkeypatch.setattr("rodgen.studies.task.analyse", slow)
    rodgen.static_equilibrium(SCENE)  # whose module takes longer to be made than a point may
    vary = {"parameters.A": [1.0, HANGS]}
    found = rodgen.study(SCENE, vary, analysis="static", time_limit=LIMIT, workers=1)
    assert found.status.values.tolist() == ["finished", "too long"]


@pytest.mark.slow
def test_runs_side_by_side_that_take_too_long_are_done_one_by_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole = rodgen.study(_study("last(phi_0)", None), workers=1)
    monkeypatch.setattr(point_runs, "simulate_rods", lambda *_, **__: _hang(600.0))
    found = rodgen.study(_study("last(phi_0)", 0.5), workers=1)
    assert set(found.status.values.tolist()) == {"finished"}
    name = "last(phi_0)"
    np.testing.assert_allclose(found[name], whole[name], rtol=1e-6)  # ten times the tolerance


def test_nothing_comes_late() -> None:
    """Whether what is limited ends before its time, after it, or in the same moment."""
    ends = {"in time": 0, "too long": 0}
    for at in range(120):
        try:
            with time_limit.time_limit(1e-3):
                # Long before, about then, and beyond the time for which a thread keeps others out.
                _busy((0.0, 1e-3, 6e-3, 2e-2)[at % 4])
            ends["in time"] += 1
        except TimeLimitExceeded:
            ends["too long"] += 1
        _busy(1e-3)
    assert sum(ends.values()) == 120
    assert ends["too long"]


def _busy(seconds: float) -> None:
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        pass


def test_a_limit_is_part_of_the_study() -> None:
    assert _study("last(phi_0)", 1.0) != _study("last(phi_0)", 2.0)
    assert _study("last(phi_0)", None).digest == _study("last(phi_0)", None).digest
    for value in (0.0, -1.0, np.inf, np.nan, "1", True):
        told = refused(_study, "last(phi_0)", value)
        assert told.field == "compute.time_limit"


def test_the_time_for_making_a_module_is_given_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where it was not enough."""
    monkeypatch.setattr(time_limit, "_known", set())
    for making in (0.01, 1e6):
        monkeypatch.setattr(time_limit, "MAKING", making)
        with pytest.raises(TimeLimitExceeded), time_limit.time_limit(0.01, SCENE):
            _hang(600.0)


def test_a_store_with_a_limit_is_of_another_study(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    keep = "max(phi_0)"
    run_study(_study(keep), path, workers=1)
    assert refused(run_study, _study(keep, None), path, workers=1, resume=True).field == "store"
