"""Contestants at equal error: the cheapest setting of each, then their times in turns."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from textwrap import shorten

import numpy as np
from integrate_jobs import Job
from problem import Vector

PATIENCE = 120.0  # seconds of a run or of all of a method's, after which no more are tried
HOPELESS = 4.0  # or this many times the cheapest found so far
LONGEST = 200  # letters of a reason
ROUNDS, ENOUGH = 5, 60.0  # runs of each; fewer where they would take more seconds than that


class TooSlowError(RuntimeError):
    """A run that was stopped at the deadline."""


class Deadline:
    """When the run that is on its way is stopped: what can look at it now and then, does."""

    at = np.inf  # on time.perf_counter()

    @classmethod
    def look(cls) -> None:
        """Raise TooSlowError where it is over."""
        if time.perf_counter() > cls.at:
            raise TooSlowError("stopped, as it took too long")


@dataclass(frozen=True)
class Finish:
    """What a run came to: the state at the end, its cost, the seconds that it counted."""

    y: Vector
    counts: str = ""
    inside: float | None = None


@dataclass(frozen=True)
class Contestant:
    """One setting of a method: a whole integration; setup: seconds of compilation before it."""

    label: str
    integrate: Callable[[], Finish]
    setup: float = 0.0


Family = Iterable[Contestant]  # from loose to tight; each made when it is come to


@dataclass(frozen=True)
class Tried:
    """A contestant with its error and the seconds of one run."""

    who: Contestant
    error: float
    seconds: float
    finish: Finish | None
    why: str = ""  # it failed


def attempt(who: Contestant, job: Job, limit: float) -> Tried:
    """One run, of so many seconds; of one that fails the error is infinite."""
    start = time.perf_counter()
    Deadline.at = start + limit
    try:
        finish = who.integrate()
    except Exception as error:  # another's library may fail in any way
        taken = time.perf_counter() - start
        return Tried(who, np.inf, taken, None, (str(error).splitlines() or [repr(error)])[0])
    finally:
        Deadline.at = np.inf
    taken = time.perf_counter() - start
    return Tried(who, job.error(finish.y), taken, finish)


def tries(
    family: Family, job: Job, asked: float, limit: float, patience: float = PATIENCE
) -> list[Tried]:
    """Settings from loose to tight, until two in a row are good enough and costs grow.

    limit: seconds of a run after which tighter ones are not tried; patience: of all.
    """
    found: list[Tried] = []
    for who in family:
        found.append(attempt(who, job, limit))
        last = found[-1]
        if last.seconds > limit or sum(one.seconds for one in found) > patience:
            break
        good = [one.error <= asked for one in found[-2:]]
        if good == [True, True] and last.seconds > found[-2].seconds:
            break
    return found


def cheapest(found: list[Tried], asked: float) -> Tried | None:
    """The fastest within the error, with the next tighter within it too: not by luck."""
    steady = [
        one
        for one, tighter in zip(found, [*found[1:], None], strict=True)
        if one.error <= asked and (tighter is None or tighter.error <= asked)
    ]
    return min(steady, key=lambda one: one.seconds, default=None)


def best(
    families: Mapping[str, Family], job: Job, asked: float, patience: float = PATIENCE
) -> tuple[Tried | None, str]:
    """The cheapest of several methods; or None, and why there is none."""
    winner: Tried | None = None
    reasons = []
    for name, family in families.items():
        limit = min(patience, HOPELESS * winner.seconds + 0.1) if winner else patience
        try:
            found = tries(family, job, asked, limit, patience)
        except Exception as error:  # what makes its settings may fail too, or is not installed
            reasons.append(f"{name}: {(str(error).splitlines() or [repr(error)])[0]}")
            continue
        one = cheapest(found, asked)
        if one is None:
            least = min((t.error for t in found), default=np.inf)
            why = next((t.why for t in found if t.why), "")
            reasons.append(f"{name}: error {least:.1e} at best{f' ({why})' if why else ''}")
        elif winner is None or one.seconds < winner.seconds:
            winner = one
    return winner, shorten("; ".join(reasons), LONGEST)


Seconds = dict[str, list[float]]


def in_turns(contestants: Mapping[str, Contestant], expected: float) -> tuple[Seconds, Seconds]:
    """Seconds of every contestant in every round, and those that it counted itself.

    expected: seconds of one round.
    """
    rounds = int(np.clip(ENOUGH / max(expected, 1e-9), 1, ROUNDS))
    times: Seconds = {name: [] for name in contestants}
    insides: Seconds = {name: [] for name in contestants}
    for _ in range(rounds):
        for name, who in contestants.items():
            start = time.perf_counter()
            finish = who.integrate()
            times[name].append(time.perf_counter() - start)
            insides[name].append(finish.inside or np.nan)
    return times, insides


def ratio(times: Mapping[str, list[float]], slow: str, fast: str) -> float:
    """Median over the rounds of the time of one over that of the other."""
    return statistics.median(a / b for a, b in zip(times[slow], times[fast], strict=True))
