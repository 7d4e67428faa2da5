"""Runs side by side in lanes of C: which runs can be, and their arrays for the loops."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.methods.compiled_integrator import FAILURES
from rodgen.integrate.reductions import Crossing, CrossingTable, Reduction, WeightedSums
from rodgen.integrate.stretches import (
    CREEP,
    CREPT,
    SPENT,
    STRIDE,
    UNBOUNDED,
    Stretches,
    evaluation_bounds,
)
from rodgen.native.native_batch import (
    COURSE,
    KEEPS,
    KEPT,
    NUMBER,
    NUMBERS,
    STRETCH,
    Lanes,
    RunBatch,
    SharedArrays,
)
from rodgen.native.native_run import IMPLICIT
from rodgen.native.native_run import METHODS as COMPILED
from rodgen.scene.integration import IntegrationTable

Row = str
BALANCE = "energy_balance"
ENERGIES = ("kinetic_energy", "spring_energy", "gravity_energy")
NO_COURSES = np.empty(0, dtype=np.int64)
PIECES = 8  # in which each worker takes its share of the rods


def can_use_lanes(method: str) -> bool:
    """Whether a method's steps can be taken side by side."""
    return method in COMPILED and method not in IMPLICIT


@dataclass(frozen=True)
class LaneRows:
    """Rows from which numbers are computed in lanes: states, works, and observed quantities."""

    lanes: Lanes
    state: tuple[str, ...]
    links: int

    @cached_property
    def names(self) -> dict[Row, int]:
        """Index of each row, by name."""
        works = (f"work_{term}" for term in self.lanes.works)
        return {name: at for at, name in enumerate((*self.state, *works, *self.lanes.observed))}

    def terms(self, number: str) -> dict[int, float] | None:
        """Rows, with weights, whose weighted sum a number is; None where it is none."""
        weights = self._weights(number)
        if weights is None:
            return None
        # An energy that is zero for every state is not observed.
        known = {row: weight for row, weight in weights.items() if row not in ENERGIES}
        known |= {row: weights[row] for row in ENERGIES if row in weights and row in self.names}
        if known.keys() - self.names.keys():
            return None
        return {self.names[row]: weight for row, weight in known.items()}

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
class ReductionPlan:
    """Reductions as arrays for the loops; the last two are least and largest of the energy balance.

    energies: how many of the observed rows are parts of the energy, of a rod whose masses may jump,
    else 0; watched: crossings to look for; traces: numbers whose samples are all kept.
    """

    keep: NDArray[Any]
    rows: NDArray[np.int64]
    weights: Array
    observes: bool
    energies: int
    watched: CrossingTable
    traces: NDArray[Any]

    @cached_property
    def lane_arrays(self) -> SharedArrays:
        """Arrays that all its runs share."""
        watched = {"watch": self.watched.table, "numbers": self.watched.numbers}
        watched["trace"] = self.traces
        return SharedArrays(keep=self.keep, rows=self.rows, weights=self.weights, **watched)

    @classmethod
    def of(
        cls,
        rows: LaneRows,
        reductions: Sequence[Reduction],
        jumps: bool,
        crossings: Sequence[Crossing] = (),
        traced: Sequence[str] = (),
    ) -> ReductionPlan | None:
        """Encode what is kept of runs; None where a number is not to be had in lanes. jumps:
        whether masses may jump; traced: numbers of which all samples are kept."""
        balance = (Reduction("", kind, BALANCE) for kind in ("min", "max"))
        every = (*reductions, *balance)
        numbers = [*traced, *(one.number for one in every)]
        numbers += (name for one in crossings for name in (one.number, *one.kept))
        terms = {name: of for name in numbers if (of := rows.terms(name)) is not None}
        if {*numbers} - {*terms}:
            return None
        sums, known = WeightedSums(), len(rows.state) + len(rows.lanes.works)
        places = [sums.add(terms[one.number]) for one in every]
        watched = CrossingTable.of(crossings, terms, known, sums)
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
class StretchTable:
    """Stretches of runs as arrays for the loops."""

    courses: NDArray[Any]
    ends: NDArray[Any]

    @cached_property
    def lane_arrays(self) -> SharedArrays:
        """Arrays that all its runs share."""
        return SharedArrays(courses=self.courses, stretches=self.ends)

    @classmethod
    def of(cls, start: float, stretches: Sequence[Stretches]) -> StretchTable:
        """Encode the stretches of runs that start at one time [s]."""
        pairs = [pair for one in stretches for pair in pairwise([start, *one.ends])]
        courses, ends = np.zeros(len(stretches), COURSE), np.zeros(len(pairs), STRETCH)
        courses["count"] = [len(one.ends) for one in stretches]
        courses["first"] = np.cumsum(courses["count"]) - courses["count"]
        courses["longest"] = [one.half_period for one in stretches]
        courses["pole"] = [one.pole is not None for one in stretches]
        ends["end"] = [end for _, end in pairs]
        ends["low"], ends["high"] = (
            np.array([evaluation_bounds(*pair) for pair in pairs]).reshape(-1, 2).T
        )
        return cls(courses, ends)


