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
from rodgen.integrate.jumps import has_mass_jumps, may_have_blows
from rodgen.integrate.lane_runs import LaneRows, ReductionPlan, StretchTable, can_use_lanes
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.integrate.reductions import Crossing, Numbers, Reduction, parse_all
from rodgen.integrate.stretches import Stretches
from rodgen.loading.generated_module import structure_of
from rodgen.memory import check_memory
from rodgen.model.term import AIR, ANY, KNOTS, holds
from rodgen.scene.distribution import Distribution
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
        self._plan = lru_cache(maxsize=KEPT)(self._make_plan)
        self._tables: dict[Any, tuple[StretchTable, dict[int, str]]] = {}

    @cached_property
    def numbers(self) -> Numbers:
        """All numbers of its quantities."""
        of = self.structure
        boundary_condition = of.boundary_condition
        held = range(boundary_condition.first, of.n_links) if "supports" in of.loads else ()
        loads = loads_at_work(self.model), of.open_expressions
        in_air = (name for name, row in of.load_rows.items() if row.kind == AIR)
        rod = boundary_condition, of.n_links
        return Numbers.of(*rod, *loads, of.state_names, held, of.contacts, in_air)

    def parse_reductions(self, texts: Sequence[str]) -> tuple[Reduction, ...]:
        """Parse reductions of its numbers from their texts. Raises InputError."""
        return parse_all(texts, self.numbers.places)

    def plan(
        self,
        settings: IntegrationTable,
        reductions: tuple[Reduction, ...],
        crossings: tuple[Crossing, ...] = (),
        traced: tuple[str, ...] = (),
    ) -> ReductionPlan | None:
        """Plan of runs side by side; None where they cannot be. traced: numbers of which all
        samples are kept."""
        return self._plan(settings.method, settings.has_fixed_step, reductions, crossings, traced)

    def _make_plan(
        self,
        method: str,
        fixed: bool,
        reductions: Sequence[Reduction],
        crossings: Sequence[Crossing],
        traced: Sequence[str],
    ) -> ReductionPlan | None:
        alone = (self._has_switches and not fixed) or may_have_blows(self.model)
        if alone or not can_use_lanes(method) or not hasattr(self.model, "LANES"):
            return None
        jumps = has_mass_jumps(self.model)
        return ReductionPlan.of(self._rows, reductions, jumps, crossings, traced)

    @cached_property
    def _rows(self) -> LaneRows:
        return LaneRows(self.model.LANES, self.model.STATE, self.structure.n_links)

    def can_observe(self, number: str) -> bool:
        """Whether a number of a quantity can be computed side by side."""
        return hasattr(self.model, "LANES") and self._rows.terms(number) is not None

    # What changes with time ---------------------------------------------------------------------

    @cached_property
    def _has_switches(self) -> bool:
        """Whether a law of the motion switches at a sensor, a state or an angle it follows."""
        laws = any(e.switches() for e in self.structure.laws.values())
        return bool(self._has_spring_corners or self.structure.contacts or laws)

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
        values, springs = self.structure.expression_values(p), self._springs(p)
        mesh = self.structure.mesh(p)
        return TimeLaws.from_structure(self.structure, values, mesh, span[0], span[1], springs)

    def _springs(self, p: Array) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Stiffness of the springs, of a uniform rod by EI, and their rest angles; none where their
        law is smooth."""
        if not self._has_spring_corners:
            return (), ()
        of, places = self.structure, self.structure.slices
        rest = tuple(p[places["rest_angle"]].tolist()) if "rest_angle" in places else None
        if "joint_stiffness" in places:
            stiffness = tuple(p[places["joint_stiffness"]].tolist())
            return stiffness, rest or (0.0,) * len(stiffness)
        given: dict[str, Any] = {"links": of.n_links, "mass": 1.0, "boundary": of.boundary}
        given |= {name: float(p[places[name].start]) for name in ("length", "bending_stiffness")}
        rod = RodTable(**given)
        stiffness = tuple(Distribution(rod, [], (), 0.0).joint_stiffness)
        return stiffness, rest or (0.0,) * len(stiffness)

    def find_stretches(
        self, settings: IntegrationTable, p: Array, rods: int
    ) -> tuple[StretchTable, NDArray[np.int64] | None, dict[int, str]]:
        """Stretches of the runs, which of them each rod has (None: all the first), and why rods
        have none."""
        if not len(self._law_columns) or len(p) == 1:
            numbers = p[0, self._law_columns].tobytes()
            key = *settings.span, settings.has_fixed_step, numbers
            if key not in self._tables:
                if len(self._tables) >= KEPT:
                    self._tables.clear()
                self._tables[key] = self._make_table(settings, p[:1])
            table, refused = self._tables[key]
            return table, None, dict.fromkeys(range(rods), refused[0]) if refused else {}
        # Rods of equal numbers share theirs: found by their bytes, as tables are long.
        firsts = dict[bytes, int]()
        found = (row.tobytes() for row in p[:, self._law_columns])
        first = np.array([firsts.setdefault(row, at) for at, row in enumerate(found)], dtype=int)
        distinct, which = np.unique(first, return_inverse=True)
        table, refused = self._make_table(settings, p[distinct])
        whose = {number: np.flatnonzero(which == number).tolist() for number in refused}
        said = {rod: refused[number] for number, some in whose.items() for rod in some}
        return table, which.reshape(-1).astype(np.int64), said

    def _make_table(
        self, settings: IntegrationTable, rods: Array
    ) -> tuple[StretchTable, dict[int, str]]:
        """Make the table of the stretches of several rods by their parameters, and tell why some
        have none."""
        found, refused = list[Stretches](), dict[int, str]()
        for at, p in enumerate(rods):
            try:
                found.append(self._stretches_of(settings, p))
            except InputError as error:
                found.append(Stretches([]))
                refused[at] = str(error)
        return StretchTable.of(settings.span[0], found), refused

    def _stretches_of(self, settings: IntegrationTable, p: Array) -> Stretches:
        """Find the stretches of one rod. Raises InputError."""
        start, end = settings.span
        of, values = self.structure, self.structure.expression_values(p)
        laws = TimeLaws.from_structure(of, values, of.mesh(p), start, end)
        found = Stretches.of(laws, settings.has_fixed_step)
        if not found.ends:
            _, load = laws.first_pole() or (start, None)
            allowed = f"finite from {start!r} s on"
            raise InputError(load.field if load else "span", load and load.text, allowed)
        return found

    # Parameters ---------------------------------------------------------------------------------

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
        width = self.structure.width
        check_memory("their parameters", count, lambda rods: COPIES * 8.0 * width * rods, "p")
        p = np.empty((count, width))
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
    wrong = ~(np.isfinite(column) & holds(rule, column))
    if wrong.any():
        what = "" if rule == ANY else f", {rule}"
        raise InputError(name, float(column[wrong][0]), f"finite{what}")
    return column


@lru_cache(maxsize=16)
def facts_of(model: ModuleType) -> ModuleFacts:
    """Facts about a module, found once; those of the last 16 modules in use are kept."""
    return ModuleFacts(model)
