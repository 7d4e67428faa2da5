"""Inputs and outputs of linear models, by their names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError, did_you_mean
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.model.quantities import FLOW, find_quantity
from rodgen.model.terms import PARAMETERS
from rodgen.scene import Scene
from rodgen.scene.grammar import Sensor, parse, sensors_in
from rodgen.scene.keys import NUMBERS
from rodgen.system import System

ADDED = "states"  # the table of added states
UNITS = {"phi": "rad", "omega": "rad/s", "x": "m", "y": "m", "vx": "m/s", "vy": "m/s"}
# Names in the module's `outputs` of the numbers of some quantities, by the number of their axis.
MEASURED = {
    "joints": ("joint_x", "joint_y"),
    "tip": ("joint_x", "joint_y"),
    "centre_of_gravity": ("centre_x", "centre_y"),
    "bending_moments": ("bending",),
}


class InputSignal(NamedTuple):
    """An input: its value and unit, and what it changes by one: states (states,), inputs of the
    module (inputs,), and rates beside these (states,)."""

    value: float
    unit: str
    states: Array
    weights: Array
    rates: Array


class OutputSignal(NamedTuple):
    """An output: its value and unit, and its derivatives by the states (states,), by the inputs of
    the module (inputs,) and by what changes rates beside these (states,)."""

    value: float
    unit: str
    by_state: Array
    by_inputs: Array
    by_rates: Array


class Place(NamedTuple):
    """Where a quantity is in the module's `outputs`: its name there, and the joint, if any."""

    name: str
    joint: tuple[int, ...]


def check_names(given: Any, field: str) -> list[str]:
    """Check a list of different names, and return it. Raises InputError for anything else."""
    names = list(given) if isinstance(given, Iterable) and not isinstance(given, str) else None
    if names is None or not all(isinstance(name, str) for name in names):
        raise InputError(field, given, "a list of names, also of one alone")
    if len({*names}) < len(names):
        raise InputError(field, given, "names of which none is there twice")
    return names


def find_place(name: str, scene: Scene) -> Place | None:
    """Where a quantity is in the module's `outputs`; None of what is not there."""
    if name in {f"{what}_{load}" for what in FLOW for load in scene.loads.air_places}:
        return Place(name, ())
    try:
        quantity, at = find_quantity(name)
    except KeyError:
        return None
    if quantity.name not in MEASURED:
        return None
    parts = MEASURED[quantity.name]
    part = parts[at[-1]] if len(parts) > 1 else parts[0]
    joint = (scene.rod.links,) if quantity.name == "tip" else at[: len(at) - (len(parts) > 1)]
    return Place(part, joint)


