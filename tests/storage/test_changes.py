"""Files of runs that were changed while they went on: every sample with what held then."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import rodgen
from rodgen.integrate.files import stream
from rodgen.integrate.files.reader import solution_of
from rodgen.integrate.files.result_file import ResultFile
from rodgen.integrate.files.stream import Stream
from rodgen.integrate.solution import Solution
from rodgen.integrate.trajectory import Changes
from rodgen.scene import Scene
from rodgen.system import System

Make = Callable[..., Any]
EDGES = 0, 70, 71, 130, 200
GIVEN = np.repeat([0.0, 1.5, -2.0, -2.0], np.diff(EDGES))  # J


@pytest.fixture
def changed(samples: Make) -> Callable[..., tuple[Solution, list[Solution]]]:
    """A solution with changes, and the same piece by piece, each a solution without."""

    def make(boundary: str = "free") -> Any:
        sol = samples(EDGES[-1], boundary=boundary).solution
        pieces = []
        for k, (first, last) in enumerate(itertools.pairwise(EDGES)):
            table = sol.scene.model_dump(exclude_none=True)
            table["rod"] |= {"mass": 3.0 + min(k, 2), "length": 2.0 + k % 2}
            if boundary == "cantilever":
                table["rod"]["clamp_angle"] = 0.1 * k
            table["loads"]["gravity"]["g"] = 9.81 / (1 + k)
            table["loads"]["external_damping"]["fin_factor"]["tail"] = 5.0 + k
            part = sol.isel(slice(first, last))
            part.system, part.model = System(Scene.from_dict(table)), sol.model
            pieces.append(part)
        p = [sol.model.parameters(**piece.scene.parameters) for piece in pieces]
        sol.changes = Changes(np.repeat(p, np.diff(EDGES), axis=0), GIVEN)
        sol.system = pieces[-1].system
        return sol, pieces

    return make


@pytest.mark.parametrize("boundary", ["free", "cantilever"])
def test_loaded_run_follows_from_what_held(changed: Make, tmp_path: Path, boundary: str) -> None:
    """Against solutions of scenes that have the values of each piece."""
    sol, pieces = changed(boundary)
    sol.save(tmp_path / "run.nc")
    back = rodgen.load(tmp_path / "run.nc")
    back.model = sol.model
    for name in ("phi", "omega", "joints", "tip", "centre_of_gravity"):
        due = np.concatenate([getattr(piece, name) for piece in pieces])
        np.testing.assert_array_equal(getattr(back, name), due)
    for name in ("energy", "inertia"):
        due = np.concatenate([getattr(piece, name) for piece in pieces], axis=1)
        np.testing.assert_array_equal(getattr(back, name), due)
    total = np.concatenate([piece.energy.total for piece in pieces])
    balance = total - total[0] - sum(sol.work.values()) - GIVEN
    np.testing.assert_allclose(back.energy_balance, balance, atol=1e-9)  # of some 1000 J
    assert back.energy_error == pytest.approx(np.abs(balance).max())
    xr.testing.assert_identical(back.to_xarray(), sol.to_xarray())
    masses = np.repeat([3.0, 4.0, 5.0, 5.0], np.diff(EDGES))
    np.testing.assert_array_equal(back.parameter("mass"), masses)


def test_other_readers_see_what_held(changed: Make, tmp_path: Path) -> None:
    sol, pieces = changed()
    sol.save(tmp_path / "run.nc")
    energies = np.concatenate([piece.energy.total for piece in pieces])
    with xr.open_dataset(tmp_path / "run.nc", engine="scipy") as data:
        gravity = data["parameters"].sel(parameter="gravity").values
        np.testing.assert_array_equal(gravity, np.repeat(9.81 / np.arange(1, 5), np.diff(EDGES)))
        fins = data["parameters"].isel(time=-1).sel(parameter=[f"fin_factor_{k}" for k in range(3)])
        assert fins.values.tolist() == [1.0, 1.0, 8.0]
        np.testing.assert_array_equal(data["energy_given"], GIVEN)
        due = np.concatenate([piece.energy.gravity for piece in pieces])
        np.testing.assert_array_equal(data["gravity_energy"], due)
    # Of some samples, too.
    kept = np.array([0, 69, 70, 71, 199])
    with ResultFile(tmp_path / "run.nc") as file:
        some = solution_of(file, file.samples()[0], kept)
    np.testing.assert_array_equal(some.energy.total, energies[kept])
    np.testing.assert_array_equal(sol.isel(kept).energy.total, energies[kept])
    np.testing.assert_array_equal(sol.head(100).energy.total, energies[:100])
    few = rodgen.load(tmp_path / "run.nc", max_samples=3)
    np.testing.assert_array_equal(few.energy.total, energies[[0, 100, 199]])


def test_changes_grow_in_blocks_and_are_due(
    changed: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file for changes takes no samples without them, and one without takes none with."""
    sol, _ = changed()
    monkeypatch.setattr(stream, "BLOCK", 10**9)
    sol.save(tmp_path / "at_once.nc")
    monkeypatch.setattr(stream, "BLOCK", 20_000)  # some samples at a time
    path, parts = tmp_path / "in_blocks.nc", (sol.system, sol.model, list(sol.work))
    Stream.create(path, *parts, changed=True).close()
    for first, last in ((0, 50), (50, 71), (71, 200)):
        with Stream.reopen(path, sol.model) as file:
            part = sol.isel(slice(first, last))
            with pytest.raises(ValueError, match="shapes"):
                file.append(part.t, part.y, part.work)
            file.append(part.t, part.y, part.work, part.changes)
            file.write_status("finished", "", sol.stats)
    assert path.read_bytes() == (tmp_path / "at_once.nc").read_bytes()
    with Stream.create(tmp_path / "plain.nc", *parts) as file:
        with pytest.raises(ValueError, match="shapes"):
            file.append(sol.t, sol.y, sol.work, sol.changes)
        file.append(sol.t, sol.y, sol.work)
    plain = rodgen.load(tmp_path / "plain.nc")
    assert plain.changes is None
    assert "parameters" not in plain.to_xarray()
