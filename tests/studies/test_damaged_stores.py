"""Stores that are not as they were written: refused in a line that names the file, or right."""

from __future__ import annotations

import json
import random
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from rodgen import InputError, Study, StudyError
from rodgen.studies.counts import count_points
from rodgen.studies.engine import run_study
from rodgen.studies.store import StudyStore, read_store
from tests.studies.conftest import PENDULUM, assert_same, scene
from tests.told import refused

pytestmark = pytest.mark.compiler
SHORT = scene(PENDULUM, integrate={"span": [0.0, 0.2]})
KEEP = ["last(tip_x)", "max(phi_2)"]
GRID = Study.of(
    SHORT,
    {"parameters.A": np.linspace(0, 2, 10), "integrate.method": ["dop853", "rk45"]},
    keep=KEEP,
)
SAMPLE = Study.of(
    SHORT,
    {"parameters.A": {"bounds": [0, 2]}, "rod.mass": {"bounds": [1, 3]}},
    keep=KEEP,
    sample={"method": "random", "count": 20, "seed": 1},
)
STUDIES = {"grid": GRID, "sample": SAMPLE}


@pytest.fixture(scope="module", params=STUDIES)
def computed(request: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[Study, Path]:
    """A study of five blocks, and its store."""
    path = tmp_path_factory.mktemp("computed") / "a.zarr"
    StudyStore.create(path, STUDIES[request.param], 4)
    run_study(STUDIES[request.param], path, workers=1, resume=True)
    return STUDIES[request.param], path


@pytest.fixture
def copied(computed: tuple[Study, Path], tmp_path: Path) -> Callable[[], Path]:
    """Makes a copy of the store, in place of the one before."""

    def make() -> Path:
        shutil.rmtree(tmp_path / "a.zarr", ignore_errors=True)
        return Path(shutil.copytree(computed[1], tmp_path / "a.zarr"))

    return make


def flip(file: Path, at: float) -> None:
    content = bytearray(file.read_bytes())
    bit = int(at * 8 * len(content))
    content[bit // 8] ^= 1 << bit % 8
    file.write_bytes(content)


DAMAGE: list[Callable[[Path, float], object]] = [
    flip,
    flip,
    lambda file, at: file.write_bytes(file.read_bytes()[: int(at * file.stat().st_size)]),
    lambda file, at: file.write_bytes(file.read_bytes() + b"x"),
    lambda file, at: file.write_bytes(b""),
    lambda file, at: file.unlink(),
    lambda file, at: (file.unlink(), file.mkdir()),
    lambda file, at: shutil.rmtree(file.parent) if file.name == "zarr.json" else file.unlink(),
]


def files(path: Path) -> list[Path]:
    return sorted(one for one in path.rglob("*") if one.is_file())


def damaged(copied: Callable[[], Path], count: int, seed: int) -> Iterator[tuple[Path, str]]:
    """Stores with a damaged file, and its name below the store."""
    chance = random.Random(seed)
    for k in range(count):
        path = copied()
        file = chance.choice(files(path))
        DAMAGE[k % len(DAMAGE)](file, chance.random())
        yield path, file.relative_to(path).as_posix()


def there(data: xr.Dataset, whole: xr.Dataset) -> int:
    """How many points a store has, all of which are right."""
    known = np.asarray(data.status != "")
    for name in {*data.data_vars} - {"seconds"}:
        np.testing.assert_array_equal(np.asarray(data[name])[known], np.asarray(whole[name])[known])
    return int(known.sum())


def points_of(study: Study, path: Path, data: xr.Dataset, again: bool) -> int | str:
    """How many points a store has, gone on with or not, or why it is refused; any other error ends
    the test."""
    try:
        if again:
            run_study(study, path, workers=1, resume=True)
        return there(read_store(path), data)
    except InputError as error:
        return f"{error}" if error.value == str(path) else f"{error}\nanother value"
    except StudyError as error:
        return str(error)


def held(copied: Callable[[], Path], whole: tuple[Study, Path], count: int, seed: int) -> int:
    """How many damaged stores are refused when they are read; the others are right, and all are
    gone on with to the same numbers, or refused."""
    study, data = whole[0], read_store(whole[1])
    told = 0
    for path, name in damaged(copied, count, seed):
        for again in (False, True):
            found = points_of(study, path, data, again)
            if isinstance(found, str):
                assert len(found.splitlines()) == 1, found
                told += not again
            else:  # without its mark, a block is not there
                assert found == data.status.size or (name.startswith("status/c/") and not again)
    return told


def test_damage_is_refused_or_harmless(copied: Any, computed: Any) -> None:
    assert held(copied, computed, len(DAMAGE), 1) >= len(DAMAGE) - 2


@pytest.mark.nightly
def test_much_damage_is_refused_or_harmless(copied: Any, computed: Any) -> None:
    assert held(copied, computed, 150, 2) > 130


@pytest.mark.slow
def test_each_file_is_checked_and_named(copied: Callable[[], Path]) -> None:
    """Whether a bit of it changes, or it is missing; by all that read stores."""
    path = copied()
    for file in files(path):
        name, content = file.relative_to(path).as_posix(), file.read_bytes()
        flip(file, 0.5)
        assert f" ({name} " in refused(read_store, path).allowed
        if name.startswith(("status/c/", "seconds/c/")):
            assert f" ({name} " in refused(count_points, path).allowed
        file.unlink()
        if name != "zarr.json" and not name.startswith("status/c/"):  # no store, a block not done
            assert f" ({name} " in refused(read_store, path).allowed
        file.write_bytes(content)


@pytest.mark.parametrize("name", ["last(tip_x)", "message", "status"])
@pytest.mark.parametrize("is_missing", [True, False])
def test_a_block_that_is_not_as_it_was_written_is_computed_again(
    name: str, is_missing: bool, copied: Callable[[], Path], computed: Any
) -> None:
    """And no other."""
    (study, whole), path = computed, copied()
    file = sorted(one for one in (path / name / "c").rglob("*") if one.is_file())[1]
    if is_missing:
        file.unlink()
        assert (~StudyStore.of(path, study).done_blocks()).nonzero()[0].tolist() == [1]
    else:
        flip(file, 0.3)
    run_study(study, path, workers=1, resume=True)
    assert_same(read_store(path), read_store(whole))
    same = read_store(path).seconds.values == read_store(whole).seconds.values
    assert same.sum() == 16


def test_stores_without_checksums_are_read(copied: Callable[[], Path], computed: Any) -> None:
    """Those of the first format; they are not gone on with."""
    path = copied()
    group = json.loads((path / "zarr.json").read_bytes())
    group["attributes"]["format"] = "1"
    for name in ("checksums", "sha256"):
        del group["attributes"][name]
    (path / "zarr.json").write_text(json.dumps(group))
    assert there(read_store(path), read_store(computed[1])) == 20
    assert refused(run_study, computed[0], path, workers=1, resume=True).value == str(path)


def test_an_axis_is_there_before_any_block(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    StudyStore.create(path, GRID, 4)
    assert (read_store(path).status == "").all()
    (path / "parameters.A" / "c" / "0").unlink()
    assert refused(read_store, path).value == str(path)
