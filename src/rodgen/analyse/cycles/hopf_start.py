"""Where a branch of cycles may begin in a Hopf point, and Hopf points of branches of equilibria."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from rodgen.analyse.branches.branch_data import FORMAT
from rodgen.analyse.curves.datasets import scene_of
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.hopf import Hopf, hopf_near
from rodgen.analyse.cycles.search import Search
from rodgen.errors import AnalysisError, InputError
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.scene.plain import plain
from rodgen.system import ParameterRange

if TYPE_CHECKING:
    import xarray

HOPF = "hopf"


def check_smooth(scene: Scene) -> None:
    """Raise AnalysisError where a load of a scene has no normal form at rest."""
    for term in map(TERMS.__getitem__, scene.loads.terms):
        if term.kinked and np.any(scene.parameters[term.parameters[0].name]):
            raise AnalysisError(
                f"no Hopf point: {term.parameters[0].name} is not smooth at rest, and no normal "
                "form has the cycles that begin there; start from a run"
            )


def recorded_hopf(
    search: Search, along: ParameterRange, data: xarray.Dataset, at: object
) -> tuple[Hopf, Callable[[float], Flow]]:
    """The Hopf point of a number (1 is the first special point) of a branch of equilibria along the
    same key, and the flow at a value. Raises InputError for another point or branch,
    AnalysisError."""
    if data.attrs.get("format") != FORMAT or data.attrs["key"] != along.key:
        raise InputError("start", data.attrs.get("key"), f"a branch along {along.key}")
    other = scene_of(data)
    if other.structure != search.given.structure:
        raise InputError("start", other.name, "a branch of this scene")
    kinds = data["special_kind"].values.tolist()
    number = plain(at, "at")
    if not (isinstance(number, int) and 1 <= number <= len(kinds)) or kinds[number - 1] != HOPF:
        names = ", ".join(f"{k}: {kind}" for k, kind in enumerate(kinds, 1)) or "none"
        raise InputError("at", at, f"the number of a Hopf point (special points are {names})")
    check_smooth(search.given)
    value = float(data["special_value"][number - 1])
    turns = 2 * np.pi * float(data["special_frequency"][number - 1])
    y = data["y"].values[int(data["special_after"][number - 1])]
    quotient = search.flow(0.0, y).quotient

    def flow(there: float) -> Flow:
        return Flow(search.model, along.parameters(there), quotient)

    return hopf_near(flow, 0.0, y[quotient.kept], value, turns, along.unit), flow
