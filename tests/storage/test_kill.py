"""A process that ends at any moment leaves a file that opens, and that can be gone on with."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import rodgen
from rodgen.integrate.files import netcdf
from rodgen.integrate.files.checksums import NO_STATS
from rodgen.integrate.files.stream import Stream

Make = Callable[..., Any]

PROGRAM = """
import sys
from pathlib import Path
import numpy as np
from rodgen.integrate.files.checksums import NO_STATS
from rodgen.integrate.files.stream import Stream

with Stream.reopen(Path(sys.argv[1])) as file:
    file.truncate(file.count, min(file.events, file.count // 50))
    up = False
    while True:
        t = np.arange(file.count, file.count + file.count % 7 + 1, dtype=float)
        y = np.sin(t[:, None] + np.arange(14))
        file.append(t, y, {"follower": t, "internal_damping": 2 * t, "external_damping": 3 * t})
        file.note("running", f"{file.count} " * (file.count % 700), NO_STATS)
        if file.events < file.count // 50:
            file.add_event(file.events % 2, 50.0 * file.events, np.full(14, file.events))
        if not up:
            up = True
            print("up", flush=True)
"""


@pytest.mark.nightly
def test_killed_processes_leave_whole_samples(samples: Make, tmp_path: Path) -> None:
    """Each goes on where the one before it was killed. Every record tells its number."""
    given, path = samples(1, terms=("follower", "internal_damping", "external_damping")), tmp_path
    path = tmp_path / "run.nc"
    given.create(path, events=100_000).close()
    before, moments = 0, random.Random(5)
    for _ in range(3):
        process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, str(path)], stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        assert process.stdout.readline() == "up\n"
        time.sleep(moments.uniform(0.0, 0.2))
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=60)
        before = _whole(given, path, before)


def _whole(given: Any, path: Path, before: int) -> int:
    sol = rodgen.load(path)
    assert sol.status == "interrupted"
    assert "rodgen run --resume" in sol.message
    count = len(sol.t)
    assert count > before
    np.testing.assert_array_equal(sol.t, np.arange(count))
    np.testing.assert_array_equal(sol.y, np.sin(sol.t[:, None] + np.arange(14)))
    np.testing.assert_array_equal(sol.work["external_damping"], 3 * sol.t)
    sol.model = given.model
    with xr.open_dataset(path, engine="scipy") as data:
        # The text of the run tells of a block, of at most 7, just before NetCDF's count does.
        seen = data.sizes["time"]
        assert count - 7 <= seen <= count
        for name, due in sol.to_xarray().variables.items():
            if "time" in due.dims and name in data:  # a Dataset has more than a file
                np.testing.assert_array_equal(data[name], due.isel(time=slice(seen)))
        kept = int((data["event_number"].values >= 0).sum())
        assert abs(kept - count // 50) <= 1
        for k in range(kept):
            assert float(data["event_time"][k]) == 50.0 * k
            assert set(data["event_y"].values[k]) == {float(k)}
    return count


class Killed(BaseException):
    """In place of a signal."""


def test_cut_off_in_every_write(
    samples: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every write in turn gets only part of its bytes into the file, and is the last one."""
    given, path = samples(12), tmp_path / "run.nc"
    write = netcdf.RecordFile._write
    left, shares = 0, [0.0]

    def cut(self: netcdf.RecordFile, at: int, content: bytes) -> None:
        nonlocal left
        left -= 1
        if left < 0:
            # The system writes what lies in one page in one piece.
            one_page = at // netcdf.PAGE == (at + len(content) - 1) // netcdf.PAGE
            write(self, at, content[: 0 if one_page else int(shares[0] * len(content))])
            raise Killed
        write(self, at, content)

    def run() -> bool:
        with given.create(path, events=2) as file:
            try:
                given.append(file, 0, 5)
                file.add_event(0, given.t[3], given.y[3])
                file.note("running", "a note", NO_STATS)
                given.append(file, 5, 12)
                file.add_event(1, given.t[9], given.y[9])
                file.truncate(8, 1)
                file.finish("finished", "", NO_STATS)
            except Killed:
                return False
        return True

    monkeypatch.setattr(netcdf.RecordFile, "_write", cut)
    writes = 0
    for shares[0] in (0.0, 0.3, 0.99):
        writes, left = 0, 0
        while not run():
            sol = rodgen.load(path)
            assert len(sol.t) in (0, 5, 12, 8)
            np.testing.assert_array_equal(sol.y, given.y[: len(sol.t)])
            with xr.open_dataset(path, engine="scipy") as data:
                numbers = data["event_number"].values
                for number, k in zip(numbers[numbers >= 0], (3, 9), strict=False):
                    assert number == (0 if k == 3 else 1)
                    assert float(data["event_time"][number]) == given.t[k]
                    np.testing.assert_array_equal(data["event_y"][number], given.y[k])
            left = 10**6
            with Stream.reopen(path, given.model) as file:
                given.append(file, file.count, 12)
            np.testing.assert_array_equal(rodgen.load(path).y, given.y)
            writes += 1
            left = writes
    assert writes > 15
    assert os.listdir(tmp_path) == ["run.nc"]
