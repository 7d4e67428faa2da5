"""rodgen branch, boundary, cycle and static --all: what they print, write and draw."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from rodgen.analyse.branches import equilibrium_data
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.curves import curve_datasets
from rodgen.integrate import simulate
from rodgen.scene import Scene
from rodgen.system import System
from tests.cli.conftest import Run, Write, one_object, python
from tests.told import numbers

BOTH = ("--vary", "loads.follower.force,loads.internal_damping.coefficient", "--bounds", "0,60")
FLUTTER = ("boundary", *BOTH)


@pytest.fixture
def scene(column: Write, work: Path) -> Path:
    """The scene of a column under a dead load, in a file; commands run in an empty folder."""
    damped = "[loads.internal_damping]\ncoefficient = 0.3"
    return column(damped, length=1.0, mass=1.0, bending_stiffness=1.0)


def test_branch_as_json(works: Run, scene: Path) -> None:
    way = ("--vary", "loads.tip.x", "--bounds", "0,-30", "--step", 0.1)
    found = one_object(works("branch", scene, *way, "--json"))
    data = continue_equilibria(Scene.from_toml(scene), "loads.tip.x", (0.0, -30.0), step=0.1)
    assert [one["value"] for one in found["points"]] == data["value"].values.tolist()
    assert {"value", "unstable", "tip", "phi"} <= set(found["points"][0])
    assert len(found["points"][0]["phi"]) == 3
    assert [one["kind"] for one in found["special"]] == ["branch", "branch"]
    assert {"kind", "value", "frequency"} <= set(found["special"][0])
    assert found["points"][-1]["unstable"] == 2


@pytest.mark.slow
def test_branch_as_table_file_and_picture(works: Run, scene: Path) -> None:
    way = ("--vary", "loads.tip.x", "--bounds", "0,-10", "--step", 0.1)
    done = works("branch", scene, *way, "--branch-point", 1)
    # Euler's load, pi^2/4, of which six links have some per cent less or more.
    assert any(abs(n / -(np.pi**2) * 4 - 1) < 0.05 for n in numbers(done.stdout))
    folder = Path("results/rod")
    assert {file.name for file in folder.iterdir()} == {"branch_1.nc", "branch_1.png"}
    data = equilibrium_data.FORMAT.read(folder / "branch_1.nc")
    assert np.abs(data["phi"].values).max() > 1.5
    more = ("--vary", "loads.tip.x", "--bounds", "0,-15", "--step", 0.1, "--json")
    found = works("branch", scene, *more, "--resume", folder / "branch_1.nc")
    points = json.loads(found.stdout)["points"]
    assert [one["value"] for one in points[: data.sizes["point"]]] == data["value"].values.tolist()
    assert points[-1]["value"] == -15.0


def test_a_branch_that_ends_is_kept(rodgen: Run, scene: Path) -> None:
    way = ("--vary", "loads.tip.x", "--bounds", "0,50", "--max-points", 5)
    folder = Path("results/rod")
    done = rodgen("branch", scene, *way)
    assert done.returncode == 3
    assert 5 in numbers(done.stderr)
    assert done.stderr.count("\n") == 1
    assert len(equilibrium_data.FORMAT.read(folder / "branch.nc")["value"]) == 5


def test_boundary_in_a_file_with_its_picture(works: Run, scene: Path) -> None:
    works("boundary", scene, *BOTH)
    folder = Path("results/rod")
    assert {file.name for file in folder.iterdir()} == {"boundary.nc", "boundary.png"}
    data = curve_datasets.read_curve(
        folder / "boundary.nc", "file", "a boundary", "rodgen boundary 1"
    )
    assert data.attrs["complete"]


@pytest.mark.nightly
def test_all_equilibria(works: Run, write: Write, work: Path) -> None:
    """Straight, and bent to either side in two shapes."""
    pressed = write("[loads.tip]\nx = -30.0", 6, length=1.0, mass=1.0, bending_stiffness=1.0)
    found = one_object(works("static", pressed, "--all", "--json"))["equilibria"]
    assert [one["stable"] for one in found] == [True, True, False, False, False]
    shown = numbers(works("static", pressed, "--all").stdout)
    for one in found:
        assert min(abs(n - one["tip_x"]) for n in shown) < 1e-4  # it has few digits


PROGRAM = """
import signal, sys
if signal.{name} != signal.SIGINT:  # which may be ignored, of a test under nohup
    signal.signal(signal.{name}, signal.SIG_DFL)
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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "command", "file"),
    [
        ("SIGINT", ("branch", "--vary", "loads.tip.x", "--bounds", "0,-30"), "branch"),
        pytest.param("SIGTERM", FLUTTER, "boundary", marks=pytest.mark.nightly),
        pytest.param("SIGHUP", FLUTTER, "boundary", marks=pytest.mark.nightly),
    ],
)
def test_ctrl_c_writes_what_was_found(
    works: Run, scene: Path, name: str, command: tuple[Any, ...], file: str
) -> None:
    """And no picture; --resume gives the whole, and nothing but it is left."""
    first, *rest = map(str, command)
    done = python(PROGRAM.format(name=name), first, scene, *rest)
    assert done.returncode == 130, done.stderr
    written = Path(f"results/rod/{file}.nc")
    assert done.stderr.count("\n") == 1
    assert f"--resume {written}" in done.stderr
    names = {written.name, f"{written.name}.steps"}
    assert {one.name for one in written.parent.iterdir()} == names
    data = curve_datasets.read_curve(written, "file", "a curve", f"rodgen {file} 1")
    assert data.sizes["point"] in numbers(done.stderr)
    assert not data.attrs["complete"]
    works(first, scene, *rest, "--resume", written, "--no-pictures")
    assert [one.name for one in written.parent.iterdir()] == [written.name]
    works(first, scene, *rest, "--out", "whole", "--no-pictures")
    found, whole = (
        curve_datasets.read_curve(path, "file", "a curve", f"rodgen {file} 1")
        for path in (written, Path(f"whole/rod/{file}.nc"))
    )
    xr.testing.assert_identical(found, whole)


