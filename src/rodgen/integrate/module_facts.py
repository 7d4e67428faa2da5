"""Facts about a module that many runs need: found once, and kept as long as it is in use."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError, Missing
from rodgen.integrate.lane_runs import LaneRows, ReductionPlan, StretchTable, can_use_lanes
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.integrate.reductions import Crossing, Numbers, Reduction, parse_all
from rodgen.integrate.stretches import Stretches, has_mass_jumps
from rodgen.loading.generated_module import structure_of
from rodgen.memory import check_memory
from rodgen.model.rod import BOUNDARIES
from rodgen.model.term import ANY, KNOTS, NOT_NEGATIVE, POSITIVE
from rodgen.native.native_batch import Lanes
from rodgen.scene.distribution import Distribution
from rodgen.scene.expression import Expression
from rodgen.scene.grammar import TableData
from rodgen.scene.integration import IntegrationTable
from rodgen.scene.tables import RodTable
from rodgen.scene.time_laws import TimeLaws

KEPT = 256  # plans, tables and stretches that are remembered
COPIES = 4  # of the parameters of all rods that are held at once


class ModuleFacts:
    """Module with its structure, and what many runs need of them, each found once."""

    def __init__(self, model: ModuleType):
        self.model, self.structure = model, structure_of(model)
        self.states = len(model.STATE)
        self._plans: dict[Any, ReductionPlan | None] = {}
        self._reductions: dict[tuple[str, ...], tuple[Reduction, ...]] = {}
        self._tables: dict[bytes, TableData] = {}
        self._courses: dict[Any, tuple[StretchTable, dict[int, str]]] = {}

    @property
    def works(self) -> tuple[str, ...]:
        """Names of the loads without potential."""
        return loads_at_work(self.model)

    @cached_property
    def lanes(self) -> Lanes:
        """Equations side by side in C, compiled on first use."""
        made: Lanes = self.model.LANES
        return made

    @cached_property
    def numbers(self) -> Numbers:
        """All numbers of its quantities."""
        of = self.structure
        boundary_condition = BOUNDARIES[of.boundary]
        held = range(boundary_condition.first, of.links) if "supports" in of.loads else ()
        return Numbers.of(
            boundary_condition, of.links, self.works, of.open_expressions, of.state_names, held
        )

    def reductions(self, texts: tuple[str, ...]) -> tuple[Reduction, ...]:
        """Parse reductions of its numbers from their texts. Raises InputError."""
        found = self._reductions.get(texts)
        if found is None:
            found = parse_all(texts, self.numbers.places)
            _remember(self._reductions, texts, found)
        return found

    def plan(
        self,
        settings: IntegrationTable,
        reductions: tuple[Reduction, ...],
        crossings: tuple[Crossing, ...] = (),
        traced: tuple[str, ...] = (),
    ) -> ReductionPlan | None:
        """Plan of runs side by side; None where they cannot be. traced: numbers of which all
        samples are kept."""
        key = settings.method, settings.has_fixed_step, reductions, crossings, traced
        if key not in self._plans:
            _remember(self._plans, key, self._make_plan(settings, reductions, crossings, traced))
        return self._plans[key]

    def _make_plan(
        self,
        settings: IntegrationTable,
        reductions: Sequence[Reduction],
        crossings: Sequence[Crossing],
        traced: Sequence[str],
    ) -> ReductionPlan | None:
        switches = self._has_switches and not settings.has_fixed_step
        if switches or not can_use_lanes(settings.method) or not hasattr(self.model, "LANES"):
            return None
        return ReductionPlan.of(
            self._rows, reductions, has_mass_jumps(self.model), crossings, traced
        )

    @cached_property
    def _rows(self) -> LaneRows:
        return LaneRows(self.lanes, self.model.STATE, self.structure.links)

    def can_observe(self, number: str) -> bool:
        """Whether a number of a quantity can be computed side by side."""
        return hasattr(self.model, "LANES") and self._rows.terms(number) is not None

    # What changes with time ---------------------------------------------------------------------

    @cached_property
    def _has_switches(self) -> bool:
        """Whether a law of the motion switches at a sensor, a state or an angle it follows."""
        return self._has_spring_corners or any(e.switches() for e in self.structure.laws.values())

    @cached_property
    def _has_spring_corners(self) -> bool:
        """Whether the law of the springs is not smooth."""
        return bool(self.structure.spring and self.structure.spring_law.corners())

    @cached_property
    def _law_columns(self) -> NDArray[np.int64]:
        """Indices in p of the numbers and tables of its expressions."""
        of = self.structure
        places = [of.slices[name] for name in (*of.numbers, *dict(of.tables))]
        return np.array([at for one in places for at in range(one.start, one.stop)], dtype=int)

    def time_laws(self, span: Sequence[float], p: Array) -> TimeLaws:
        """Laws in time of one rod within a span [s]. Raises InputError."""
        values, stiffness = self._values(p), self._spring_stiffness(p)
        return TimeLaws.from_structure(self.structure, values, span[0], span[1], stiffness)

    def _values(self, p: Array) -> dict[str, Any]:
        """Numbers and tables in its expressions for one rod, by name."""
        of = self.structure
        found: dict[str, Any] = {name: float(p[of.indices[name]]) for name in of.numbers}
        return found | {name: self._table(p[of.slices[name]]) for name, _ in of.tables}

    def _table(self, numbers: Array) -> TableData:
        """Table of p, which many rods have in common."""
        key = numbers.tobytes()
        if key not in self._tables:
            _remember(self._tables, key, TableData.of(numbers))
        return self._tables[key]

    def time_dependent_loads(self, p: Array) -> dict[str, Expression]:
        """Loads of one rod that change with time alone, by the names of their parameters."""
        values, loads = self._values(p), self.structure.open_expressions.items()
        return {name: e.with_values(values) for name, e in loads if not e.signals}

    def _spring_stiffness(self, p: Array) -> tuple[float, ...]:
        """Stiffness of the springs, of a uniform rod by EI; none where their law is smooth."""
        if not self._has_spring_corners:
            return ()
        places = self.structure.slices
        if "joint_stiffness" in places:
            return tuple(p[places["joint_stiffness"]].tolist())
        of = self.structure
        length, stiffness = (
            float(p[places[name].start]) for name in ("length", "bending_stiffness")
        )
        rod = RodTable(
            links=of.links,
            length=length,
            bending_stiffness=stiffness,
            mass=1.0,
            boundary=of.boundary,
        )
        return tuple(Distribution(rod, [], (), 0.0).joint_stiffness)

    def courses(
        self, settings: IntegrationTable, p: Array, rods: int
    ) -> tuple[StretchTable, NDArray[np.int64] | None, dict[int, str]]:
        """Stretches of the runs, which of them each rod has (None: all the first), and why rods
        have none."""
        if not len(self._law_columns) or len(p) == 1:
            numbers = p[0, self._law_columns].tobytes()
            key = settings.span[0], settings.span[1], settings.has_fixed_step, numbers
            known = self._courses.get(key)
            if known is None:
                known = self._find_courses(settings, p[:1])
                _remember(self._courses, key, known)
            courses, refused = known
            return courses, None, dict.fromkeys(range(rods), refused[0]) if refused else {}
        # Rods of equal numbers share theirs: found by their bytes, as tables are long.
        firsts = dict[bytes, int]()
        found = (row.tobytes() for row in p[:, self._law_columns])
        first = np.array([firsts.setdefault(row, at) for at, row in enumerate(found)], dtype=int)
        distinct, which = np.unique(first, return_inverse=True)
        courses, refused = self._find_courses(settings, p[distinct])
        which = which.reshape(-1).astype(np.int64)
        return (
            courses,
            which,
            {
                rod: said
                for number, said in refused.items()
                for rod in np.flatnonzero(which == number).tolist()
            },
        )

    def _find_courses(
        self, settings: IntegrationTable, rods: Array
    ) -> tuple[StretchTable, dict[int, str]]:
        """Find the stretches of several rods by their parameters, and why some have none."""
        found, refused = list[Stretches](), dict[int, str]()
        for at, p in enumerate(rods):
            try:
                found.append(self._find_stretches(settings, p))
            except InputError as error:
                found.append(Stretches([]))
                refused[at] = str(error)
        return StretchTable.of(settings.span[0], found), refused

    def _find_stretches(self, settings: IntegrationTable, p: Array) -> Stretches:
        """Find the stretches of one rod. Raises InputError."""
        start, end = settings.span
        course = TimeLaws.from_structure(self.structure, self._values(p), start, end)
        found = Stretches.of(course, settings.has_fixed_step)
        if not found.ends:
            _, load = course.first_pole() or (start, None)
            allowed = f"finite from {start!r} s on"
            raise InputError(load.field if load else "span", load and load.text, allowed)
        return found

    # Parameters ---------------------------------------------------------------------------------

    @cached_property
    def width(self) -> int:
        """Length of p."""
        return self.structure.width

    def pack(self, given: Mapping[str, Any]) -> Array:
        """Pack parameters (rods, parameters) from values by name. Raises InputError."""
        rows = {row.name: row for row in self.structure.rows}
        places = self.structure.slices
        for name in given:
            if name not in rows:
                raise InputError("p", name, f"one of {', '.join(rows)}")
        made: dict[str, Array] = {}
        for name, row in rows.items():
            value = given.get(name, row.default)
            if value is None:
                raise InputError(f"p.{name}", Missing(), "given")
            count = places[name].stop - places[name].start if row.is_array else 0
            made[name] = _check_column(f"p.{name}", value, count, row.rule)
            if row.each == KNOTS and (np.diff(made[name][:, : count // 2]) <= 0).any():
                raise InputError(f"p.{name}", value, "knots that ascend, and then their values")
        rods = {len(column) for column in made.values() if len(column) != 1}
        if len(rods) > 1:
            shown = ", ".join(f"{n}: {len(c)}" for n, c in made.items() if len(c) != 1)
            raise InputError("p", shown, "as many values of every parameter as there are rods")
        count = rods.pop() if rods else 1
        check_memory("their parameters", count, lambda rods: COPIES * 8.0 * self.width * rods, "p")
        p = np.empty((count, self.width))
        for name, column in made.items():
            p[:, places[name]] = column
        return p


def _check_column(name: str, value: Any, count: int, rule: str) -> Array:
    """Check values of a parameter of one number (count 0) or several: (rods or 1, numbers)."""
    array = np.asarray(value)
    if isinstance(value, np.ma.MaskedArray) or array.dtype.kind not in "iuf":
        raise InputError(name, value, "real numbers")
    if count and array.ndim == 0:
        array = np.full(count, array)
    if count and (array.ndim > 2 or array.shape[-1] != count):
        raise InputError(name, value, f"{count} numbers, or (rods, {count})")
    if not count and array.ndim > 1:
        raise InputError(name, value, "a number, or (rods,)")
    column = array.reshape(-1, count or 1).astype(float)
    allowed = {ANY: column == column, NOT_NEGATIVE: column >= 0, POSITIVE: column > 0}
    wrong = ~(np.isfinite(column) & allowed[rule])
    if wrong.any():
        what = "" if rule == ANY else f", {rule}"
        raise InputError(name, float(column[wrong][0]), f"finite{what}")
    return column


def _remember(kept: dict[Any, Any], key: Any, value: Any) -> None:
    """Keep a value by its key; forget all others once there are too many."""
    if len(kept) >= KEPT:
        kept.clear()
    kept[key] = value


@lru_cache(maxsize=16)
def facts_of(model: ModuleType) -> ModuleFacts:
    """Facts about a module, found once; those of the last 16 modules in use are kept."""
    return ModuleFacts(model)
