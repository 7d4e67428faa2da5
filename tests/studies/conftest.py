"""Workers of the tests of studies: two processes for all of them, and stores to compare."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import xarray as xr


@pytest.fixture(scope="session")
def scheduler() -> Iterator[Any]:
    """A cluster of two workers that is there already."""
    import dask
    import distributed

    from rodgen.studies.cluster import SETTINGS, _as_no_script, _quiet

    with (
        dask.config.set(SETTINGS),
        _quiet(),
        _as_no_script(),
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",  # else that of another test process may be taken
            silence_logs=logging.CRITICAL + 1,
        ) as cluster,
    ):
        yield cluster


def assert_same(a: xr.Dataset, b: xr.Dataset) -> None:
    """Both studies have the same bits, but for the time that points took."""
    assert set(a.variables) == set(b.variables)
    for name in set(a.variables) - {"seconds"}:
        x, y = a[name], b[name]
        assert x.dims == y.dims, name
        if x.dtype.kind == "f":
            assert np.asarray(x).tobytes() == np.asarray(y).tobytes(), name
        else:
            assert (np.asarray(x) == np.asarray(y)).all(), name
