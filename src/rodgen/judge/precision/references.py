"""Reference solutions by extrapolation methods, a family that no contestant is of."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import rodgen
from rodgen.judge.cases import Case
from rodgen.judge.precision.contestant import Array, Deadline, TooSlowError
from rodgen.judge.precision.errors import MEASURES, Errors, Measures
from rodgen.judge.precision.extended import library
from rodgen.judge.precision.job import Job
from rodgen.judge.precision.ladder import Way, ladder
from rodgen.judge.precision.measured import words
from rodgen.judge.unit import Row, Unit

# Of all solutions for a reference; implicit, that of 200 links is told by the last two of four.
SECONDS, QUICKLY = {False: 10.0, True: 40.0}, 4.0
# By whether it is implicit; the next where rounding lets the one before get nowhere.
CHECKS = {
    False: (("dop853", 1e-13), ("dop853", 1e-10)),
    True: (("radau", 1e-10), ("radau", 1e-8)),
}
PATIENCE = 6.0  # seconds of such a run
NO_REFERENCE = "no reference: "  # how reasons begin where there is none

COLUMNS = (
    *("method", "order", "tolerance"),
    *(name.replace("error_", "estimate_") for name in MEASURES),
    *("checked_by", "check_phi", "rhs", "events"),
)


class NoReferenceError(RuntimeError):
    """There is no reference solution of a scene."""


@dataclass(frozen=True)
class Reference:
    """states: (samples, states); off: its estimated error over time [rad] (samples,); estimate:
    of all measures."""

    states: Array
    off: Array
    estimate: Errors

    @classmethod
    def load(cls, folder: str | Path, name: str, table: dict[str, Any]) -> Reference:
        """From the folder of references. Raises NoReferenceError with why there is none."""
        file, why = Path(folder) / f"{name}.npz", Path(folder) / f"{name}.txt"
        if why.exists():
            raise NoReferenceError(why.read_text(encoding="utf-8"))
        if not file.exists():
            raise NoReferenceError(f"there is no reference solution of {name}")
        with np.load(file) as held:
            if "scene" not in held.files or str(held["scene"]) != fingerprint(table):
                raise NoReferenceError(f"the reference of {name} is of another scene")
            estimate = {k[9:]: _none(held[k]) for k in held.files if k.startswith("estimate_")}
            return cls(held["states"], held["off"], estimate)

    def save(self, folder: str | Path, name: str, table: dict[str, Any]) -> None:
        """Into that folder, for that scene."""
        numbers: dict[str, Any] = {
            f"estimate_{k}": np.nan if v is None else v for k, v in self.estimate.items()
        }
        numbers |= {"scene": np.array(fingerprint(table))}
        file = Path(folder) / f"{name}.npz"
        np.savez(file, states=self.states, off=self.off, **numbers)


def fingerprint(table: dict[str, Any]) -> str:
    """Of a scene's tables."""
    return hashlib.sha256(json.dumps(table, sort_keys=True).encode()).hexdigest()


def check(job: Job, implicit: bool, measures: Measures) -> tuple[str, float | None]:
    """What else it is compared with, and the largest difference of an angle at the end [rad]."""
    said = []
    for method, rtol in CHECKS[implicit]:
        Deadline.at = time.perf_counter() + PATIENCE
        try:
            run = rodgen.simulate(
                job.scene,
                target="c",
                method=method,
                rtol=rtol,
                atol=rtol / 100,
                progress=lambda _: Deadline.look(),
            )
            said.append(f"{method}, rtol {rtol:g}")
            return "; ".join(said), measures.errors(run.y)["error_phi"]
        except (rodgen.RunError, TooSlowError) as error:
            said.append(f"{method}, rtol {rtol:g}: {error}")
        finally:
            Deadline.at = np.inf
    return "; ".join(said), None


def reference(name: str, table: dict[str, Any], folder: str, quick: bool = False) -> list[Row]:
    """Make and keep the reference solution of a scene, with its own error estimate.

    Where none can be made, the row and a file beside where it would be say why.
    """
    file, reason = Path(folder) / f"{name}.npz", Path(folder) / f"{name}.txt"
    Path(folder).mkdir(parents=True, exist_ok=True)
    for old in (file, reason):
        old.unlink(missing_ok=True)
    start = time.perf_counter()
    row: Row = {"scene": name, "n": table["rod"]["links"], **dict.fromkeys(COLUMNS)}
    row["events"] = len(table.get("events", ()))  # that no run of the report stops at
    try:
        row |= _made(name, table, folder, quick)
    except Exception as error:  # a scene of a user may fail in any way
        row["failed"] = words(error)
        reason.write_text(words(error), encoding="utf-8")
        file.unlink(missing_ok=True)
        return [row | {"seconds": time.perf_counter() - start}]
    return [row | {"failed": ""}]


def _made(name: str, table: dict[str, Any], folder: str, quick: bool) -> Row:
    """What is known of a reference solution that was made and kept."""
    job = Job.of(name, table)
    start = time.perf_counter()
    way = Way.of(job)
    methods = library(job.scene.structure, way.long)
    *_, other, best = ladder(job, way, methods, QUICKLY if quick else SECONDS[way.implicit])
    measures = Measures(job, best.states)
    estimate = measures.errors(other.states)
    seconds = time.perf_counter() - start
    checked_by, off = check(job, way.implicit, measures)
    row: Row = {"method": way.words(methods.bits)}
    row |= {"order": way.order(best.columns), "tolerance": best.tolerance}
    row |= {key.replace("error_", "estimate_"): value for key, value in estimate.items()}
    row |= {"checked_by": checked_by, "check_phi": off, "rhs": best.counts["rhs"]}
    kept = Reference(best.states, measures.over_time(other.states), estimate)
    kept.save(folder, name, table)
    return row | {"seconds": seconds}


def units(cases: Sequence[Case], quick: bool, folder: str | Path) -> list[Unit]:
    """One for every scene; nothing of them is a measurement of time."""
    here = f"{__name__}:reference"
    return [
        Unit("references", f"references-{case.name}", here, arguments, timed=False, limit=180.0)
        for case, arguments in _arguments(cases, quick, folder)
    ]


def _arguments(
    cases: Sequence[Case], quick: bool, folder: str | Path
) -> Iterable[tuple[Case, dict[str, Any]]]:
    for case in cases:
        known = {"name": case.name, "table": case.scene, "folder": str(folder), "quick": quick}
        yield case, known


def _none(value: Any) -> float | None:
    return None if np.isnan(value) else float(value)
