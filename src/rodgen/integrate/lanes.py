"""Runs side by side in lanes of C: what of many runs can be, and how they are told to the loops."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.crossings import Crossing, Sums, Watched
from rodgen.integrate.methods.compiled import FAILURES
from rodgen.integrate.reductions import Reduction
from rodgen.integrate.stretches import CREEP, CREPT, SPENT, STRIDE, UNBOUNDED, Stretches, inside
from rodgen.native.many import COURSE, KEEPS, KEPT, NUMBER, NUMBERS, STRETCH, Block, Lanes, Shared
from rodgen.native.run import IMPLICIT
from rodgen.native.run import METHODS as COMPILED
from rodgen.scene.integration import Integrate

Row = str
BALANCE = "energy_balance"
ENERGIES = ("kinetic_energy", "spring_energy", "gravity_energy")
EVERY = Shared(course_of=np.empty(0, dtype=np.int64))
PIECES = 8  # in which each worker takes its share of the rods


def explicit(method: str) -> bool:
    """Whether a method's steps can be taken side by side."""
    return method in COMPILED and method not in IMPLICIT


class Times(NamedTuple):
    """Times of the samples of all runs [s], and how the loops know them."""

    all: Array
    shared: Shared

    @classmethod
    def of(cls, times: Array) -> Times:
        """From the times alone."""
        return cls(times, Shared(times=times))


@dataclass(frozen=True)
class Rows:
    """The rows of which numbers are made in lanes: states, works, and what is observed."""

    lanes: Lanes
    state: tuple[str, ...]
    links: int

    @cached_property
    def names(self) -> dict[Row, int]:
        """Where each row is, by name."""
        works = (f"work_{term}" for term in self.lanes.works)
        return {name: at for at, name in enumerate((*self.state, *works, *self.lanes.observed))}

    def terms(self, number: str) -> dict[int, float] | None:
        """The rows that a number is the weighed sum of; None where it is none."""
        weights = self._weights(number)
        if weights is None:
            return None
        # An energy that is zero for every state is not observed.
        known = {row: weight for row, weight in weights.items() if row not in ENERGIES}
        known |= {row: weights[row] for row in ENERGIES if row in weights and row in self.names}
        return (
            {self.names[row]: w for row, w in known.items()} if {*known} <= {*self.names} else None
        )

    def _weights(self, number: str) -> Mapping[Row, float] | None:
        works = dict.fromkeys((f"work_{term}" for term in self.lanes.works), 1.0)
        match number.split("_"):
            case ["tip", axis] if axis in ("x", "y"):
                return {f"joint_{self.links}_{axis}": 1.0}
            case ["total", "energy"]:
                return dict.fromkeys(ENERGIES, 1.0)
            case ["total", "work"]:
                return works
            case ["energy", "balance"]:
                return dict.fromkeys(ENERGIES, 1.0) | dict.fromkeys(works, -1.0)
            case ["bend", joint]:
                return {f"phi_{joint}": 1.0, f"phi_{int(joint) - 1}": -1.0}
            case ["bend", "rate", joint]:
                return {f"omega_{joint}": 1.0, f"omega_{int(joint) - 1}": -1.0}
        return {number: 1.0}


@dataclass(frozen=True)
class Plan:
    """Reductions as the loops know them; the last two are least and largest of the balance.

    energies: how many of the rows that are observed are parts of the energy, of a rod whose masses
    may jump; else 0; watched: what is watched; traces: of what all samples are kept.
    """

    keep: NDArray[Any]
    rows: NDArray[np.int64]
    weights: Array
    observes: bool
    energies: int
    watched: Watched
    traces: NDArray[Any]

    @cached_property
    def shared(self) -> Shared:
        """Its arrays."""
        watched = {"watch": self.watched.table, "numbers": self.watched.numbers}
        watched["trace"] = self.traces
        return Shared(keep=self.keep, rows=self.rows, weights=self.weights, **watched)

    @classmethod
    def of(
        cls,
        rows: Rows,
        reductions: Sequence[Reduction],
        jumps: bool,
        crossings: Sequence[Crossing] = (),
        traced: Sequence[str] = (),
    ) -> Plan | None:
        """None where a number is not to be had in lanes; jumps: whether masses may jump; traced:
        numbers of which all samples are kept."""
        balance = (Reduction("", kind, BALANCE) for kind in ("min", "max"))
        every = (*reductions, *balance)
        numbers = [*traced, *(one.number for one in every)]
        numbers += (name for one in crossings for name in (one.number, *one.kept))
        terms = {name: of for name in numbers if (of := rows.terms(name)) is not None}
        if {*numbers} - {*terms}:
            return None
        sums, known = Sums(), len(rows.state) + len(rows.lanes.works)
        places = [sums.add(terms[one.number]) for one in every]
        watched = Watched.of(crossings, terms, known, sums)
        traces = np.array([sums.add(terms[name]) for name in traced], dtype=NUMBER)
        keep = np.zeros(len(every), KEPT)
        keep["reduction"] = [KEEPS[one.kind] for one in every]
        keep["less_start"] = [one.number == BALANCE for one in every]
        keep["first"], keep["terms"] = np.array(places).T
        keep["from"], keep["to"] = [one.start for one in every], [one.end for one in every]
        at, weights = sums.arrays()
        energies = sum(name in ENERGIES for name in rows.lanes.observed) if jumps else 0
        return cls(keep, at, weights, bool((at >= known).any()), energies, watched, traces)


