"""What a run came to: right to so many digits, lost as it says itself, or wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodgen.integrate import Solution
from rodgen.judge.stability.extremes_case import EPS, KINDS, RATES, SPEEDS, Measure, Truth

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


def of_adaptive(truth: Truth, solution: Solution, warned: bool = False) -> Said:
    """Errors, kind by kind, beside what the tolerance asks for; Gauss's method promises places
    and angles alone."""
    scene = solution.scene
    measure = Measure(scene, truth.y)
    errors, asked = measure.errors(solution.y), measure.tolerated()
    if scene.integrate.method == "gauss" or truth.positions:
        errors = {kind: e for kind, e in errors.items() if kind not in (RATES, SPEEDS)}
    off = max(errors.values())
    how = f"{solution.stats.steps} steps by {scene.integrate.method}"
    most = max(CAP, LOOSE * scene.integrate.rtol)
    # At worst, the rounding of all steps goes in one direction.
    unavoidable = _unavoidable(truth, measure, max(SLACK, solution.stats.steps / 4))
    slack = SLACK_OF.get(scene.integrate.method or "", SLACK)
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


def of_fixed(truth: Truth, coarse: Solution, fine: Solution, warned: bool = False) -> Said:
    """The error of a step, which a finer one must make less, down to rounding.

    A fixed step has no error estimate: where the energy balance does not show the error either,
    it is unseen. Errors as large as the motion have no room to become less.
    """
    measure = Measure(coarse.scene, truth.y)
    kinds = [kind for kind in KINDS if not truth.positions or kind not in (RATES, SPEEDS)]
    a, b = (max(measure.errors(sol.y)[kind] for kind in kinds) for sol in (coarse, fine))
    allowed = min(HALF, TWO_DIGITS + max(_unavoidable(truth, measure).values()))
    floor = max(_unavoidable(truth, measure, max(SLACK, fine.stats.steps / 4)).values())
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


def _unavoidable(truth: Truth, measure: Measure, slack: float = SLACK) -> dict[str, float]:
    """Errors of the truth and of rounding, which no method can help."""
    rounding = measure.rounding()
    return {
        kind: 3 * truth.error + slack * truth.condition * (rounding[kind] + EPS) for kind in KINDS
    }


def _unless_told(solution: Solution, off: float) -> str:
    """Wrong, unless its energy balance says how wrong it is."""
    share, settings = balance(solution), solution.scene.integrate
    alarming = LEAK if settings.fixed else ALARM * settings.rtol
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
    """How many decimal digits are right, of at most 16."""
    return round(float(-np.log10(max(off, 1e-16))), 1) if np.isfinite(off) else 0.0
