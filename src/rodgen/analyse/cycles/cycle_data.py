"""Branches of cycles as xarray Datasets with one dimension along them, and cycles from these."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rodgen.analyse.curves import curve_files
from rodgen.analyse.curves.curve import Curve
from rodgen.analyse.curves.curve_datasets import (
    SPECIAL_ROWS,
    attributes,
    lengths,
    point_number,
    resume_numbers,
    scene_of,
)
from rodgen.analyse.cycles.cycle_problem import CycleFamily
from rodgen.analyse.cycles.cycle_result import nontrivial
from rodgen.analyse.cycles.hopf import HopfPoint
from rodgen.analyse.cycles.shooting import segment_states
from rodgen.arrays import Array
from rodgen.dataset_result import POINT, SPECIAL, dataset_variables
from rodgen.errors import InputError
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.result import Row
from rodgen.scene import Scene
from rodgen.system import System

if TYPE_CHECKING:
    import xarray

FORMAT = "rodgen cycles 1"
SAMPLES = 128  # of a period
DIMS = {"multipliers": ("multiplier", "part"), "y0": ("state",), "work": ("load",)}
ROWS = (
    Row("value", "{key}", along=POINT),
    Row("period", "period", "s", along=POINT),
    Row("amplitude", "amplitude of the angles", "rad", along=POINT),
    Row("tip", "amplitude of the tail", "m", along=POINT),
    Row("energy", "mean energy", "J", along=POINT),
    Row("angle", "turned after a period by", "rad", along=POINT),
    Row("unstable", "multipliers larger than 1", along=POINT),
    Row("trivial_error", "error of the multipliers that are 1", along=POINT),
    Row("multipliers", "other multipliers", along=POINT),
    Row("work", "work over a period", "J", along=POINT),
    Row("y0", "state on the cycle", along=POINT),
    Row("length", "length along the branch", along=POINT),
    Row("supercritical", "supercritical Hopf point"),
    Row("lyapunov", "first Lyapunov coefficient", "1/rad^2"),
    Row("end", "ends"),
    *SPECIAL_ROWS,
    Row("special_value", "{key}", along=SPECIAL),
    Row("special_period", "period", "s", along=SPECIAL),
    Row("special_frequency", "frequency", "Hz", along=SPECIAL),
)


@dataclass(frozen=True)
class CycleBranch:
    """A curve of cycles of a scene along a key; hopf: the Hopf point where it begins, if any."""

    scene: Scene
    key: str
    problem: CycleFamily
    curve: Curve
    hopf: HopfPoint | None = None


def dataset(branch: CycleBranch) -> xarray.Dataset:
    """Make the Dataset of a branch."""
    import xarray  # only where it is needed: it takes long to import

    problem, points, special = branch.problem, branch.curve.points, branch.curve.special
    rows = [_point_values(branch, point.u) for point in points]
    loads = list(rows[0]["work"])

    of_each = {name: np.array([row[name] for row in rows]) for name in rows[0] if name != "work"}
    of_each |= {
        "unstable": np.array([point.unstable for point in points], dtype=np.int32),
        "length": lengths(problem, branch.curve),
        "work": np.array([list(row["work"].values()) for row in rows]).reshape(len(rows), -1),
    }
    kinds = [one.kind for one in special]
    values = [problem.value(one.u) for one in special]
    periods = [problem.orbit(one.u).period for one in special]
    after = [one.after for one in special]
    frequencies = [one.frequency for one in special]
    if branch.hopf is not None:
        frequency = branch.hopf.frequency / (2 * np.pi)
        kinds, values, after = ["hopf", *kinds], [branch.hopf.value, *values], [-1, *after]
        periods, frequencies = [1 / frequency, *periods], [frequency, *frequencies]
    of_each |= {
        "special_kind": np.array(kinds, dtype="U16"),
        "special_value": np.array(values),
        "special_period": np.array(periods),
        "special_frequency": np.array(frequencies),
        "special_after": np.array(after, dtype=np.int32),
    }
    # Loads that do not repeat are those of the end of the span, whenever the cycle was met.
    t = problem.first.t if problem.forced else branch.scene.integrate.span[1]
    said = attributes(FORMAT, branch.scene, branch.curve, t) | {"key": branch.key}
    if branch.hopf is not None:
        c = branch.hopf.coefficient
        said |= {
            "lyapunov": branch.hopf.lyapunov,
            "supercritical": int(branch.hopf.supercritical),
            "coefficient": [c.real, c.imag],
        }
    data = dataset_variables(ROWS, of_each, DIMS, key=branch.key)
    return xarray.Dataset(data, {"part": ["re", "im"], "load": loads}, said)


def _point_values(branch: CycleBranch, u: Array) -> dict[str, Any]:
    """Values of the cycle at u, by the names of variables."""
    problem = branch.problem
    orbit, value = problem.orbit(u), problem.value(u)
    flow, q = problem.shooting(u).flow, problem.quotient
    model, p = flow.model, flow.p
    x = segment_states(flow, orbit.t, orbit.x[0], orbit.period, SAMPLES)
    y = q.lift(x)
    times: Array = orbit.t + orbit.period / SAMPLES * np.arange(SAMPLES, dtype=float)
    angles = x[:, q.angles]
    if q.turns:
        angles = angles - angles.mean(axis=1, keepdims=True)
    tips = model.joints(y, p)[:, -1]
    if branch.scene.boundary_condition.translates:
        tips = tips - model.centre_of_gravity(y, p)
    mu = problem.multipliers(u)
    left = nontrivial(mu, problem.trivial)
    powers = [model.power(float(t), one, p) for t, one in zip(times, y, strict=True)]
    # The mean over a whole period of a smooth periodic function: the trapezoidal rule is exact.
    work = {
        name: orbit.period * float(np.mean([power[name] for power in powers]))
        for name in (powers[0] if hasattr(model, "power") else ())
    }
    errors = np.sort(np.abs(mu - 1))[: problem.trivial]
    return {
        "value": value,
        "period": orbit.period,
        "angle": orbit.angle,
        "amplitude": float(np.ptp(angles, axis=0).max()) / 2,
        "tip": float(np.linalg.norm(tips - tips.mean(axis=0), axis=1).max()),
        "energy": float(np.mean(MotionSlice(model, p, y, times).values("total_energy"))),
        "multipliers": np.stack((left.real, left.imag), -1),
        "trivial_error": float(errors.max(initial=0.0)),
        "y0": y[0],
        "work": work,
    }


def read(path: Path) -> xarray.Dataset:
    """Read a branch from a file. Raises InputError for any other file."""
    return curve_files.read(path, "from", "a branch of cycles", FORMAT)


def nearest_point(data: xarray.Dataset, scene: Scene) -> int:
    """Find the number of the cycle whose value is nearest to the scene's own. Raises InputError for
    the branch of another scene."""
    key = str(data.attrs["key"])
    other = scene_of(data)
    if other.structure != scene.structure:
        raise InputError("start", other.name, "a branch of this scene")
    value = scene.value_of(key)
    return int(np.abs(data["value"].values - float(value)).argmin())


class SavedCycle(NamedTuple):
    """A saved cycle: the value, the time [s] of a state y0 on it, its period [s], and the angle by
    which the rod has turned after it [rad]."""

    value: float
    t: float
    y0: Array
    period: float
    angle: float

    @classmethod
    def of(cls, data: xarray.Dataset, number: int) -> SavedCycle:
        """Read the cycle of a number."""
        value, period, angle = (float(data[name][number]) for name in ("value", "period", "angle"))
        return cls(value, float(data.attrs["t"]), data["y0"].values[number], period, angle)


def read_cycles(data: xarray.Dataset, scene: Scene, key: str, at: int) -> list[SavedCycle]:
    """Read a cycle of a saved branch and its neighbour, if any. Raises InputError for a branch of
    another scene or key, and for a cycle that it does not have."""
    rows = resume_numbers(data, FORMAT, scene, {"key": key}, at)
    return [SavedCycle.of(data, row) for row in rows]


def system_and_cycle_at(data: xarray.Dataset, at: int) -> tuple[System, SavedCycle]:
    """Return the system at the value of a branch's point, and the cycle of that point. Raises
    InputError for a point that the branch does not have."""
    found = SavedCycle.of(data, point_number(data, at))
    return System(scene_of(data)).at({data.attrs["key"]: found.value}), found


def scene_at(data: xarray.Dataset, at: int) -> Scene:
    """Scene that starts on the cycle of a branch's point, at the time whose loads were taken.
    Raises InputError for a point that the branch does not have."""
    system, found = system_and_cycle_at(data, at)
    start, end = system.settings.span
    return system.with_settings(span=(found.t, found.t + end - start)).at(y0=found.y0).scene
