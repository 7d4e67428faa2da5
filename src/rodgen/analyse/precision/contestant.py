"""Contestants: settings of a method, rodgen's or another's, measured within a budget of seconds.

A family is one method's settings from loose to tight; every setting becomes a row of a table.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from rodgen.analyse.precision.job import MEASURES, Measures
from rodgen.arrays import Array as Array

COUNTS = ("nsteps", "rejected", "nfev", "njev", "nlu")  # of a run, as SciPy calls them
SETUP = ("generate", "compile")
SHORT, ROUNDS = 0.1, 3  # seconds of a run that is measured so often, and the median taken
LONGEST = 200  # letters of a reason
MOST_FACTOR = 4.0  # by which costs are expected to grow from one setting to the next
USELESS = 3  # settings in a row that fail alike before the rest is left out
# A line of a table: numbers, texts, None for what there is not, lists for curves. Infinite and
# not-a-number are kept as JSON of Python has them.
Value = str | float | int | bool | None | list[float]
Measurement = dict[str, Value]


class TooSlowError(RuntimeError):
    """A run that was stopped at the deadline."""


class NotModelledError(ValueError):
    """Refusal, not failure, of a peer that cannot model a scene, or not in any sensible time."""

    def __init__(self, why: str):
        super().__init__(f"not modelled: {why}")


class Deadline:
    """Time at which the current run is stopped, if it looks at the clock now and then."""

    at = np.inf  # on time.perf_counter()

    @classmethod
    def check(cls) -> None:
        """Raise TooSlowError after the deadline."""
        if time.perf_counter() > cls.at:
            raise TooSlowError("stopped, as it took too long")


@dataclass(frozen=True)
class RunResult:
    """Result of a run: y (samples, states) in rodgen's order at the job's sample times, and its
    counts, as far as they are known: nsteps, rejected, nfev, njev, nlu.

    balance: gives the largest error of the run's own energy balance [J]; called after the clock has
    been read.
    """

    y: Array
    counts: dict[str, int] = field(default_factory=dict)
    inside: float | None = None  # seconds that it counted itself, without the calls around it
    balance: Callable[[], float] | None = None


@dataclass(frozen=True)
class Contestant:
    """One integration by one method at one setting.

    setting: the step [s] or relative tolerance; kind: "step" or "rtol"; setup: seconds of
    generation or compilation before it, by what it consists of ("generate", "compile"); agreed: how
    far another's formulation is from ours in the rates, relative.
    """

    who: str  # "rodgen", "SciPy", "CVODE", "heyoka", ...
    method: str
    target: str  # what evaluates the equations: "c", "numpy", or the peer's own formulation
    kind: str
    setting: float
    integrate: Callable[[], RunResult]
    order: float | None = None  # nominal, where it has one
    setup: dict[str, float] = field(default_factory=dict)
    agreed: float | None = None


Family = Iterator[Contestant]  # one method's settings from loose to tight, each made when asked for


@dataclass(frozen=True)
class Limits:
    """Limits of time [s], of a run and of all of a family."""

    run: float
    family: float


@dataclass(frozen=True)
class Attempt:
    """Outcome of a setting. seconds: the median of the rounds, with the finish of that round;
    spent: on all of them."""

    seconds: float
    rounds: int
    spent: float
    finish: RunResult | None
    failed: str = ""
    slow: bool = False


def attempt(who: Contestant, limits: Limits) -> Attempt:
    """Run a setting once, or several times if that is short. Any exception is its failure."""
    ended: list[tuple[float, RunResult]] = []
    begun = time.perf_counter()
    for _ in range(ROUNDS):
        start = time.perf_counter()
        Deadline.at = start + limits.run
        try:
            finish = who.integrate()
        except Exception as error:  # another's library may fail in any way
            taken = time.perf_counter() - start
            slow = isinstance(error, TooSlowError)
            reason = f"stopped after {limits.run:g} s" if slow else describe_error(error)
            return Attempt(taken, len(ended) + 1, time.perf_counter() - begun, None, reason, slow)
        finally:
            Deadline.at = float("inf")
        ended.append((time.perf_counter() - start, finish))
        if ended[0][0] > SHORT:
            break
    spent = time.perf_counter() - begun
    # An odd number: the median is one of them, and what it counted goes with it.
    seconds, finish = sorted(ended, key=lambda one: one[0])[len(ended) // 2]
    return Attempt(seconds, len(ended), spent, finish)


def sweep(
    family: Family, label: Measurement, measures: Measures, limits: Limits
) -> list[Measurement]:
    """Measure every setting, from loose to tight, until the seconds are spent; return rows.

    label: scene, n, who, method, target, and setup of every row. Settings that fail are rows with
    the reason; those that are left out are one row with failed = "not tried: ...".
    """
    rows: list[Measurement] = []
    spent, before, failures = 0.0, 0.0, 0
    try:
        for who in family:
            tried = attempt(who, limits)
            rows.append(make_row(who, tried, label, measures))
            spent += tried.spent
            failures = failures + 1 if tried.finish is None else 0
            growth = min(MOST_FACTOR, max(1.0, tried.seconds / before)) if before else 2.0
            before = tried.seconds
            expected = tried.seconds * growth
            why = _stop_reason(tried, expected, spent, failures, limits)
            if why and (following := next(iter(family), None)) is not None:
                rows.append(skipped_row(following, label, why))
            if why:
                break
    except Exception as error:  # what makes settings may fail too
        rows.append(empty_row(label) | {"failed": describe_error(error)})
    return rows or [empty_row(label) | {"failed": "not tried: it has no settings"}]


def _stop_reason(
    tried: Attempt, expected: float, spent: float, failures: int, limits: Limits
) -> str:
    """Reason why tighter settings are not tried, or an empty text."""
    if tried.slow or expected > limits.run:
        return f"would take more than {limits.run:g} s"
    if spent + expected > limits.family:
        return f"the {limits.family:g} s of this method are spent"
    if failures >= USELESS and tried.seconds > limits.run / 10:
        return "failed so often before"
    return ""


def make_row(
    who: Contestant, tried: Attempt, label: Measurement, measures: Measures
) -> Measurement:
    row = empty_row(label) | {"kind": who.kind, "setting": who.setting, "order": who.order}
    row |= {"agreed": who.agreed, "failed": tried.failed}
    row |= {f"setup_{kind}": seconds for kind, seconds in who.setup.items() if kind in SETUP}
    row |= {"seconds": tried.seconds, "rounds": tried.rounds}
    if tried.finish is None:
        return row
    row["inside"] = tried.finish.inside
    row |= {name: tried.finish.counts.get(name) for name in COUNTS}
    try:
        errors = measures.errors(tried.finish.y)
        balance = tried.finish.balance
        row["balance"] = balance() / measures.energy_scale if balance else None
    except Exception as error:  # a peer's states may have the wrong shape
        return row | {"failed": f"its states cannot be compared: {describe_error(error)}"}
    return row | dict(errors)


def skipped_row(who: Contestant, label: Measurement, why: str) -> Measurement:
    row = empty_row(label) | {"kind": who.kind, "setting": who.setting, "order": who.order}
    return row | {"failed": f"not tried: {why}, from {who.kind} {who.setting:.3g} on"}


def empty_row(label: Measurement) -> Measurement:
    """Row of all columns, filled with what is known of a family."""
    nothing = ("kind", "setting", "order", "seconds", "inside", *MEASURES, "balance", *COUNTS)
    row: Measurement = dict.fromkeys((*nothing, *(f"setup_{kind}" for kind in SETUP), "agreed"))
    return row | {"rounds": 0, "failed": ""} | label


def describe_error(error: BaseException | str) -> str:
    return " ".join(str(error).split())[:LONGEST] or repr(error)


def sweep_methods(
    family: Iterable[Contestant], known: Measurement, measures: Measures, limits: Limits
) -> list[Measurement]:
    """Measure settings of several methods in a row, each method within limits of its own."""
    rows: list[Measurement] = []
    for (who, method, target, _), settings in groupby(family, _family_key):
        one = known | {"who": who, "method": method, "target": target}
        rows += sweep(settings, one, measures, limits)
    return rows or [empty_row(known) | {"failed": "not tried: it has no settings"}]


def _family_key(one: Contestant) -> tuple[str, str, str, str]:
    return one.who, one.method, one.target, one.kind
