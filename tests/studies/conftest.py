"""What tests of studies share: scenes of two structures in all, two workers, stores compared."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
import xarray as xr

from rodgen import Scene

PENDULUM: dict[str, Any] = {
    "name": "pendulum",
    "parameters": {"A": 1.0, "w": 3.0},
    "rod": {"links": 3, "length": 1.0, "bending_stiffness": 1.0, "mass": 2.0, "boundary": "pinned"},
    "loads": {
        "gravity": {"g": 9.81},
        "internal_damping": {"coefficient": 0.02},
        "tip": {"x": "A*sin(w*t)"},
    },
    "initial": {"phi": 0.8, "omega": 0.0},
    "events": [{"quantity": "phi_0", "value": -1.0, "direction": "rising", "name": "up"}],
    "integrate": {"span": [0.0, 2.0], "output_every": 0.05, "method": "dop853", "rtol": 1e-7},
}
BECK: dict[str, Any] = {
    "name": "beck",
    "rod": {
        "links": 8,
        "length": 5.0,
        "bending_stiffness": 100.0,
        "mass": 20.0,
        "boundary": "clamped",
    },
    "loads": {"follower": {"force": 20.0}, "material_damping": {"time": 1e-3}},
    "initial": {"phi": 0.0},
}


def scene(table: dict[str, Any], **tables: Any) -> Scene:
    """A scene with other values in some of its tables."""
    made = {name: dict(v) if isinstance(v, dict) else v for name, v in table.items()}
    for name, values in tables.items():
        made[name] = {**made.get(name, {}), **values} if isinstance(values, dict) else values
    return Scene.from_dict(made)


def study_file(path: Path, name: str, table: dict[str, Any], vary: dict[str, Any]) -> Path:
    """Writes a study of a scene to a file, which keeps last(tip_x)."""
    study = {"name": name, "scene": table, "vary": vary, "compute": {"keep": ["last(tip_x)"]}}
    path.write_text(tomli_w.dumps(study), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def scheduler() -> Iterator[Any]:
    """A cluster of two workers that is there already."""
    import dask
    import distributed

    from rodgen.studies.cluster import SETTINGS, _hide_main_script, _silence_dask

    with (
        dask.config.set(SETTINGS),
        _silence_dask(),
        _hide_main_script(),
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",  # else that of another test process may be taken
            scheduler_kwargs={"dashboard": False},
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
