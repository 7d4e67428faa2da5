"""How errors grow over time, on a chaotic scene and on a regular one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rodgen.judge.cases import Case
from rodgen.judge.precision import ours
from rodgen.judge.precision.contestant import Array
from rodgen.judge.precision.measured import words
from rodgen.judge.precision.references import NO_REFERENCE, NoReferenceError
from rodgen.judge.precision.sweep import prepared
from rodgen.judge.unit import Row, Unit

CHAOTIC = "falling_chain"
MOST = 5  # scenes, where none is chaotic
METHOD, TOLERANCES = "dop853", (1e-6, 1e-10)
LARGE = 0.3  # rad, from which on errors have no room to grow exponentially
TRUSTED = 10.0  # times the reference's own error that an error must be
BEGUN = 0.1  # share of the span after which a rate is fitted


def growth(name: str, table: dict[str, Any], folder: str) -> list[Row]:
    """Largest error of an angle at every sample, for two tolerances, and the reference's own."""
    nothing: Row = {"error": None, "rate": None, "failed": ""}
    known: Row = {"scene": name, "n": table["rod"]["links"], "t": None}
    try:
        job, held, measures = prepared(name, table, folder)
    except NoReferenceError as why:
        said = words(f"{NO_REFERENCE}{why}")
        return [known | nothing | {"method": METHOD, "setting": None, "failed": said}]
    known["t"] = job.times.tolist()
    rows: list[Row] = []
    for rtol in TOLERANCES:
        row = known | nothing | {"method": METHOD, "setting": rtol}
        try:
            run = ours.contestant(job, METHOD, "c", rtol=rtol).integrate()
            error = measures.over_time(run.y)
            row |= {"error": error.tolist(), "rate": rate(job.times, error, held.off)}
        except Exception as why:  # the other tolerance may still do
            row |= {"failed": words(why)}
        rows.append(row)
    own = {"method": "reference, estimated", "setting": None, "error": held.off.tolist()}
    return [*rows, known | nothing | own | {"rate": rate(job.times, held.off, 0 * held.off)}]


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


def units(cases: Sequence[Case], quick: bool, folder: str | Path) -> list[Unit]:
    """Of the chaotic scene and the first other one; of the first few where none is chaotic."""
    chaotic = [case for case in cases if case.name == CHAOTIC]
    others = [case for case in cases if case.name != CHAOTIC]
    return [
        Unit(
            "growth",
            f"growth-{case.name}",
            f"{__name__}:growth",
            {"name": case.name, "table": case.scene, "folder": str(folder)},
            timed=False,
        )
        for case in [*chaotic, *others[: 1 if chaotic else MOST]]
    ]
