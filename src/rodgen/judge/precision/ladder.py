"""Solutions of rising accuracy by extrapolation methods."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from rodgen.integrate.spectrum import spectrum
from rodgen.judge.precision.contestant import Array, TooSlowError
from rodgen.judge.precision.extended import Library
from rodgen.judge.precision.job import Job

STIFF, DAMPED = 2e4, 0.3  # |lambda| times the span, and damping ratio, from which on it is implicit
LONG_UP_TO = {False: 100, True: 200}  # links up to which numbers are long doubles; implicit
# Columns and tolerance of a step, one after the other while there is time: neighbours differ in
# order, and the last two are compared. Of what rounding leaves of the digits.
RUNGS = {
    (False, True): ((8, 1e-14), (10, 1e-16), (8, 1e-17)),
    (False, False): ((8, 1e-12), (10, 1e-13), (8, 1e-13)),
    (True, True): ((10, 1e-10), (12, 1e-11), (10, 1e-12), (9, 1e-12)),
    (True, False): ((8, 1e-7), (10, 1e-8), (8, 1e-8), (7, 1e-9)),
}
MOST_FACTOR = 3.0  # more steps than the one before: rounding errors are what it follows
LOOSEST = 1e-7  # tolerance, beyond which nothing is tried
FIRST, SECOND = 30.0, 60.0  # seconds of processor time up to which there is such a solution
NUDGE = 8  # units in the last place that loads are asked for inside a stretch, as in every run


@dataclass(frozen=True)
class Rung:
    """One solution of several."""

    columns: int
    tolerance: float
    states: Array
    counts: dict[str, int]


@dataclass(frozen=True)
class Way:
    """How a job is integrated: by which of both methods, in what numbers, from which step on."""

    implicit: bool
    long: bool
    rate: float
    first: float
    drag: bool  # rates have kinks, where loose tolerances are of no use

    @classmethod
    def of(cls, job: Job) -> Way:
        """By its fastest motion at the start."""
        fastest = spectrum(job.model, job.span[0], job.start, job.p)
        span = job.span[1] - job.span[0]
        implicit = fastest.rate * span > STIFF and fastest.damping > DAMPED
        long = LONG_UP_TO[implicit] >= job.model.N
        first = min(1 / max(fastest.rate, 1e-9), float(job.times[1] - job.times[0]))
        drag = "external_damping" in job.model.TERMS
        return cls(implicit, long, fastest.rate, first, drag)

    def words(self, bits: int) -> str:
        """The method, and the numbers that it is computed with."""
        method = "linearly implicit Euler method" if self.implicit else "midpoint rule"
        return f"{method}, extrapolated, in numbers of {bits} bits"

    def order(self, columns: int) -> int:
        """With so many columns."""
        return columns if self.implicit else 2 * columns


def ladder(job: Job, way: Way, methods: Library, seconds: float) -> list[Rung]:
    """Solutions of rising accuracy, at least two; as long as rounding and the time allow.

    Raises TooSlowError where there are not two in time, ArithmeticError where rounding or rates
    that are not finite leave less than two.
    """
    times, inside = stops(job)
    samples = np.searchsorted(times, job.times)
    weights = np.ones(len(job.start))
    # An error of the fastest motion is |lambda| times larger in rates than in angles.
    if not way.implicit:
        weights[len(weights) // 2 :] = max(1.0, way.rate**0.5)
    found: list[Rung] = []
    start, last = time.process_time(), 0.0
    most = 10**8
    waiting = list(RUNGS[way.implicit, way.long][way.drag :])
    while waiting:
        columns, tolerance = waiting.pop(0)
        begun = time.process_time()
        if len(found) > 1 and begun - start + last > seconds:
            break
        try:
            how = (way.implicit, columns, tolerance, way.first)
            given = (job.p, weights, job.start)
            left = (SECOND if found else FIRST) - (begun - start)
            states, counts = methods.extrapolate(*how, *given, times, inside, most, left)
        except TooSlowError:
            if len(found) > 1:
                break
            raise
        except ArithmeticError:
            if len(found) > 1:
                break
            if tolerance > LOOSEST:
                raise
            waiting.insert(0, (columns, 10 * tolerance))  # less than rounding allows
            continue
        found.append(Rung(columns, tolerance, states[samples], counts))
        last = time.process_time() - begun
        most = 100 + int(MOST_FACTOR * counts["steps"])
    return found


def stops(job: Job) -> tuple[Array, tuple[Array, Array]]:
    """Samples and break points, and between which times loads are asked for before each."""
    breaks = np.array([job.span[0], *(end for _, end in job.stretches)])
    times = np.unique(np.concatenate((job.times, breaks)))
    stretch = np.clip(np.searchsorted(breaks, times) - 1, 0, None)
    low, high = breaks[stretch], breaks[stretch + 1]
    return times, (low + NUDGE * np.spacing(np.abs(low)), high - NUDGE * np.spacing(np.abs(high)))
