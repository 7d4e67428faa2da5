"""rodgen branch, boundary and static --all: what they print, write, draw and refuse."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rodgen.analyse.branches import branch_data
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.curves import files
from rodgen.scene import Scene
from tests.cli.conftest import Run

ROOT = Path(__file__).parents[2]
COLUMN = """
name = "column"
[rod]
links = 6
length = 1.0
bending_stiffness = 1.0
mass = 1.0
boundary = "clamped"
[loads.tip]
x = {load}
y = 0.0
[loads.follower]
force = 0.0
[loads.material_damping]
time = 0.02
"""


@pytest.fixture
def column(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[float], Path]:
    """The scene of a column under a dead load, in a file; commands run in an empty folder."""
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")

    def write(load: float = 0.0) -> Path:
        file = tmp_path / "column.toml"
        file.write_text(COLUMN.format(load=load))
        return file

    return write


def _one_object(done: Any) -> dict[str, Any]:
    assert done.stdout.count("\n") == 1
    assert list(Path.cwd().iterdir()) == []
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_branch_as_json(works: Run, column: Callable[..., Path]) -> None:
    scene, way = column(), ("--vary", "loads.tip.x", "--from", 0, "--to", -30, "--step", 0.1)
    found = _one_object(works("branch", scene, *way, "--json"))
    data = continue_equilibria(Scene.from_toml(scene), "loads.tip.x", (0.0, -30.0), step=0.1)
    assert [one["value"] for one in found["points"]] == data["value"].values.tolist()
    assert set(found["points"][0]) == {"value", "unstable", "tip", "phi"}
    assert len(found["points"][0]["phi"]) == 6
    assert [one["kind"] for one in found["special"]] == ["branch", "branch"]
    assert set(found["special"][0]) == {"kind", "value", "frequency"}
    assert found["points"][-1]["unstable"] == 2


def test_branch_as_table_file_and_picture(works: Run, column: Callable[..., Path]) -> None:
    scene, way = column(), ("--vary", "loads.tip.x", "--from", 0, "--to", -10, "--step", 0.1)
    done = works("branch", scene, *way, "--switch", 1)
    assert "branch point at -2.4" in done.stdout
    folder = Path("results/column")
    assert {file.name for file in folder.iterdir()} == {"branch_1.nc", "branch_1.png"}
    data = branch_data.read(folder / "branch_1.nc")
    assert np.abs(data["phi"].values).max() > 1.5
    more = ("--vary", "loads.tip.x", "--from", 0, "--to", -15, "--step", 0.1, "--json")
    found = works("branch", scene, *more, "--resume", folder / "branch_1.nc")
    points = json.loads(found.stdout)["points"]
    assert [one["value"] for one in points[: data.sizes["point"]]] == data["value"].values.tolist()
    assert points[-1]["value"] == -15.0


def test_a_branch_that_ends_is_kept(rodgen: Run, column: Callable[..., Path]) -> None:
    way = ("--vary", "loads.tip.x", "--from", 0, "--to", 50, "--most", 5)
    folder = Path("results/column")
    done = rodgen("branch", column(), *way)
    assert done.returncode == 3
    assert "5 points were computed" in done.stderr
    assert done.stderr.count("\n") == 1
    assert len(branch_data.read(folder / "branch.nc")["value"]) == 5


def test_boundary_as_json_and_picture(works: Run, column: Callable[..., Path]) -> None:
    scene, way = column(), ("--vary", "loads.follower.force,loads.material_damping.time")
    found = _one_object(works("boundary", scene, *way, "--a", "0:60", "--json"))
    assert len(found["points"][0]) == 3
    assert found["points"][0][1] == 0.0
    assert found["kind"] == "flutter"
    done = works("boundary", scene, *way, "--a", "0:60")
    assert "flutter" in done.stdout
    names = {file.name for file in Path("results/column").iterdir()}
    assert names == {"boundary.nc", "boundary.png"}


@pytest.mark.nightly
def test_all_equilibria(works: Run, column: Callable[..., Path]) -> None:
    scene = column(-30.0)
    found = _one_object(works("static", scene, "--all", "--json"))["equilibria"]
    assert [one["stable"] for one in found] == [True, True, False, False, False]
    assert "5 equilibria" in works("static", scene, "--all").stdout


BRANCH = ("--from", 0, "--to", 10)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("branch", "--vary", "rod.links", *BRANCH), "rod.links"),
        (("branch", "--vary", "loads.tip.q", *BRANCH), "loads.tip.q"),
        (("branch", "--vary", "loads.tip.x", "--from", 0, "--to", 0), "vary.loads.tip.x"),
        (("branch", "--vary", "loads.tip.x", "--from", 0, "--to", "nan"), "--to"),
        (("branch", "--vary", "loads.tip.x", *BRANCH, "--switch", 1), "switch"),
        (("branch", "--vary", "loads.tip.x", *BRANCH, "--start", 11), "start"),
        (("branch", "--vary", "loads.tip.x", *BRANCH, "--at", 3), "--at"),
        (("branch", "--vary", "loads.tip.x", *BRANCH, "--step", 0), "step"),
        (("branch", "--vary", "loads.tip.x", *BRANCH, "--resume", ROOT / "README.md"), "file"),
        (("boundary", "--vary", "loads.tip.x"), "--vary"),
        (("boundary", "--vary", "loads.tip.x,loads.tip.x"), "vary"),
        (("boundary", "--vary", "loads.follower.force,rod.mass", "--b", "2"), "--b"),
        (("static", "--all", "--imperfection", 0.1), "--imperfection"),
        (("view", "--from", ROOT / "README.md"), "SCENE"),
        (("view", "--at", 3), "--at"),
    ],
)
def test_what_is_refused(
    refused: Run, column: Callable[..., Path], arguments: tuple[Any, ...], says: str
) -> None:
    command, *rest = arguments
    refused(command, column(), *rest, says=says)


PROGRAM = """
import signal, sys
from rodgen.analyse.curves import continuation
from rodgen.cli import main
made, count = continuation.point_at, [0]
def point_at(*arguments):
    count[0] += 1
    if count[0] == 9:
        signal.raise_signal(signal.{name})
    return made(*arguments)
