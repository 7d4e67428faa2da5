"""Stores of studies: what is marked is kept, and of another study or version nothing is touched."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import rodgen
from rodgen import InputError, Study, StudyError
from rodgen.studies import engine, local, store
from rodgen.studies.counts import count_points, without_numbers
from rodgen.studies.engine import run_study
from rodgen.studies.store import StudyStore, read_store
from tests.studies.conftest import PENDULUM, assert_same, scene, study_file
from tests.told import numbers, refused

pytestmark = pytest.mark.compiler
KEEP = ["last(tip_x)", "max(phi_2)", "section(tip_y, where='phi_0', rising=0)"]
SHORT = scene(PENDULUM, integrate={"span": [0.0, 0.2]})


def grid(count: int = 6, **given: Any) -> Study:
    vary = {"parameters.A": np.linspace(0, 2, count), "integrate.method": ["dop853", "rk45"]}
    return Study.of(SHORT, vary, **{"keep": KEEP, **given})


def sampled(count: int, method: str = "random") -> Study:
    vary = {"parameters.A": {"bounds": [0, 2]}, "rod.mass": {"bounds": [1, 3]}}
    sample = {"method": method, "count": count, "seed": 1}
    return Study.of(SHORT, vary, keep=KEEP[:2], sample=sample)


@pytest.fixture(scope="module")
def computed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of the grid."""
    path = tmp_path_factory.mktemp("computed") / "a.zarr"
    run_study(grid(), path, workers=1)
    return path


