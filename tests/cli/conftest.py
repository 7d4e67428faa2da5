"""What tests of the command line share: scenes in files, and commands that end as they should."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import tomli_w

ROOT = Path(__file__).parents[2]
Done = subprocess.CompletedProcess[str]
Run = Callable[..., Done]
Write = Callable[..., Path]
LENGTH, STIFFNESS = 5.0, 100.0  # of columns
# Columns have the loads of structures of the palette, which other tests compile as well: of no
# size, unless a test gives them one.
ENDS: dict[str, dict[str, float]] = {
    "follower": {"force": 0.0},
    "gravity": {"g": 0.0},
    "internal_damping": {"coefficient": 0.0},
    "external_damping": {"coefficient": 0.0},
    "tip": {"x": 0.0, "y": 0.0},
}
# One structure for all runs: its module is compiled once.
SHORT = """
name = "short"
[rod]
links = 4
length = 1.0
bending_stiffness = 2.0
mass = 1.0
[loads.follower]
force = "5*min(t/0.1, 1)"
[loads.gravity]
[initial]
phi = "0.1*cos(pi*s)"
[integrate]
span = [0.0, 0.3]
[[events]]
quantity = "tip_y"
value = -0.2
name = "low"
"""


def names(line: str, field: str) -> bool:
    """Whether a line of rodgen's names a field, or a field = value, before it says what is wrong
    with it; Typer quotes its own, in capitals or not."""
    what = line.removeprefix("rodgen: ").partition(": ")[0]
    return bool(re.search(rf"(^|[ '(]){re.escape(field)}($|[ '.)])", what, re.IGNORECASE))


def python(program: str, *arguments: object, cwd: Path | None = None) -> Done:
    """Run a program in a process of its own."""
    command = [sys.executable, "-c", program, *map(str, arguments)]
    return subprocess.run(
        command, cwd=cwd, capture_output=True, text=True, timeout=600, check=False
    )


@pytest.fixture
def works(rodgen: Run) -> Run:
    """Run a command that ends well."""

    def run(*arguments: object, **options: object) -> Done:
        done = rodgen(*arguments, **options)
        assert done.returncode == 0, done.stderr
        return done

    return run


@pytest.fixture
def refused(rodgen: Run) -> Run:
    """Run a command that ends in a line on standard error, which names a field, and nothing
    else."""

    def run(*arguments: object, field: str = "", status: int = 2, **options: object) -> Done:
        done = rodgen(*arguments, **options)
        assert done.returncode == status, (arguments, done.stdout + done.stderr)
        assert done.stderr.count("\n") == 1, done.stderr
        assert not field or names(done.stderr.strip(), field), (arguments, done.stderr)
        assert done.stdout == "", arguments
        return done

    return run


def one_object(done: Done) -> dict[str, Any]:
    """What a command prints: one JSON object on one line, without NaN and Infinity; and it wrote
    nothing."""

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    assert done.returncode == 0, done.stderr
    assert done.stdout.count("\n") == 1
    assert list(Path.cwd().iterdir()) == []
    found: dict[str, Any] = json.loads(done.stdout, parse_constant=refuse)
    return found


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder in which commands are called."""
    folder = tmp_path / "work"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def short(tmp_path: Path) -> Path:
    """The file of the scene of a short run."""
    path = tmp_path / "short.toml"
    path.write_text(SHORT, encoding="utf-8")
    return path


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes the scene of a rod with these loads alone; loads: text of its tables."""

    def make(loads: str = "", links: int = 4, boundary: str = "clamped", **rod: Any) -> Path:
        rod = {"mass": 20.0, "bending_stiffness": STIFFNESS, "length": LENGTH, **rod}
        rod |= {"links": links, "boundary": boundary}
        path = tmp_path / "rod.toml"
        table = {"name": "rod", "rod": rod, **tomllib.loads(loads)}
        path.write_text(tomli_w.dumps(table), encoding="utf-8")
        return path

    return make


@pytest.fixture
def column(write: Write) -> Write:
    """Writes the scene of three clamped links, or of five free ones, with other loads of no size
    beside those that are given."""

    def make(loads: str = "", boundary: str = "clamped", **rod: Any) -> Path:
        table = tomllib.loads(loads)
        given = table.get("loads", {})
        kinds = [name for name in ENDS if name != "tip" or boundary == "clamped"]
        table["loads"] = {name: {**ENDS[name], **given.get(name, {})} for name in kinds}
        return write(tomli_w.dumps(table), 3 if boundary == "clamped" else 5, boundary, **rod)

    return make
