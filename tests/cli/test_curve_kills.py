"""Commands that follow curves, killed in the middle of a line of their journal: --resume gives the
curve that there would have been."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
import xarray as xr

from rodgen.analyse.curves import curve_datasets
from tests.cli.conftest import Done, Run, python
from tests.sets import sets

SIZES = {"length": 1.0, "mass": 1.0, "bending_stiffness": 1.0}
SCENE: dict[str, Any] = {
    "name": "rod",
    "rod": {"links": 3, "boundary": "clamped", **SIZES},
    "loads": {
        "follower": {"force": 20.0},
        "gravity": {"g": 0.0},
        "internal_damping": {"coefficient": 0.3},
        "external_damping": {"coefficient": 0.0},
        "tip": {"x": 0.0, "y": 0.0},
    },
    "initial": {"phi": "0.2*s"},
    "integrate": {"span": [0.0, 20.0]},
}
UNLOADED = ("--set", "loads.follower.force=0")
FORCE, TIP, DAMPING = "loads.follower.force", "loads.tip.x", "loads.internal_damping.coefficient"
# Of each command: its file, and what is asked for.
COMMANDS: dict[str, tuple[str, tuple[Any, ...]]] = {
    "branch": (
        "branch_1",
        (*UNLOADED, "--vary", TIP, "--bounds", "0,-30", "--start", -15, "--branch-point", 1),
    ),
    "boundary": ("boundary", (*UNLOADED, "--vary", f"{FORCE},{DAMPING}", "--bounds", "0,60")),
    "cycle-branch": ("cycles", ("--vary", FORCE, "--bounds", "5,20")),
}
# Ends after so many lines, of which the last is cut off.
KILLED = """
import os, signal, sys
from rodgen.analyse.curves.journal import Journal
from rodgen.cli import main
last, write, count = int(sys.argv.pop(1)), Journal._write, [0]
def cut_off(self, content):
    write(self, content)
    count[0] += 1
    if count[0] == last:
        os.truncate(self.path, self.path.stat().st_size - 9)
        os.kill(os.getpid(), signal.SIGKILL)
Journal._write = cut_off
main()
"""

pytestmark = pytest.mark.usefixtures("work")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "rod.toml"
    path.write_text(tomli_w.dumps(SCENE), encoding="utf-8")
    return path


def _killed(after: int, *words: Any) -> None:
    done: Done = python(KILLED, after, *words, "--no-pictures")
    assert done.returncode == -signal.SIGKILL, done.stderr


@pytest.mark.parametrize("command", sets([], slow=["branch"], nightly=["boundary", "cycle-branch"]))
def test_what_was_killed_is_gone_on_with(
    works: Run, rodgen: Run, scene: Path, command: str
) -> None:
    """After one kill, after several that follow each other, and after all was computed; without
    --resume, or with other options, what is left is not lost."""
    name, words = COMMANDS[command]
    told = (command, scene, *words)
    works(*told, "--no-pictures", "--out", "whole")
    file, steps = Path(f"results/rod/{name}.nc"), Path(f"results/rod/{name}.nc.steps")
    kind = f"rodgen {'cycles' if command == 'cycle-branch' else command} 1"
    whole = curve_datasets.read_curve(Path(f"whole/rod/{name}.nc"), "file", "a curve", kind)
    points = whole.sizes["point"]
    for kills in ([2], [5, 3, 4], [points - 2]):
        for after in kills:
            known = ("--resume", file) if steps.exists() else ()
            _killed(after, *told, *known)
            assert not file.exists()
            left = steps.read_bytes()
        for more in ((), ("--resume", file, "--step", 0.05)):
            done = rodgen(*told, *more)
            assert (done.returncode, done.stderr.count("\n")) == (2, 1)
            assert steps.read_bytes() == left
        works(*told, "--no-pictures", "--resume", file)
        found = curve_datasets.read_curve(file, "file", "a curve", kind)
        kinds = whole["special_kind"].values.tolist()
        assert found["special_kind"].values.tolist() == kinds
        xr.testing.assert_identical(found, whole)
        assert [one.name for one in file.parent.iterdir()] == [file.name]
        file.unlink()


@pytest.mark.nightly
def test_what_a_kill_of_an_extension_leaves(works: Run, scene: Path) -> None:
    """A branch that is gone on with from a point of its file is one, and its file stays as it was
    until the whole is there."""
    way = ("branch", scene, *UNLOADED, "--vary", TIP, "--no-pictures")
    file = Path("results/rod/branch.nc")
    works(*way, "--bounds", "0,-3")
    before = file.read_bytes()
    more = (*way, "--bounds", "0,-30", "--resume", file)
    _killed(6, *more)
    assert file.read_bytes() == before
    works(*more)
    found = curve_datasets.read_curve(file, "file", "a curve", "rodgen branch 1")
    works(*way, "--bounds", "0,-3", "--out", "other")
    works(*way, "--bounds", "0,-30", "--out", "other", "--resume", "other/rod/branch.nc")
    whole = curve_datasets.read_curve(
        Path("other/rod/branch.nc"), "file", "a curve", "rodgen branch 1"
    )
    xr.testing.assert_identical(found, whole)
    assert np.all(np.diff(found["length"]) > 0)
