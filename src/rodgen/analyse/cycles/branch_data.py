"""Branches of cycles as xarray's Datasets, with one dimension along them, and cycles from them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rodgen.analyse.curves import files
from rodgen.analyse.curves.curve import Curve
from rodgen.analyse.curves.datasets import (
    SPECIAL_ROWS,
    attributes,
    lengths,
    point_number,
    scene_of,
    to_go_on,
)
from rodgen.analyse.cycles.cycle import nontrivial
from rodgen.analyse.cycles.family import Cycles
from rodgen.analyse.cycles.hopf import Hopf
from rodgen.analyse.cycles.shooting import cut
from rodgen.arrays import Array
from rodgen.dataset_result import POINT, SPECIAL, variables
from rodgen.errors import InputError
from rodgen.integrate.catalogue import Piece
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
class Branch:
    """A curve of cycles of a scene along a key; hopf: where it begins, unless that was a run."""

    scene: Scene
    key: str
    problem: Cycles
    curve: Curve
    hopf: Hopf | None = None


def dataset(branch: Branch) -> xarray.Dataset:
    """The Dataset of a branch."""
    import xarray  # only where it is needed: it takes long to import

    problem, points, special = branch.problem, branch.curve.points, branch.curve.special
    rows = [_row(branch, point.u) for point in points]
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
    data = variables(ROWS, of_each, DIMS, key=branch.key)
    return xarray.Dataset(data, {"part": ["re", "im"], "load": loads}, said)


def _row(branch: Branch, u: Array) -> dict[str, Any]:
    """What there is to say of the cycle of u."""
    problem = branch.problem
    orbit, value = problem.orbit(u), problem.value(u)
    flow, q = problem.shooting(u).flow, problem.quotient
    model, p = flow.model, flow.p
    x = cut(flow, orbit.t, orbit.x[0], orbit.period, SAMPLES)
    y = q.lifted(x)
    times: Array = orbit.t + orbit.period / SAMPLES * np.arange(SAMPLES, dtype=float)
    angles = x[:, q.angles]
    if q.turns:
        angles = angles - angles.mean(axis=1, keepdims=True)
    tips = model.joints(y, p)[:, -1]
    if branch.scene.hold.translates:
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
        "energy": float(np.mean(Piece(model, p, y, times).values("total_energy"))),
        "multipliers": np.stack((left.real, left.imag), -1),
        "trivial_error": float(errors.max(initial=0.0)),
        "y0": y[0],
        "work": work,
    }


def read(path: Path) -> xarray.Dataset:
    """The branch in a file. Raises InputError for what is none."""
    return files.read(path, "from", "a branch of cycles", FORMAT)


def nearest(data: xarray.Dataset, scene: Scene) -> int:
    """The number of the cycle whose value is nearest to a scene's own. Raises InputError for the
    branch of another scene."""
    key = str(data.attrs["key"])
    other = scene_of(data)
    if other.structure != scene.structure:
        raise InputError("start", other.name, "a branch of this scene")
    value = scene.value_of(key)
    return int(np.abs(data["value"].values - float(value)).argmin())


class Recorded(NamedTuple):
    """A cycle of a file: the value, the time [s] of a state y0 on it, its period [s], and the angle
    by which the rod has turned after it [rad]."""

    value: float
    t: float
    y0: Array
    period: float
    angle: float

    @classmethod
    def of(cls, data: xarray.Dataset, number: int) -> Recorded:
        """The cycle of this number."""
        value, period, angle = (float(data[name][number]) for name in ("value", "period", "angle"))
        return cls(value, float(data.attrs["t"]), data["y0"].values[number], period, angle)


def recorded(data: xarray.Dataset, scene: Scene, key: str, at: int) -> list[Recorded]:
    """A cycle of a branch and the one that it comes after, if any. Raises InputError for a branch
    of another scene or key, and for a cycle that it does not have."""
    rows = to_go_on(data, FORMAT, scene, {"key": key}, at)
    return [Recorded.of(data, row) for row in rows]


def on_branch(data: xarray.Dataset, at: int) -> tuple[System, Recorded]:
    """The system at the value of a point of a branch, and its cycle. Raises InputError for a point
    that it does not have."""
    found = Recorded.of(data, point_number(data, at))
    return System(scene_of(data)).at({data.attrs["key"]: found.value}), found


def scene_at(data: xarray.Dataset, at: int) -> Scene:
    """The scene at a point of a branch, which starts in a state of its cycle, at the time whose
    loads were taken. Raises InputError for a point that it does not have."""
    system, found = on_branch(data, at)
    start, end = system.settings.span
    return system.with_settings(span=(found.t, found.t + end - start)).at(y0=found.y0).scene
