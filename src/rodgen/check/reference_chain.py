"""A chain at one state in mpmath numbers: its sizes, positions, springs and masses, by hand."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from types import ModuleType
from typing import Any

import numpy as np
from mpmath import mp, mpf, mpmathify
from sympy import Dummy, Indexed, IndexedBase, Symbol, lambdify

from rodgen.derive.base_motion import ORDERS
from rodgen.derive.closed_form import Arithmetic, ClosedForm, LinkMasses, link_masses, link_sizes
from rodgen.derive.link_properties import Rod
from rodgen.derive.loads import loads_of
from rodgen.derive.symbols import bend, k, l, m, n, phi
from rodgen.emit.spring_expression import law_of
from rodgen.loading.generated_module import structure_of
from rodgen.model.terms import MOVING_BASE
from rodgen.scene import grammar, spring_law
from rodgen.scene.grammar import LINEAR, TABLE, Sensor, TableData

FIFTY_DIGITS = Arithmetic(
    mp.cos,
    mp.sin,
    mpf(1) / 2,
    lambda term, low, high: mp.fsum(term(q) for q in range(low, high + 1)),
)


def _table(table: TableData, x: Any, kind: str) -> Any:
    """Value of a table of numbers; of straight lines, in the present precision."""
    knots, values = table.knots, table.values
    if kind != LINEAR or not knots[0] < x < knots[-1]:
        return mpf(float(table.at(float(x), kind)))
    i = bisect_right(knots, x) - 1
    (a, b), (u, v) = (map(mpf, pair[i : i + 2].tolist()) for pair in (knots, values))
    return u + (v - u) * (x - a) / (b - a)


# Functions of the grammar of expressions.
FUNCTIONS = {name: getattr(mp, name) for name in grammar.FUNCTIONS if hasattr(mp, name)}
FUNCTIONS |= {TABLE: _table}


def base_by_hand(number: Mapping[str, Any]) -> tuple[Any, ...]:
    """Place, velocity and acceleration of what holds a rod, each (x, y), and the angle of its clamp
    over clamp_angle with its two derivatives; zero for what is not among the numbers."""
    x, y, angle = (
        [number.get(f"{MOVING_BASE}_{key}{order}", mpf(0)) for order in ORDERS]
        for key in ("x", "y", "angle")
    )
    return *zip(x, y, strict=True), *angle


class ReferenceChain:
    """The chain of a module at one state, in mpmath numbers of the present precision, without its
    equations."""

    # Forces and moments of loads that follow the motion, by joint or link.
    force_values: dict[IndexedBase, dict[int, Any]]

    def __init__(self, module: ModuleType, values: dict[str, Any], y: np.ndarray):
        self.n, self.structure = module.N, structure_of(module)
        rod = Rod(self.structure.inertia, self.structure.nonuniform)
        self.acting = loads_of(module.TERMS, rod)
        boundary = self.structure.boundary_condition
        number: dict[str, Any] = {
            name: [mpmathify(v) for v in value] if np.ndim(value) else mpmathify(value)
            for name, value in values.items()
        }
        self.number = number
        M, L = number["mass"], number["length"]
        self.m, self.l, self.k = link_sizes(M, L, number.get("bending_stiffness", mpf(0)), self.n)
        joints = boundary.spring_joints(self.n)
        stiffness, rest = (
            dict(zip(joints, number[name], strict=True)) if name in number else None
            for name in ("joint_stiffness", "rest_angle")
        )
        added = getattr(module, "STATES", {})
        half, base = (len(y) - len(added)) // 2, 2 * boundary.translates
        q, u, z = ([mpmathify(v) for v in part] for part in np.split(y, [half, 2 * half]))
        self.signals: dict[str, Any] = dict(zip(added, z, strict=True))
        self.rates: list[Any] = []
        held = boundary.first
        self.u, self.boundary = u, boundary
        self.base = base_by_hand(number)
        self.origin, self.v0 = ((q[0], q[1]), (u[0], u[1])) if base else self.base[:2]
        self.clamp = [number.get("clamp_angle", 0) + self.base[3], *self.base[4:]]
        self.phi = [self.clamp[0]] * held + q[base:]
        self.omega = [self.clamp[1]] * held + u[base:]
        self.lumped = module.INERTIA == "lumped"
        sizes = self.n, self.m, self.l, self.k, self.phi
        half, nonuniform = FIFTY_DIGITS.half, getattr(module, "NONUNIFORM", ())
        links = link_masses(nonuniform, number.__getitem__, self.lumped, half)
        how = boundary, FIFTY_DIGITS, self.lumped
        self.closed = ClosedForm(*sizes, *how, stiffness, links, rest, number.get("link_length"))
        # Every angle that a spring knows; stiffness and rest angle between it and the next.
        root, tail = (
            [size] if size else [] for size in (self.closed.root_size, self.closed.tail_size)
        )
        clamp = [self.clamp[0]] if boundary.is_clamped else []
        self.bent = clamp * len(root) + self.phi + clamp * len(tail)
        inner = (*root, *[1] * (self.n - 1), *tail)
        self.stiffness = list(map(self.closed.spring_stiffness, joints, inner))
        self.rest = [mpf(0)] * len(joints) if rest is None else list(rest.values())

    def value(self, of: Any) -> Any:
        """A parameter, forces at the joints, or an expression in parameters and angles."""
        if isinstance(of, IndexedBase):
            return self.number[str(of)] if str(of) in self.number else self.force_values[of]
        if isinstance(of, Symbol):
            return self._number(of)
        expression = of.subs(n, self.n)
        known = {x: self._number(x) for x in expression.atoms(Symbol, Indexed)}
        known = {x: number for x, number in known.items() if number is not None}
        letters = {x: Dummy() for x in known}
        function = lambdify(letters.values(), expression.xreplace(letters), "mpmath")
        return mpf(0) + function(*known.values())

    def _number(self, of: Any) -> Any:
        """Value of a symbol; None of the name of an array."""
        if isinstance(of, Indexed):
            values = self.phi if of.base == phi else self.value(of.base)
            return values[int(of.indices[0])]
        number = self.number.get(str(of))
        return {m: self.m, l: self.l, k: self.k}.get(
            of, None if isinstance(number, list) else number
        )

    def joints(self) -> list[tuple[Any, Any]]:
        """Positions of the joints."""
        return self._running_sums(self.origin, self.closed.joint_step)

    @cached_property
    def _velocities(self) -> list[tuple[Any, Any]]:
        return self._running_sums(self.v0, self.closed.velocity_step, self.omega)

    @cached_property
    def links(self) -> LinkMasses:
        """Mass, centre and spread of every link; of an even rod, all alike."""
        kept = link_masses(("mass",), lambda _: [self.m] * self.n, self.lumped, FIFTY_DIGITS.half)
        assert kept is not None
        return self.closed.links_differ or kept

    def centre_of_gravity(self) -> tuple[Any, Any]:
        """Mean of the centres of the links, by their mass."""
        masses = [self.links.mass(q) for q in range(self.n)]
        x, y = zip(*self._centres(), strict=True)
        return dot(masses, x) / mp.fsum(masses), dot(masses, y) / mp.fsum(masses)

    def inertia(self) -> list[Any]:
        """Moments and product of inertia: those of the links about their centres, turned with
        them, and of the centres (Steiner)."""
        X, Y = self.centre_of_gravity()
        x, y, xy = mpf(0), mpf(0), mpf(0)
        for q, (a, b) in enumerate(self._centres()):
            m, c, s = self.links.mass(q), mp.cos(self.phi[q]), mp.sin(self.phi[q])
            along, across, mixed = (m * self.closed.length(q) ** 2 * of for of in self._spread(q))
            x += along * s**2 + across * c**2 + 2 * mixed * s * c + m * (b - Y) ** 2
            y += along * c**2 + across * s**2 - 2 * mixed * s * c + m * (a - X) ** 2
            xy += (along - across) * s * c + mixed * (c**2 - s**2) + m * (a - X) * (b - Y)
        return [x, y, xy]

    def _spread(self, q: int) -> tuple[Any, Any, Any]:
        """Mean squares and product of the mass of a link about its centre, over l^2."""
        if "link_spread_along" in self.number:
            along, across, mixed = (
                self.number[f"link_spread_{way}"][q] for way in ("along", "across", "mixed")
            )
            return along, across, mixed
        return self.links.second(q) - self.links.along(q) ** 2, mpf(0), mpf(0)

    def _centres(self) -> list[tuple[Any, Any]]:
        """Centres of gravity of the links."""
        found = []
        for q, (x, y) in enumerate(self.joints()[:-1]):
            l = self.closed.length(q)
            a, b = l * self.links.along(q), l * self.links.across(q)
            c, s = mp.cos(self.phi[q]), mp.sin(self.phi[q])
            found.append((x + a * c - b * s, y + a * s + b * c))
        return found

    def _running_sums(
        self, start: tuple[Any, Any], step: Any, *of_link: Sequence[Any]
    ) -> list[tuple[Any, Any]]:
        """Running sums from the start over the steps of the links, one for every joint."""
        values = [start]
        for link in range(self.n):
            dx, dy = step(link, *(of[link] for of in of_link))
            values.append((values[-1][0] + dx, values[-1][1] + dy))
        return values

    def bending_moments(self) -> list[Any]:
        """Moments of the springs in all joints; zero where there is none."""
        moments = [mpf(0)] * (self.n + 1)
        for s, (stiffness, angle) in zip(
            self.boundary.spring_joints(self.n), self._springs(), strict=True
        ):
            moments[s] = self._spring_law(stiffness, angle)
        return moments

    def _springs(self) -> list[tuple[Any, Any]]:
        """Stiffness of every spring, and the angle by which it is bent."""
        ends = zip(pairwise(self.bent), self.rest, strict=True)
        return list(zip(self.stiffness, (b - a - rest for (a, b), rest in ends), strict=True))

    @cached_property
    def _spring_law(self) -> Any:
        """Law of the springs: moment by stiffness and angle."""
        numbers = [*self.structure.numbers]
        law = lambdify((k, bend, *numbers), law_of(self.structure), "mpmath")
        return lambda *of: law(*of, *(self.number[name] for name in numbers))

    def _spring_energy(self, stiffness: Any, angle: Any) -> Any:
        """Energy of a spring: k d^2/2 by Hooke's law, else the integral of its moment, in parts
        between the angles at which it is not smooth."""
        if not self.structure.spring:
            return stiffness * angle**2 / 2
        values = {name: float(self.number[name]) for name in self.structure.numbers}
        law = self.structure.spring_law.with_values(
            values | {spring_law.STIFFNESS: float(stiffness)}
        )
        low, high = sorted((0.0, float(angle)))
        ends = [0, *law.breaks(low, high)[:: 1 if angle > 0 else -1], angle]
        return mp.quad(lambda d: self._spring_law(stiffness, d), ends)

    def sensor_value(self, sensor: Sensor) -> Any:
        """Value that a sensor measures."""
        link, share = self._sensor_place(sensor)
        if sensor.what in ("phi", "omega"):
            return (self.phi if sensor.what == "phi" else self.omega)[link]
        if sensor.what in ("x", "y"):
            starts, way = self.joints(), self.closed.joint_step(link)
        else:
            starts, way = self._velocities, self.closed.velocity_step(link, self.omega[link])
        axis = int(sensor.what[-1] == "y")
        return starts[link][axis] + share * way[axis]

    def _sensor_place(self, sensor: Sensor) -> tuple[int, Any]:
        """Link of a sensor and share of that before its point."""
        text = dict(self.structure.sensor_places).get(repr(sensor.at))
        if text is not None:
            link, _, share = text.partition("+")
            over = Fraction(share or 0)
            return (int(link), mpf(over.numerator) / over.denominator) if text else (self.n - 1, 1)
        at = mpf(repr(sensor.at)) * self.n
        link = min(int(at), self.n - 1)
        return link, at - link

    def point_force(self, link: int, share: float, force: tuple[float, float]) -> list[Any]:
        """Generalised forces of a force at a share of a link: the force times the derivatives of
        its point by the coordinates."""
        fx, fy = map(mpf, force)
        arms = [mpf(1)] * link + [mpf(share)] + [mpf(0)] * (self.n - link - 1)
        turning = [
            arm * self.closed.length(q) * (fy * mp.cos(angle) - fx * mp.sin(angle))
            for q, (arm, angle) in enumerate(zip(arms, self.phi, strict=True))
        ]
        return [*([fx, fy] if self.boundary.translates else []), *turning[self.boundary.first :]]


def matrix_vector(matrix: list[list[Any]], vector: Sequence[Any]) -> list[Any]:
    """Product of a matrix, as rows, and a vector."""
    return [dot(row, vector) for row in matrix]


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Sum of the products of the elements of two vectors."""
    return mp.fsum(x * y for x, y in zip(a, b, strict=True))


def add(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """Sum of two vectors."""
    return [x + y for x, y in zip(a, b, strict=True)]
