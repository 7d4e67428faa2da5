"""Sweep of a number of a scene: stability of the steady state, and the equilibria.

Computed in the process beside the server, a part at a time; a part is a dictionary that JSON has.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.modal import DIVERGENCE, FLUTTER
from rodgen.analyse.modes import natural_modes
from rodgen.errors import AnalysisError, InputError
from rodgen.scene import Scene
from rodgen.scene.literals import literals, replace_literal_by_name
from rodgen.scene.plain_tables import get_at
from rodgen.system import System

COUNT = 41  # values
TOGETHER = 7  # of them between two looks at what else is asked for
ROUNDS, PARTS = 4, 6  # of the step between two values, for where it becomes unstable
SWEPT = "swept_number"  # what a number in an expression is called while it is swept
ROUNDING = 1e-9  # of the length, below which a deflection is none
MODES = 16  # that are looked at for whether one grows
MOST_LINKS = 200  # beyond, a value takes seconds

Part = dict[str, Any]
Row = list[Any]  # value, largest growth [1/s], whether stable; None where it failed


def sweep(scene: Scene, key: str, low: float, high: float, t: float) -> Iterator[Part]:
    """Sweep a number in parts: "rows" of the stability map; "critical", the value at which the
    stability changes first, and "change", how, or nothing; "branch" and "special" of the
    bifurcation diagram, nothing where all equilibria are straight, or "note", why there is none.
    t: the time whose loads are taken [s]. Raises InputError."""
    if scene.rod.links > MOST_LINKS:
        raise InputError("rod.links", scene.rod.links, f"at most {MOST_LINKS} for a sweep")
    start, end = scene.integrate.span
    scene = scene.with_integrate(span=[start, max(end, t)])  # a live run may be beyond it
    scene, key = _name_number(scene, key)
    system = System(scene)
    values = np.linspace(low, high, COUNT).tolist()
    rows: list[Row] = []
    for at in range(0, COUNT, TOGETHER):
        found = [stability_row(system, key, value, t) for value in values[at : at + TOGETHER]]
        rows += found
        yield {"rows": found}
    yield _change_of_stability(system, key, rows, t)
    yield _branch(scene, key, (low, high), t)


def stability_row(system: System, key: str, value: float, t: float) -> Row:
    """Row of the stability map: the value, the largest growth [1/s], and whether the steady state
    is stable (see natural_modes), None where that failed."""
    try:
        found = natural_modes(system.at({key: value}), MODES, t=t)
    except (AnalysisError, InputError):
        return [value, None, None]
    growth = float(found.largest_growth)
    return [value, growth, found.stable] if math.isfinite(growth) else [value, None, None]


def _name_number(scene: Scene, key: str) -> tuple[Scene, str]:
    """Replace a number in an expression by a named one: the scene with it, and its key. Other keys
    stay as they are. Raises InputError."""
    outer, _, last = key.rpartition(".")
    text = get_at(scene, *outer.split("."))
    if not isinstance(text, str):
        return scene, key
    at, name = int(last), f"parameters.{SWEPT}"
    value = literals(text)[at].value
    return scene.replace({outer: replace_literal_by_name(text, at, SWEPT), name: value}), name


def _change_of_stability(system: System, key: str, rows: list[Row], t: float) -> Part:
    """First value at which stability changes, and how; nothing without one."""
    known = [(value, stable) for value, _, stable in rows if stable is not None]
    for (low, before), (high, after) in pairwise(known):
        if before == after:
            continue
        found = natural_modes(system.at({key: high if before else low}), MODES, t=t)
        kind = FLUTTER if found.frequencies[found.growth.argmax()] else DIVERGENCE
        for _ in range(ROUNDS):
            places = np.linspace(low, high, PARTS + 1).tolist()
            inner = (stability_row(system, key, value, t)[-1] == before for value in places[1:-1])
            first = [*inner, False].index(False)
            low, high = places[first : first + 2]
        change = f"{kind} {'begins' if before else 'ends'}"
        return {"critical": float(f"{(low + high) / 2:.4g}"), "change": change}
    return {}


def _branch(scene: Scene, key: str, ends: tuple[float, float], t: float) -> Part:
    """Branch of equilibria on which the scene is: values, the deflection of the tip from the first
    one [m], how many directions are unstable, states; and the special points on it."""
    try:
        data = continue_equilibria(scene, key, ends, t=t)
    except (AnalysisError, InputError) as error:
        return {"note": f"no equilibria: {error}"}
    tip = data["tip"].values
    away = np.hypot(*(tip - tip[0]).T)
    away[away < ROUNDING * scene.rod.length] = 0.0
    if not np.nan_to_num(away).any():
        return {}
    return {
        "branch": {
            "value": data["value"].values.tolist(),
            "away": [one if math.isfinite(one) else None for one in away.tolist()],
            "unstable": data["unstable"].values.tolist(),
            "state": data["y"].values.tolist(),
        },
        "special": [
            [float(value), str(kind)]
            for value, kind in zip(
                data["special_value"].values, data["special_kind"].values, strict=True
            )
        ],
    }
