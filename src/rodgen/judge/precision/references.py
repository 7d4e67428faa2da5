"""Reference solutions by extrapolation methods, a family that no contestant is of."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import rodgen
from rodgen.judge.cases import Case
from rodgen.judge.precision.contestant import Array
from rodgen.judge.precision.errors import Errors, Measures
from rodgen.judge.precision.extended import library
from rodgen.judge.precision.job import Job
from rodgen.judge.precision.ladder import Way, ladder
from rodgen.judge.precision.setup import setup
from rodgen.judge.unit import Row, Unit

SECONDS, QUICKLY = 18.0, 8.0  # of all solutions for a reference
CHECKS = {False: ("dop853", 1e-13), True: ("radau", 1e-10)}
MOST_CHECKED = 400_000  # steps of that run


@dataclass(frozen=True)
class Reference:
    """states: (samples, states); off: its estimated error over time [rad] (samples,); estimate:
    of all measures; setup: seconds of the scene's module by target and kind."""

    states: Array
    off: Array
    estimate: Errors
    setup: dict[str, float]

    @classmethod
    def load(cls, folder: str | Path, name: str) -> Reference:
        """From the folder of references. Raises FileNotFoundError with what is missing."""
        file = Path(folder) / f"{name}.npz"
        if not file.exists():
            raise FileNotFoundError(f"there is no reference solution of {name}")
        with np.load(file) as held:
            estimate = {k[9:]: _none(held[k]) for k in held.files if k.startswith("estimate_")}
            taken = {k[6:]: float(held[k]) for k in held.files if k.startswith("setup_")}
            return cls(held["states"], held["off"], estimate, taken)

    def save(self, folder: str | Path, name: str) -> None:
        """Into that folder."""
        Path(folder).mkdir(parents=True, exist_ok=True)
        numbers: dict[str, Any] = {
            f"estimate_{k}": np.nan if v is None else v for k, v in self.estimate.items()
        }
        numbers |= {f"setup_{k}": v for k, v in self.setup.items()}
        file = Path(folder) / f"{name}.npz"
        np.savez(file, states=self.states, off=self.off, **numbers)


def check(job: Job, implicit: bool, measures: Measures) -> tuple[str, float | None]:
    """What else it is compared with, and the largest difference of an angle at the end [rad]."""
    method, rtol = CHECKS[implicit]
    settings: dict[str, Any] = {"method": method, "rtol": rtol, "atol": rtol / 100}
    try:
        run = rodgen.simulate(job.scene, target="c", max_steps=MOST_CHECKED, **settings)
    except rodgen.RunError as error:
        return f"{method}, rtol {rtol:g}: {error}", None
    return f"{method}, rtol {rtol:g}", measures.errors(run.y)["error_phi"]


def reference(name: str, table: dict[str, Any], folder: str, quick: bool = False) -> list[Row]:
    """Make and keep the reference solution of a scene, with its own error estimate."""
    job = Job.of(name, table)
    taken = {f"c_{key}": value for key, value in setup(job.scene, "c").items()}
    taken |= {f"numpy_{key}": value for key, value in setup(job.scene, "numpy").items()}
    start = time.perf_counter()
    way = Way.of(job)
    methods = library(job.scene.structure, way.long)
    *_, other, best = ladder(job, way, methods, QUICKLY if quick else SECONDS)
    measures = Measures(job, best.states)
    estimate = measures.errors(other.states)
    seconds = time.perf_counter() - start
    Reference(best.states, measures.over_time(other.states), estimate, taken).save(folder, name)
    checked_by, off = check(job, way.implicit, measures)
    row: Row = {"scene": name, "n": job.model.N, "method": way.words(methods.bits)}
    row |= {"order": way.order(best.columns), "tolerance": best.tolerance}
    row |= {key.replace("error_", "estimate_"): value for key, value in estimate.items()}
    row |= {"checked_by": checked_by, "check_phi": off, "rhs": best.counts["rhs"]}
    return [row | {"seconds": seconds, "failed": ""}]


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
