"""Solutions saved and loaded; files that are damaged, and those of others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.io import netcdf_file

import rodgen
from rodgen.integrate.files import result_file
from rodgen.integrate.files.checksums import NO_STATS
from rodgen.integrate.files.result_file import header_of
from rodgen.integrate.files.stream import Stream
from rodgen.integrate.solution import Event
from tests.scene.tables import NUMBER, refused

Make = Callable[..., Any]


def test_saved_and_loaded_is_the_same(samples: Make, tmp_path: Path) -> None:
    sol = samples(30).solution
    sol.status, sol.message = "failed", "why"
    sol.events = (Event("high", 0.05, sol.y[5]), Event("phi_1 = 0.0", 0.11, sol.y[11]))
    sol.save(tmp_path / "run.nc")
    back = rodgen.load(tmp_path / "run.nc")
    assert (back.scene, back.stats) == (sol.scene, sol.stats)
    assert (back.status, back.message) == ("failed", "why")
    for array in (back.t, back.y, *back.work.values()):
        assert array.dtype == np.dtype(float)
        assert array.dtype.isnative
        assert array.flags.c_contiguous
    xr.testing.assert_identical(back.to_xarray(), sol.to_xarray())
    for event, due in zip(back.events, sol.events, strict=True):
        assert event[:2] == due[:2]
        np.testing.assert_array_equal(event.y, due.y)
    assert sol.to_xarray()["event_number"].values.tolist() == [1, 0]
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.nc"]


def test_run_that_was_killed_says_how_far_it_got(samples: Make, tmp_path: Path) -> None:
    given, path = samples(), tmp_path / "run.nc"
    given.create(path).close()
    sol = rodgen.load(path)
    assert sol.y.shape == (0, 8)
    assert sol.message
    with Stream.reopen(path) as file:
        given.append(file, 0, 51)
    sol = rodgen.load(path)
    assert sol.status == "interrupted"
    assert [float(number) for number in NUMBER.findall(sol.message)] == [0.5, 1.0]
    assert "rodgen run --resume" in sol.message
    assert sol.stats == NO_STATS


def test_file_that_grows_while_it_is_read(
    samples: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given, path = samples(), tmp_path / "run.nc"
    with given.create(path) as file:
        given.append(file, 0, 10)

        def slow(at: Path) -> Any:
            header = header_of(at)
            given.append(file, 10, 20)
            return header

        monkeypatch.setattr(result_file, "header_of", slow)
        sol = rodgen.load(path)
        assert sol.status == "interrupted"
        np.testing.assert_array_equal(sol.y, given.y[:20])

        def late(at: Path) -> Any:
            header = header_of(at)
            given.append(file, 20, 30)
            file.finish("finished", "", NO_STATS)
            return header

        monkeypatch.setattr(result_file, "header_of", late)
        sol = rodgen.load(path)
    assert sol.status == "finished"
    np.testing.assert_array_equal(sol.y, given.y[:30])


def test_files_of_others(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    old = b"\x89HDF\r\n\x1a\n" + bytes(100)
    for content in (b"", b"no NetCDF", old, b"CDF\x01" + bytes(28), b"CDF\x02" + bytes(28)):
        path.write_bytes(content)
        told = refused(rodgen.load, path)
        assert told.value == str(path)
        assert ("HDF5" in told.allowed) == (content == old)
    with netcdf_file(path, "w", version=2) as other:
        other.createDimension("time", None)
        for name in ("time", "temperature"):
            other.createVariable(name, "f8", ("time",))[:] = np.arange(3.0)
    for reader in (rodgen.load, Stream.reopen):
        assert refused(reader, path).value == str(path)
    assert refused(rodgen.load, tmp_path / "none.nc").value == str(tmp_path / "none.nc")
    assert len(list(tmp_path.iterdir())) == 1
