"""rodgen cycle: what it prints, writes and refuses."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from tests.cli.conftest import Run

# A structure of the palette, compiled for other tests as well; loads of no size change nothing.
COLUMN = """
name = "column"
[rod]
links = 3
length = 1.0
mass = 1.0
bending_stiffness = 1.0
boundary = "clamped"
[loads.follower]
force = 20.0
[loads.internal_damping]
coefficient = 0.3
[loads.gravity]
g = 0.0
[loads.external_damping]
coefficient = 0.0
[loads.tip]
x = 0.0
y = 0.0
[initial]
phi = "0.2*s"
[integrate]
span = [0.0, 20.0]
"""
VARIED = ("--vary", "loads.follower.force", "--between", "18,20")


@pytest.fixture
def column(tmp_path: Path) -> Path:
    file = tmp_path / "column.toml"
    file.write_text(COLUMN)
    return file


def test_one_object(works: Run, column: Path) -> None:
    found = json.loads(works("cycle", column, "--json").stdout)
    assert list(found) == ["period", "multipliers", "energy", "y0"]
    scene = rodgen.Scene.from_toml(column)
    run = rodgen.simulate(scene, y0=found["y0"], span=[0, found["period"]], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(run.y[-1], found["y0"], atol=1e-7)
    assert found["energy"] == pytest.approx(run.energy.total[0], rel=1e-12)
    mu = [complex(*one) for one in found["multipliers"]]
    assert min(abs(one - 1) for one in mu) < 1e-8
    assert len(mu) == len(found["y0"])


def test_a_branch_in_a_file_and_a_cycle_of_it(works: Run, column: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = works("cycle", column, *VARIED, "--start", "run", "--out", out)
    assert "cycles along loads.follower.force" in done.stdout
    made = sorted(path.name for path in (out / "column").iterdir())
    assert made == ["cycles.nc", "cycles.png"]
    branch = json.loads(works("cycle", column, *VARIED, "--start", "run", "--json").stdout)
    assert branch["points"][0]["value"] == 18.0
    assert branch["points"][-1]["value"] == 20.0
    file = out / "column" / "cycles.nc"
    own = json.loads(works("cycle", column, "--json").stdout)
    found = json.loads(works("cycle", column, "--from", file, "--json").stdout)
    assert found["period"] == pytest.approx(own["period"], rel=1e-9)
    first = json.loads(works("cycle", column, "--from", file, "--at", "0", "--json").stdout)
    assert first["period"] == pytest.approx(branch["points"][0]["period"], rel=1e-9)


def test_pictures(works: Run, column: Path, tmp_path: Path) -> None:
    done = works("cycle", column, "--out", tmp_path)
    assert "multipliers that are 1" in done.stdout
    for name in ("cycle.png", "multipliers.png"):
        assert (tmp_path / "column" / name).stat().st_size > 10_000


@pytest.mark.parametrize(
    ("options", "says", "status"),
    [
        (("--segments", "0"), "segments = 0", 2),
        (("--by", "hand"), "by = 'hand'", 2),
        (("--multipliers", "4", "--by", "shooting"), "picard", 2),
        (("--by", "shooting", *VARIED), "--by", 2),
        (("--at", "3"), "--from", 2),
        (("--between", "1,2"), "--vary", 2),
        (("--switch", "1"), "--vary", 2),
        (("--start", "run", "--switch", "1", *VARIED), "switch = 1", 2),
        (("--mode", "1"), "--energy", 2),
        (("--mode", "1", "--energy", "1"), "without dissipation", 2),
        (("--vary", "loads.follower.force"), "two numbers", 2),
        (("--vary", "loads.follower.forc", "--between", "1,2"), "forc", 2),
        (("--vary", "rod.links", "--between", "3,9"), "structure", 2),
        (("--vary", "loads.follower.force", "--between", "1,2"), "no Hopf point", 3),
        (("--from", "nothing.nc"), "nothing.nc", 2),
    ],
)
def test_what_is_refused(
    refused: Callable[..., Any],
    column: Path,
    tmp_path: Path,
    options: tuple[str, ...],
    says: str,
    status: int,
) -> None:
    refused("cycle", column, *options, "--out", tmp_path / "out", says=says, status=status)
    assert not (tmp_path / "out").exists()
