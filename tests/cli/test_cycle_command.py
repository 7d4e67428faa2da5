"""rodgen cycle: what it prints, writes and draws."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import rodgen
from rodgen.analyse.curves.files import read
from tests.cli.conftest import Run, Write, numbers

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
VARIED = ("--vary", "loads.follower.force", "--between", "18,20")


@pytest.fixture
def flutter(column: Write) -> Path:
    return column(COLUMN, length=1.0, mass=1.0, bending_stiffness=1.0)


def test_a_cycle_as_json_and_as_a_table(works: Run, flutter: Path, tmp_path: Path) -> None:
    """It comes back to where it began, which is a multiplier of 1; and pictures beside a table."""
    found = json.loads(works("cycle", flutter, "--json").stdout)
    assert list(found) == ["period", "multipliers", "energy", "y0"]
    scene = rodgen.Scene.from_toml(flutter)
    run = rodgen.simulate(scene, y0=found["y0"], span=[0, found["period"]], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(run.y[-1], found["y0"], atol=1e-7)
    assert found["energy"] == pytest.approx(run.energy.total[0], rel=1e-12)
    mu = [complex(*one) for one in found["multipliers"]]
    assert min(abs(one - 1) for one in mu) < 1e-8
    assert len(mu) == len(found["y0"])
    shown = numbers(works("cycle", flutter, "--out", tmp_path).stdout)
    assert min(abs(n / found["period"] - 1) for n in shown) < 1e-5  # of its digits
    assert {path.name for path in (tmp_path / "rod").iterdir()} == {
        "cycle.png",
        "multipliers.png",
    }


@pytest.mark.slow
def test_a_branch_in_a_file_and_a_cycle_of_it(works: Run, flutter: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    works("cycle", flutter, *VARIED, "--start", "run", "--out", out)
    file = out / "rod" / "cycles.nc"
    assert {path.name for path in file.parent.iterdir()} == {file.name, "cycles.png"}
    branch = read(file, "file", "a branch", "rodgen cycles 1")
    assert branch["value"][[0, -1]].values.tolist() == [18.0, 20.0]
    own = json.loads(works("cycle", flutter, "--json").stdout)
    found = json.loads(works("cycle", flutter, "--from", file, "--json").stdout)
    assert found["period"] == pytest.approx(own["period"], rel=1e-9)
    first = json.loads(works("cycle", flutter, "--from", file, "--at", "0", "--json").stdout)
    assert first["period"] == pytest.approx(float(branch["period"][0]), rel=1e-9)