@dataclass(frozen=True)
class Courses:
    """Stretches as the loops know them."""

    courses: NDArray[Any]
    ends: NDArray[Any]

    @cached_property
    def shared(self) -> Shared:
        """Its arrays."""
        return Shared(courses=self.courses, stretches=self.ends)

    @classmethod
    def of(cls, start: float, stretches: Sequence[Stretches]) -> Courses:
        """start: of all runs [s]."""
        pairs = [
            pair for one in stretches for pair in zip([start, *one.ends], one.ends, strict=False)
        ]
        courses, ends = np.zeros(len(stretches), COURSE), np.zeros(len(pairs), STRETCH)
        courses["count"] = [len(one.ends) for one in stretches]
        courses["first"] = np.cumsum(courses["count"]) - courses["count"]
        courses["longest"] = [one.swing for one in stretches]
        courses["pole"] = [one.pole is not None for one in stretches]
        ends["end"] = [end for _, end in pairs]
        ends["low"], ends["high"] = np.array([inside(*pair) for pair in pairs]).reshape(-1, 2).T
        return cls(courses, ends)


def run(
    lanes: Lanes,
    plan: Plan,
    settings: Integrate,
    times: Times,
    p: Array,
    y: Array,
    courses: Courses,
    which: NDArray[np.int64] | None,
    rods: int,
    ranges: Sequence[tuple[int, int]],
    workers: int,
) -> Block:
    """Runs of rods in some ranges, each of the course of its number; times: of the samples [s]; p,
    y: of each or of all."""
    rtol, atol = settings.per_step
    fields = {
        "method": COMPILED.index(settings.method),
        "start": settings.span[0],
        "step": (settings.step or 0.0) if settings.fixed else 0.0,
        "rtol": rtol,
        "atol": atol,
        "budget": settings.budget,
        "stride": STRIDE,
        "creep": CREEP,
        "samples": len(times.all),
        "observes": plan.observes,
        "energies": plan.energies,
        "kept": len(plan.keep),
        "watched": len(plan.watched.table),
        "looks": bool(plan.watched.table["looks"].any()),
        "crossed_width": plan.watched.width,
        "traced": len(plan.traces),
    }
    own = EVERY if which is None else Shared(course_of=which)
    block = Block(lanes, rods, p, y, (plan.shared, courses.shared, times.shared, own), fields)
    share(block, _pieces(ranges, workers), workers)
    return block


def _pieces(ranges: Sequence[tuple[int, int]], workers: int) -> list[tuple[int, int]]:
    """Ranges in pieces small enough for every worker to take some."""
    if workers == 1:
        return list(ranges)
    rods = sum(end - begin for begin, end in ranges)
    length = max(1, -(-rods // (PIECES * workers)))
    return [
        (at, min(at + length, end)) for begin, end in ranges for at in range(begin, end, length)
    ]


def share(block: Block, pieces: Sequence[tuple[int, int]], workers: int) -> None:
    """Have pieces of a block done by so many threads, this one among them."""
    if workers == 1:
        alone = iter(pieces)
        block.work(lambda: next(alone, None))
        return
    left, lock = iter(pieces), threading.Lock()
    failed: list[BaseException] = []

    def take() -> tuple[int, int] | None:
        with lock:
            return next(left, None)

    def work() -> None:
        try:
            block.work(take)
        except BaseException as error:  # raised again in the thread that waits
            failed.append(error)

    others = [threading.Thread(target=work, daemon=True) for _ in range(workers - 1)]
    for thread in others:
        thread.start()
    try:
        block.work(take)
    except BaseException:
        block.stopped = True
        raise
    finally:
        for thread in others:
            thread.join()
    if failed:
        raise failed[0]


def why(status: int, settings: Integrate, t: float) -> str:
    """What stopped a run in lanes."""
    reasons = FAILURES | {
        NUMBERS["SPENT"]: SPENT.format(settings.budget),
        NUMBERS["CREEPING"]: CREPT.format(STRIDE, t),
        NUMBERS["POLE"]: UNBOUNDED,
    }
    return reasons[status]
