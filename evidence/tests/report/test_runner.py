"""Units in processes of their own: what crashes, hangs or is stopped takes nothing along."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rodgen_evidence.report import sections
from rodgen_evidence.report.runner import Runner
from rodgen_evidence.report.unit import Measured, Unit

WORK = '''
"""What the units of these tests call."""
import os, pathlib, signal, time


def rows(value):
    print("text of a library that says too much")
    return [{"value": value, "pid": os.getpid(), "threads": os.environ["OMP_NUM_THREADS"]}]


def count(file):
    path = pathlib.Path(file)
    path.write_text(path.read_text() + "x" if path.exists() else "x")
    return [{"infinite": float("inf")}]


def fail():
    raise ValueError("a peer that\\nsays why")


def crash():
    os.kill(os.getpid(), signal.SIGSEGV)


def leave():
    os._exit(3)


def sleep(seconds, begun):
    part = pathlib.Path(begun + ".part")
    part.write_text(str(os.getpid()))
    part.rename(begun)
    time.sleep(seconds)
    return []
'''


@pytest.fixture(autouse=True)
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A module that workers can import."""
    (tmp_path / "judged_work.py").write_text(WORK, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))


def unit(
    name: str, function: str, timed: bool = True, limit: float = 60.0, **given: object
) -> Unit:
    return Unit("tests", name, f"judged_work:{function}", given, timed, limit)


def test_rows_come_back_in_order(tmp_path: Path) -> None:
    told: list[str] = []
    runner = Runner(tmp_path / "m", [], done=lambda one: told.append(one.name))
    units = [unit("b", "rows", value=1), unit("a", "rows", timed=False, value="two")]
    found = runner.run(units)
    assert [one.rows[0]["value"] for one in found] == [1, "two"]
    assert told == ["a", "b"]  # what is not timed comes first
    pids = {one.rows[0]["pid"] for one in found}
    assert len(pids | {os.getpid()}) == 3
    assert {one.rows[0]["threads"] for one in found} == {"1"}


@pytest.mark.nightly
def test_failures_are_told_and_take_none_along(tmp_path: Path) -> None:
    begun = str(tmp_path / "begun")
    units = [
        unit("fails", "fail"),
        unit("crashes", "crash"),
        unit("leaves", "leave", timed=False),
        unit("hangs", "sleep", limit=1.5, seconds=60, begun=begun),
        unit("absent", "nothing"),
        unit("works", "rows", value=1),
    ]
    found = {one.name: one for one in Runner(tmp_path / "m", []).run(units)}
    assert found["fails"].failed == "a peer that says why"
    assert "SIGSEGV" in found["crashes"].failed
    assert "exit status 3" in found["leaves"].failed
    assert found["hangs"].failed == "stopped after 1.5 s"
    assert "nothing" in found["absent"].failed
    assert found["works"].failed == ""
    assert found["works"].rows[0]["value"] == 1


def test_resume_skips_what_is_measured(tmp_path: Path) -> None:
    file, folder = tmp_path / "calls", tmp_path / "m"

    def run(resume: bool, *surroundings: str) -> Measured:
        (one,) = Runner(folder, surroundings, resume).run([unit("c", "count", file=str(file))])
        return one

    first = run(False, "one machine")
    assert run(True, "one machine") == first
    assert first.rows == [{"infinite": float("inf")}]
    assert file.read_text() == "x"
    run(True, "another machine")
    assert file.read_text() == "xx"
    (folder / "c.json").write_text("{half", encoding="utf-8")
    run(True, "another machine")
    assert file.read_text() == "xxx"
    run(False, "another machine")
    assert file.read_text() == "xxxx"


def test_what_is_held_is_not_measured(tmp_path: Path) -> None:
    folder, known, other = tmp_path / "m", unit("a", "rows", value=1), unit("b", "rows", value=2)
    measured = Runner(folder, ["here"]).run([known])
    assert Runner(folder, ["here"], resume=True).held([known, other]) == measured
    assert Runner(folder, ["there"], resume=True).held([known, other]) == []
    assert Runner(folder, ["here"]).held([known, other]) == []
    assert not (folder / "b.json").exists()


@pytest.mark.nightly
def test_other_sections_are_kept_on_resume(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """--only of one section, where another is measured already: the page has both."""

    def units(section: str, *_: object) -> list[Unit]:
        return [Unit(section, section, "judged_work:rows", {"value": section})]

    monkeypatch.setattr(sections, "_units", units)
    first = sections.measure([], tmp_path, ["steps"])
    assert list(first) == ["steps"]
    both = sections.measure([], tmp_path, ["costs"], resume=True)
    assert list(both) == ["costs", "steps"]
    assert both["steps"] == first["steps"]
    assert list(sections.measure([], tmp_path, ["costs"])) == ["costs"]


@pytest.mark.nightly
def test_what_failed_is_tried_again(tmp_path: Path) -> None:
    runner = Runner(tmp_path / "m", [], resume=True)
    assert runner.run([unit("w", "fail")])[0].failed
    file = tmp_path / "judged_work.py"
    file.write_text(WORK.replace("raise ValueError", "return [] #"), encoding="utf-8")
    assert not runner.run([unit("w", "fail")])[0].failed


PROGRAM = """
import sys
from pathlib import Path
from rodgen_evidence.report.runner import Runner
from rodgen_evidence.report.unit import Unit
folder = Path(sys.argv[1])
units = [
    Unit("tests", f"sleeps{i}", "judged_work:sleep",
         {"seconds": 60, "begun": str(folder / f"begun{i}")}, timed=False)
    for i in range(4)
]
Runner(folder / "m", []).run(units)
"""


@pytest.mark.nightly
def test_ctrl_c_ends_all_processes(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(tmp_path)], stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + 60
    while not (tmp_path / "begun0").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    children = [int(file.read_text()) for file in tmp_path.glob("begun?")]
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert "KeyboardInterrupt" in errors
    assert children
    assert not [pid for pid in children if _lives(pid)]
    assert not (tmp_path / "begun3").exists()  # what had not begun does not begin


def _lives(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True
