"""A file that grows: what other readers see in it, and that it does not matter how it grew."""

from __future__ import annotations

import gc
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.io import netcdf_file

import rodgen
from rodgen.integrate.files import netcdf, stream
from rodgen.integrate.files.file_layout import RunState
from rodgen.integrate.files.stream import Stream
from rodgen.model.terms import THESIS_TERMS
from tests.palette import ALL
from tests.storage.conftest import STATS
from tests.told import refused

Make = Callable[..., Any]
# What a Dataset has beside: it follows from what is in the file.
FOLLOWING = {
    *("tip", "total_energy", "principal_angle", "principal_moments"),
    *("principal", "state_units", "bending_moments"),
    *(f"force_{term}" for term in ALL),
}


@pytest.mark.parametrize(
    ("boundary", "inertia", "terms"),
    [
        ("free", "uniform", THESIS_TERMS),
        pytest.param("cantilever", "lumped", ALL, marks=pytest.mark.slow),
        pytest.param("clamped", "uniform", THESIS_TERMS, marks=pytest.mark.slow),
        pytest.param("pinned", "lumped", THESIS_TERMS, marks=pytest.mark.slow),
    ],
)
def test_other_readers_see_the_same(
    samples: Make, tmp_path: Path, boundary: str, inertia: str, terms: Any
) -> None:
    """SciPy's reader and xarray's, against quantities of a Solution and labels of its Dataset."""
    given = samples(20, boundary=boundary, rod={"inertia": inertia}, terms=terms)
    path = tmp_path / "run.nc"
    with given.create(path) as file:
        given.append(file, 0, 20)
        file.finish("finished", "", STATS)
    due = given.solution.to_xarray()
    with xr.open_dataset(path, engine="scipy") as data:
        assert set(data.variables) - {"run", "checksum"} == set(due.variables) - FOLLOWING
        assert data.sizes.items() <= due.sizes.items()
        for name in set(due.variables) - FOLLOWING:
            variable = due.variables[name]
            np.testing.assert_array_equal(data[name], variable)
            assert data[name].attrs == variable.attrs
            assert data[name].dims == variable.dims
        for name in ("format", "rodgen", "scene"):
            assert data.attrs[name] == due.attrs[name]
    with netcdf_file(path, mmap=False) as plain:
        assert plain.version_byte == 2
        assert plain._recs == 20
        for name in {name for name, v in due.variables.items() if "time" in v.dims} - FOLLOWING:
            np.testing.assert_array_equal(plain.variables[name][:], due[name])
        states = [b"".join(row).decode() for row in plain.variables["state"][:]]
        assert [state.rstrip("\0") for state in states] == list(due["state"].values)
    assert [entry.name for entry in path.parent.iterdir()] == ["run.nc"]


