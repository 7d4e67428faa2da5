"""From loose to tight: tolerances, and steps that part the time between samples."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, inf

from rodgen.integrate.spectrum import Dominant, spectrum
from rodgen.judge.precision.job import SAMPLES, Job

LOOSEST, TIGHTEST = 2, 12  # negative powers of ten
SHARE = 0.01  # absolute tolerance over the relative one, as a scene of rodgen has it by default
HALVINGS = 14  # of a step, at most


def tolerances(quick: bool, tightest: int = TIGHTEST) -> Iterator[float]:
    """Relative ones, two a decade; one a decade in short."""
    each = 2 if quick else 1
    for half in range(2 * LOOSEST, 2 * tightest + 1, each):
        yield 10.0 ** (-half / 2)


def steps(job: Job, limit: float, quick: bool) -> Iterator[float]:
    """Steps [s] of which a whole number is the time between samples, from the limit down.

    limit: the longest that is stable [s], which may be infinite; each is half of the one before.
    """
    first, last = job.span
    between = (last - first) / SAMPLES
    count = max(1, ceil(between / limit))
    for halving in range(0, HALVINGS, 2 if quick else 1):
        yield between / (count * 2**halving)


def stable(limit: float, rate: float) -> float:
    """The longest stable step [s]: limit over |lambda| [1/s]; infinite where nothing moves."""
    return limit / rate if rate > 0 else inf


def fastest(job: Job) -> Dominant:
    """The fastest motion at the start."""
    first, _ = job.stretches[0]
    return spectrum(job.model, first, job.start, job.p)
