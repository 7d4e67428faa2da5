"""What tests of the command line share: scenes in files, and commands that end as they should."""

from __future__ import annotations

import re
import subprocess
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


def numbers(text: str) -> list[float]:
    """The numbers that a text has, in their order."""
    return [float(n) for n in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?", text)]


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


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder in which commands are called."""
    folder = tmp_path / "work"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def short(tmp_path: Path) -> Write:
    """Writes the scene of a short run, with other texts in place of some of its."""

    def write(*changes: tuple[str, str]) -> Path:
        text, path = SHORT, tmp_path / "short.toml"
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")
        return path

    return write


def table_of(loads: str, links: int, boundary: str, **rod: Any) -> dict[str, Any]:
    """The scene of a rod; loads: text of its tables."""
    rod = {"mass": 20.0, "bending_stiffness": STIFFNESS, "length": LENGTH, **rod}
    return {
        "name": "rod",
        "rod": {"links": links, "boundary": boundary, **rod},
        **tomllib.loads(loads),
    }


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes the scene of a rod with these loads alone."""

    def make(loads: str = "", links: int = 4, boundary: str = "clamped", **rod: Any) -> Path:
        path = tmp_path / "rod.toml"
        path.write_text(tomli_w.dumps(table_of(loads, links, boundary, **rod)), encoding="utf-8")
        return path

    return make


@pytest.fixture
def column(tmp_path: Path) -> Write:
    """Writes the scene of three clamped links, or of five free ones, with other loads of no size
    beside those that are given."""

    def make(loads: str = "", boundary: str = "clamped", **rod: Any) -> Path:
        table = table_of(loads, 3 if boundary == "clamped" else 5, boundary, **rod)
        given = table.get("loads", {})
        kinds = [name for name in ENDS if name != "tip" or boundary == "clamped"]
        table["loads"] = {name: {**ENDS[name], **given.get(name, {})} for name in kinds}
        path = tmp_path / "column.toml"
        path.write_text(tomli_w.dumps(table), encoding="utf-8")
        return path

    return make
