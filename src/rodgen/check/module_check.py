"""Comparison of a generated module with the hand-assembled form in 50-digit arithmetic.

The closed form is assembled entry by entry and solved by mpmath, so nothing is shared with the
module but its parameters and states.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
from mpmath import mpf

from rodgen.check.reference_chain import FUNCTIONS
from rodgen.check.reference_equations import ReferenceEquations
from rodgen.derive.base_motion import ORDERS
from rodgen.errors import InputError
from rodgen.loading.generated_module import call_module, structure_of
from rodgen.memory import check_memory
from rodgen.model.term import AT_LEAST_ONE, SIDE
from rodgen.progress import report_stage
from rodgen.result import Result, Row
from rodgen.scene.link_parts import link_parameters_at, mesh_of
from rodgen.scene.rod_mesh import cell_means

DIGITS = 50
DRAWS = 100  # of parameters, until loads are finite
PAIR = 1e3  # bytes for every pair of links, of matrices of so many digits
LIMIT = 1e-10  # relative; about a thousand times what n = 50 reaches


@dataclass(frozen=True)
class Deviation:
    """Largest relative error of one quantity over the states of one kind."""

    quantity: str
    states: str
    error: float


@dataclass(frozen=True, repr=False)
class ModuleCheck(Result):
    """Comparison of a module with the hand-assembled form. module: its name; deviations: largest
    relative errors, by quantity and kind of state."""

    module: str
    deviations: tuple[Deviation, ...]

    ROWS = (
        Row("module", "module"),
        Row("digits", "digits of the arithmetic", of=lambda _: DIGITS),
        Row("quantity", "quantity", along="comparison", of=lambda c: [d.quantity for d in c]),
        Row("states", "states", along="comparison", of=lambda c: [d.states for d in c]),
        Row("errors", "largest relative error", format=".2e", along="comparison"),
        Row("largest", "largest of all", format=".2e"),
        Row("allowed", "allowed", format="g", of=lambda _: LIMIT),
        Row("equal", "equal"),
    )

    @property
    def errors(self) -> list[float]:
        """Relative errors."""
        return [one.error for one in self.deviations]

    @property
    def largest(self) -> float:
        """The largest relative error."""
        return max(self.errors)

    @property
    def equal(self) -> bool:
        """Whether all errors are rounding."""
        return self.largest <= LIMIT

    def __iter__(self) -> Iterator[Deviation]:
        return iter(self.deviations)

    def __repr__(self) -> str:
        return f"<ModuleCheck of {self.module}: largest relative error {self.largest:.2e}>"


def check_module(module: ModuleType, states: int = 3, seed: int = 1) -> ModuleCheck:
    """Compare all that a module computes with the hand-assembled form, at so many random states
    near to and far from straight. Raises InputError as `deviations` does."""
    return ModuleCheck(module.__name__, tuple(deviations(module, states, seed)))


def deviations(module: ModuleType, states: int = 3, seed: int = 1) -> Iterator[Deviation]:
    """Compare all that a module computes at random states near to and far from straight.

    The error of a vector is its largest absolute error over its largest magnitude; that of
    energies or powers is taken relative to the largest among them. Raises InputError for so many
    links that there is not enough memory.
    """
    check_memory("matrices of many digits", module.N, lambda links: PAIR * links**2, "N")
    draw = np.random.default_rng(seed)
    for kind, spread, speed in (("near straight", 1e-3, 1e-2), ("far from straight", 3.0, 3.0)):
        worst: dict[str, float] = {}
        for _ in range(states):
            t = float(draw.uniform(0.0, 1.0))
            values, y = _draw(module, t, draw, spread, speed)
            for quantity, error in _compare(module, values, t, y):
                worst[quantity] = max(worst.get(quantity, 0.0), error)
                report_stage(f"{quantity}, {kind}")
        for quantity, error in worst.items():
            yield Deviation(quantity, kind, error)


def _draw(
    module: ModuleType, t: float, draw: np.random.Generator, spread: float, speed: float
) -> tuple[dict[str, Any], np.ndarray]:
    """Random parameters and a state at which rhs is finite, laws of the motion included."""
    for _ in range(DRAWS):
        values, y = _draw_parameters(module, t, draw), _draw_state(module, draw, spread, speed)
        if np.isfinite(module.rhs(t, y, module.parameters(**values))).all():
            return values, y
    allowed = f"one whose loads are finite in one of {DRAWS} random states"
    raise InputError("module", module.__name__, allowed)


def _draw_parameters(module: ModuleType, t: float, draw: np.random.Generator) -> dict[str, Any]:
    """Random values with which all loads are finite at a time."""
    structure = structure_of(module)
    for _ in range(DRAWS):
        values: dict[str, Any] = {
            name: draw.uniform(0.5, 5.0, len(structure.index_ranges[name]))
            if name in structure.index_ranges
            else float(draw.uniform(0.5, 5.0))
            for name in structure.parameters
        }
        for name in values:  # of masses at both ends of a link, between them
            if name.endswith("_along"):
                values[name] /= 5.1
        for row in structure.rows:  # of contacts
            if row.rule == SIDE:
                values[row.name] = float(draw.choice([-1.0, 1.0]))
            elif row.rule == AT_LEAST_ONE:
                values[row.name] = 1.0 + values[row.name] / 5.0
            elif row.key == "gap":
                values[row.name] -= 2.5
        for name in values.keys() & {"bending_stiffness", "joint_stiffness"}:
            values[name] *= 20.0
        every = [*structure.open_expressions.values(), *structure.open_rates.values()]
        every += (*structure.open_masses.values(), *structure.open_along.values())
        for knots in (knots for e in every for knots in e.knot_names):
            values |= zip(knots, sorted(values[name] for name in knots), strict=True)
        for name, rows in structure.tables:
            values[name][:rows].sort()
        if all(map(math.isfinite, _load_values(module, values, t).values())):
            return values
    allowed = f"one whose loads are finite for one of {DRAWS} random sets of parameters"
    raise InputError("module", module.__name__, allowed)


def _draw_state(
    module: ModuleType, draw: np.random.Generator, spread: float, speed: float
) -> np.ndarray:
    added = len(getattr(module, "STATES", ()))
    half = (len(module.STATE) - added) // 2
    angle = draw.uniform(-3, 3)
    y = np.empty(2 * half + added)
    y[:half] = angle + spread * draw.standard_normal(half)
    y[half:] = speed * draw.standard_normal(half + added)
    return y


def _load_values(module: ModuleType, values: dict[str, Any], t: float) -> dict[str, float]:
    """Values at a time of the loads that are expressions; 1 of those that follow the motion."""
    expressions = structure_of(module).open_expressions
    return {
        name: 1.0 if e.signals else float(e.with_values(values)(t))
        for name, e in expressions.items()
    }


def _link_means(module: ModuleType, values: dict[str, Any], t: float) -> dict[str, Any]:
    """Means over every link at a time of the loads that are functions of place as well."""
    structure, found = structure_of(module), {}
    places = mesh_of(structure, values).gauss_points()
    for name, e in structure.open_along.items():
        density = e.with_values(values).evaluate(np.float64(t), {"s": places})
        found[name] = cell_means(np.broadcast_to(density, places.shape))
    return found


def _base_derivatives(module: ModuleType, values: dict[str, Any], t: float) -> dict[str, Any]:
    """Derivatives at a time of what moves the base, by differences in the present precision; of a
    table, which is known in doubles alone, by its own slopes."""
    structure, found = structure_of(module), {}
    for name in structure.base_parameters:
        e = structure.open_expressions.get(name)
        e = e.with_values(values) if e else None
        for order, word in enumerate(ORDERS[1:], start=1):
            if e is None:
                value = mpf(0)
            elif e.has_table:
                value = mpf(float(e.derivative(t, {}, order)))
            else:
                exact = partial(e.evaluate, signals={}, functions=FUNCTIONS)
                value = mpmath.diff(lambda at, of=exact: mpf(0) + of(at), t, order)
            found[f"{name}{word}"] = value
    return found


def assemble(
    module: ModuleType, values: dict[str, Any], t: float, y: np.ndarray
) -> ReferenceEquations:
    """The hand-assembled equations with parameters of the module, at a time and a state."""
    structure, given = structure_of(module), values | _load_values(module, values, t)
    given |= _link_means(module, values, t) | _base_derivatives(module, values, t)
    if structure.masses:
        exact = ReferenceEquations(module, given | link_parameters_at(structure, values, t), y)
        gained = ReferenceEquations(
            module, given | link_parameters_at(structure, values, t, rates=True), y
        )
        exact.emptying = gained.energy()[0] + gained.weight_energy()
    else:
        exact = ReferenceEquations(module, given, y)
    exact.apply_laws({name: law.with_values(values) for name, law in structure.laws.items()}, t)
    return exact


def _compare(
    module: ModuleType, values: dict[str, Any], t: float, y: np.ndarray
) -> Iterator[tuple[str, float]]:
    """Every quantity of a module at one state, with its relative error."""
    p = module.parameters(**values)
    with mpmath.workdps(DIGITS):
        exact = assemble(module, values, t, y)
        yield "rhs", _vector_error(module.rhs(t, y, p), exact.rhs())
        mass = [entry for row in exact.closed.M() for entry in row]
        yield (
            "mass matrix",
            _vector_error(call_module(module, "mass_matrix", t, y, p).ravel(), mass),
        )
        yield "energy", _vector_error(call_module(module, "energy", t, y, p), exact.energy())
        if hasattr(module, "power"):
            power, by_hand = call_module(module, "power", t, t, y, p), exact.power()
            yield "power", _vector_error([power[x] for x in power], [by_hand[x] for x in power])
        joints = [c for joint in exact.joints() for c in joint]
        found = call_module(module, "joints", t, y, p)
        yield "joints", _vector_error(found.ravel(), joints)
        centre = exact.centre_of_gravity()
        found = call_module(module, "centre_of_gravity", t, y, p)
        yield "centre of gravity", _vector_error(found, centre)
        yield "inertia", _vector_error(call_module(module, "inertia", t, y, p), exact.inertia())
        yield (
            "bending moments",
            _vector_error(call_module(module, "bending_moments", t, y, p), exact.bending_moments()),
        )
        acting = exact.forces()
        if acting:
            forces, order = module.forces(t, y, p), sorted(acting)
            got = np.concatenate([forces[term].ravel() for term in order])
            yield "forces", _vector_error(got, [c for x in order for f in acting[x] for c in f])
        if by_hand := exact.contacts():
            found = module.contacts(t, y, p)
            names = found.keys() & by_hand.keys()
            got = np.concatenate([np.ravel(found[name]) for name in names])
            yield "contacts", _vector_error(got, [c for name in names for c in by_hand[name]])
        if by_hand := exact.air():
            found = module.air(t, y, p)
            yield "air", _vector_error([found[x] for x in by_hand], [*by_hand.values()])
        errors = []
        for link, share in ((0, 0.25), (module.N // 2, 0.0), (module.N - 1, 1.0)):
            force = values["mass"], -values["length"]  # any two numbers
            got = module.generalised_force(y, p, link, share, force)
            errors.append(_vector_error(got, exact.point_force(link, share, force)))
        yield "generalised force", max(errors)


def _vector_error(got: Sequence[Any] | np.ndarray, exact: Sequence[Any]) -> float:
    largest = max(abs(e) for e in exact)
    if not all(np.isfinite(float(g)) for g in got):
        return float("inf")
    off = max(abs(mpf(float(g)) - e) for g, e in zip(got, exact, strict=True))
    return float(off / largest) if largest else float(off)
