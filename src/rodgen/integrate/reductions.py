"""Reductions: what is kept of the numbers of quantities in a run, over its samples; and crossings
of levels in many runs side by side.

last(tip_x)    max(phi_19)    rms(tip_y, from=5)    mean(kinetic_energy, from=1, to=2)
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError, did_you_mean
from rodgen.integrate.quantity_formulas import Motion
from rodgen.model.quantities import ADDED, IN_AIR, LOADS, POWERS, QUANTITIES, WORKS, Index, numbers
from rodgen.model.rod import Boundary
from rodgen.native.native_batch import NUMBER, WATCHED
from rodgen.scene.contact_terms import ContactTerm

# Of times and values at the samples; those in C have the same names.
REDUCTIONS: dict[str, Callable[[Array, Array], float]] = {
    "last": lambda t, values: values[-1],
    "min": lambda t, values: values.min(),
    "max": lambda t, values: values.max(),
    "mean": lambda t, values: values.mean(),
    "rms": lambda t, values: np.sqrt(np.mean(values**2)),
    "std": lambda t, values: values.std(),
    "time_of_max": lambda t, values: t[values.argmax()],
}
_FORM = re.compile(r"\s*(\w+)\s*\(\s*(\w+)\s*((?:,\s*\w+\s*=\s*[^,()=]+)*)\)\s*")
_ALLOWED = (
    "a reduction of a quantity, such as max(phi_0) or rms(tip_y, from=5): {of} of one of {names}, "
    "with times from and to if need be"
)

Terms = Mapping[int, float]  # rows, and their weights in a sum


@dataclass(frozen=True)
class Reduction:
    """Reduction of a number, by its name, over the samples between two times [s]."""

    text: str
    kind: str
    number: str
    start: float = -math.inf
    end: float = math.inf

    def reduce(self, t: Array, values: Array) -> float:
        """Reduce samples at times t (T,) to a value; not-a-number if none is between its times."""
        inside = (t >= self.start) & (t <= self.end)
        return float(REDUCTIONS[self.kind](t[inside], values[inside])) if inside.any() else math.nan


@lru_cache(maxsize=1024)
def parse(text: str) -> Reduction | None:
    """Parse a reduction from its text; None for what is none."""
    found = _FORM.fullmatch(text)
    if not found or found[1] not in REDUCTIONS:
        return None
    times = {}
    for part in found[3].split(",")[1:]:
        name, _, value = (piece.strip() for piece in part.partition("="))
        try:
            times[name] = float(value)
        except ValueError:
            return None
    if {*times} - {"from", "to"} or found[3].count(",") > len(times):
        return None
    start, end = times.get("from", -math.inf), times.get("to", math.inf)
    return Reduction(text, found[1], found[2], start, end) if start <= end else None


def parse_all(texts: Iterable[str], names: Collection[str]) -> tuple[Reduction, ...]:
    """Parse reductions from their texts. Raises InputError for one of no number by these names."""
    found = []
    for at, text in enumerate(texts):
        one = parse(text) if isinstance(text, str) else None
        if one is None or one.number not in names:
            allowed = _ALLOWED.format(of=", ".join(REDUCTIONS), names=patterns_of(names))
            hint = did_you_mean(one.number, names) if one else ""
            raise InputError(f"keep[{at}]", text, allowed + hint)
        found.append(one)
    return tuple(found)


def patterns_of(names: Iterable[str]) -> str:
    """Names of numbers for a message, those that differ in an index once: phi_{}, tip_x."""
    return ", ".join(dict.fromkeys(re.sub(r"(?<=_)\d+", "{}", name) for name in names))


@dataclass(frozen=True)
class Numbers:
    """All single numbers of the quantities of a rod: by name, the quantity and the index in it."""

    places: Mapping[str, tuple[str, Index]]
    kinds: Mapping[str, str] = field(default_factory=dict)  # of numbers of contacts

    @classmethod
    def of(
        cls,
        boundary: Boundary,
        links: int,
        works: Iterable[str],
        loads: Iterable[str],
        added: Iterable[str],
        supported: Sequence[int] = (),
        contacts: Iterable[ContactTerm] = (),
        in_air: Iterable[str] = (),
    ) -> Numbers:
        """Collect all numbers. works, loads, added: names of the loads that do work, of parameters
        that change, and of states that are added; supported: links that supports may be on;
        contacts: of the rod; in_air: names of the loads that the air is."""
        works = tuple(works)
        each = {WORKS: works, POWERS: works, LOADS: tuple(loads), ADDED: tuple(added)}
        places: dict[str, tuple[str, Index]] = {"total_work": ("total_work", ())}
        contacts = tuple(contacts)
        each[IN_AIR] = tuple(in_air)
        for one in contacts:
            each[one.kind] = (*each.get(one.kind, ()), *one.places)
        for quantity in QUANTITIES:
            if quantity.each:
                named = (quantity.name.format(term) for term in each.get(quantity.each, ()))
                places |= {name: (name, ()) for name in named}
            else:
                found = numbers(quantity, boundary, links, supported)
                places |= {one.name: (quantity.name, one.at) for one in found}
        kinds = {name: one.kind for one in contacts for name in one.numbers}
        return cls(places, kinds)

    def values(self, motion: Motion, name: str) -> Array:
        """Values of a number at all samples of a motion, (T,)."""
        quantity, at = self.places[name]
        found: Array = motion.values(quantity)[(..., *at)]
        return found


@dataclass(frozen=True)
class Crossing:
    """Crossing to look for: a number of a run passes a level between two times [s].

    direction: rising, falling or either; kept: numbers whose values there are kept, of the first
    crossings, `max_points` at most; stop: name of the event, if it ends the run.
    """

    number: str
    level: float
    direction: str = "either"
    kept: tuple[str, ...] = ()
    max_points: int = 0
    start: float = -math.inf
    end: float = math.inf
    stop: str = ""

    @property
    def width(self) -> int:
        """Length of its results for one rod: the count of crossings, and the numbers of each."""
        return 1 + self.max_points * (1 + len(self.kept))


class CrossingResults(NamedTuple):
    """Crossings found. counts: how many, (rods,); t: when [s], (rods, max_points); values: of what
    is kept of each, (rods, max_points, kept); not-a-number behind the last."""

    counts: NDArray[np.int64]
    t: Array
    values: Array


class WeightedSums:
    """Weighted sums of rows, stored one after the other."""

    def __init__(self) -> None:
        self._rows: list[int] = []
        self._weights: list[float] = []

    def add(self, terms: Terms) -> tuple[int, int]:
        """Add a sum, and return where it begins and how many terms it has."""
        first = len(self._rows)
        self._rows += terms
        self._weights += terms.values()
        return first, len(terms)

    def arrays(self) -> tuple[NDArray[np.int64], Array]:
        """Rows and weights of all sums."""
        return np.array(self._rows, dtype=np.int64), np.array(self._weights, dtype=float)


@dataclass(frozen=True)
class CrossingTable:
    """Crossings as arrays for the loops in C."""

    crossings: tuple[Crossing, ...]
    table: NDArray[Any]
    numbers: NDArray[Any]

    @classmethod
    def of(
        cls,
        crossings: Sequence[Crossing],
        terms: Mapping[str, Terms],
        known: int,
        sums: WeightedSums,
    ) -> CrossingTable:
        """Encode crossings. terms: of every number, by name; known: how many rows are not observed;
        sums: where the sums of the numbers are added."""
        table = np.zeros(len(crossings), WATCHED)
        numbers: list[tuple[int, int]] = []
        place = 0
        for row, one in zip(table, crossings, strict=True):
            row["rising"], row["falling"] = one.direction != "falling", one.direction != "rising"
            row["looks"] = any(at >= known for at in terms[one.number])
            row["level"], row["from"], row["to"] = one.level, one.start, one.end
            row["first"], row["terms"] = sums.add(terms[one.number])
            row["place"], row["most"] = place, one.max_points
            row["first_number"], row["numbers"] = len(numbers), len(one.kept)
            numbers += (sums.add(terms[name]) for name in one.kept)
            place += one.width
        stops = [at for at, one in enumerate(crossings) if one.stop]
        table["stops"][stops] = np.array(stops, dtype=np.int64) + 1
        return cls(tuple(crossings), table, np.array(numbers, dtype=NUMBER))

    @cached_property
    def width(self) -> int:
        """Length of the results of all crossings for one rod."""
        return sum(one.width for one in self.crossings)

    def decode(self, rows: Array) -> Iterator[CrossingResults]:
        """Decode the crossings of many rods from what the loops have written, (rods, width)."""
        for place, one in zip(self.table["place"].tolist(), self.crossings, strict=True):
            counts = rows[:, place].astype(np.int64)
            each = rows[:, place + 1 : place + one.width]
            made = each.reshape(len(rows), one.max_points, 1 + len(one.kept)).copy()
            made[np.arange(one.max_points) >= counts[:, None]] = np.nan
            yield CrossingResults(counts, made[..., 0], made[..., 1:])

    def stop_name(self, number: int) -> str:
        """Name of the event that has ended a run, by the number in its outcome."""
        return self.crossings[number - 1].stop