@dataclass(frozen=True)
class LinearPoint:
    """A rod at a time and in a state, with inputs and outputs.

    system: the rod; extended: the same with the expressions among the outputs as added states,
    which are the last, and whose rates they are; expressions: their texts; t [s]; state (states,),
    of the extended one.
    """

    system: System
    extended: System
    expressions: tuple[str, ...]
    t: float
    state: Array

    @classmethod
    def of(cls, system: System, outputs: Iterable[str], t: float, y: Array) -> LinearPoint:
        """Set up for some outputs. Raises InputError for what is no state, quantity or
        expression."""
        scene, known = system.scene, {*system.model("numpy").STATE}
        texts = [x for x in outputs if x not in known and find_place(x, scene) is None]
        if not texts:
            return cls(system, system, (), t, y)
        added = dict[str, dict[str, str]]()
        for text in texts:
            name = f"output_{len(added) + 1}"
            while name in scene.states:
                name += "_"
            added[name] = {"rate": text}
        tables = scene.model_dump(exclude_none=True).get(ADDED, {})
        try:
            extended = System(scene.replace({ADDED: tables | added}))
        except InputError as error:
            _, name, *_ = *error.field.split("."), ""
            if name not in added:
                raise
            text, allowed = added[name]["rate"], error.allowed.replace(f", {name}", "")
            if text.isidentifier():
                allowed = "a state, a quantity such as tip_x, or an expression such as omega(0.3)"
                allowed += did_you_mean(text, [*known, *MEASURED])
            raise InputError("outputs", text, allowed) from None
        return cls(system, extended, tuple(texts), t, np.append(y, np.zeros(len(texts))))

    @property
    def _at(self) -> tuple[float, Array, Array]:
        """Arguments of functions of the module."""
        return self.t, self.state, self.extended.p

    @cached_property
    def model(self) -> ModuleType:
        """Module with the derivatives."""
        return self.extended.model("numpy", parts=("rhs", "jac", "inputs"))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the states, without those of expressions."""
        return tuple(self.model.STATE[: len(self.state) - len(self.expressions)])

    @cached_property
    def rates(self) -> Array:
        """Rates of the states (states,); of expressions their values."""
        return np.asarray(self.model.rhs(*self._at))

    @cached_property
    def by_state(self) -> Array:
        """Derivatives of the rates by the states (states, states)."""
        return np.asarray(self.model.jac(*self._at))

    @cached_property
    def by_inputs(self) -> Array:
        """Derivatives of the rates by the inputs of the module (states, inputs)."""
        return np.asarray(self.model.inputs(*self._at))

    @cached_property
    def motion(self) -> MotionSlice:
        """The rod in this state."""
        return MotionSlice(self.model, self.extended.p, self.state, np.asarray(self.t))

    # Inputs -------------------------------------------------------------------------------------

    def input(self, key: str) -> InputSignal:
        """Find an input by its key. Raises InputError for what is none."""
        table, _, name = key.partition(".")
        none, weights, nothing = "", np.zeros(len(self.model.INPUTS)), np.zeros(len(self.state))
        if table == ADDED and name in self.system.structure.state_names:
            at = self.names.index(name)
            own = np.eye(len(self.state))[at]
            return InputSignal(float(self.state[at]), none, own, weights, nothing)
        if table == NUMBERS:
            weights, rates = self._number_weights(name, key)
            return InputSignal(self.extended.parameter(name), none, nothing, weights, rates)
        scene = self.extended.scene
        every = [one for one in self.model.INPUTS if scene.key_of(one) == key]
        if not every:
            raise InputError("inputs", key, self._allowed_inputs(key))
        values = {self._input_value(one) for one in every}
        value = values.pop() if len(values) == 1 else np.nan  # at the heights of several points
        weights = np.isin(self.model.INPUTS, every).astype(float)
        return InputSignal(value, PARAMETERS[every[0]].unit, nothing, weights, nothing)

    def _allowed_inputs(self, key: str) -> str:
        scene = self.system.scene
        known = [*dict.fromkeys(map(self.extended.scene.key_of, self.model.INPUTS))]
        known += [f"{ADDED}.{name}" for name in scene.states]
        known += [f"{NUMBERS}.{name}" for name in scene.numbers]
        hint = did_you_mean(key, known)
        return f"one of {', '.join(known)}{hint}" if known else "absent: the scene has no loads"

    def _input_value(self, name: str) -> float:
        """Value of an input of the module: a number, or that of its law."""
        structure = self.extended.structure
        if name in structure.slices:
            return float(self.extended.parameter(name))
        if name in structure.laws:
            return float(self._signals[name])
        values = structure.expression_values(self.extended.p)
        return float(structure.open_expressions[name].with_values(values)(self.t))

    @cached_property
    def _signals(self) -> dict[str, Any]:
        """Values of sensors, of loads that follow the motion, and of added states."""
        measured = getattr(self.model, "signals", None)
        found = {} if measured is None else measured(*self._at)
        added = self.extended.structure.state_names
        own = self.state[len(self.state) - len(added) :]
        return dict(found) | dict(zip(added, own.tolist(), strict=True))

    def _number_weights(self, number: str, key: str) -> tuple[Array, Array]:
        """Derivatives by a number of [parameters] of the inputs of the module (inputs,), and of the
        rates of added states (states,). Raises InputError for one that is in anything else."""
        structure, inputs = self.extended.structure, self.model.INPUTS
        if number not in self.system.scene.numbers:
            raise InputError("inputs", key, self._allowed_inputs(key))
        slot, laws = self.extended.parameter_map.slot(key), structure.open_expressions
        elsewhere = [e for name, e in laws.items() if name not in inputs]
        elsewhere += (*structure.open_masses.values(), *structure.open_along.values())
        if slot is None or any(number in e.names for e in (*elsewhere, structure.spring_law)):
            allowed = "a number that laws of loads and rates of states name, and nothing else"
            raise InputError("inputs", key, allowed)
        values = structure.expression_values(self.extended.p)
        weights, rates = np.zeros(len(inputs)), np.zeros(len(self.state))
        places = {name: (weights, at) for at, name in enumerate(inputs)}
        first = len(self.state) - len(structure.state_names)
        places |= {name: (rates, first + at) for at, name in enumerate(structure.state_names)}
        for name, e in (laws | structure.open_rates).items():
            if number in e.names:
                made, at = places[name]
                slope = e.with_values(values).derivative(self.t, self._signals, by=number)
                made[at] = float(slope)
        return weights, rates

    # Outputs ------------------------------------------------------------------------------------

    def output(self, name: str) -> OutputSignal:
        """Find an output that is a state, a quantity or one of the expressions. Raises
        InputError."""
        own, nothing = np.eye(len(self.state)), np.zeros(len(self.state))
        if name in self.names:
            at = self.names.index(name)
            none = np.zeros(len(self.model.INPUTS))
            return OutputSignal(float(self.state[at]), state_unit(name), own[at], none, nothing)
        if name in self.expressions:
            at = len(self.names) + self.expressions.index(name)
            derivatives = self.by_state[at], self.by_inputs[at], own[at]
            return OutputSignal(float(self.rates[at]), _sensor_unit(name), *derivatives)
        return self._quantity(name)

    def _quantity(self, name: str) -> OutputSignal:
        place = find_place(name, self.system.scene)
        assert place is not None
        try:
            by_state, by_inputs = (part[place.joint] for part in self._measured[place.name])
            unit, value = self._measure(name)
        except IndexError:
            joints = f"0 to {self.system.structure.n_links}"
            raise InputError("outputs", name, f"of a joint of the rod, {joints}") from None
        if not (np.isfinite(by_state).all() and np.isfinite(by_inputs).all()):
            raise InputError("outputs", name, "absent at rest, where it has no derivative")
        return OutputSignal(value, unit, by_state, by_inputs, np.zeros(len(self.state)))

    @cached_property
    def _measured(self) -> dict[str, tuple[Array, Array]]:
        """Derivatives of what may be measured, by the states and by the inputs."""
        return dict(self.model.outputs(*self._at))

    def _measure(self, name: str) -> tuple[str, float]:
        """Unit and value of a quantity."""
        if name.startswith(FLOW):
            return ("m/s" if name.startswith(FLOW[0]) else "rad"), float(self.motion.values(name))
        quantity, at = find_quantity(name)
        return quantity.unit, float(self.motion.values(quantity.name)[at])


def state_unit(name: str) -> str:
    """Unit of a state of a module; none of an added one."""
    what, _, number = name.rpartition("_")
    if what in ("phi", "omega") and number.isdecimal():
        return UNITS[what]
    return UNITS[name[:-1]] if name in ("x0", "y0", "vx0", "vy0") else ""


def _sensor_unit(text: str) -> str:
    """Unit of an expression that is one sensor; none of others."""
    tree = parse(text, "outputs")
    sensors: list[Sensor] = [] if tree is None else [*sensors_in(tree)]
    plain = text.replace(" ", "")
    alone = [of for of in sensors if plain.startswith(f"{of.what}(") and plain.count("(") == 1]
    return UNITS.get(alone[0].what, "") if alone and plain.endswith(")") else ""
