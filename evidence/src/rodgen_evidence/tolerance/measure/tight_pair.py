"""Two tight runs of a scene by different families of methods, and one from beside its start."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from types import ModuleType
from typing import Any

import numpy as np

import rodgen
from rodgen.system import System
from rodgen_evidence.tolerance.measure.error_kinds import (
    WORK,
    Array,
    Kinds,
    apart,
    quantities,
    relative,
    sizes,
)
from rodgen_evidence.tolerance.measure.timed_runs import time_run

FIRST = ("dop853", 1e-13), ("gauss", 1e-13)
THIRD = "radau", 1e-12
GOOD = 1e-12  # of the largest value: a pair that is closer needs no third run
PATIENCE = 4.0  # seconds of a run
# Of the largest value, between two starts: what the first has become is seen above the errors of
# the runs, the second does not end as far apart as motions can be.
BESIDE = 1e-8, 1e-12
SATURATED = 1e4  # times that the first grows, from which it is the second that tells


@dataclass(frozen=True)
class TightPair:
    """values: of the reference; methods: those of the pair; errors: between both, by kind, at all
    samples and at the end; growth: times its size, that a shift of the start grew at most."""

    values: dict[str, Array]
    size: Kinds
    methods: tuple[str, str]
    errors: dict[str, Any]
    growth: float


def tight_pair(scene: rodgen.Scene, model: ModuleType) -> TightPair | None:
    """The two of three runs that are closest; None where there are no two."""
    runs: dict[str, dict[str, Array]] = {}
    for method, rtol in (*FIRST, THIRD):
        if method == THIRD[0] and (not runs or _are_close(runs)):
            break
        solution = time_run(scene, model, method, rtol, PATIENCE, 1).solution
        if solution is not None:
            runs[method] = quantities(solution)
    if len(runs) < 2:
        return None
    a, b = min(combinations(runs, 2), key=lambda two: _distance(runs[two[0]], runs[two[1]]))
    rtol = dict((*FIRST, THIRD))[a]
    size, growth = sizes(runs[a]), 0.0
    for shift in BESIDE:
        beside = _beside(scene, runs[a], shift)
        parted = time_run(System(scene).at(y0=beside), model, a, rtol, 2 * PATIENCE, 1).solution
        if parted is None:
            return None
        grown = apart(runs[a], quantities(parted))
        growth = max(growth, *(grown[k][0] / (shift * size[k]) for k in grown if size[k]))
        if growth < SATURATED:
            break
    return TightPair(runs[a], size, (a, b), apart(runs[a], runs[b]), growth)


def _are_close(runs: dict[str, dict[str, Array]]) -> bool:
    return len(runs) == 2 and _distance(*runs.values()) < GOOD


def _distance(a: dict[str, Array], b: dict[str, Array]) -> float:
    """Relative distance of two motions, without their works."""
    differences = {kind: off for kind, off in apart(a, b).items() if kind != WORK}
    return relative(differences, sizes(a))


def _beside(scene: rodgen.Scene, values: dict[str, Array], shift: float) -> Array:
    """The start with angles and rates shifted smoothly along the rod, by a share of their largest
    values: errors of its fastest modes would count as those of a chaotic motion."""
    y = scene.initial_state()
    size = sizes(values)
    count = values["angles"].shape[1]
    half = (len(y) - len(scene.states)) // 2
    s = (np.arange(count) + 0.5) / count
    smooth = s**3 * (10 - 15 * s + 6 * s**2)
    y[half - count : half] += shift * size["angles"] * smooth
    y[2 * half - count : 2 * half] += shift * size["rates"] * smooth
    return y
