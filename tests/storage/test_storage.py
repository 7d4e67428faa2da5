"""Solutions saved and loaded; files that are damaged, and those of others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import netcdf_file

import rodgen
from rodgen.integrate.files import result_file
from rodgen.integrate.files.file_layout import NO_STATS
from rodgen.integrate.files.result_file import header_of
from rodgen.integrate.files.stream import Stream
from rodgen.integrate.trajectory import Event
from tests.storage.conftest import same
from tests.told import numbers, refused

Make = Callable[..., Any]


def test_saved_and_loaded_is_the_same(samples: Make, tmp_path: Path) -> None:
    sol = samples(30).solution
    sol.status, sol.message = "failed", "why"
    sol.events = (Event("high", 0.05, sol.y[5]), Event("phi_1 = 0.0", 0.11, sol.y[11]))
    sol.save(tmp_path / "run.nc")
    back = rodgen.load(tmp_path / "run.nc")
    same(back, sol)
    assert (back.status, back.message) == ("failed", "why")
    for array in (back.t, back.y, *back.work.values()):
        assert array.dtype == np.dtype(float)
        assert array.dtype.isnative
        assert array.flags.c_contiguous
    for event, due in zip(back.events, sol.events, strict=True):
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
    assert numbers(sol.message) == [0.5, 1.0]
    assert "rodgen run --resume" in sol.message
    assert sol.stats == NO_STATS


def test_file_that_grows_while_it_is_read(
    samples: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given, path = samples(), tmp_path / "run.nc"
    with given.create(path) as file:
        given.append(file, 0, 10)

        for last, status in ((20, "interrupted"), (30, "finished")):

            def slow(at: Path, last: int = last, status: str = status) -> Any:
                header = header_of(at)
                given.append(file, last - 10, last)
                if status == "finished":
                    file.finish(status, "", NO_STATS)
                return header

            monkeypatch.setattr(result_file, "header_of", slow)
            sol = rodgen.load(path)
            assert sol.status == status
            np.testing.assert_array_equal(sol.y, given.y[:last])


def test_states_beside_those_of_the_rod(make_scene: Make, tmp_path: Path) -> None:
    """A thrust that is turned by a state, and an event of that."""
    bare = make_scene(2, initial={"phi": 0.0, "omega": 0.1}, span=[0.0, 0.5], output_every=0.05)
    tables = {
        "loads": {"follower": {"force": 40.0, "angle": "max(-0.1, min(0.1, gimbal))"}},
        "states": {"gimbal": {"rate": "(-2*phi(0.3) - gimbal)/0.05", "initial": 0.25}},
        "events": [{"quantity": "gimbal", "value": 0.0, "name": "centred", "action": "stop"}],
    }
    sol = rodgen.simulate(bare.replace(tables), target="numpy", out=tmp_path / "run.nc")
    read = rodgen.load(tmp_path / "run.nc")
    np.testing.assert_array_equal(read.y, sol.y)
    assert [event.name for event in read.events] == ["centred"]
    assert abs(read.events[0].y[-1]) < 1e-9
    assert read.scene.structure == sol.scene.structure
    assert read.to_xarray().y.sel(state="gimbal").values[0] == 0.25
    # What the thrust did is in the balance, whichever way it was turned.
    assert read.energy_error < 1e-5
    assert float(np.abs(read.work["follower"]).max()) > 0.1


def test_files_of_others(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    hdf5 = b"\x89HDF\r\n\x1a\n" + bytes(100)
    for content in (b"", b"no NetCDF", hdf5, b"CDF\x01" + bytes(28), b"CDF\x02" + bytes(28)):
        path.write_bytes(content)
        assert refused(rodgen.load, path).value == str(path)
    with netcdf_file(path, "w", version=2) as other:
        other.createDimension("time", None)
        for name in ("time", "temperature"):
            other.createVariable(name, "f8", ("time",))[:] = np.arange(3.0)
    for reader in (rodgen.load, Stream.reopen):
        assert refused(reader, path).value == str(path)
    assert refused(rodgen.load, tmp_path / "none.nc").value == str(tmp_path / "none.nc")
    assert len(list(tmp_path.iterdir())) == 1
