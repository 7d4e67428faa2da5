"""Workers that are killed, clients that follow others, schedulers that die: the same bits."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import distributed
import numpy as np
import pytest
from distributed.comm import CommClosedError

import rodgen
from rodgen import SceneError, Study, StudyError
from rodgen.studies import cluster, worker
from rodgen.studies.engine import run
from rodgen.studies.here import FORKS
from rodgen.studies.store import Store, read
from tests.studies.conftest import assert_same
from tests.studies.scenes import PENDULUM, scene

pytestmark = pytest.mark.compiler
SHORT = scene(PENDULUM, integrate={"span": [0.0, 0.1]})
POINTS = 24


def study_of(function: Callable[[Any], float] | None = None, keep: str = "max(phi_2)") -> Study:
    kept = [keep] if function is None else [keep, function]
    return Study.of(SHORT, {"parameters.A": np.arange(float(POINTS))}, keep=kept)


def in_blocks(path: Path, study: Study, size: int) -> Path:
    Store.make(path, study, size)
    return path


@pytest.mark.nightly
@pytest.mark.parametrize("size", [1, 5, 24])
def test_workers_and_blocks_leave_the_bits_alone(size: int, tmp_path: Path, scheduler: Any) -> None:
    path = in_blocks(tmp_path / "a.zarr", study_of(), size)
    run(study_of(), path, scheduler=scheduler.scheduler_address, resume=True)
    assert_same(read(path), rodgen.study(study_of(), workers=1))


def test_there_are_blocks_for_all_workers_of_a_scheduler(
    tmp_path: Path, scheduler: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However many processors the machine of the client has."""
    monkeypatch.setattr(cluster.Cluster, "count", property(lambda self: 3 * self._threads))
    path = tmp_path / "a.zarr"
    run(study_of(), path, scheduler=scheduler.scheduler_address)
    assert Store.of(path, study_of()).layout.count == POINTS  # four for each of six workers
    assert (read(path).status == "finished").all()


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
    run(study, path, scheduler=scheduler.scheduler_address, resume=True)
    assert len(list(flags.glob("*.0"))) == 3  # killed they were
    assert_same(read(path), rodgen.study(study, workers=1))


