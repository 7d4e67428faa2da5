"""What tests of the command line share: scenes in files, and commands that end as they should."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Done = subprocess.CompletedProcess[str]
Run = Callable[..., Done]
LENGTH, STIFFNESS = 5.0, 100.0  # of columns
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
    """Run a command that ends in a line (or more) on standard error, which says something, and
    nothing else."""

    def run(
        *arguments: object, says: str, status: int = 2, lines: int = 1, **options: object
    ) -> Done:
        done = rodgen(*arguments, **options)
        assert done.returncode == status, done.stdout + done.stderr
        assert says.lower() in done.stderr.lower()  # typer's versions differ in case
        assert len(done.stderr.splitlines()) == lines, done.stderr
        assert done.stdout == ""
        return done

    return run


@pytest.fixture
def short(tmp_path: Path) -> Callable[..., Path]:
    """Writes the scene of a short run, with other texts in place of some of its."""

    def write(*changes: tuple[str, str]) -> Path:
        text, path = SHORT, tmp_path / "short.toml"
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Writes the scene of a column; loads: text of the tables of loads."""

    def make(loads: str = "", links: int = 20, boundary: str = "clamped", **rod: Any) -> Path:
        table = {"mass": 20.0, "bending_stiffness": STIFFNESS, **rod}
        keys = "\n".join(f"{k} = {json.dumps(v)}" for k, v in table.items())
        path = tmp_path / "rod.toml"
        path.write_text(
            f'name = "rod"\n[rod]\nlinks = {links}\nlength = {LENGTH}\nboundary = "{boundary}"\n'
            f"{keys}\n{loads}\n",
            encoding="utf-8",
        )
        return path

    return make
