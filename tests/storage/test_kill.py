"""A process that ends within any write leaves a file that opens, and that can be gone on with."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import rodgen
from rodgen.integrate.files import netcdf
from rodgen.integrate.files.file_layout import NO_STATS
from rodgen.integrate.files.stream import Stream

Make = Callable[..., Any]


class Killed(BaseException):
    """In place of a signal."""


@pytest.mark.parametrize("share", [0.3, pytest.param(0.99, marks=pytest.mark.slow)])
def test_cut_off_in_every_write(
    samples: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, share: float
) -> None:
    """Every write in turn gets only part of its bytes into the file, and is the last one."""
    given, path = samples(12), tmp_path / "run.nc"
    write = netcdf.RecordFile._write
    left = 0

    def cut(self: netcdf.RecordFile, at: int, content: bytes) -> None:
        nonlocal left
        left -= 1
        if left < 0:
            # The system writes what lies in one page in one piece.
            one_page = at // netcdf.PAGE == (at + len(content) - 1) // netcdf.PAGE
            write(self, at, content[: 0 if one_page else int(share * len(content))])
            raise Killed
        write(self, at, content)

    def run() -> bool:
        with given.create(path, events=2) as file:
            try:
                given.append(file, 0, 5)
                file.add_event(0, given.t[3], given.y[3])
                file.write_status("running", "a note", NO_STATS)
                given.append(file, 5, 12)
                file.add_event(1, given.t[9], given.y[9])
                file.truncate(8, 1)
                file.finish("finished", "", NO_STATS)
            except Killed:
                return False
        return True

    monkeypatch.setattr(netcdf.RecordFile, "_write", cut)
    writes = 0
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
