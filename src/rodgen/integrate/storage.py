"""Solutions in NetCDF, through xarray."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rodgen.integrate.solution import Solution, Stats
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError

FORMAT = "rodgen 1"


def to_xarray(solution: Solution) -> xr.Dataset:
    """Dataset over time, state, link, joint and axis; work by load as work_<term>."""
    energy, inertia = solution.energy, solution.inertia

    def over(*dimensions: str) -> Callable[[Array, str, str], Any]:
        return lambda values, unit, name: (dimensions, values, {"units": unit, "long_name": name})

    in_time, by_link = over("time"), over("time", "link")
    variables: dict[str, Any] = {
        "y": (("time", "state"), solution.y, {"long_name": "state"}),
        "phi": by_link(solution.phi, "rad", "angles of the links"),
        "omega": by_link(solution.omega, "rad/s", "rates of the links"),
        "joints": over("time", "joint", "axis")(solution.joints, "m", "positions of the joints"),
        "centre_of_gravity": over("time", "axis")(solution.centre_of_gravity, "m", "centre"),
        "kinetic_energy": in_time(energy.kinetic, "J", "kinetic energy"),
        "spring_energy": in_time(energy.spring, "J", "energy of the springs"),
        "gravity_energy": in_time(energy.gravity, "J", "energy in gravity"),
        "energy_balance": in_time(solution.energy_balance, "J", "energy gained less work done"),
        "inertia_x": in_time(inertia.x, "kg m2", "moment of inertia about x"),
        "inertia_y": in_time(inertia.y, "kg m2", "moment of inertia about y"),
        "product_xy": in_time(inertia.xy, "kg m2", "product of inertia"),
    }
    for term, values in solution.work.items():
        variables[f"work_{term}"] = in_time(values, "J", f"work of {term.replace('_', ' ')}")
    n = solution.scene.rod.links
    coordinates = {
        "time": ("time", solution.t, {"units": "s"}),
        "state": list(solution._model.STATE),
        "link": np.arange(n),
        "joint": np.arange(n + 1),
        "axis": ["x", "y"],
    }
    attributes = {
        "format": FORMAT,
        "rodgen": version("rodgen"),
        "scene": json.dumps(solution.scene.model_dump(exclude_none=True)),
        "stats": json.dumps(asdict(solution.stats)),
        "status": solution.status,
        "message": solution.message,
    }
    return xr.Dataset(variables, coordinates, attributes)


def save(solution: Solution, path: Path) -> None:
    """Write a NetCDF file under another name first, so that none is left half written."""
    if not path.parent.is_dir():
        raise SceneError("file", str(path), "in a folder that exists")
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        to_xarray(solution).to_netcdf(part, engine="h5netcdf")
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def load(path: str | Path) -> Solution:
    """Read a Solution from a NetCDF file that rodgen wrote; raises SceneError for others."""
    try:
        with xr.open_dataset(path, engine="h5netcdf") as data:
            data.load()
    except (OSError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise SceneError("file", str(path), f"a NetCDF file that can be read ({reason})") from None
    if data.attrs.get("format") != FORMAT:
        raise SceneError("file", str(path), f"written by rodgen (format {FORMAT!r})")
    try:
        scene = Scene.from_dict(json.loads(data.attrs["scene"]))
    except (KeyError, ValueError) as error:
        raise SceneError("file", str(path), f"written by rodgen ({error})") from None
    prefix = "work_"
    work = {str(v)[len(prefix) :]: data[v].values for v in data if str(v).startswith(prefix)}
    return Solution(
        scene=scene,
        t=data["time"].values,
        y=data["y"].values,
        work=work,
        stats=Stats(**json.loads(data.attrs["stats"])),
        status=str(data.attrs["status"]),
        message=str(data.attrs["message"]),
    )