def run_lanes(
    lanes: Lanes,
    plan: ReductionPlan,
    settings: IntegrationTable,
    times: Array,
    p: Array,
    y: Array,
    table: StretchTable,
    which: NDArray[np.int64] | None,
    rods: int,
    ranges: Sequence[tuple[int, int]],
    workers: int,
) -> RunBatch:
    """Run the rods in some ranges. which: number of the course of each (None: all have the first);
    times: of the samples [s]; p, y: of each or of all."""
    rtol, atol = settings.step_tolerances
    fields = {
        "method": COMPILED.index(settings.method),
        "start": settings.span[0],
        "step": (settings.step or 0.0) if settings.has_fixed_step else 0.0,
        "rtol": rtol,
        "atol": atol,
        "budget": settings.step_limit,
        "stride": STRIDE,
        "creep": CREEP,
        "samples": len(times),
        "observes": plan.observes,
        "energies": plan.energies,
        "kept": len(plan.keep),
        "watched": len(plan.watched.table),
        "looks": bool(plan.watched.table["looks"].any()),
        "crossed_width": plan.watched.width,
        "traced": len(plan.traces),
    }
    own = SharedArrays(times=times, course_of=NO_COURSES if which is None else which)
    shared = plan.lane_arrays, table.lane_arrays, own
    block = RunBatch(lanes, rods, p, y, shared, fields)
    run_in_threads(block, _split_ranges(ranges, workers), workers)
    return block


def _split_ranges(ranges: Sequence[tuple[int, int]], workers: int) -> list[tuple[int, int]]:
    """Split ranges into pieces small enough for every worker to take some."""
    if workers == 1:
        return list(ranges)
    rods = sum(end - begin for begin, end in ranges)
    length = max(1, -(-rods // (PIECES * workers)))
    return [
        (at, min(at + length, end)) for begin, end in ranges for at in range(begin, end, length)
    ]


def run_in_threads(block: RunBatch, pieces: Sequence[tuple[int, int]], workers: int) -> None:
    """Share pieces of a block among so many threads, this one among them."""
    left, lock = iter(pieces), threading.Lock()

    def take() -> tuple[int, int] | None:
        with lock:
            return next(left, None)

    if workers == 1:
        block.run(take)
        return
    with ThreadPoolExecutor(workers - 1) as pool:
        others = [pool.submit(block.run, take) for _ in range(workers - 1)]
        try:
            block.run(take)
        except BaseException:
            block.stopped = True
            raise
    for one in others:
        one.result()


def stop_reason(status: int, settings: IntegrationTable, t: float) -> str:
    """Reason why a run in lanes stopped, by its status."""
    reasons = FAILURES | {
        NUMBERS["SPENT"]: SPENT.format(settings.step_limit),
        NUMBERS["CREEPING"]: CREPT.format(STRIDE, t),
        NUMBERS["POLE"]: UNBOUNDED,
    }
    return reasons[status]
