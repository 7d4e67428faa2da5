"""Checkpoints come back as they were written, or not at all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rodgen.integrate.files import saver
from tests.told import refused

ARRAYS = {
    "y": np.random.default_rng(2).normal(size=(3, 4)),
    "file": np.array([np.nan, -0.0, np.inf]),
    "none": np.empty((0, 7)),
    "number": np.array(3),
    "words": np.array(["a", "bc"]),
    "flags": np.array([True, False]),
}
NUMBERS: dict[str, Any] = {
    "t": 0.1 + 0.2,
    "tiny": 5e-324,
    "endless": float("inf"),
    "count": 2**60,
    "method": "dop853",
    "numpy": np.float32(0.5),
}


def test_comes_back_as_it_was(tmp_path: Path) -> None:
    path = saver.checkpoint_path(tmp_path / "run.nc")
    assert path.name == "run.nc.checkpoint"
    for _ in range(2):  # the second takes the place of the first
        saver.write_checkpoint(path, ARRAYS, NUMBERS)
    arrays, numbers = saver.read_checkpoint(path)
    assert numbers == NUMBERS
    assert arrays.keys() == ARRAYS.keys()
    for name, array in arrays.items():
        assert (array.dtype, array.shape) == (ARRAYS[name].dtype, ARRAYS[name].shape)
        assert array.tobytes() == ARRAYS[name].tobytes()
    assert list(tmp_path.iterdir()) == [path]
    content = path.read_bytes()
    saver.write_checkpoint(path, ARRAYS, NUMBERS)
    assert path.read_bytes() == content  # no date in it
    with np.load(path, allow_pickle=False) as other:
        np.testing.assert_array_equal(other["array_y"], ARRAYS["y"])


def test_any_damage_is_seen(tmp_path: Path) -> None:
    path = tmp_path / "run.nc.checkpoint"
    saver.write_checkpoint(path, ARRAYS, NUMBERS)
    whole = path.read_bytes()
    random = np.random.default_rng(4)
    for _ in range(100):
        damaged = bytearray(whole)
        damaged[random.integers(len(whole))] ^= 1 << random.integers(8)
        cut = whole[: random.integers(len(whole))]
        for content in (bytes(damaged), cut, whole + cut[:3]):
            if content == whole:
                continue
            path.write_bytes(content)
            assert refused(saver.read_checkpoint, path)[:2] == ("checkpoint", str(path))


def test_other_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.checkpoint"
    assert refused(saver.read_checkpoint, path)[:2] == ("checkpoint", str(path))
    with path.open("wb") as file:
        np.savez(file, y=np.ones(3))
    assert refused(saver.read_checkpoint, path)[:2] == ("checkpoint", str(path))
    beyond = tmp_path / "none" / "run.nc.checkpoint"
    assert str(beyond) == refused(saver.write_checkpoint, beyond, {}, {}).value


def test_what_cannot_come_back_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.nc.checkpoint"
    for arrays, numbers in (({"y": np.array([None])}, {}), ({}, {"t": object()})):
        with pytest.raises(TypeError):
            saver.write_checkpoint(path, arrays, numbers)
    assert list(tmp_path.iterdir()) == []
