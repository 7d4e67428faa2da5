"""Distances of two runs by kind of quantity, over what a tolerance allows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import rodgen

Array = NDArray[np.float64]
Kinds = dict[str, float]

ANGLES, RATES, POSITIONS, VELOCITIES, ADDED, WORK = (
    *("angles", "rates", "positions", "velocities", "added states", "work"),
)
KINDS = ANGLES, RATES, POSITIONS, VELOCITIES, ADDED, WORK
ATOL = 0.01  # of rtol, as the default tolerances of scenes are


def quantities(solution: rodgen.Solution) -> dict[str, Array]:
    """Quantities that are compared, each (T, parts); velocities are those of a free joint 0."""
    count = len(solution.t)
    base = 2 * solution.boundary_condition.translates
    half = (solution.y.shape[1] - len(solution.extra_states)) // 2
    work = np.reshape([*solution.work.values()], (-1, count)).T
    found = {
        ANGLES: solution.y[:, base:half],
        RATES: solution.y[:, half + base : 2 * half],
        POSITIONS: solution.joints.reshape(count, -1),
        VELOCITIES: solution.y[:, half : half + base],
        ADDED: solution.y[:, 2 * half :],
        WORK: work,
    }
    return {kind: values for kind, values in found.items() if values.size}


def sizes(reference: dict[str, Array]) -> Kinds:
    """The largest value of every kind."""
    return {kind: float(np.abs(values).max()) for kind, values in reference.items()}


def apart(a: dict[str, Array], b: dict[str, Array]) -> dict[str, Any]:
    """Largest differences at all samples, and at the last one, by kind."""
    found = {}
    for kind, values in a.items():
        off = np.abs(values - b[kind])
        found[kind] = float(off.max()), float(off[-1].max())
    return found


def tolerated_error(size: float, rtol: float) -> float:
    """Largest error that a tolerance allows in a quantity of that largest value."""
    return rtol * size + ATOL * rtol


def relative(differences: dict[str, Any], size: Kinds) -> float:
    """The largest difference of all kinds, over the largest value of its kind."""
    return max(off[0] / size[kind] if size[kind] else 0.0 for kind, off in differences.items())
