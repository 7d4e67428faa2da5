"""Clients that are killed and followed by others, schedulers that die, Ctrl-C: the same bits."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Study
from rodgen.studies.engine import run_study
from rodgen.studies.store import read_store
from tests.studies.conftest import PENDULUM, assert_same, study_file
from tests.studies.test_workers import in_blocks, study_of

pytestmark = [pytest.mark.compiler, pytest.mark.nightly]
CLIENT = """
import sys
from pathlib import Path
from rodgen.studies.engine import run_study
from tests.studies.test_kills import slow, study_of
run_study(study_of(slow), Path(sys.argv[1]), workers=1, resume=True)
"""


def slow(solution: Any) -> float:
    """The number of a point, after a pause; the last ends the client, whose process computes."""
    a = float(solution.scene.numbers["A"])
    if a == float(os.environ.get("LAST", "nan")):
        os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(float(os.environ.get("PAUSE", "0")))
    return a


def client(path: Path, **told: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", CLIENT, path], env={**os.environ, **told})


def test_a_client_that_is_killed_is_followed_by_another(tmp_path: Path) -> None:
    study = study_of(slow)
    path = in_blocks(tmp_path / "a.zarr", study, 2)
    assert client(path, LAST="13").wait(timeout=600) == -signal.SIGKILL
    before = read_store(path)
    there = before.status.values == "finished"
    assert there.sum() == 12  # six blocks of two
    run_study(study, path, workers=1, resume=True)
    after = read_store(path)
    assert_same(after, rodgen.study(study, workers=1))
    np.testing.assert_array_equal(after.seconds.values[there], before.seconds.values[there])


def test_two_clients_do_not_harm_each_other(tmp_path: Path) -> None:
    study = study_of(slow)
    path = in_blocks(tmp_path / "a.zarr", study, 1)
    both = [client(path, PAUSE="0.05") for _ in range(2)]
    assert [one.wait(timeout=600) for one in both] == [0, 0]
    assert_same(read_store(path), rodgen.study(study, workers=1))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A study of 40 points of a few hundredths of a second, in blocks of two."""
    long = {"method": "rk4", "step": 1e-4, "span": [0.0, 4.0]}
    vary = {"parameters.A": {"bounds": [0.1, 2], "count": 40}}
    path = study_file(tmp_path / "study.toml", "swings", {**PENDULUM, "integrate": long}, vary)
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
    assert "--resume" in err
    assert err.count("\n") == 1
    path = file.parent / "swings" / "study.zarr"
    assert 6 <= (read_store(path).status.values == "finished").sum() < 40
    run_study(Study.from_toml(file), path, workers=1, resume=True)
    assert_same(read_store(path), rodgen.study(Study.from_toml(file), workers=1))


@pytest.mark.parametrize(
    ("sent", "workers"),
    [("SIGINT", 2), ("SIGHUP", 2), ("SIGQUIT", 1), ("SIGTERM", 1), ("SIGKILL", 2), ("SIGKILL", 1)],
)
def test_a_signal_keeps_what_is_marked_and_ends_the_workers(
    sent: str, workers: int, file: Path
) -> None:
    """In one process group as in a terminal, to which a terminal sends what it sends; workers of a
    client that is killed end with it."""
    import psutil

    process, number = command(file, "--workers", workers), getattr(signal, sent)
    wait_for_marks(file, 3, process)
    children = psutil.Process(process.pid).children(recursive=True)
    if sent in ("SIGINT", "SIGHUP", "SIGQUIT"):
        os.killpg(process.pid, number)
    else:
        process.send_signal(number)
    _, err = process.communicate(timeout=600)
    if sent != "SIGKILL":  # of which the tracker of Python's processes tells
        assert process.returncode == 130, err
        assert err.count("\n") == 1
    psutil.wait_procs(children, timeout=20)
    assert not [one for one in children if one.is_running()]
    path = file.parent / "swings" / "study.zarr"
    assert 6 <= (read_store(path).status.values == "finished").sum() < 40
    again = command(file, "--workers", 1)
    _out, err = again.communicate(timeout=600)
    assert again.returncode == 0, err
    assert_same(read_store(path), rodgen.study(Study.from_toml(file), workers=1))


def test_the_death_of_python_s_tracker_is_not_told(file: Path) -> None:
    import psutil

    process = command(file, "--workers", 2)
    wait_for_marks(file, 3, process)
    (tracker,) = [
        one
        for one in psutil.Process(process.pid).children()
        if any("resource_tracker" in word for word in one.cmdline())
    ]
    tracker.kill()
    _, err = process.communicate(timeout=600)
    assert (process.returncode, err) == (0, "")
