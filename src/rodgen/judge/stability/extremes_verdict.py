"""What a run came to: right to so many digits, lost as it says itself, or wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodgen.integrate import Solution
from rodgen.judge.stability.extremes_case import KINDS, RATES, SPEEDS, Measure, Truth

RIGHT, STOPPED, REFUSED, WARNED, LOST, WRONG, UNFINISHED = (
    *("right", "stopped", "refused", "warned", "lost", "wrong", "unfinished"),
)
SLACK = 300.0  # errors of many steps, beside what a tolerance allows in one
HALF = 0.3  # no error above this share of the motion counts as right
SHRINKS = 0.8  # at least, the error of a fixed step when it is halved
ALARM = 1e3  # times the tolerance, from which an energy balance is alarming
LEAK = 1e-3  # of the largest exchange of energy, from which that of a fixed step is


@dataclass(frozen=True)
class Said:
    """A verdict, with the digits that it rests on and what the run said."""

    outcome: str
    digits: float | None = None
    said: str = ""


def of_adaptive(truth: Truth, solution: Solution) -> Said:
    """Errors, kind by kind, beside what the tolerance asks for; Gauss's method promises places
    and angles alone."""
    scene = solution.scene
    measure = Measure(scene, truth.y)
    errors, allowed = measure.errors(solution.y), measure.tolerated()
    if scene.integrate.method == "gauss" or truth.positions:
        errors = {kind: e for kind, e in errors.items() if kind not in (RATES, SPEEDS)}
    off = max(errors.values())
    how = f"{solution.stats.steps} steps by {scene.integrate.method}"
    excess = {
        kind: e / min(HALF, SLACK * truth.condition * allowed[kind] + 3 * truth.error)
        for kind, e in errors.items()
    }
    worst = max(excess, key=lambda kind: excess[kind])
    if excess[worst] <= 1:
        return Said(RIGHT, digits(off), how)
    text = f"{worst} off by {errors[worst]:.1e} of the motion; {how}"
    return Said(_unless_told(solution, errors[worst]), digits(off), text)


def of_fixed(truth: Truth, coarse: Solution, fine: Solution, warned: bool = False) -> Said:
    """Errors of a step and of half of it."""
    measure = Measure(coarse.scene, truth.y)
    kinds = [kind for kind in KINDS if not truth.positions or kind not in (RATES, SPEEDS)]
    a, b = (max(measure.errors(sol.y)[kind] for kind in kinds) for sol in (coarse, fine))
    floor = 3 * truth.error + SLACK * truth.condition * max(measure.tolerated().values())
    step = coarse.scene.integrate.step
    how = f"step {step:.3g} s: error {a:.1e} of the motion, half of it {b:.1e}"
    how += f"; energy balances to {balance(fine):.1e}"
    if b <= HALF and b <= max(SHRINKS * a, floor):
        return Said(RIGHT, digits(b), how)
    return Said(WARNED if warned else _unless_told(fine, b), digits(b), how)


def _unless_told(solution: Solution, off: float) -> str:
    """Wrong, unless its energy balance says how wrong it is."""
    share, settings = balance(solution), solution.scene.integrate
    least = LEAK if settings.fixed else max(0.1 * min(off, 1.0), ALARM * settings.rtol)
    return WRONG if share < least else LOST


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
