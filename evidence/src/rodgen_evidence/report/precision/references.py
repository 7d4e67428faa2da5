"""Reference solutions of the report's scenes, made once and kept in files."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rodgen.analyse.precision.contestant import Measurement, describe_error
from rodgen.analyse.precision.job import MEASURES, Job
from rodgen.analyse.precision.work_precision import Reference, compute_reference
from rodgen.scene import Scene
from rodgen_evidence.report.cases import Case
from rodgen_evidence.report.unit import Unit

SECONDS, QUICKLY = 40.0, 4.0  # of all solutions for a reference
NO_REFERENCE = "no reference: "  # how reasons begin where there is none

COLUMNS = (
    *("method", "order", "tolerance"),
    *(name.replace("error_", "estimate_") for name in MEASURES),
    *("checked_by", "check_phi", "nfev", "events"),
)


class NoReferenceError(RuntimeError):
    """There is no reference solution of a scene."""


def load(folder: str | Path, name: str, table: dict[str, Any]) -> Reference:
    """Load from the folder of references. Raises NoReferenceError with why there is none."""
    file, why = Path(folder) / f"{name}.npz", Path(folder) / f"{name}.txt"
    if why.exists():
        raise NoReferenceError(why.read_text(encoding="utf-8"))
    if not file.exists():
        raise NoReferenceError(f"there is no reference solution of {name}")
    with np.load(file) as held:
        if "scene" not in held.files or str(held["scene"]) != fingerprint(table):
            raise NoReferenceError(f"the reference of {name} is of another scene")
        estimate, method = json.loads(str(held["estimate"])), str(held["method"])
        return Reference(held["states"], held["other"], held["off"], estimate, method)


def save(kept: Reference, folder: str | Path, name: str, table: dict[str, Any]) -> None:
    """Save a reference into a folder, for a scene."""
    np.savez(
        Path(folder) / f"{name}.npz",
        scene=fingerprint(table),
        method=kept.method,
        estimate=json.dumps(kept.estimate),
        states=kept.states,
        other=kept.other,
        off=kept.off,
    )


def fingerprint(table: dict[str, Any]) -> str:
    """Hash of a scene's tables."""
    return hashlib.sha256(json.dumps(table, sort_keys=True).encode()).hexdigest()


def measure(
    name: str, table: dict[str, Any], folder: str, quick: bool = False
) -> list[Measurement]:
    """Make and keep the reference solution of a scene, with its own error estimate.

    Where none can be made, the row and a file beside where it would be say why.
    """
    file, reason = Path(folder) / f"{name}.npz", Path(folder) / f"{name}.txt"
    Path(folder).mkdir(parents=True, exist_ok=True)
    for old in (file, reason):
        old.unlink(missing_ok=True)
    start = time.perf_counter()
    row: Measurement = {"scene": name, "n": table["rod"]["links"], **dict.fromkeys(COLUMNS)}
    row["events"] = len(table.get("events", ()))  # that no run of the report stops at
    try:
        row |= _made(name, table, folder, quick)
    except Exception as error:  # a scene of a user may fail in any way
        row["failed"] = describe_error(error)
        reason.write_text(describe_error(error), encoding="utf-8")
        file.unlink(missing_ok=True)
        return [row | {"seconds": time.perf_counter() - start}]
    return [row | {"failed": ""}]


def _made(name: str, table: dict[str, Any], folder: str, quick: bool) -> Measurement:
    """Make and keep a reference solution; return the entries of its row."""
    job = Job.of(name, Scene.from_dict(table))
    start = time.perf_counter()
    kept = compute_reference(job, QUICKLY if quick else SECONDS)
    seconds = time.perf_counter() - start
    row: Measurement = {"method": kept.method, "order": kept.order, "tolerance": kept.tolerance}
    row |= {key.replace("error_", "estimate_"): value for key, value in kept.estimate.items()}
    row |= {"checked_by": kept.checked_by, "check_phi": kept.estimate["error_phi"]}
    row |= {"nfev": kept.nfev}
    save(kept, folder, name, table)
    return row | {"seconds": seconds}


def units(cases: Sequence[Case], quick: bool, folder: str | Path, *_: object) -> list[Unit]:
    """One for every scene; nothing of them is a measurement of time."""
    here = f"{__name__}:measure"
    return [
        Unit(
            *("references", f"references-{case.name}", here, case.given(folder, quick=quick)),
            timed=False,
            limit=180.0,
        )
        for case in cases
    ]