def test_a_worker_may_die_while_it_is_told_of_the_study(
    tmp_path: Path, scheduler: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Then Dask reports a connection that was closed, be it at the start or at the end."""
    calls: list[str] = []

    def dying(name: str) -> Callable[..., Any]:
        of = getattr(distributed.Client, name)

        def call(*given: Any, **named: Any) -> Any:
            calls.append(name)
            if calls.count(name) == 1:
                raise CommClosedError("in <TCP (closed)>: Stream is closed")
            return of(*given, **named)

        return call

    for name in ("register_plugin", "unregister_worker_plugin"):
        monkeypatch.setattr(distributed.Client, name, dying(name))
    path = in_blocks(tmp_path / "a.zarr", study_of(), 12)
    run(study_of(), path, scheduler=scheduler.scheduler_address, resume=True)
    assert calls == ["register_plugin", "register_plugin", "unregister_worker_plugin"]
    assert_same(read(path), rodgen.study(study_of(), workers=1))


def test_a_point_that_kills_its_worker_is_recorded(tmp_path: Path, scheduler: Any) -> None:
    """And the others of its block, and those beside it, are what they are without it."""

    def poisonous(solution: Any) -> float:
        a = solution.scene.numbers["A"]
        if a == 7.0:
            os.kill(os.getpid(), signal.SIGKILL)
        if a == 9.0:
            raise ArithmeticError("nine")
        return float(a)

    study = study_of(poisonous)
    path = in_blocks(tmp_path / "a.zarr", study, 6)
    run(study, path, scheduler=scheduler.scheduler_address, resume=True)
    data = read(path)
    others = data.where(data["parameters.A"] != 7, drop=True)
    assert data.status.values[7] == "failed"
    assert data.message.values[7] == "its process was ended by SIGKILL, twice and alone"
    assert np.isnan(data["max(phi_2)"].values[7])
    assert "nine" in data.message.values[9]
    assert (data.status.values == "failed").sum() == 2

    def harmless(solution: Any) -> float:
        return float(solution.scene.numbers["A"])

    expected = rodgen.study(study_of(harmless), workers=1)["max(phi_2)"]
    good = [a for a in range(POINTS) if a not in (7, 9)]
    np.testing.assert_array_equal(data["max(phi_2)"].values[good], expected.values[good])
    assert len(others["parameters.A"]) == POINTS - 1


@pytest.mark.skipif(not FORKS, reason="where there are no forks, it ends with the study")
def test_a_single_worker_survives_a_point_that_kills_its_process(tmp_path: Path) -> None:
    """It kills it twice, is recorded and all others are computed; also where it is the one by which
    the time of a point is found."""

    def poisonous(solution: Any) -> float:
        a = solution.scene.numbers["A"]
        if a in (3.0, POINTS // 2):
            os.kill(os.getpid(), signal.SIGKILL)
        return float(a)

    study = study_of(poisonous)
    run(study, tmp_path / "a.zarr", workers=1)
    data = read(tmp_path / "a.zarr")
    bad = np.isin(np.arange(POINTS), (3, POINTS // 2))
    np.testing.assert_array_equal(data.status.values == "failed", bad)
    said = "its process was ended by SIGKILL, twice and alone"
    assert (data.message.values[bad] == said).all()
    np.testing.assert_array_equal(data["poisonous"].values[~bad], np.arange(POINTS)[~bad])


CLIENT = """
import os, signal, sys, time
from pathlib import Path
import numpy as np
from rodgen import Study
from rodgen.studies.engine import run
from tests.studies.test_workers import SHORT, POINTS

path, pause, last = Path(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
def slow(solution):
    if solution.scene.numbers["A"] == last:
        os.kill(os.getppid(), signal.SIGKILL)  # of the client, whose process computes
    time.sleep(pause)
    return float(solution.scene.numbers["A"])
# As another function it would be that of another study.
import rodgen.studies.specification as specification
specification._named = lambda kept: str(kept) if isinstance(kept, str) else "slow"
study = Study.of(SHORT, {"parameters.A": np.arange(float(POINTS))}, keep=["max(phi_2)", slow])
run(study, path, workers=1, resume=True)
"""


def client(path: Path, pause: float, last: float = -1.0) -> subprocess.Popen[bytes]:
    arguments = map(str, (path, pause, last))
    return subprocess.Popen([sys.executable, "-c", CLIENT, *arguments], cwd=Path.cwd())


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> Study:
    """The study of these clients."""

    def slow(solution: Any) -> float:
        return float(solution.scene.numbers["A"])

    from rodgen.studies import specification

    monkeypatch.setattr(
        specification, "_named", lambda kept: str(kept) if isinstance(kept, str) else "slow"
    )
    return study_of(slow)


@pytest.mark.nightly
def test_a_client_that_is_killed_is_followed_by_another(tmp_path: Path, slow: Study) -> None:
    path = in_blocks(tmp_path / "a.zarr", slow, 2)
    assert client(path, 0.0, last=13.0).wait(timeout=600) == -signal.SIGKILL
    before = read(path)
    there = before.status.values == "finished"
    assert there.sum() == 12  # six blocks of two
    run(slow, path, workers=1, resume=True)
    after = read(path)
    assert_same(after, rodgen.study(slow, workers=1))
    np.testing.assert_array_equal(after.seconds.values[there], before.seconds.values[there])


@pytest.mark.nightly
def test_two_clients_do_not_harm_each_other(tmp_path: Path, slow: Study) -> None:
    path = in_blocks(tmp_path / "a.zarr", slow, 1)
    both = [client(path, 0.05), client(path, 0.05)]
    assert [one.wait(timeout=600) for one in both] == [0, 0]
    assert_same(read(path), rodgen.study(slow, workers=1))


FILE = """
name = "swings"
[scene]
name = "pendulum"
[scene.rod]
links = 3
length = 1.0
bending_stiffness = 1.0
mass = 2.0
boundary = "pinned"
[scene.loads.gravity]
g = 9.81
[scene.loads.internal_damping]
coefficient = 0.02
[scene.loads.tip]
x = "A*sin(w*t)"
[scene.parameters]
A = 1.0
w = 3.0
[scene.initial]
phi = 0.8
[scene.integrate]
method = "rk4"
step = 1e-4
span = [0.0, 4.0]
[vary]
"parameters.A" = {from = 0.1, to = 2, count = 40}
[compute]
keep = ["last(tip_x)"]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A study of 40 points of a few hundredths of a second, in blocks of two."""
    path = tmp_path / "study.toml"
    path.write_text(FILE)
    in_blocks(tmp_path / "swings" / "study.zarr", Study.from_toml(path), 2)
    return path


def command(file: Path, *options: object) -> subprocess.Popen[str]:
    words = ["-m", "rodgen", "study", file, "--out", file.parent, "--resume", *options]
    return subprocess.Popen(
        [sys.executable, *map(str, words)],
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def wait_for_marks(file: Path, count: int, process: subprocess.Popen[str]) -> None:
    marks = file.parent / "swings" / "study.zarr" / "status" / "c"
    while process.poll() is None and (not marks.exists() or len(list(marks.iterdir())) < count):
        time.sleep(0.02)


@pytest.mark.nightly  # it starts workers of its own, twice
def test_the_death_of_a_scheduler_ends_in_one_line(file: Path, tmp_path: Path) -> None:
    """And status 3; what is marked is kept, and another client does the rest."""
    where = tmp_path / "scheduler.json"
    start = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0"]
    quiet: Any = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    begun = [subprocess.Popen([*start, "--scheduler-file", where, "--no-dashboard"], **quiet)]
    try:
        work = [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", where]
        alone = ["--no-nanny", "--no-dashboard", "--nthreads", "1", "--death-timeout", "60"]
        begun.append(subprocess.Popen([*work, *alone], **quiet))
        while not where.exists():
            time.sleep(0.05)
        address = where.read_text().split('"address": "')[1].split('"')[0]
        process = command(file, "--scheduler", address)
        wait_for_marks(file, 3, process)
        begun[0].kill()
        _out, err = process.communicate(timeout=600)
    finally:
        for one in begun:
            one.kill()
            one.wait()
    assert process.returncode == 3, err
    assert "the scheduler does not answer any more" in err
    assert "--resume goes on" in err
    assert err.count("\n") == 1
    path = file.parent / "swings" / "study.zarr"
    there = read(path).status.values == "finished"
    assert 6 <= there.sum() < 40
    run(Study.from_toml(file), path, workers=1, resume=True)
    assert_same(read(path), rodgen.study(Study.from_toml(file), workers=1))


@pytest.mark.nightly  # it starts workers of its own, twice
def test_ctrl_c_keeps_what_is_marked_and_ends_the_workers(file: Path) -> None:
    """With two workers of its own, in one process group as in a terminal."""
    import psutil

    process = command(file, "--workers", 2)
    wait_for_marks(file, 3, process)
    children = psutil.Process(process.pid).children(recursive=True)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=600)
    assert process.returncode == 130, err
    assert "dashboard: http://127.0.0.1:" in out
    assert "points are kept" in err
    assert err.count("\n") == 1
    psutil.wait_procs(children, timeout=20)
    assert not [one for one in children if one.is_running()]
    path = file.parent / "swings" / "study.zarr"
    assert 6 <= (read(path).status.values == "finished").sum() < 40
    again = command(file, "--workers", 1)
    out, err = again.communicate(timeout=600)
    assert again.returncode == 0, err
    assert_same(read(path), rodgen.study(Study.from_toml(file), workers=1))


def test_a_scheduler_that_does_not_answer_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "ANSWER", 1.0)
    for address in ("127.0.0.1:9", "tcp://127.0.0.1:9", "nowhere", "tcp://", "http://x:y"):
        with pytest.raises(SceneError, match="--scheduler"):
            run(study_of(), tmp_path / "a.zarr", scheduler=address)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("key", ["rodgen", "sources", "Python"])
def test_workers_of_another_version_are_refused(
    key: str, tmp_path: Path, scheduler: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """That of the client is changed: what matters is that they differ."""
    own = worker.who()
    monkeypatch.setattr(cluster, "of_client", lambda: {**own, key: "another"})
    with pytest.raises(SceneError, match=f"{key} {own[key]}, not another"):
        run(study_of(), tmp_path / "a.zarr", scheduler=scheduler.scheduler_address)
    assert not list(tmp_path.iterdir())


def test_workers_that_do_not_see_the_store_are_refused(
    tmp_path: Path, scheduler: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    study, path = study_of(), tmp_path / "a.zarr"
    in_blocks(path, study, 4)
    before = Store.of(path, study)
    elsewhere = Store(tmp_path / "b.zarr", *(getattr(before, k) for k in FIELDS))
    with cluster.Cluster(2, scheduler.scheduler_address) as workers:
        with pytest.raises(SceneError, match="a folder that all workers see"):
            list(workers.compute(elsewhere, iter([0]), {}))
        in_blocks(tmp_path / "b.zarr", study, 4)
        with pytest.raises(SceneError, match="there is another store"):
            list(workers.compute(elsewhere, iter([0]), {}))


FIELDS = ("study", "layout", "arrays", "token")


def test_workers_that_never_come_end_the_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import distributed

    monkeypatch.setattr(cluster, "PATIENCE", {True: 0.5, False: 0.5})
    with (
        distributed.LocalCluster(
            n_workers=0, processes=False, protocol="tcp://", dashboard_address="127.0.0.1:0"
        ) as empty,
        pytest.raises(StudyError, match="no worker"),
    ):
        run(study_of(), tmp_path / "a.zarr", scheduler=empty.scheduler_address)


def test_a_worker_takes_the_texts_that_the_client_has(tmp_path: Path, scheduler: Any) -> None:
    """They are put into the cache of a worker that does not have them."""
    from rodgen.loading import cache

    study = study_of()
    store = Store.make(tmp_path / "a.zarr", study, 24)
    entry = ("modules", "0" * 32, "text_of_a_test.json")
    cache.cache_root().joinpath(*entry).unlink(missing_ok=True)
    with cluster.Cluster(2, scheduler.scheduler_address) as workers:
        list(workers.compute(store, iter([0]), {entry: "the text"}))
        seconds, _texts = workers.timed(study_of(keep="max(phi_1)"))
    assert cache.read_text(*entry) == "the text"
    assert seconds > 0
    cache.cache_root().joinpath(*entry).unlink()
