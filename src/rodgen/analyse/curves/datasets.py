"""Curves as xarray's Datasets, with one dimension along them: kept where Ctrl-C stops them, and
gone on with."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.curves.curve import Curve, Problem, Special
from rodgen.arrays import Array
from rodgen.dataset_result import SPECIAL, show_datasets
from rodgen.errors import BranchInterrupted, InputError
from rodgen.result import NOTES, Row, notes_as_text, notes_from
from rodgen.scene import Scene
from rodgen.scene.plain import plain

if TYPE_CHECKING:
    import xarray

SPECIAL_ROWS = (
    Row("special_kind", "kind", along=SPECIAL),
    Row("special_after", "number of the point that it comes after", along=SPECIAL),
)


def lengths(problem: Problem, curve: Curve) -> Array:
    """How long the curve is up to each of its points (points,)."""
    u = np.array([point.u for point in curve.points])
    return np.cumsum([0.0, *(problem.length(step) for step in np.diff(u, axis=0))])


def special_values(special: Sequence[Special]) -> dict[str, NDArray[Any]]:
    """Return what SPECIAL_ROWS say of special points."""
    return {
        "special_kind": np.array([one.kind for one in special], dtype="U16"),
        "special_after": np.array([one.after for one in special], dtype=np.int32),
    }


def attributes(form: str, scene: Scene, curve: Curve, t: float) -> dict[str, Any]:
    """What the Datasets of all curves say of themselves. form: their format; t: of the loads [s]"""
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
    """The scene that a curve was followed for."""
    return Scene.from_dict(json.loads(data.attrs["scene"]))


def point_number(data: xarray.Dataset, at: object) -> int:
    """The number of a point, counted from the start. Raises InputError for one that is not
    there."""
    count, number = data.sizes["point"], plain(at, "at")
    if not isinstance(number, int) or isinstance(number, bool) or not -count <= number < count:
        raise InputError("at", at, f"the number of a point, 0 to {count - 1}")
    return number % count


def to_go_on(
    data: xarray.Dataset, form: str, scene: Scene, keys: Mapping[str, str], at: int
) -> list[int]:
    """The numbers of the point that a curve of this format, of a scene along these keys (by the
    attribute that has them), is gone on with from, and of the one next to it from which it came:
    of the first point the one after it, since it is gone on from backwards. Raises InputError."""
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


def kept(curve: Curve, dataset: Callable[[], xarray.Dataset]) -> xarray.Dataset:
    """The Dataset of a curve. Raises BranchInterrupted with it where Ctrl-C stopped the curve, or
    comes while the Dataset is made, which is then made all the same."""
    interrupted = curve.interrupted
    show_datasets()
    try:
        found = dataset()
    except KeyboardInterrupt:
        interrupted, found = True, dataset()
    if interrupted:
        raise BranchInterrupted(found)
    return found


def extended(before: xarray.Dataset, at: int, on: xarray.Dataset) -> xarray.Dataset:
    """A branch up to one of its points, and from there on another, which begins in that point; one
    that goes on from the first point goes before the branch. What the other says of its end
    counts."""
    import xarray

    number, last = at % before.sizes["point"], on.sizes["point"] - 1
    if number:
        known = np.flatnonzero(before["special_after"].values < number)
        parts = [
            before.isel(point=slice(number + 1), special=known),
            _moved(on, number, before["length"][number]).isel(point=slice(1, None)),
        ]
    else:
        turned = on.isel(point=slice(None, 0, -1), special=slice(None, None, -1))
        length = on["length"][-1]
        turned = turned.assign(
            special_after=last - 1 - turned["special_after"], length=length - turned["length"]
        )
        parts = [turned, _moved(before, last, length)]
    how: dict[str, Any] = {"data_vars": "minimal", "coords": "minimal", "compat": "override"}
    whole = xarray.merge(
        [
            xarray.concat([part.drop_dims(other) for part in parts], along, **how)
            for along, other in (("point", "special"), ("special", "point"))
        ]
    )
    notes = [note for one in (before, on) for note in notes_from(one.attrs)]
    return whole.assign_attrs(on.attrs | {NOTES: notes_as_text(notes)})


def _moved(branch: xarray.Dataset, points: int, length: xarray.DataArray) -> xarray.Dataset:
    """A branch that comes after so many points, and so long a way."""
    return branch.assign(
        special_after=branch["special_after"] + points, length=branch["length"] + length
    )
