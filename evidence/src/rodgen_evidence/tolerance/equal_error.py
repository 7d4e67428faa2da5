"""Costs of methods at equal error, in one scene: time over that of the best method."""

from __future__ import annotations

from collections import defaultdict
from typing import Any, NamedTuple

import numpy as np

from rodgen_evidence.tolerance.measure.error_kinds import ANGLES, POSITIONS, RATES, VELOCITIES
from rodgen_evidence.tolerance.measure.scene_record import AUTO, METHODS

Record = dict[str, Any]
Curve = list[tuple[float, float]]

PLACES = ANGLES, POSITIONS
ALL = (*PLACES, RATES, VELOCITIES)
LARGEST = 0.1  # of the motion: a run that is further off is not compared
FINER = 10.0  # times, that the reference is closer than the errors that are compared
BEYOND = 3.0  # times less than the least error of a method, that it may still be asked for


class Cost(NamedTuple):
    """times: of the time of the best method at equal error, no number where the reference cannot
    tell; alone: no other method comes to that error."""

    seed: int
    rtol: float
    method: str
    times: float
    best: str
    alone: bool = False


def costs(record: Record, kinds: tuple[str, ...] = ALL) -> list[Cost]:
    """The cost of every method at every tolerance, with that of auto last."""
    curves = {method: points for method in METHODS if (points := curve(record, method, kinds))}
    found: list[Cost] = []
    for row in (row for row in record["runs"] if row["seconds"] is not None):
        error = _error(record, row, kinds)
        if error is None:
            found.append(Cost(record["seed"], row["rtol"], row["method"], np.nan, "", True))
            continue
        own = np.log(row["seconds"])
        others = {method: _time_at(points, error) for method, points in curves.items()}
        mine = row["chosen"] if row["method"] == AUTO else row["method"]
        alone = all(np.isinf(time) for method, time in others.items() if method != mine)
        others[mine] = own
        best = min(others, key=others.__getitem__)
        times = float(np.exp(own - others[best]))
        found.append(Cost(record["seed"], row["rtol"], row["method"], times, best, alone))
    return found


def curve(record: Record, method: str, kinds: tuple[str, ...]) -> Curve:
    """Logarithms of error and time of a method, the least error first; a run that another of the
    method beats in both is left out."""
    points: Curve = []
    for row in record["runs"]:
        if row["method"] == method and row["seconds"] is not None:
            error = _error(record, row, kinds)
            if error is not None:
                points.append((error, float(np.log(row["seconds"]))))
    points.sort()
    return [one for one in points if not any(o[0] <= one[0] and o[1] < one[1] for o in points)]


def _error(record: Record, row: Record, kinds: tuple[str, ...]) -> float | None:
    """Logarithm of the largest error over the largest value of its kind; None where that is none
    or the reference cannot tell."""
    reference, shares = record["reference"], defaultdict[str, float](float)
    for kind in kinds:
        if kind in row["errors"] and (size := reference["size"][kind]):
            shares["run"] = max(shares["run"], row["errors"][kind][0] / size)
            shares["pair"] = max(shares["pair"], reference["errors"][kind][0] / size)
    if not FINER * shares["pair"] < shares["run"] < LARGEST:
        return None
    return float(np.log(shares["run"]))


def _time_at(points: Curve, error: float) -> float:
    """Logarithm of the time of a method at an error; infinite where it is too small for it."""
    errors, times = zip(*points, strict=True)
    if error < errors[0] - np.log(BEYOND):
        return float("inf")
    if error < errors[0] and len(points) > 1:
        slope = (times[1] - times[0]) / (errors[1] - errors[0])
        return float(times[0] + slope * (error - errors[0]))
    return float(np.interp(error, errors, times))
