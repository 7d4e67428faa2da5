"""A case by every method and target: run, and judged."""

from __future__ import annotations

import time
import warnings
from types import ModuleType
from typing import Any

import numpy as np

import rodgen
from rodgen.integrate import Interrupted, RunError, Solution, StepWarning
from rodgen.integrate.spectrum import spectrum
from rodgen.integrate.stability import limit
from rodgen.integrate.stepper import StepError
from rodgen.judge.stability.extremes_case import Extreme, Truth
from rodgen.judge.stability.extremes_verdict import (
    REFUSED,
    STOPPED,
    UNFINISHED,
    WRONG,
    Said,
    of_adaptive,
    of_fixed,
)
from rodgen.judge.unit import Row
from rodgen.scene import SceneError
from rodgen.scene.tables import FIXED_STEP

# Who: method and target.
ALL = (
    *(("euler", "c"), ("semi_implicit_euler", "c"), ("rk4", "c"), ("thesis_runge_kutta", "c")),
    *(("dop853", "c"), ("gauss", "c"), ("radau", "c"), ("lsoda", "c"), ("auto", "c")),
    *(("dop853", "numpy"), ("radau", "numpy"), ("rk4", "numpy")),
)
STEPS = {"c": 20_000, "numpy": 1000}  # of fixed length, in a span
LEAST = {"c": 4000, "numpy": 200}
PATIENCE = {"c": 2.0, "numpy": 1.0}  # seconds of a run
LOOSE = 1e-6  # the tightest relative tolerance of an implicit method on dense matrices


def judge(case: Extreme, quick: bool = False) -> list[Row]:
    """A row for every contestant, of the short report or of the long one."""
    truth = case.truth(case.scene)
    return [row(case, truth, *who) for who in contestants(case, quick)]


def contestants(case: Extreme, quick: bool = False) -> list[tuple[str, str]]:
    """Those of the case."""
    asked = (case.few if quick else ()) or case.who
    return [who for who in ALL if not asked or f"{who[0]} {who[1]}" in asked]


def row(case: Extreme, truth: Truth, method: str, target: str) -> Row:
    """Run a method on a case; what happened."""
    start = time.perf_counter()
    said = verdict(case, truth, method, target)
    return {
        "group": case.group,
        "case": case.name,
        "n": case.scene.rod.links,
        "target": target,
        "method": method,
        "outcome": said.outcome,
        "digits": said.digits,
        "condition": truth.condition,
        "allowed": said.allowed,
        "truth_error": truth.error,
        "seconds": time.perf_counter() - start,
        "said": said.said,
        "truth": truth.by,
    }


def verdict(
    case: Extreme, truth: Truth, method: str, target: str, model: ModuleType | None = None
) -> Said:
    """Of one run, or of two where the step is fixed: half the step must have less error.

    At a kink of the rates the error depends on where in a step it lies, and may grow by chance:
    an eighth of the step must then have less.
    """
    model = model or rodgen.build(case.scene, target)
    settings: dict[str, Any] = {"method": method}
    if target == "numpy" and method == "radau":
        settings["rtol"] = max(LOOSE, case.scene.integrate.rtol)
        settings["atol"] = max(LOOSE * 1e-2, case.scene.integrate.atol)
    if method not in FIXED_STEP:
        return _adaptive(case, truth, model, settings)
    step = fixed_step(case, model, method, target)
    coarse = _run(case, model, {**settings, "step": step})
    if isinstance(coarse, Said):
        return coarse
    said = Said(WRONG)
    for part in (2, 8):
        fine = _run(case, model, {**settings, "step": step / part})
        if isinstance(fine, Said):
            return said if part > 2 else fine
        said = of_fixed(truth, coarse[0], fine[0], warned=coarse[1])
        if said.outcome != WRONG:
            break
    return said


def fixed_step(case: Extreme, model: ModuleType, method: str, target: str) -> float:
    """A fifth of the stable step, if so many are not too many."""
    scene = case.scene
    first, last = scene.integrate.span
    count = STEPS[target] * 5 // max(5, scene.rod.links)
    p = model.parameters(**scene.parameters)
    try:
        with np.errstate(all="ignore"):
            fastest = spectrum(model, first + 1e-9 * (last - first), scene.initial_state(), p)
    except (StepError, np.linalg.LinAlgError):
        return (last - first) / 100
    stable = limit("rk4" if method == "euler" else method, fastest.value, fastest.partner)
    return float(max((last - first) / count, min(stable / 10, (last - first) / LEAST[target])))


def _run(
    case: Extreme, model: ModuleType, settings: dict[str, Any]
) -> tuple[Solution, bool] | Said:
    """The solution, and whether it was warned of before."""
    most = PATIENCE[model.PROVENANCE["target"]]
    end = time.perf_counter() + most

    def look(_: float) -> None:
        if time.perf_counter() > end:
            raise KeyboardInterrupt

    try:
        with warnings.catch_warnings(record=True) as heard, np.errstate(all="ignore"):
            warnings.simplefilter("always")
            solution = rodgen.simulate(case.scene, model=model, progress=look, **settings)
    except SceneError as error:
        return Said(REFUSED, said=str(error))
    except Interrupted as error:
        return Said(UNFINISHED, said=f"{most:g} s were not enough; {error}")
    except RunError as error:
        if "budget" in str(error):
            return Said(UNFINISHED, said=str(error))
        warned = [str(one.message) for one in heard if issubclass(one.category, StepWarning)]
        return Said(STOPPED, said="; ".join([str(error), *warned]))
    return solution, any(issubclass(one.category, StepWarning) for one in heard)


def _adaptive(case: Extreme, truth: Truth, model: ModuleType, settings: dict[str, Any]) -> Said:
    found = _run(case, model, settings)
    return found if isinstance(found, Said) else of_adaptive(truth, *found)