def test_growing_in_blocks_is_growing_at_once(
    samples: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = samples(400)
    at_once, in_blocks = tmp_path / "at_once.nc", tmp_path / "in_blocks.nc"
    monkeypatch.setattr(stream, "BLOCK", 10**9)
    with given.create(at_once) as file:
        given.append(file, 0, 400)
    monkeypatch.setattr(stream, "BLOCK", 5_000)  # some samples at a time
    random = np.random.default_rng(3)
    with given.create(in_blocks) as file:
        while (count := file.count) < 400:
            given.append(file, count, count + int(random.choice([1, 2, 3, 7, 60])))
    assert in_blocks.read_bytes() == at_once.read_bytes()


def test_going_back_and_on_is_never_having_stopped(samples: Make, tmp_path: Path) -> None:
    given = samples(90)
    straight, back = tmp_path / "straight.nc", tmp_path / "back.nc"
    with given.create(straight, events=2) as file:
        given.append(file, 0, 90)
        for k in (10, 20, 30):
            file.add_event(k % 2, given.t[k], given.y[k])
        file.finish("finished", "", STATS)
    with given.create(back, events=2) as file:
        given.append(file, 0, 50)
        for k in (10, 40, 45, 48):
            file.add_event(k % 2, given.t[k], -given.y[k])
        assert file.events == 4
    with back.open("ab") as opened:
        opened.write(b"half a record")
    for count, events in ((40, 3), (0, 0), (30, 1)):
        with Stream.reopen(back) as file:
            file.truncate(min(count, file.count), min(events, file.events))
            given.append(file, file.count, count)
            for k in (10, 20, 30)[file.events : events]:
                file.add_event(k % 2, given.t[k], given.y[k])
    with Stream.reopen(back, given.model) as file:
        assert (file.count, file.events, file.system.scene) == (30, 1, given.scene)
        with pytest.raises(ValueError, match=r"31"):
            file.truncate(31)
        given.append(file, 30, 90)
        for k in (20, 30):
            file.add_event(k % 2, given.t[k], given.y[k])
        file.finish("finished", "", STATS)
    assert back.read_bytes() == straight.read_bytes()


def test_memory_does_not_grow_with_the_run(samples: Make, tmp_path: Path) -> None:
    given = samples(2000, links=20, terms=("internal_damping",))
    with given.create(tmp_path / "run.nc") as file:
        given.append(file, 0, 2000)
        tracemalloc.start()
        given.append(file, 0, 2000)
        start, most = tracemalloc.get_traced_memory()
        for _ in range(10):
            given.append(file, 0, 2000)
        gc.collect()  # small tuples that Python keeps for later
        end, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert (tmp_path / "run.nc").stat().st_size > 20e6
    assert end - start < 20_000
    assert peak < 1.1 * most < 20e6  # a block of 1 MiB and what it is made from


def test_text_of_the_run_changes_in_place(samples: Make, tmp_path: Path) -> None:
    given, path = samples(), tmp_path / "run.nc"
    with given.create(path) as file:
        given.append(file, 0, 100)
        before = path.read_bytes()
        of_run = file._file.header.variables["run"]
        at = of_run.begin
        # Written in one piece by the system: no longer than a page, from the start of one.
        assert (at % netcdf.PAGE, of_run.size) == (0, netcdf.PAGE)
        long = 'a "quoted"\n \u00fc \U0001f680 ' * 1000
        for message in ("", "so far so good", long, long[:3000]):
            file.write_status("failed", message, STATS)
            after = path.read_bytes()
            run = RunState.of(after[at : at + netcdf.PAGE], path)
            assert (run.status, run.stats) == ("failed", STATS)
            assert message.startswith(run.message)
            assert run.message == message or len(run.message) > 1000
            rest = slice(at + netcdf.PAGE, None)
            assert after[:at] + after[rest] == before[:at] + before[rest]
    sol = rodgen.load(path)
    assert (sol.status, sol.message, sol.stats) == ("failed", run.message, STATS)


def test_events_beyond_the_room_are_counted(samples: Make, tmp_path: Path) -> None:
    given, path = samples(), tmp_path / "run.nc"
    with given.create(path, events=3) as file:
        given.append(file, 0, 10)
        for k in range(8):
            file.add_event(k % 2, given.t[k], given.y[k])
            assert file.events == k + 1
    with xr.open_dataset(path, engine="scipy") as data:
        assert '"lost": 5' in str(data["run"].values)
        assert data["event_number"].values.tolist() == [0, 1, 0]
        np.testing.assert_array_equal(data["event_y"], given.y[:3])
    with given.create(path, events=3) as file:
        file.add_event(1, given.t[0], given.y[0])
    with netcdf_file(path, mmap=False) as plain:
        assert plain.variables["event_number"][:].tolist() == [1, -1, -1]
        assert np.isnan(plain.variables["event_time"][1:]).all()
        assert np.isnan(plain.variables["event_y"][1:]).all()
    with given.create(path) as file:  # no room at all
        file.add_event(1, given.t[0], given.y[0])
        assert file.events == 1


def test_what_does_not_fit_is_refused_before(
    samples: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given, path = samples(), tmp_path / "run.nc"
    told = refused(given.create, path, events=10**8)
    assert told[:2] == ("events", 10**8)
    # Each has a number, a time and its states: what netCDF counts ends at 2^31 bytes.
    assert max(told.numbers) == pytest.approx(2**31 / (8 * len(given.y[0])), rel=1e-6)
    monkeypatch.setattr("rodgen.integrate.files.file_layout.MOST", 100)
    assert refused(given.create, path)[:2] == ("rod.links", 2)
    monkeypatch.undo()
    assert refused(given.create, tmp_path / "none" / "run.nc").value
    assert list(tmp_path.iterdir()) == []
    with given.create(path) as file:
        monkeypatch.setattr(stream, "MOST", 100)
        given.append(file, 0, 99)
        assert refused(given.append, file, 99, 101)[:2] == ("samples", 101)
        assert file.count == 99


def test_samples_of_another_shape_are_refused(samples: Make, tmp_path: Path) -> None:
    given = samples()
    t, y, work, more = given.t, given.y, given.work, given.work | {"x": given.t}
    with given.create(tmp_path / "run.nc") as file:
        for wrong in ((t[:3], y[:4], work), (t, y[:, :1], work), (t, y, {}), (t, y, more)):
            with pytest.raises(ValueError, match="shapes"):
                file.append(*wrong)
        given.append(file, 0, 0)
        assert file.count == 0
