"""Branches of equilibria as xarray Datasets with one dimension along them: write and read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rodgen.analyse.branches.equilibria import Equilibria
from rodgen.analyse.branches.steady_motions import SteadyMotions
from rodgen.analyse.curves.curve import Curve, CurvePoint, SpecialPoint
from rodgen.analyse.curves.curve_datasets import (
    SPECIAL_ROWS,
    UNKNOWN,
    CurveFormat,
    lengths,
    point_number,
    scene_of,
)
from rodgen.arrays import Array
from rodgen.dataset_result import POINT, PREFIX, SPECIAL
from rodgen.result import Row, doubt
from rodgen.scene import Scene
from rodgen.system import System

if TYPE_CHECKING:
    import xarray

DIMS = {"phi": ("link",), "tip": ("axis",), "y": ("state",), "force": ("cell", "axis")}
FORMAT = CurveFormat(
    "rodgen branch 1",
    "a branch",
    (
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
    ),
    DIMS | {f"{PREFIX}{name}": over for name, over in DIMS.items()},
    {"axis": ["x", "y"]},
)


def dataset(
    scene: Scene, key: str, problem: Equilibria, curve: Curve, number: int
) -> xarray.Dataset:
    """Make the Dataset of a branch of a scene; number: of the branch point it was entered by, or
    0."""
    special, base = curve.special, problem.along.base
    values: dict[str, Any] = _state_variables(problem, curve.points)
    values["length"] = lengths(problem, curve)
    values |= {
        f"{PREFIX}{name}": value for name, value in _state_variables(problem, special).items()
    }
    values["special_note"] = np.array([one.note for one in special], dtype="U200")
    notes = [*curve.notes]
    if problem.why_unknown:
        notes.append(doubt(f"stability is not known everywhere: {problem.why_unknown}"))
    moving = isinstance(problem, SteadyMotions)
    if moving:
        rates = [problem.steady_state(point.u).y for point in curve.points]
        at = len(rates[0]) // 2 + base.n_base
        values["turning"] = np.array([float(y[at]) for y in rates])
    said = {"key": key, "branch_point": number, "moving": int(moving)}
    return FORMAT.dataset(scene, replace(curve, notes=notes), base.t, values, said, key=key)


def _state_variables(
    problem: Equilibria, points: Sequence[CurvePoint | SpecialPoint]
) -> dict[str, Array]:
    """Variables of the steady states at points, by name."""
    base = problem.along.base
    n, n_moving = base.scene.rod.links, base.n_moving
    shapes = {"value": (), "phi": (n,), "tip": (2,), "y": (len(base.scene.initial_state()),)}
    made = {name: np.zeros((len(points), *shape)) for name, shape in shapes.items()}
    made["force"] = np.zeros((len(points), n_moving, 2))
    low, high = problem.along.numbers.bounds
    for row, point in enumerate(points):
        state = problem.steady_state(point.u)
        rod, y = state.rod, state.y
        exact = [end for end in (low, high) if problem.scale(end) == point.u[-1]]
        made["value"][row] = exact[0] if exact else problem.value(point.u)
        made["phi"][row] = rod.all_angles(state.phi)
        made["tip"][row] = rod.model.joints(y, state.p)[-1]
        made["y"][row], made["force"][row] = y, state.joint_forces
    return made


class SavedPoint(NamedTuple):
    """A saved point of a branch and its neighbour, if any: values, states and joint forces; moving:
    whether these are steady motions."""

    values: list[float]
    states: list[tuple[Array, Array]]
    moving: bool


def read_point(data: xarray.Dataset, scene: Scene, key: str, at: int) -> SavedPoint:
    """Read a point of a saved branch and its neighbour. Raises InputError for a branch of another
    scene or key, and for a point that it does not have."""
    rows = FORMAT.resume_numbers(data, scene, {"key": key}, at)
    states = [(data["y"].values[row], data["force"].values[row]) for row in rows]
    return SavedPoint(
        [float(data["value"][row]) for row in rows], states, bool(data.attrs["moving"])
    )


def scene_at(data: xarray.Dataset, at: int) -> Scene:
    """Scene that starts in the state at a point of a branch; in straight flight, in the scene's own
    state. Raises InputError for a point that the branch does not have."""
    number = point_number(data, at)
    system = System(scene_of(data)).at({data.attrs["key"]: float(data["value"][number])})
    if system.boundary_condition.translates and not (
        system.scene.anchors.support_points or data.attrs["moving"]
    ):
        return system.scene
    return system.at(y0=data["y"].values[number]).scene
