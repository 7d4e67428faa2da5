"""Expressions of a scene that follow its motion, as functions of sensors and states in SymPy.

SymPy knows the arguments of such a law and the symbols of its derivatives by them; the text of both
is that of the scene's grammar.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from sympy import Expr, Function, Rational, Symbol

from rodgen.derive.general import GeneralEquations
from rodgen.derive.link_properties import Rod
from rodgen.derive.loads import loads_of
from rodgen.derive.loads.joint_stop import JointStop
from rodgen.derive.loads.stop import Stop
from rodgen.derive.sensors import SensorPoint, point_at
from rodgen.derive.symbols import n
from rodgen.scene.contact_terms import stop_name
from rodgen.scene.expression import Expression
from rodgen.scene.grammar import OF_STOPS, Language, Sensor
from rodgen.scene.structure import Structure

HIDDEN = 2.0  # place of the first sensor that no law names
SENSOR, STATE, RATE_OF = "sensor_", "state_", "rate_"  # before the number of one, the name of one


class LawFunction(Function):  # type: ignore[misc]  # SymPy has no types
    """A law of the numbers that it is called with, or its derivative by one of them."""

    name: ClassVar[str]
    expression: ClassVar[Expression]
    places: ClassVar[dict[str, slice]]
    by: ClassVar[str] = ""

    def fdiff(self, argindex: int = 1) -> Expr:
        """Symbol of the derivative by one of its arguments."""
        return _gain_symbol(self.name, argindex - 1)

    def text(self, language: Language, start: str, clock: str, signals: Sequence[str]) -> str:
        """Code of its value; start: of p; clock, signals: code of the time, and of what it is
        called with."""
        known = {"t": clock} | dict(zip(self.expression.signals, signals, strict=True))
        if self.by:
            return self.expression.derivative_source(self.by, language, self.places, start, known)
        return self.expression.source(language, self.places, start, known)


def _push_symbol(of: Sensor) -> Symbol:
    return Symbol(f"{of.what}_{int(of.at)}_push", real=True)


def _gain_symbol(name: str, at: int) -> Symbol:
    return Symbol(f"{name}_by_{at}", real=True)


@dataclass(frozen=True)
class Laws:
    """The laws of a structure, and the sensors that they read."""

    structure: Structure

    @cached_property
    def points(self) -> list[tuple[Sensor, SensorPoint]]:
        """Sensors in their order, each with the point that it is fixed to."""
        structure, places = self.structure, dict(self.structure.sensor_places)
        rod, boundary = Rod(structure.inertia, structure.nonuniform), structure.boundary_condition
        found = []
        for of in structure.sensors:
            if of.what in OF_STOPS:
                continue
            if (text := places.get(repr(of.at))) is None:
                place = Rational(repr(of.at)) * structure.n_links
            else:
                link, _, share = text.partition("+")
                place = Rational(link) + Rational(share or 0) if text else structure.n_links
            found.append((of, point_at(place, structure.n_links, boundary, rod)))
        for number, (stop, measured) in enumerate(self._stops.values()):
            for what, place in stop.inputs:
                of = Sensor(what, HIDDEN + number + len(found))
                place = place.subs(n, structure.n_links)
                measured.append(Symbol(f"{SENSOR}{len(found)}", real=True))
                found.append((of, point_at(place, structure.n_links, boundary, rod)))
        return found

    @cached_property
    def _stops(self) -> dict[Sensor, tuple[Stop | JointStop, list[Symbol]]]:
        """Stops that laws read, by sensor, each with the symbols of what its push follows."""
        structure = self.structure
        loads = loads_of(structure.terms, Rod(structure.inertia, structure.nonuniform))
        found: dict[Sensor, tuple[Stop | JointStop, list[Symbol]]] = {}
        for of in (one for one in structure.sensors if one.what in OF_STOPS):
            stop = loads[stop_name(of)]
            assert isinstance(stop, Stop | JointStop)
            found[of] = stop, []
        return found

    @cached_property
    def pushes(self) -> dict[Symbol, Expr]:
        """Pushes of the stops that laws read, by symbol, in what they follow."""
        if not self.points:  # which tells what they follow
            return {}
        of = self.structure
        chain = GeneralEquations(of.boundary, of.inertia, of.terms, of.nonuniform)
        stops = self._stops.items()
        return {_push_symbol(at): stop.push_of(chain, seen) for at, (stop, seen) in stops}

    @cached_property
    def sensors(self) -> dict[Symbol, Expr]:
        """Expressions that sensors measure, by symbol."""
        measured = (point.measurement(of.what) for of, point in self.points)
        return {Symbol(f"{SENSOR}{at}", real=True): e for at, e in enumerate(measured)}

    @cached_property
    def states(self) -> list[Symbol]:
        """Symbols of the states that are added."""
        return [Symbol(f"{STATE}{name}", real=True) for name in self.structure.state_names]

    @cached_property
    def sensor_symbols(self) -> dict[Sensor, Symbol]:
        """Symbols of what sensors measure, by sensor."""
        return {of: symbol for (of, _), symbol in zip(self.points, self.sensors, strict=True)}

    def _signals(self, expression: Expression) -> list[Symbol]:
        named = {of.text: symbol for of, symbol in self.sensor_symbols.items()}
        named |= {of.text: _push_symbol(of) for of in self._stops}
        named |= dict(zip(self.structure.state_names, self.states, strict=True))
        return [named[signal] for signal in expression.signals]

    def _law(self, name: str, by: int | None = None) -> Expr:
        expression = self.structure.laws[name]
        known = {"name": name, "expression": expression, "places": self.structure.slices}
        known |= {"by": "" if by is None else expression.signals[by]}
        kind = type(name if by is None else str(_gain_symbol(name, by)), (LawFunction,), known)
        return kind(*self._signals(expression))

    @cached_property
    def inputs(self) -> list[Symbol]:
        """Symbols of the parameters that follow the motion."""
        names = [name for name in self.structure.laws if not name.startswith(RATE_OF)]
        return [Symbol(name, real=True) for name in names]

    @cached_property
    def rates(self) -> dict[str, Expr]:
        """Rates of the states that are added, by name."""
        names = (f"{RATE_OF}{name}" for name in self.structure.state_names)
        return {name: self._law(name) for name in names}

    @cached_property
    def gains(self) -> dict[Symbol, tuple[str, Symbol, Expr]]:
        """Derivatives of laws by symbol: name of the law, argument, and expression of each."""
        found = {}
        for name, expression in self.structure.laws.items():
            for at, signal in enumerate(self._signals(expression)):
                found[_gain_symbol(name, at)] = name, signal, self._law(name, at)
        return found

    @property
    def push_names(self) -> dict[str, str]:
        """Names of the pushes, by the texts that a scene has for them."""
        return {of.text: str(_push_symbol(of)) for of in self._stops}

    @cached_property
    def seen_gains(self) -> dict[Symbol, tuple[str, Symbol, Expr]]:
        """Derivatives of laws by what is measured and by added states, likewise: of one that reads
        a stop by what its push follows."""
        found = {}
        for gain, (name, signal, e) in self.gains.items():
            if signal not in self.pushes:
                found[gain] = name, signal, e
                continue
            push = self.pushes[signal]
            for seen in sorted(push.free_symbols & {*self.sensors}, key=str):
                found[Symbol(f"{gain}_{seen}", real=True)] = name, seen, gain * push.diff(seen)
        return found

    @cached_property
    def signal_expressions(self) -> dict[str, Expr]:
        """Sensors and parameters that follow the motion, by name."""
        every = (*self.sensors, *self.pushes, *self.inputs)
        return {str(symbol): self.definitions[symbol] for symbol in every}

    @cached_property
    def definitions(self) -> dict[Symbol, Expr]:
        """Expressions of all that a function may read, by symbol."""
        fed = {symbol: self._law(str(symbol)) for symbol in self.inputs}
        gains = {name: e for name, (_, _, e) in self.gains.items()}
        return fed | self.pushes | self.sensors | gains
