"""Curves as xarray Datasets with one dimension along the curve: attributes, Ctrl-C, and the
extension of saved curves."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.curves.curve import ContinuationProblem, Curve, SpecialPoint
from rodgen.arrays import Array
from rodgen.dataset_result import SPECIAL, register_accessor
from rodgen.errors import BranchInterrupted, InputError
from rodgen.result import NOTES, Row, notes_as_text, notes_from
from rodgen.scene import Scene
from rodgen.scene.plain_tables import to_plain

if TYPE_CHECKING:
    import xarray

SPECIAL_ROWS = (
    Row("special_kind", "kind", along=SPECIAL),
    Row("special_after", "number of the point that it comes after", along=SPECIAL),
)


def lengths(problem: ContinuationProblem, curve: Curve) -> Array:
    """Length along a curve up to each of its points (points,)."""
    u = np.array([point.u for point in curve.points])
    return np.cumsum([0.0, *(problem.length(step) for step in np.diff(u, axis=0))])


def special_variables(special: Sequence[SpecialPoint]) -> dict[str, NDArray[Any]]:
    """Return the variables of SPECIAL_ROWS for special points."""
    return {
        "special_kind": np.array([one.kind for one in special], dtype="U16"),
        "special_after": np.array([one.after for one in special], dtype=np.int32),
    }


def attributes(form: str, scene: Scene, curve: Curve, t: float) -> dict[str, Any]:
    """Attributes of the Dataset of any curve. form: its format; t: time of the loads [s]"""
    return {
        "format": form,
        "rodgen": version("rodgen"),
        "scene": json.dumps(scene.to_dict()),
        "t": t,
        "end": curve.end,
        "complete": int(curve.complete),
        NOTES: notes_as_text(curve.notes),
    }


def scene_of(data: xarray.Dataset) -> Scene:
    """Read the scene of a curve from its attributes."""
    return Scene.from_dict(json.loads(data.attrs["scene"]))


def point_number(data: xarray.Dataset, at: object) -> int:
    """Check the number of a point and count it from the start. Raises InputError if there is
    none."""
    count, number = data.sizes["point"], to_plain(at, "at")
    if not isinstance(number, int) or isinstance(number, bool) or not -count <= number < count:
        raise InputError("at", at, f"the number of a point, 0 to {count - 1}")
    return number % count


def resume_numbers(
    data: xarray.Dataset, form: str, scene: Scene, keys: Mapping[str, str], at: int
) -> list[int]:
    """Check that a saved curve can be resumed at a point; return the numbers of this point and of
    its neighbour, away from which the curve goes on: the point before it, or, for the first point,
    the one after. form, scene, keys (by attribute): what the curve must have. Raises InputError."""
    if data.attrs.get("format") != form:
        raise InputError("resume", data.attrs.get("format"), f"a file of the format {form!r}")
    for attribute, key in keys.items():
        if data.attrs[attribute] != key:
            raise InputError("resume", data.attrs[attribute], f"a file along {key}")
    other = scene_of(data)
    if other.rod != scene.rod or other.structure != scene.structure:
        raise InputError("resume", other.name, "a file of this scene")
    number, last = point_number(data, at), data.sizes["point"] - 1
    return [number, number - 1 if number else 1] if last else [number]


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