# Cycles ------------------------------------------------------------------------------------------

COLUMN = """
[loads.follower]
force = 20.0
[loads.internal_damping]
coefficient = 0.3
[initial]
phi = "0.2*s"
[integrate]
span = [0.0, 20.0]
"""
VARIED = ("--vary", "loads.follower.force", "--bounds", "18,20")


@pytest.fixture
def flutter(column: Write) -> Path:
    return column(COLUMN, length=1.0, mass=1.0, bending_stiffness=1.0)


def test_a_cycle_as_json_and_as_a_table(works: Run, flutter: Path, tmp_path: Path) -> None:
    """It comes back to where it began, which is a multiplier of 1; and pictures beside a table."""
    found = json.loads(works("cycle", flutter, "--json").stdout)
    assert {"period", "multipliers", "energy", "y0", "notes"} <= {*found}
    scene = Scene.from_toml(flutter)
    run = simulate(
        System(scene).at(y0=found["y0"]), span=[0, found["period"]], rtol=1e-10, atol=1e-12
    )
    np.testing.assert_allclose(run.y[-1], found["y0"], atol=1e-7)
    assert found["energy"] == pytest.approx(run.energy.total[0], rel=1e-12)
    mu = [complex(*one) for one in found["multipliers"]]
    assert min(abs(one - 1) for one in mu) < 1e-8
    assert len(mu) == len(found["y0"])
    shown = numbers(works("cycle", flutter, "--out", tmp_path).stdout)
    assert min(abs(n / found["period"] - 1) for n in shown) < 1e-5  # of its digits
    assert {path.name for path in (tmp_path / "rod").iterdir()} == {"cycle.png", "multipliers.png"}


@pytest.mark.slow
def test_a_branch_in_a_file_and_a_cycle_of_it(works: Run, flutter: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    works("cycle-branch", flutter, *VARIED, "--start", "run", "--out", out)
    file = out / "rod" / "cycles.nc"
    assert {path.name for path in file.parent.iterdir()} == {file.name, "cycles.png"}
    branch = curve_datasets.read_curve(file, "file", "a branch", "rodgen cycles 1")
    assert branch["value"][[0, -1]].values.tolist() == [18.0, 20.0]
    own = json.loads(works("cycle", flutter, "--json").stdout)
    found = json.loads(works("cycle", flutter, "--from", file, "--json").stdout)
    assert found["period"] == pytest.approx(own["period"], rel=1e-9)
    first = json.loads(works("cycle", flutter, "--from", file, "--point", "0", "--json").stdout)
    assert first["period"] == pytest.approx(float(branch["period"][0]), rel=1e-9)
