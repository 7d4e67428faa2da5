"""Branches as xarray's Datasets, with one dimension along them, and from them again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rodgen.analyse.branches.equilibria import Equilibria
from rodgen.analyse.branches.motions import Motions
from rodgen.analyse.curves import files
from rodgen.analyse.curves.curve import Curve, Point, Special
from rodgen.analyse.curves.datasets import (
    SPECIAL_ROWS,
    attributes,
    lengths,
    point_number,
    scene_of,
    special_values,
    to_go_on,
)
from rodgen.analyse.steady import Steady
from rodgen.arrays import Array
from rodgen.dataset_result import POINT, PREFIX, SPECIAL, variables
from rodgen.result import Row, doubt
from rodgen.scene import Scene
from rodgen.system import System

if TYPE_CHECKING:
    import xarray

FORMAT = "rodgen branch 1"
UNKNOWN = -1  # unstable directions, where they were not looked at
DIMS = {"phi": ("link",), "tip": ("axis",), "y": ("state",), "force": ("cell", "axis")}
ROWS = (
    Row("value", "{key}", along=POINT),
    Row("unstable", "unstable directions", along=POINT, unknown=UNKNOWN),
    Row("tip", "place of the tail", "m", along=POINT),
    Row("phi", "angles of the links", "rad", along=POINT),
    Row("turning", "rate of turning", "rad/s", along=POINT),
    Row("y", "state", along=POINT),
    Row("force", "joint forces over the mass", "m/s2", along=POINT),
    Row("length", "length along the branch", along=POINT),
    Row("end", "ends"),
    *SPECIAL_ROWS,
    Row("special_value", "{key}", along=SPECIAL),
    Row("special_frequency", "frequency", "Hz", along=SPECIAL),
    Row("special_tip", "place of the tail", "m", along=SPECIAL),
    Row("special_phi", "angles of the links", "rad", along=SPECIAL),
    Row("special_note", "note", along=SPECIAL),
)


@dataclass(frozen=True)
class Branch:
    """A curve of steady states of a scene; number: of the branch point that it leaves, or 0."""

    scene: Scene
    key: str
    problem: Equilibria
    curve: Curve
    number: int = 0

    def state(self, point: Point | Special) -> Steady:
        """The steady state at a point."""
        return self.problem.steady(point.u)


def dataset(branch: Branch) -> xarray.Dataset:
    """The Dataset of a branch."""
    import xarray  # only where it is needed: it takes long to import

    points, special = branch.curve.points, branch.curve.special
    unstable = [UNKNOWN if p.unstable is None else p.unstable for p in points]
    values: dict[str, Any] = _states(branch, points)
    values["unstable"] = np.array(unstable, dtype=np.int32)
    values["length"] = lengths(branch.problem, branch.curve)
    values |= {f"{PREFIX}{name}": value for name, value in _states(branch, special).items()}
    values |= special_values(special)
    values["special_frequency"] = np.array([one.frequency for one in special])
    values["special_note"] = np.array([one.note for one in special], dtype="U200")
    notes = [*branch.curve.notes]
    if branch.problem.why_unknown:
        notes.append(doubt(f"stability is not known everywhere: {branch.problem.why_unknown}"))
    t = branch.problem.along.base.t
    said = attributes(FORMAT, branch.scene, replace(branch.curve, notes=notes), t)
    moving = isinstance(branch.problem, Motions)
    if moving:
        rates = [branch.problem.steady(point.u).y for point in points]
        base, half = branch.problem.along.base.base, len(rates[0]) // 2
        turning = [float(y[half + base]) for y in rates]
        values["turning"] = np.array(turning)
    said |= {"key": branch.key, "switch": branch.number, "moving": int(moving)}
    dims = DIMS | {f"{PREFIX}{name}": over for name, over in DIMS.items()}
    data = variables(ROWS, values, dims, key=branch.key)
    return xarray.Dataset(data, {"axis": ["x", "y"]}, said)


def _states(branch: Branch, points: Sequence[Point | Special]) -> dict[str, Array]:
    """Values of the steady states at points."""
    problem, base = branch.problem, branch.problem.along.base
    n, cells = base.scene.rod.links, base.cells
    shapes = {"value": (), "phi": (n,), "tip": (2,), "y": (len(base.scene.initial_state()),)}
    made = {name: np.zeros((len(points), *shape)) for name, shape in shapes.items()}
    made["force"] = np.zeros((len(points), cells, 2))
    low, high = problem.along.bounds
    for row, point in enumerate(points):
        state = problem.steady(point.u)
        rod, y = state.rod, state.y
        exact = [end for end in (low, high) if problem.scaled(end) == point.u[-1]]
        made["value"][row] = exact[0] if exact else problem.value(point.u)
        made["phi"][row] = rod.all_links(state.phi)
        made["tip"][row] = rod.model.joints(y, state.p)[-1]
        made["y"][row], made["force"][row] = y, state.force
    return made


class Recorded(NamedTuple):
    """A point of a file and the one that it comes after, if any: values, states and joint
    forces; moving: whether these are steady motions."""

    values: list[float]
    states: list[tuple[Array, Array]]
    moving: bool


def recorded(data: xarray.Dataset, scene: Scene, key: str, at: int) -> Recorded:
    """A point of a branch. Raises InputError for one of another scene or key, and for a point that
    it does not have."""
    rows = to_go_on(data, FORMAT, scene, {"key": key}, at)
    states = [(data["y"].values[row], data["force"].values[row]) for row in rows]
    return Recorded([float(data["value"][row]) for row in rows], states, bool(data.attrs["moving"]))


def scene_at(data: xarray.Dataset, at: int) -> Scene:
    """The scene at a point of a branch, which starts in its state; straight in steady flight, in
    its own. Raises InputError for a point that the branch does not have."""
    number = point_number(data, at)
    system = System(scene_of(data)).at({data.attrs["key"]: float(data["value"][number])})
    if system.hold.translates and not (system.scene.anchors.ties or data.attrs["moving"]):
        return system.scene
    return system.at(y0=data["y"].values[number]).scene


def read(path: Path) -> xarray.Dataset:
    """The branch in a file. Raises InputError for what is none."""
    return files.read(path, "file", "a branch", FORMAT)
