"""Runs of extreme cases, and what is said of each of them."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

import rodgen
from rodgen.analyse.precision.contestant import Measurement
from rodgen.errors import InputError
from rodgen.integrate import Interrupted, RunError, Solution
from rodgen.integrate.stability import dominant, step_limit
from rodgen.integrate.stepper import StepError
from rodgen.model.methods import FIXED_STEP
from rodgen_evidence.report.stability.extremes_case import (
    EPS,
    KINDS,
    RATES,
    SPEEDS,
    ExtremeCase,
    Measure,
    TrueMotion,
)

RIGHT, STOPPED, REFUSED, WARNED, LOST, WRONG, UNFINISHED, UNSEEN = (
    *("right", "stopped", "refused", "warned", "lost", "wrong", "unfinished", "unseen"),
)
SLACK = 30.0  # errors of many steps, beside what a tolerance allows in one
# LSODA controls the root mean square of what a step adds, to the tolerance and no better: over
# thousands of steps of a steady motion this adds up, in one direction.
SLACK_OF = {"lsoda": 1000.0}
CAP, LOOSE = 0.03, 3.0  # of the motion, and of the relative tolerance: no more is allowed by it
HALF = 0.3  # no error above this share of the motion counts as right, whatever its excuse
TWO_DIGITS = 1e-2  # what the step of a fixed-step method has to reach
SHRINKS = 0.8  # at least, the error of a fixed step when it is halved
ALARM = 1e3  # times the tolerance, from which an energy balance is alarming
LEAK = 1e-3  # of the largest exchange of energy, from which that of a fixed step is
TOLD = 0.1  # of the error: what a balance has to show of it, to say how wrong a run is
NOISE = 1e-12  # of the largest energy: a balance that is off by less shows rounding alone


@dataclass(frozen=True)
class Said:
    """A verdict, with the digits that it rests on, what the run said and the error allowed."""

    outcome: str
    digits: float | None = None
    said: str = ""
    allowed: float | None = None


def of_adaptive(truth: TrueMotion, solution: Solution, warned: bool = False) -> Said:
    """Errors, kind by kind, beside what the tolerance asks for.

    Gauss's method promises places and angles alone, at every step: an error that a kink makes in
    the rates it does not see, and it goes on to move what follows by up to a tolerance a step.
    """
    scene = solution.scene
    measure = Measure(scene, truth.y)
    errors, asked = measure.errors(solution.y), measure.allowances()
    if scene.integrate.method == "gauss" or truth.positions:
        errors = {kind: e for kind, e in errors.items() if kind not in (RATES, SPEEDS)}
    off = max(errors.values())
    how = f"{solution.stats.nsteps} steps by {scene.integrate.method}"
    most = max(CAP, LOOSE * scene.integrate.rtol)
    # At worst, the rounding of all steps goes in one direction.
    unavoidable = _unavoidable(truth, measure, max(SLACK, solution.stats.nsteps / 4))
    slack = SLACK_OF.get(scene.integrate.method or "", SLACK)
    if scene.integrate.method == "gauss":
        slack = max(slack, solution.stats.nsteps)
    allowed = {
        kind: min(HALF, min(slack * truth.condition * asked[kind], most) + unavoidable[kind])
        for kind in errors
    }
    worst = max(errors, key=lambda kind: errors[kind] / allowed[kind])
    if errors[worst] <= allowed[worst]:
        return Said(RIGHT, digits(off), how, allowed[worst])
    text = f"{worst} off by {errors[worst]:.1e} of the motion, {allowed[worst]:.1e} allowed; {how}"
    outcome = WARNED if warned else _unless_told(solution, errors[worst])
    return Said(outcome, digits(off), text, allowed[worst])


def judge_fixed_step(
    truth: TrueMotion, coarse: Solution, fine: Solution, warned: bool = False
) -> Said:
    """Judge the error of a step, which a finer one must make less, down to rounding.

    A fixed step has no error estimate: where the energy balance does not show the error either,
    it is unseen. Errors as large as the motion have no room to become less.
    """
    measure = Measure(coarse.scene, truth.y)
    kinds = [kind for kind in KINDS if not truth.positions or kind not in (RATES, SPEEDS)]
    a, b = (max(measure.errors(sol.y)[kind] for kind in kinds) for sol in (coarse, fine))
    allowed = min(HALF, TWO_DIGITS + max(_unavoidable(truth, measure).values()))
    floor = max(_unavoidable(truth, measure, max(SLACK, fine.stats.nsteps / 4)).values())
    how = f"step {coarse.scene.integrate.step:.3g} s: error {a:.1e} of the motion, "
    how += f"{fine.scene.integrate.step:.3g} s: {b:.1e}; energy balances to {balance(coarse):.1e}"
    converges = b <= max(SHRINKS * a, floor)
    if a <= allowed and converges:
        return Said(RIGHT, digits(a), how, allowed)
    outcome = WARNED if warned else _unless_told(coarse, a)
    if outcome == WRONG and (converges or b > HALF):
        outcome = UNSEEN
        how = f"a fixed step has no error estimate; {how}"
    return Said(outcome, digits(a), how, allowed)


def _unavoidable(truth: TrueMotion, measure: Measure, slack: float = SLACK) -> dict[str, float]:
    """Errors of the truth and of rounding, which no method can help."""
    rounding = measure.rounding()
    return {
        kind: 3 * truth.error + slack * truth.condition * (rounding[kind] + EPS) for kind in KINDS
    }


def _unless_told(solution: Solution, off: float) -> str:
    """Wrong, unless its energy balance says how wrong it is."""
    share, settings = balance(solution), solution.scene.integrate
    alarming = LEAK if settings.has_fixed_step else ALARM * settings.rtol
    least = max(TOLD * min(off, 1.0), alarming)
    with np.errstate(all="ignore"):
        largest = max(float(np.abs(part).max(initial=0.0)) for part in solution.energy)
    told = share >= least and not solution.energy_error <= NOISE * largest
    return LOST if told else WRONG


def balance(solution: Solution) -> float:
    """The error of the energy balance over the largest exchange, as the summary has it."""
    with np.errstate(all="ignore"):
        moved = [np.ptp(part) for part in solution.energy]
        moved += [np.ptp(work) for work in solution.work.values()]
        scale = float(max(moved))
        return solution.energy_error / scale if scale > 0 else 0.0


def digits(off: float) -> float:
    """Number of decimal digits that are right, at most 16."""
    return round(float(-np.log10(max(off, 1e-16))), 1) if np.isfinite(off) else 0.0


# Who: method and target.
ALL = (
    *(("euler", "c"), ("semi_implicit_euler", "c"), ("rk4", "c"), ("thesis_runge_kutta", "c")),
    *(("dop853", "c"), ("gauss", "c"), ("radau", "c"), ("lsoda", "c"), ("auto", "c")),
    *(("dop853", "numpy"), ("radau", "numpy"), ("rk4", "numpy")),
)
STEPS = {"c": 20_000, "numpy": 1000}  # of fixed length, in a span
LEAST = {"c": 4000, "numpy": 200}
PATIENCE = {"c": 2.0, "numpy": 1.0}  # seconds of a run
TIGHTEST = 1e-6  # the tightest relative tolerance of an implicit method on dense matrices


def judge(case: ExtremeCase, group: str = "", quick: bool = False) -> list[Measurement]:
    """A row for every contestant, of the short report or of the long one."""
    truth, rows = case.truth(case.scene), []
    for method, target in contestants(case, quick):
        start = time.perf_counter()
        said = verdict(case, truth, method, target)
        rows.append(row((group, case.name, case.scene.rod.links), said, truth, method, target))
        rows[-1]["seconds"] = time.perf_counter() - start
    return rows


def row(
    case: tuple[str, str, int], said: Said, truth: TrueMotion, method: str, target: str
) -> Measurement:
    """Row of a method on a case, which is given by its group, name and links."""
    group, name, links = case
    return {
        "group": group,
        "case": name,
        "n": links,
        "target": target,
        "method": method,
        "outcome": said.outcome,
        "digits": said.digits,
        "condition": truth.condition,
        "allowed": said.allowed,
        "truth_error": truth.error,
        "seconds": 0.0,
        "said": said.said,
        "truth": truth.by,
    }


def contestants(case: ExtremeCase, quick: bool = False) -> list[tuple[str, str]]:
    """Methods and targets that are tried on a case."""
    asked = (case.few if quick else ()) or case.who
    return [who for who in ALL if not asked or f"{who[0]} {who[1]}" in asked]


def verdict(
    case: ExtremeCase, truth: TrueMotion, method: str, target: str, model: ModuleType | None = None
) -> Said:
    """Judge one run, or two where the step is fixed: half the step must have less error.

    At a kink of the rates the error depends on where in a step it lies, and may grow by chance:
    an eighth of the step must then have less.
    """
    model = model or rodgen.build(case.scene, target)
    settings: dict[str, Any] = {"method": method}
    if target == "numpy" and method == "radau":
        settings["rtol"] = max(TIGHTEST, case.scene.integrate.rtol)
        settings["atol"] = max(TIGHTEST * 1e-2, case.scene.integrate.atol)
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
        said = judge_fixed_step(truth, coarse[0], fine[0], warned=coarse[1])
        if said.outcome != WRONG:
            break
    return said


def fixed_step(case: ExtremeCase, model: ModuleType, method: str, target: str) -> float:
    """A fifth of the stable step, if so many are not too many."""
    scene = case.scene
    first, last = scene.integrate.span
    count = STEPS[target] * 5 // max(5, scene.rod.links)
    p = model.parameters(**scene.parameters)
    try:
        with np.errstate(all="ignore"):
            fastest = dominant(model, first + 1e-9 * (last - first), scene.initial_state(), p)
    except (StepError, np.linalg.LinAlgError):
        return (last - first) / 100
    stable = step_limit("rk4" if method == "euler" else method, fastest.value, fastest.partner)
    return float(max((last - first) / count, min(stable / 10, (last - first) / LEAST[target])))


def _run(
    case: ExtremeCase, model: ModuleType, settings: dict[str, Any]
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
    except InputError as error:
        return Said(REFUSED, said=str(error))
    except Interrupted as error:
        return Said(UNFINISHED, said=f"{most:g} s were not enough; {error}")
    except RunError as error:
        if "budget" in str(error):
            return Said(UNFINISHED, said=str(error))
        return Said(STOPPED, said="; ".join([str(error), *_doubts(heard)]))
    return solution, bool(_doubts(heard))


def _doubts(heard: list[warnings.WarningMessage]) -> list[str]:
    """Doubts about a run before its first step; of angles of many turns, which a case may be about,
    none."""
    doubts = [one.message for one in heard if isinstance(one.message, rodgen.DoubtWarning)]
    return [str(doubt) for doubt in doubts if "turns" not in doubt.figures]


def _adaptive(
    case: ExtremeCase, truth: TrueMotion, model: ModuleType, settings: dict[str, Any]
) -> Said:
    found = _run(case, model, settings)
    return found if isinstance(found, Said) else of_adaptive(truth, *found)
