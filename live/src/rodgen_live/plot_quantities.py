"""Catalogue of the quantities of a live run that plots can show, with their values at samples."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError, did_you_mean
from rodgen.integrate.quantity_formulas import MotionSlice, loads_at_work
from rodgen.integrate.reductions import patterns_of
from rodgen.loading.generated_module import call_module
from rodgen.model.quantities import (
    ADDED,
    IN_AIR,
    KINDS,
    LOADS,
    OWN,
    PERIODS,
    POWERS,
    QUANTITIES,
    TURNS,
    WORKS,
    numbers,
)
from rodgen.model.term import typeset
from rodgen.model.terms import PARAMETERS, describe
from rodgen.scene import Scene
from rodgen.system import System
from rodgen_live.sample_store import Chunk
from rodgen_live.user_expression import UserExpression

__all__ = ["KINDS", "PERIODS", "TURNS", "Catalogue", "PlotQuantity"]

MOST_OWN = 100  # expressions that are known at a time
MOST_PLANS = 256  # kept, one for every set of names that plots have asked for
STATE = "state"  # kind of the states that a scene adds, whose units are not known
POTENTIAL = ("spring_energy", "gravity_energy")


# Columns of a quantity, and the columns of the result that they go to.
_ColumnCopy = tuple[NDArray[np.int64], ...]


class PlotQuantity(NamedTuple):
    """A scalar that a plot can show; kind: those that it can share a plot with."""

    name: str
    label: str
    unit: str
    kind: str


class _Place(NamedTuple):
    """Place of a scalar: its column in the values of a quantity, (K, columns), and how far along
    the rod it is, from 0 at joint 0 to 1 at the tail."""

    quantity: str
    column: int
    along: float | None


class Catalogue:
    """Quantities of a system that can be shown.

    quantities: all of them by name, in the order in which they are offered; kinds: names by kind,
    of quantities that can share a plot; along: for kinds that go along the rod, where on it their
    quantities are, from 0 at joint 0 to 1 at the tail; works: loads without potential. An
    expression of quantities is one of them once it has been asked for. All are fixed by the
    structure of the system, for which model is made: values of parameters are taken from each
    chunk.
    """

    def __init__(self, system: System | Scene, model: ModuleType):
        system = System.of(system)
        self.model, self._timed = model, system.time_dependent_loads
        self.works = loads_at_work(model)
        self.quantities: dict[str, PlotQuantity] = {}
        self.kinds: dict[str, list[str]] = {}
        self.along: dict[str, Array] = {}
        self._places: dict[str, _Place] = {}
        order = list(KINDS)
        every = _scalars(system.scene, self.works)
        for shown, place in sorted(every, key=lambda one: order.index(one[0].kind)):
            self.kinds.setdefault(shown.kind, []).append(shown.name)
            self.quantities[shown.name], self._places[shown.name] = shown, place
        for kind, names in self.kinds.items():
            along = [self._places[name].along for name in names]
            if along := [one for one in along if one is not None]:
                self.along[kind] = system.scene.mesh.at(along)
        self._plan = lru_cache(MOST_PLANS)(self._make_plan)
        self._last: tuple[Chunk, MotionSlice] | None = None
        self._own: dict[str, UserExpression] = {}
        self._absent: set[str] = set()
        t, p, self._atol = system.settings.span[0], system.p, system.settings.atol
        some = np.sin(np.arange(1.0, 1.0 + len(model.STATE)))[None, :]  # bent and moving
        none = np.zeros((1, len(self.works)))
        self._some = Chunk(np.array([t]), some, none, self.works, p)
        self.update_zero_energies(t, p)

    def update_zero_energies(self, t: float, p: Array) -> bool:
        """Leave those potential energies out of their kind that are zero however the rod moves, as
        that of the springs in a chain. Returns whether others are left out than before."""
        with np.errstate(all="ignore"):
            _, *values = call_module(self.model, "energy", t, self._some.y[0], p)
        before = self._absent
        self._absent = {name for name, value in zip(POTENTIAL, values, strict=True) if value == 0}
        return self._absent != before

    def columns(self, names: Sequence[str], chunk: Chunk) -> Array:
        """Values of quantities at the samples of a chunk, (K, names). Raises InputError for a name
        that is not known. What was computed is kept for the next call with the same chunk."""
        plan = self._plan(tuple(names))
        if self._last is None or self._last[0] is not chunk:
            self._last = chunk, motion_of(self.model, chunk, self._timed)
        motion, out = self._last[1], np.empty((len(chunk), len(names)))
        with np.errstate(all="ignore"):  # a state may have stopped being finite
            for quantity, (columns, to) in plan.items():
                out[:, to] = motion.values(quantity).reshape(len(chunk), -1)[:, columns]
        for at, name in enumerate(names):
            if own := self._own.get(name):
                out[:, at] = own.values(self.model, self.columns, chunk)
        return out

    def error_level(self, names: Sequence[str]) -> float:
        """Error level of quantities: the absolute tolerance times the largest magnitude that they
        have in a state of size one."""
        sizes = np.abs(self.columns(names, self._some))
        return self._atol * float(np.where(np.isfinite(sizes), sizes, 0.0).max(initial=0.0))

    def _add_expression(self, name: str, field: str) -> PlotQuantity:
        if len(self._own) >= MOST_OWN:
            raise InputError(field, name, f"one of the {MOST_OWN} expressions that are known")
        known = self._places.keys()
        own = self._own[name] = UserExpression.parse(name, known, field)
        told = {one.name: one.unit for one in self.quantities.values() if one.kind != STATE}
        found = self.quantities[name] = PlotQuantity(name, name, own.unit(told), OWN)
        return found

    def quantity(self, name: object, field: str = "quantity") -> PlotQuantity:
        """Look up a quantity, or add an expression. Raises InputError with the known names."""
        if isinstance(name, str) and name in self.quantities:
            return self.quantities[name]
        if isinstance(name, str) and not name.isidentifier():
            return self._add_expression(name, field)
        allowed = f"one of {patterns_of(self.quantities)}"
        raise InputError(field, name, allowed + did_you_mean(name, self.quantities))

    def expand(self, name: object, field: str = "quantity") -> list[str]:
        """Names that a name or a kind stands for. Raises InputError with the known names."""
        if isinstance(name, str) and name in self.kinds:
            return [one for one in self.kinds[name] if one not in self._absent]
        return [self.quantity(name, field).name]

    def _make_plan(self, names: tuple[str, ...]) -> dict[str, _ColumnCopy]:
        """Find which columns of which quantities a set of names needs, without expressions."""
        wanted: dict[str, list[tuple[int, int]]] = {}
        for at, name in enumerate(names):
            if self.quantity(name).kind != OWN:
                place = self._places[name]
                wanted.setdefault(place.quantity, []).append((place.column, at))
        return {quantity: tuple(np.transpose(pairs)) for quantity, pairs in wanted.items()}


def motion_of(model: ModuleType, chunk: Chunk, timed: Mapping[str, Any]) -> MotionSlice:
    """Motion at the samples of a chunk; timed: loads that change with time."""
    works = dict(zip(chunk.works, chunk.work.T, strict=True))
    return MotionSlice(model, chunk.p, chunk.y, chunk.t, works, chunk.given, chunk.start, timed)


def _scalars(scene: Scene, works: tuple[str, ...]) -> Iterator[tuple[PlotQuantity, _Place]]:
    loads = [PARAMETERS[name] for name in scene.loads.parameters]
    terms = {
        WORKS: {term: describe(term) for term in works},
        POWERS: {term: describe(term) for term in works},
        LOADS: {one.name: one.label for one in loads if one.timed and one.unit == "N"},
        ADDED: {name: name for name in scene.states},
        IN_AIR: {name: describe(name) for name in scene.loads.air_places},
        **{one.kind: {} for one in scene.structure.contacts},
        "": {"": ""},
    }
    for one in scene.structure.contacts:
        terms[one.kind] |= {one.name: describe(one.name)}
    held = sorted({tie.link for tie in scene.anchors.support_points})
    for quantity in QUANTITIES:
        if quantity.name == "gravity_energy" and not scene.structure.potentials:
            continue
        unit = typeset(quantity.unit)
        for term, words in terms.get(quantity.each, {}).items():
            for name, label, kind, at, along in numbers(
                quantity, scene.boundary_condition, scene.rod.links, held
            ):
                column = sum(at) if len(at) < 2 else 2 * at[0] + at[1]  # of x and y by joint
                shown = PlotQuantity(name.format(term), label.format(words), unit, kind)
                yield shown, _Place(quantity.name.format(term), column, along)