continuation.point_at = point_at
main()
"""
FLUTTER = ("boundary", "--vary", "loads.follower.force,loads.material_damping.time", "--a", "0:60")


@pytest.mark.parametrize(
    ("name", "command", "file"),
    [
        ("SIGINT", ("branch", "--vary", "loads.tip.x", "--from", 0, "--to", -30), "branch"),
        pytest.param("SIGTERM", FLUTTER, "boundary", marks=pytest.mark.nightly),
    ],
)
def test_ctrl_c_writes_what_was_found(
    works: Run, column: Callable[..., Path], name: str, command: tuple[Any, ...], file: str
) -> None:
    first, *rest = map(str, command)
    scene = str(column())
    program = [sys.executable, "-c", PROGRAM.format(name=name), first, scene, *rest]
    done = subprocess.run(program, capture_output=True, text=True)
    assert done.returncode == 130, done.stderr
    written = Path(f"results/column/{file}.nc")
    assert done.stderr.count("\n") == 1
    assert "it was interrupted at" in done.stderr
    assert [one.name for one in written.parent.iterdir()] == [written.name]  # and no picture
    data = files.read(written, "file", "a curve", f"rodgen {file} 1")
    count = data.sizes["point"]
    assert f"{count} points in {written}; --resume {written} goes on with it" in done.stderr
    assert not data.attrs["complete"]
    ways = ("--resume", written, *(("--at", 0) if file == "boundary" else ()))
    works(first, scene, *rest, *ways)
    assert files.read(written, "file", "a curve", f"rodgen {file} 1").attrs["complete"]