@pytest.fixture
def stored(computed: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return Path(shutil.copytree(computed, tmp_path / "a.zarr"))


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_a_study_is_what_its_runs_are(computed: Path) -> None:
    """As any reader of zarr has it, too."""
    data = read_store(computed)
    assert [*data["max(phi_2)"].sizes.items()] == [("parameters.A", 6), ("integrate.method", 2)]
    point = data.isel({"parameters.A": 5}).sel({"integrate.method": "rk45"})
    changes = {"parameters.A": float(point["parameters.A"]), "integrate.method": "rk45"}
    sol = rodgen.simulate(SHORT.replace(changes))
    np.testing.assert_allclose(point["last(tip_x)"], sol.tip[-1, 0], rtol=1e-12)
    assert (data.status == "finished").all()
    assert data["last(tip_x)"].attrs["units"] == "m"
    assert data.attrs["rodgen"] == rodgen.__version__
    other = xr.open_zarr(computed, consolidated=False)
    assert other["max(phi_2)"].dims == ("parameters.A", "integrate.method")
    np.testing.assert_array_equal(other["max(phi_2)"], data["max(phi_2)"])


def test_what_is_marked_is_not_computed_again(tmp_path: Path) -> None:
    """A block whose mark is missing is, and what was torn in it is whole again."""
    log, path = tmp_path / "log", tmp_path / "a.zarr"

    def logged(solution: Any) -> float:
        with log.open("a") as file:
            file.write(f"{solution.scene.numbers['A']}\n")
        return float(solution.t[-1])

    study = Study.of(SHORT, {"parameters.A": np.linspace(0, 2, 8)}, keep=[logged])
    StudyStore.create(path, study, 2)
    run_study(study, path, workers=1, resume=True)
    whole = read_store(path)
    assert len(log.read_text().split()) == 8
    (path / "status" / "c" / "1").unlink()
    (path / "logged" / "c" / "1").unlink()
    assert (read_store(path).status.values[2:4] == "").all()
    assert count_points(path).computed == 6
    run_study(study, path, workers=1, resume=True)
    assert log.read_text().split()[8:] == [str(a) for a in whole["parameters.A"].values[2:4]]
    assert_same(read_store(path), whole)
    assert (read_store(path).seconds.values == whole.seconds.values)[[0, 1, 4, 5, 6, 7]].all()


@pytest.mark.parametrize("method", ["random", pytest.param("sobol", marks=pytest.mark.slow)])
def test_a_study_that_is_extended_is_the_larger_one(method: str, tmp_path: Path) -> None:
    few, many, path = sampled(10, method), sampled(25, method), tmp_path / "a.zarr"
    StudyStore.create(path, few, 4)  # the last block has 2 points
    run_study(few, path, workers=1, resume=True)
    before = read_store(path)
    run_study(many, path, workers=1, resume=True)
    data = read_store(path)
    assert_same(data, rodgen.study(many, workers=1))
    assert_same(data.isel(point=slice(10)), before)
    np.testing.assert_array_equal(data.seconds[:8], before.seconds[:8])  # whole blocks are kept
    with pytest.raises(InputError, match=r"\b25\b"):
        run_study(few, path, workers=1, resume=True)
    assert {*xr.open_zarr(path, consolidated=False).coords} == {"parameters.A", "rod.mass"}


def test_the_store_of_another_study_or_version_is_left_alone(
    stored: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What differs is named."""
    before, own = contents(stored), store.identity()
    for other, keys in (
        (grid(7), "vary"),
        (grid(keep=KEEP[:1]), "keep"),
        (Study.of(scene(PENDULUM), {"parameters.A": [1]}, keep=KEEP), "scene, vary"),
        (sampled(4), "sample"),
    ):
        with pytest.raises(InputError, match=keys):
            run_study(other, stored, workers=1, resume=True)
    with pytest.raises(InputError, match="--resume"):
        run_study(grid(), stored, workers=1)
    for key in ("rodgen", "sources"):
        monkeypatch.setattr(store, "identity", lambda key=key: {**own, key: "another"})
        with pytest.raises(InputError, match=rf"{key} {re.escape(own[key])}\b"):
            run_study(grid(), stored, workers=1, resume=True)
    assert contents(stored) == before


def test_what_is_no_store_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.zarr").mkdir()
    (tmp_path / "b.zarr").write_text("text")
    xr.Dataset({"x": ("x", [1.0])}).to_zarr(tmp_path / "c.zarr", zarr_format=3, consolidated=False)
    for name in ("a", "b", "c", "missing"):
        path = tmp_path / f"{name}.zarr"
        assert str(refused(read_store, path).value) == str(path)
        if path.exists():
            assert str(refused(run_study, grid(), path, workers=1, resume=True).value) == str(path)
    with pytest.raises(InputError, match=r"^out = "):
        run_study(grid(), tmp_path / "b.zarr" / "inside.zarr", workers=1)


def test_success_is_what_the_store_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers that say that they are done are not believed."""

    def lying(
        self: Any, store: StudyStore, blocks: Iterator[int], texts: Any
    ) -> Iterator[tuple[int, int]]:
        for block in blocks:
            yield block, 0

    monkeypatch.setattr(local.LocalWorker, "compute", lying)
    with pytest.raises(StudyError):
        run_study(grid(), tmp_path / "a.zarr", workers=1)


def test_failures_are_counted_by_reason(tmp_path: Path, rodgen: Any) -> None:
    """Four points have masses below zero, and two of the others too few steps."""
    few = {"span": [0.0, 0.2], "method": "dop853"}
    masses, steps = [-1.0, -2.0, 1.0, 2.0], [1, 500]
    vary = {"rod.mass": {"values": masses}, "integrate.max_steps": {"values": steps}}
    file = study_file(tmp_path / "study.toml", "masses", {**PENDULUM, "integrate": few}, vary)
    done = rodgen("study", file, "--out", tmp_path, "--workers", 1, "--no-pictures")
    assert done.returncode == 0, done.stderr
    assert numbers(done.stdout)[0] == 8  # what will be done, first of all
    path = tmp_path / "masses" / "study.zarr"
    found = count_points(path)
    assert (found.points, found.computed, found.failed) == (8, 8, 6)
    assert sorted(found.reasons.values()) == [2, 4]
    assert "rod.mass" in max(found.reasons, key=lambda why: found.reasons[why])
    shown = rodgen("study", "show", path, "--json", "--no-pictures")
    assert shown.returncode == 0
    told = json.loads(shown.stdout)
    assert (told["name"], told["points"], told["failed"]) == ("masses", 8, 6)
    assert told["reasons"] == dict(found.reasons)


def test_a_study_of_which_every_point_failed_has_failed(tmp_path: Path, rodgen: Any) -> None:
    """As a run has; what came out is kept, and shown as that of any other."""
    vary = {"integrate.max_steps": {"values": [1, 2]}}
    file = study_file(tmp_path / "study.toml", "masses", PENDULUM, vary)
    done = rodgen("study", file, "--out", tmp_path, "--workers", 1, "--no-pictures", "--json")
    assert done.returncode == 3
    assert "max_steps" in done.stderr.splitlines()[-1]
    assert json.loads(done.stdout)["failed"] == 2
    path = tmp_path / "masses" / "study.zarr"
    assert read_store(path).status.values.tolist() == ["failed"] * 2
    assert rodgen("study", "show", path, "--no-pictures").returncode == 0


def test_a_file_is_no_store(tmp_path: Path, rodgen: Any) -> None:
    """What it is, where that is known: a study, or another file."""
    vary = {"parameters.A": {"values": [1]}}
    file = study_file(tmp_path / "study.toml", "swings", PENDULUM, vary)
    other = tmp_path / "notes.txt"
    other.write_text("nothing", encoding="utf-8")
    for path, command in ((file, True), (other, False)):
        done = rodgen("study", "show", path)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
        assert "zarr.json" not in done.stderr
        assert ("for rodgen study" in done.stderr) == command


def test_a_reason_has_no_numbers() -> None:
    assert (
        without_numbers("stopped at t = 0.25 s: x_2 beyond -1e-3")
        == "stopped at t = # s: x_2 beyond #"
    )


def test_large_stores_are_read_as_they_are_asked_for(
    stored: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = read_store(stored)
    monkeypatch.setattr(store, "LARGE", 10)
    lazy = read_store(stored)
    assert {*lazy.coords} == {*whole.coords}
    np.testing.assert_array_equal(lazy["max(phi_2)"], whole["max(phi_2)"])
    shutil.rmtree(stored / "last(tip_x)" / "c")  # what is not there any more was not read before
    assert refused(lazy["last(tip_x)"].load).value == str(stored)


def test_how_many_points_a_block_has() -> None:
    for points, seconds, workers, size in (
        (10**6, 1e-3, 2, 1000),  # a second of work
        (10**9, 1e-3, 1000, 5000),  # so that there are 200 tasks a second
        (10**5, 1e-3, 1000, 25),  # four for every worker
        (10**9, 1e-6, 2, 10**5),
        (10**4, 60.0, 2, 1),
    ):
        assert engine.block_size(sampled(points), seconds, workers) == size
