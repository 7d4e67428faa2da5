"""Growth of errors over time, on a chaotic scene and on a regular one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rodgen.analyse.precision import method_families
from rodgen.analyse.precision.contestant import Measurement, describe_error
from rodgen.analyse.precision.rows import has_result, read_number
from rodgen.arrays import Array
from rodgen_evidence.report.cases import Case
from rodgen_evidence.report.precision.contests import load_job
from rodgen_evidence.report.precision.references import NO_REFERENCE, NoReferenceError
from rodgen_evidence.report.unit import Unit

CHAOTIC = "falling_chain"
MOST = 5  # scenes, where none is chaotic
METHOD, TOLERANCES = "dop853", (1e-6, 1e-10)
LARGE = 0.3  # rad, from which on errors have no room to grow exponentially
TRUSTED = 10.0  # times the reference's own error that an error must be
SATURATED = 0.1  # [rad], from which on an error hardly grows
MUCH = 1e3  # times that errors grow in the span, from which on that is exponential
BEGUN = 0.1  # share of the span after which a rate is fitted


def growth(name: str, table: dict[str, Any], folder: str) -> list[Measurement]:
    """Largest error of an angle at every sample, for two tolerances, and the reference's own."""
    nothing: Measurement = {"error": None, "rate": None, "failed": ""}
    known: Measurement = {"scene": name, "n": table["rod"]["links"], "t": None}
    try:
        job, held = load_job(name, table, folder)
    except NoReferenceError as why:
        said = describe_error(f"{NO_REFERENCE}{why}")
        return [known | nothing | {"method": METHOD, "setting": None, "failed": said}]
    measures = held.measures(job, METHOD)
    known["t"] = job.sample_times.tolist()
    rows: list[Measurement] = []
    for rtol in TOLERANCES:
        row = known | nothing | {"method": METHOD, "setting": rtol}
        try:
            run = method_families.contestant(job, METHOD, "c", rtol=rtol).integrate()
            error = measures.angle_errors(run.y)
            row |= {"error": error.tolist(), "rate": rate(job.sample_times, error, held.off)}
        except Exception as why:  # the other tolerance may still do
            row |= {"failed": describe_error(why)}
        rows.append(row)
    own = {"method": "reference, estimated", "setting": None, "error": held.off.tolist()}
    return [*rows, known | nothing | own | {"rate": rate(job.sample_times, held.off, 0 * held.off)}]


def rate(times: Array, error: Array, off: Array) -> float | None:
    """Exponent r [1/s] of error ~ exp(r t), by least squares, or None.

    Of samples after the first tenth where the error is neither large nor that of the reference.
    """
    begun = times >= times[0] + BEGUN * (times[-1] - times[0])
    kept = begun & (error < LARGE) & (error > TRUSTED * off) & (error > 0)
    # Beyond the first large error it may be small again by chance.
    large = np.flatnonzero(error >= LARGE)
    if len(large):
        kept[large[0] :] = False
    if kept.sum() < 10:
        return None
    return float(np.polyfit(times[kept], np.log(error[kept]), 1)[0])


def units(cases: Sequence[Case], quick: bool, folder: str | Path, *_: object) -> list[Unit]:
    """Plan units of the chaotic scene and the first other one, or of the first few scenes."""
    chaotic = [case for case in cases if case.name == CHAOTIC]
    others = [case for case in cases if case.name != CHAOTIC]
    return [
        Unit(
            *("growth", f"growth-{case.name}", f"{__name__}:growth", case.given(folder)),
            timed=False,
        )
        for case in [*chaotic, *others[: 1 if chaotic else MOST]]
    ]


def curve(row: Measurement, key: str) -> Array:
    """An entry that is a list, nan where it has no number; empty where there is none."""
    value = row.get(key)
    return np.array(value if isinstance(value, list) else [], dtype=float)


def grows(row: Measurement) -> bool:
    """Whether errors grow exponentially: so much in the span that it is no other growth."""
    t, exponent = curve(row, "t"), read_number(row, "rate")
    return has_result(row) and len(t) > 0 and exponent * (t[-1] - t[0]) > math.log(MUCH)


def growth_line(row: Measurement) -> tuple[Array, Array] | None:
    """Times and values of the fitted exponential, through the middle of what it is fitted to."""
    if not grows(row):
        return None
    t, error, exponent = curve(row, "t"), curve(row, "error"), read_number(row, "rate")
    rising = (error > 0) & (error < SATURATED)
    if not rising.any():
        return None
    height = np.median(np.log(error[rising]) - exponent * t[rising])
    ends = t[rising][[0, -1]]
    return ends, np.exp(height + exponent * ends)
