"""Workers of a study, and points that kill them: the same bits; and workers that are refused."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import InputError, Study, StudyError
from rodgen.studies.engine import run_study
from rodgen.studies.local import FORKS
from rodgen.studies.store import StudyStore, read_store
from tests.studies.conftest import PENDULUM, assert_same, scene
from tests.told import refused

pytestmark = pytest.mark.compiler
SHORT = scene(PENDULUM, integrate={"span": [0.0, 0.1]})
POINTS = 24


def study_of(function: Callable[[Any], float] | None = None, keep: str = "max(phi_2)") -> Study:
    kept = [keep] if function is None else [keep, function]
    return Study.of(SHORT, {"parameters.A": np.arange(float(POINTS))}, keep=kept)


def in_blocks(path: Path, study: Study, size: int) -> Path:
    StudyStore.create(path, study, size)
    return path


def fatal(*at: float) -> Callable[[Any], float]:
    """The number of a point, whose process some are the end of."""

    def poisonous(solution: Any) -> float:
        a = float(solution.scene.numbers["A"])
        if a in at:
            os.kill(os.getpid(), signal.SIGKILL)
        return a

    return poisonous


@pytest.mark.slow
def test_workers_and_blocks_leave_the_bits_alone(tmp_path: Path, scheduler: Any) -> None:
    path = in_blocks(tmp_path / "a.zarr", study_of(), 5)
    run_study(study_of(), path, scheduler=scheduler.scheduler_address, resume=True)
    assert_same(read_store(path), rodgen.study(study_of(), workers=1))


@pytest.mark.nightly
def test_a_worker_that_is_killed_is_replaced(tmp_path: Path, scheduler: Any) -> None:
    """At three points, each once."""
    flags = tmp_path

    def mortal(solution: Any) -> float:
        a = solution.scene.numbers["A"]
        flag = flags / f"{a}"
        if a in (3.0, 4.0, 17.0) and not flag.exists():
            flag.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return float(a)

    study = study_of(mortal)
    path = in_blocks(tmp_path / "a.zarr", study, 2)
    run_study(study, path, scheduler=scheduler.scheduler_address, resume=True)
    assert len(list(flags.glob("*.0"))) == 3  # killed they were
    assert_same(read_store(path), rodgen.study(study, workers=1))


@pytest.mark.nightly
def test_a_point_that_kills_its_worker_is_recorded(tmp_path: Path, scheduler: Any) -> None:
    """And the others of its block, and those beside it, are what they are without it."""
    study = study_of(fatal(7.0))
    path = in_blocks(tmp_path / "a.zarr", study, 6)
    run_study(study, path, scheduler=scheduler.scheduler_address, resume=True)
    _recorded(path, 7)


@pytest.mark.slow
@pytest.mark.skipif(not FORKS, reason="where there are no forks, it ends with the study")
def test_a_single_worker_survives_a_point_that_kills_its_process(tmp_path: Path) -> None:
    """It kills it twice, is recorded and all others are computed; also where it is the one by which
    the time of a point is found."""
    run_study(study_of(fatal(3.0, POINTS // 2)), tmp_path / "a.zarr", workers=1)
    _recorded(tmp_path / "a.zarr", 3, POINTS // 2)


def _recorded(path: Path, *at: int) -> None:
    """These points failed, with the signal that ended their process; all others are there."""
    data, bad = read_store(path), np.isin(np.arange(POINTS), at)
    np.testing.assert_array_equal(data.status.values == "failed", bad)
    assert all("SIGKILL" in message for message in data.message.values[bad])
    assert np.isnan(data["max(phi_2)"].values[bad]).all()
    np.testing.assert_array_equal(data["poisonous"].values[~bad], np.arange(POINTS)[~bad])
    expected = rodgen.study(study_of(fatal()), workers=1)["max(phi_2)"].values
    np.testing.assert_array_equal(data["max(phi_2)"].values[~bad], expected[~bad])


@pytest.mark.slow
def test_a_scheduler_that_does_not_answer_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rodgen.studies.cluster.ANSWER", 1.0)
    nobody = "127.0.0.1:9"
    # For the last, there are no certificates.
    for address in (
        nobody,
        f"tcp://{nobody}",
        "nowhere",
        "tcp://",
        "http://x:y",
        f"tls://{nobody}",
    ):
        told = refused(run_study, study_of(), tmp_path / "a.zarr", scheduler=address)
        assert told.field == "--scheduler"
    assert not list(tmp_path.iterdir())


@pytest.mark.nightly
def test_workers_of_another_version_are_refused(
    tmp_path: Path, scheduler: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """That of the client is changed: what matters is that they differ."""
    from rodgen.studies import worker_tasks

    own = worker_tasks.versions()
    for key in own:
        monkeypatch.setattr(worker_tasks, "identity", lambda key=key: {**own, key: "another"})
        with pytest.raises(InputError, match=rf"{key} {re.escape(str(own[key]))}\b"):
            run_study(study_of(), tmp_path / "a.zarr", scheduler=scheduler.scheduler_address)
    assert not list(tmp_path.iterdir())


@pytest.mark.nightly
def test_workers_that_do_not_see_the_store_are_refused(tmp_path: Path, scheduler: Any) -> None:
    """Where it is not there for them, and where another one is."""
    from rodgen.studies.cluster import Cluster

    study = study_of()
    before = StudyStore.of(in_blocks(tmp_path / "a.zarr", study, 4), study)
    elsewhere = StudyStore(
        tmp_path / "b.zarr", before.study, before.layout, before.arrays, before.token
    )
    with Cluster(2, scheduler.scheduler_address) as workers:
        for _ in range(2):
            told = refused(lambda: list(workers.compute(elsewhere, iter([0]), {})))
            assert str(told.value) == str(tmp_path / "b.zarr")
            in_blocks(tmp_path / "b.zarr", study, 4)


@pytest.mark.nightly
def test_workers_that_never_come_end_the_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import distributed

    monkeypatch.setattr("rodgen.studies.cluster.PATIENCE", {True: 0.5, False: 0.5})
    with (
        distributed.LocalCluster(
            n_workers=0, processes=False, protocol="tcp://", dashboard_address="127.0.0.1:0"
        ) as empty,
        pytest.raises(StudyError),
    ):
        run_study(study_of(), tmp_path / "a.zarr", scheduler=empty.scheduler_address)


@pytest.mark.nightly
def test_a_worker_takes_the_texts_that_the_client_has(tmp_path: Path, scheduler: Any) -> None:
    """They are put into the cache of a worker that does not have them."""
    from rodgen.loading import cache
    from rodgen.studies.cluster import Cluster

    store = StudyStore.create(tmp_path / "a.zarr", study_of(), 24)
    entry = ("modules", "0" * 32, "text_of_a_test.json")
    file = cache.cache_root().joinpath(*entry)
    file.unlink(missing_ok=True)
    with Cluster(2, scheduler.scheduler_address) as workers:
        list(workers.compute(store, iter([0]), {entry: "the text"}))
        seconds, _texts = workers.time_point(study_of(keep="max(phi_1)"))
    assert cache.read_text(*entry) == "the text"
    assert seconds > 0
    file.unlink()
