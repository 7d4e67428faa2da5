"""Curves as xarray Datasets with one dimension along the curve: attributes, Ctrl-C, NetCDF files,
and the extension of saved curves.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.analyse.analysis_guard import check_whole_number
from rodgen.analyse.curves.curve import ContinuationProblem, Curve
from rodgen.arrays import Array
from rodgen.dataset_result import SPECIAL, dataset_variables, register_accessor
from rodgen.errors import BranchInterrupted, InputError
from rodgen.integrate.files import atomic_write
from rodgen.result import NOTES, Row, notes_as_text, notes_from
from rodgen.scene import Scene

if TYPE_CHECKING:
    import xarray

UNKNOWN = -1  # unstable directions, where they were not looked at
SPECIAL_ROWS = (
    Row("special_kind", "kind", along=SPECIAL),
    Row("special_after", "number of the point that it comes after", along=SPECIAL),
)


def lengths(problem: ContinuationProblem, curve: Curve) -> Array:
    """Length along a curve up to each of its points (points,)."""
    u = np.array([point.u for point in curve.points])
    return np.cumsum([0.0, *(problem.length(step) for step in np.diff(u, axis=0))])


@dataclass(frozen=True)
class CurveFormat:
    """Format of the Datasets and files of a kind of curve. name: the attribute `format`; kind: of
    curve, in words; rows: its quantities; dims: further dimensions of these, after the one along
    the curve; labels: texts along dimensions; argument: name of the one that takes its file."""

    name: str
    kind: str
    rows: tuple[Row, ...]
    dims: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    labels: Mapping[str, list[str]] = field(default_factory=dict)
    argument: str = "file"

    def dataset(
        self,
        scene: Scene,
        curve: Curve,
        t: float,
        values: Mapping[str, Any],
        said: Mapping[str, Any],
        **names: str,
    ) -> xarray.Dataset:
        """Make the Dataset of a curve.

        t: time of the loads [s]; values: by the names of rows, beside those that the points and
        special points of any curve have; said: further attributes; names: for the words of rows.
        """
        import xarray  # only where it is needed: it takes long to import

        special = curve.special
        unstable = [UNKNOWN if one.unstable is None else one.unstable for one in curve.points]
        of_any = {
            "unstable": np.array(unstable, dtype=np.int32),
            "special_kind": np.array([one.kind for one in special], dtype="U16"),
            "special_after": np.array([one.after for one in special], dtype=np.int32),
            "special_frequency": np.array([one.frequency for one in special]),
        }
        attributes = {
            "format": self.name,
            "rodgen": version("rodgen"),
            "scene": json.dumps(scene.to_dict()),
            "t": t,
            "end": curve.end,
            "complete": int(curve.complete),
            NOTES: notes_as_text(curve.notes),
        }
        data = dataset_variables(self.rows, of_any | {**values}, self.dims, **names)
        return xarray.Dataset(data, self.labels, attributes | {**said})

    def read(self, path: Path) -> xarray.Dataset:
        """Read a curve of this kind from a file. Raises InputError for any other file."""
        return read_curve(path, self.argument, self.kind, self.name)

    def resume_numbers(
        self, data: xarray.Dataset, scene: Scene, keys: Mapping[str, str], at: int
    ) -> list[int]:
        """Check that a saved curve can be resumed at a point; return the numbers of this point and
        of its neighbour, away from which the curve goes on: the point before it, or, for the first
        point, the one after. scene, keys (by attribute): what the curve must have. Raises
        InputError."""
        if data.attrs.get("format") != self.name:
            raise InputError(
                "resume", data.attrs.get("format"), f"a file of the format {self.name!r}"
            )
        for attribute, key in keys.items():
            if data.attrs[attribute] != key:
                raise InputError("resume", data.attrs[attribute], f"a file along {key}")
        other = scene_of(data)
        if other.rod != scene.rod or other.structure != scene.structure:
            raise InputError("resume", other.name, "a file of this scene")
        number, last = point_number(data, at), data.sizes["point"] - 1
        return [number, number - 1 if number else 1] if last else [number]


def scene_of(data: xarray.Dataset) -> Scene:
    """Read the scene of a curve from its attributes."""
    return Scene.from_dict(json.loads(data.attrs["scene"]))


def point_number(data: xarray.Dataset, at: object) -> int:
    """Check the number of a point and count it from the start. Raises InputError if there is
    none."""
    count = data.sizes["point"]
    allowed = f"the number of a point, 0 to {count - 1}"
    return check_whole_number(at, "point", -count, count - 1, allowed) % count


def make_dataset(curve: Curve, dataset: Callable[[], xarray.Dataset]) -> xarray.Dataset:
    """Make the Dataset of a curve. Raises BranchInterrupted, which carries it, if Ctrl-C stopped
    the curve, or comes while the Dataset is made, which is then made again."""
    interrupted = curve.interrupted
    register_accessor()
    try:
        found = dataset()
    except KeyboardInterrupt:
        interrupted, found = True, dataset()
    if interrupted:
        raise BranchInterrupted(found)
    return found


def extend(before: xarray.Dataset, at: int, on: xarray.Dataset) -> xarray.Dataset:
    """Join a saved branch up to one of its points and another branch that begins there. One that
    goes on from the first point is put before the saved branch, reversed. The attributes are those
    of the other, except for the notes, which are those of both."""
    import xarray

    number, last = at % before.sizes["point"], on.sizes["point"] - 1
    if number:
        known = np.flatnonzero(before["special_after"].values < number)
        parts = [
            before.isel(point=slice(number + 1), special=known),
            _shift(on, number, before["length"][number]).isel(point=slice(1, None)),
        ]
    else:
        turned = on.isel(point=slice(None, 0, -1), special=slice(None, None, -1))
        length = on["length"][-1]
        turned = turned.assign(
            special_after=last - 1 - turned["special_after"], length=length - turned["length"]
        )
        parts = [turned, _shift(before, last, length)]
    how: dict[str, Any] = {"data_vars": "minimal", "coords": "minimal", "compat": "override"}
    whole = xarray.merge(
        [
            xarray.concat([part.drop_dims(other) for part in parts], along, **how)
            for along, other in (("point", "special"), ("special", "point"))
        ]
    )
    notes = [note for one in (before, on) for note in notes_from(one.attrs)]
    return whole.assign_attrs(on.attrs | {NOTES: notes_as_text(notes)})


def _shift(branch: xarray.Dataset, points: int, length: xarray.DataArray) -> xarray.Dataset:
    """Shift the point numbers and lengths of a branch that follows another one."""
    return branch.assign(
        special_after=branch["special_after"] + points, length=branch["length"] + length
    )


def save_curve(data: xarray.Dataset, path: Path) -> None:
    """Write a branch to a NetCDF file, whole or not at all."""
    with atomic_write(path) as part:
        data.to_netcdf(part, engine="scipy")


def read_curve(path: Path, field: str, kind: str, *forms: str) -> xarray.Dataset:
    """Read a branch from a NetCDF file. field: name of the argument; kind: of branch, in words;
    forms: allowed values of its attribute `format`. Raises InputError for any other file."""
    import xarray

    register_accessor()
    try:
        with xarray.open_dataset(path, engine="scipy") as file:
            data = file.load()
    except (OSError, ValueError, TypeError, KeyError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(field, str(path), f"a NetCDF file that can be read ({reason})") from None
    if data.attrs.get("format") not in forms:
        allowed = " or ".join(map(repr, forms))
        raise InputError(field, str(path), f"{kind} written by rodgen (format {allowed})")
    return data
