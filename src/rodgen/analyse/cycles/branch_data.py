"""Branches of cycles as xarray's Datasets, with one dimension along them, and cycles from them."""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.analyse.curves import files
from rodgen.analyse.cycles.cycle import nontrivial
from rodgen.analyse.cycles.shooting import cut
from rodgen.integrate.catalogue import Piece
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError
from rodgen.scene.keys import key_place, with_value
from rodgen.scene.plain import entry, plain

if TYPE_CHECKING:
    import xarray

    from rodgen.analyse.cycles.branches import Branch

FORMAT = "rodgen cycles 1"
SAMPLES = 128  # of a period


def dataset(branch: Branch) -> xarray.Dataset:
    """The Dataset of a branch."""
    import xarray  # only where it is needed: it takes long to import

    problem, points, special = branch.problem, branch.curve.points, branch.curve.special
    rows = [_row(branch, point.u) for point in points]
    loads = list(rows[0]["work"])

    def of(name: str) -> Array:
        return np.array([row[name] for row in rows])

    data: dict[str, Any] = {
        "value": ("point", of("value"), {"long_name": branch.key}),
        "period": ("point", of("period"), {"units": "s"}),
        "amplitude": ("point", of("amplitude"), {"units": "rad"}),
        "tip": ("point", of("tip"), {"units": "m"}),
        "energy": ("point", of("energy"), {"units": "J", "long_name": "mean energy"}),
        "unstable": ("point", np.array([point.unstable for point in points], dtype=np.int32)),
        "multipliers": (("point", "multiplier", "part"), of("multipliers")),
        "trivial_error": ("point", of("trivial_error")),
        "angle": ("point", of("angle"), {"units": "rad"}),
        "y0": (("point", "state"), of("y0")),
        "work": (
            ("point", "load"),
            np.array([list(row["work"].values()) for row in rows]).reshape(len(rows), -1),
            {"units": "J", "long_name": "work over a period"},
        ),
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
    data |= {
        "special_kind": ("special", np.array(kinds, dtype="U16")),
        "special_value": ("special", np.array(values)),
        "special_period": ("special", np.array(periods), {"units": "s"}),
        "special_frequency": ("special", np.array(frequencies), {"units": "Hz"}),
        "special_after": ("special", np.array(after, dtype=np.int32)),
    }
    attributes = {
        "format": FORMAT,
        "rodgen": version("rodgen"),
        "scene": json.dumps(branch.scene.model_dump(exclude_none=True)),
        "key": branch.key,
        "t": problem.first.t,
        "end": branch.curve.end,
        "complete": int(branch.curve.complete),
        "notes": "\n".join(branch.curve.notes),
    }
    if branch.hopf is not None:
        c = branch.hopf.coefficient
        attributes |= {
            "lyapunov": branch.hopf.lyapunov,
            "supercritical": int(branch.hopf.supercritical),
            "coefficient": [c.real, c.imag],
        }
    coordinates = {"part": ["re", "im"], "load": loads}
    return xarray.Dataset(data, coordinates, attributes)


def _row(branch: Branch, u: Array) -> dict[str, Any]:
    """What there is to say of the cycle of u."""
    problem = branch.problem
    orbit, value = problem.orbit(u), problem.value(u)
    flow, q = problem.shooting(value).flow, problem.quotient
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
    """The branch in a file. Raises SceneError for what is none."""
    return files.read(path, "from", "a branch of cycles", FORMAT)


def nearest(data: xarray.Dataset, scene: Scene) -> int:
    """The number of the cycle whose value is nearest to a scene's own. Raises SceneError for the
    branch of another scene."""
    key = str(data.attrs["key"])
    other = Scene.from_dict(json.loads(data.attrs["scene"]))
    if other.structure != scene.structure:
        raise SceneError("from", other.name, "a branch of this scene")
    table = scene.model_dump(exclude_none=True)
    value = entry(table, *key_place(table, key))
    return int(np.abs(data["value"].values - float(value)).argmin())


def on_branch(data: xarray.Dataset, at: int) -> tuple[Scene, float, Array, float]:
    """The scene, the value, the state and the period [s] of a point of a branch. Raises
    SceneError for a point that it does not have."""
    count, number = data.sizes["point"], plain(at, "at")
    if not (isinstance(number, int) and -count <= number < count):
        raise SceneError("at", at, f"the number of a point, 0 to {count - 1}")
    value = float(data["value"][number])
    scene = with_value(Scene.from_dict(json.loads(data.attrs["scene"])), data.attrs["key"], value)
    return scene, value, data["y0"].values[number], float(data["period"][number])
