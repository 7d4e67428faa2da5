"""Branches as xarray's Datasets, with one dimension along them, and from them again."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.analyse.curves import files
from rodgen.analyse.curves.curve import Point, Special
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError
from rodgen.scene.keys import with_value
from rodgen.scene.overrides import with_state
from rodgen.scene.plain import plain

if TYPE_CHECKING:
    import xarray

    from rodgen.analyse.branches.equilibrium_branch import Branch

FORMAT = "rodgen branch 1"
UNKNOWN = -1  # unstable directions, where they were not looked at


def dataset(branch: Branch) -> xarray.Dataset:
    """The Dataset of a branch."""
    import xarray  # only where it is needed: it takes long to import

    points, special = branch.curve.points, branch.curve.special
    u = np.array([point.u for point in points])
    steps = [branch.problem.length(step) for step in np.diff(u, axis=0)]
    unstable = [UNKNOWN if p.unstable is None else p.unstable for p in points]
    data: dict[str, Any] = {
        name: (("point", *dims), values, attributes)
        for name, (dims, values, attributes) in _states(branch, points).items()
    }
    data["unstable"] = ("point", np.array(unstable, dtype=np.int32))
    data["length"] = ("point", np.concatenate(([0.0], np.cumsum(steps))))
    for name, (dims, values, attributes) in _states(branch, special).items():
        if name in ("value", "phi", "tip"):
            data[f"special_{name}"] = (("special", *dims), values, attributes)
    data["special_kind"] = ("special", np.array([one.kind for one in special], dtype="U16"))
    frequency = np.array([one.frequency for one in special])
    data["special_frequency"] = ("special", frequency, {"units": "Hz"})
    data["special_after"] = ("special", np.array([one.after for one in special], dtype=np.int32))
    data["special_note"] = ("special", np.array([one.note for one in special], dtype="U200"))
    notes = [*branch.curve.notes]
    if branch.problem.why_unknown:
        notes.append(f"stability is not known everywhere: {branch.problem.why_unknown}")
    attributes = {
        "format": FORMAT,
        "rodgen": version("rodgen"),
        "scene": json.dumps(branch.scene.model_dump(exclude_none=True)),
        "key": branch.key,
        "t": branch.problem.variable.base.t,
        "end": branch.curve.end,
        "complete": int(branch.curve.complete),
        "notes": "\n".join(notes),
        "switch": branch.number,
    }
    return xarray.Dataset(data, {"axis": ["x", "y"]}, attributes)


def _states(branch: Branch, points: Sequence[Point | Special]) -> dict[str, Any]:
    """What steady states at points are: dimensions beside the points, values, attributes."""
    problem, base = branch.problem, branch.problem.variable.base
    n, cells = base.scene.rod.links, base.cells
    shapes = {"value": (), "phi": (n,), "tip": (2,), "y": (len(base.scene.initial_state()),)}
    made = {name: np.zeros((len(points), *shape)) for name, shape in shapes.items()}
    made["force"] = np.zeros((len(points), cells, 2))
    low, high = problem.variable.ends
    for row, point in enumerate(points):
        state = problem.steady(point.u)
        system, y = state.system, state.system.at_rest(state.at)
        exact = [end for end in (low, high) if problem.scaled(end) == point.u[-1]]
        made["value"][row] = exact[0] if exact else problem.value(point.u)
        made["phi"][row] = system.all_links(state.phi)
        made["tip"][row] = system.model.joints(y, state.p)[-1]
        made["y"][row], made["force"][row] = y, state.force
    dims = {
        "value": ((), {"long_name": branch.key}),
        "phi": (("link",), {"units": "rad"}),
        "tip": (("axis",), {"units": "m"}),
        "y": (("state",), {"long_name": "state"}),
        "force": (("cell", "axis"), {"units": "m/s2", "long_name": "joint forces over the mass"}),
    }
    return {name: (over, made[name], attributes) for name, (over, attributes) in dims.items()}


@dataclass(frozen=True)
class Recorded:
    """A point of a file, its number, its value and that of the point before it; states: of both, as
    angles, joint forces, position and added states."""

    number: int
    value: float
    others: tuple[float, ...]
    states: list[tuple[Array, Array, Array, Array]]


def recorded(data: xarray.Dataset, scene: Scene, key: str, at: int) -> Recorded:
    """A point of a branch. Raises SceneError for one of another scene or key, and for a point that
    it does not have."""
    if data.attrs.get("format") != FORMAT:
        raise SceneError("resume", data.attrs.get("format"), f"a branch of rodgen ({FORMAT})")
    if data.attrs["key"] != key:
        raise SceneError("resume", data.attrs["key"], f"a branch along {key}")
    own, other = (scene.model_dump(exclude_none=True), json.loads(data.attrs["scene"]))
    other = Scene.from_dict(other).model_dump(exclude_none=True)
    if own["rod"] != other["rod"] or set(own["loads"]) != set(other["loads"]):
        raise SceneError("resume", other.get("name"), "a branch of this scene")
    count, number = data.sizes["point"], plain(at, "at")
    if not isinstance(number, int) or isinstance(number, bool) or not -count <= number < count:
        raise SceneError("at", at, f"the number of a point, 0 to {count - 1}")
    number %= count
    rows = [number] + ([number - 1] if number else [])
    if not number and count > 1:  # the first point is gone on from backwards
        rows.append(1)
    values = [float(data["value"][row]) for row in rows]
    base = 2 * scene.hold.translates
    half = base + scene.rod.links - scene.held
    states = []
    for row in rows:
        y, force = data["y"].values[row], data["force"].values[row]
        states.append((y[base:half], force, y[:base], y[2 * half :]))
    return Recorded(number, values[0], tuple(values[1:]), states)


def scene_at(data: xarray.Dataset, at: int) -> Scene:
    """The scene at a point of a branch, which starts in its state; of a free rod that nothing
    holds, in its own. Raises SceneError for a point that the branch does not have."""
    count = data.sizes["point"]
    if not -count <= at < count:
        raise SceneError("at", at, f"the number of a point, 0 to {count - 1}")
    scene = Scene.from_dict(json.loads(data.attrs["scene"]))
    scene = with_value(scene, data.attrs["key"], float(data["value"][at]))
    if scene.hold.translates and not scene.anchors.ties:
        return scene
    return with_state(scene, data["y"].values[at])


def read(path: Path) -> xarray.Dataset:
    """The branch in a file. Raises SceneError for what is none."""
    return files.read(path, "file", "a branch", FORMAT)
