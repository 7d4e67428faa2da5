"""Branches of cycles as xarray Datasets with one dimension along them, and cycles from these."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rodgen.analyse.branches.equilibria import HOPF
from rodgen.analyse.curves.curve import Curve, SpecialPoint
from rodgen.analyse.curves.curve_datasets import (
    SPECIAL_ROWS,
    CurveFormat,
    lengths,
    point_number,
    scene_of,
)
from rodgen.analyse.cycles.cycle_problem import CycleFamily
from rodgen.analyse.cycles.hopf import HopfPoint
from rodgen.arrays import Array
from rodgen.dataset_result import POINT, SPECIAL
from rodgen.errors import InputError
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.loading.generated_module import call_module
from rodgen.result import Row
from rodgen.scene import Scene
from rodgen.system import System

if TYPE_CHECKING:
    import xarray

SAMPLES = 128  # of a period
FORMAT = CurveFormat(
    "rodgen cycles 1",
    "a branch of cycles",
    (
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
    ),
    {"multipliers": ("multiplier", "part"), "y0": ("state",), "work": ("load",)},
    {"part": ["re", "im"]},
    "from",
)


@dataclass(frozen=True)
class CycleBranch:
    """A curve of cycles; hopf: the Hopf point where it begins, if any."""

    problem: CycleFamily
    curve: Curve
    hopf: HopfPoint | None = None

    @property
    def special(self) -> list[SpecialPoint]:
        """Special points of the curve, after the Hopf point where it begins."""
        if self.hopf is None:
            return self.curve.special
        begin = SpecialPoint(HOPF, self.curve.points[0].u, -1, self.hopf.frequency / (2 * np.pi))
        return [begin, *self.curve.special]


def dataset(branch: CycleBranch) -> xarray.Dataset:
    """Make the Dataset of a branch."""
    problem, curve, hopf = branch.problem, branch.curve, branch.hopf
    scene, key = problem.search.given, problem.along.key
    rows = [_point_values(problem, point.u) for point in curve.points]
    loads = list(rows[0]["work"])
    values = {name: np.array([row[name] for row in rows]) for name in rows[0] if name != "work"}
    values["work"] = np.array([[*row["work"].values()] for row in rows]).reshape(len(rows), -1)
    values["length"] = lengths(problem, curve)
    places = [(problem.value(one.u), problem.orbit(one.u).period) for one in curve.special]
    said: dict[str, Any] = {"key": key}
    if hopf is not None:
        places = [(hopf.value, 1 / branch.special[0].frequency), *places]
        said |= {
            "lyapunov": hopf.lyapunov,
            "supercritical": int(hopf.supercritical),
            "coefficient": [hopf.coefficient.real, hopf.coefficient.imag],
        }
    values["special_value"], values["special_period"] = np.array(places).reshape(-1, 2).T
    # Loads that do not repeat are those of the end of the span, whenever the cycle was met.
    t = problem.first.t if problem.forced else scene.integrate.span[1]
    curve = replace(curve, special=branch.special)
    return FORMAT.dataset(scene, curve, t, values, said, key=key).assign_coords(load=loads)


def _point_values(problem: CycleFamily, u: Array) -> dict[str, Any]:
    """Values of the cycle at u, by the names of variables."""
    orbit = problem.orbit(u)
    flow = problem.shooting(u).flow
    model, p = flow.model, flow.p
    x, values = problem.sample_motion(u, SAMPLES)
    y = problem.quotient.lift(x)
    times: Array = orbit.t + orbit.period / SAMPLES * np.arange(SAMPLES, dtype=float)
    tips = call_module(model, "joints", times, y, p)[:, -1]
    if problem.search.given.boundary_condition.translates:
        tips = tips - call_module(model, "centre_of_gravity", times, y, p)
    has_power = hasattr(model, "power")
    powers = call_module(model, "power", times, times, y, p) if has_power else {}
    # The mean over a whole period of a smooth periodic function: the trapezoidal rule is exact.
    work = {name: orbit.period * float(np.mean(power)) for name, power in powers.items()}
    errors = np.sort(np.abs(problem.multipliers(u) - 1))[: problem.trivial]
    return values | {
        "value": problem.value(u),
        "angle": orbit.angle,
        "tip": float(np.linalg.norm(tips - tips.mean(axis=0), axis=1).max()),
        "energy": float(np.mean(MotionSlice(model, p, y, times).values("total_energy"))),
        "trivial_error": float(errors.max(initial=0.0)),
        "work": work,
    }


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
    rows = FORMAT.resume_numbers(data, scene, {"key": key}, at)
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
