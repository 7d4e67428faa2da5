"""Derivation 3 against derivation 1: accelerations at a random rational point, exactly.

The system of joint forces is solved in rational numbers, and its accelerations are put into
M v' = Q omega^2 - K phi + loads of derivation 1: nothing may be left.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

from sympy import QQ, Expr, Matrix, Symbol, cos, sin
from sympy.polys.rings import PolyElement

from .angles import Angle
from .calculus import TIME
from .comparison import JOINTS, Comparison, DisagreementError
from .explicit import ExplicitDerivation
from .general import Array, Equations, drag_x, drag_y
from .joint_forces import joint_system
from .joint_system import System, alpha, link_moment
from .loads import TERMS
from .points import TURNED, evaluate, pythagorean
from .symbols import ALPHA, C_INT, F_TIP, NU, G, P, i, k, l, m, n, omega, phi


def prove_joint_forces(
    links: int, boundary: str, inertia: str, terms: Sequence[str] = TERMS, seed: int = 1
) -> Iterator[Comparison]:
    """Accelerations of derivation 3 at n links; raises DisagreementError."""
    point = _Point(links, boundary, inertia, tuple(terms), seed)
    accelerations = point.accelerations()
    for row, (name, residual) in enumerate(point.residuals(accelerations)):
        if residual != 0:
            raise DisagreementError(JOINTS, f"accelerations[{row}], {name}", residual, 0)
    yield Comparison("accelerations", JOINTS, len(accelerations))


class _Point:
    """A random state of a chain in rational numbers; angles and their directions are drawn apart,
    since the equations are polynomials in both."""

    def __init__(self, links: int, boundary: str, inertia: str, terms: tuple[str, ...], seed: int):
        self.links, self.terms, self.draw = links, terms, random.Random(seed)
        self.equations = Equations(boundary, inertia, terms)
        self.explicit = ExplicitDerivation(links, boundary, inertia)
        hold = self.equations.hold
        held = range(hold.first)
        clamp, clamp_direction = self._number(), self._direction()
        angles = [clamp if q in held else self._number() for q in range(links)]
        self.directions = [
            clamp_direction if q in held else self._direction() for q in range(links)
        ]
        rates = [Fraction(0) if q in held else self._number() for q in range(links)]
        tail = self._direction()
        self.drag = [[self._number() for _ in range(links + 1)] for _ in range(2)]
        self.values: dict[Any, Any] = {x: self._number() for x in (m, l, k, P, G, C_INT, *F_TIP)}
        self.values |= {n: links, ALPHA: clamp, phi: angles, omega: rates}
        self.values |= {drag_x: self.drag[0], drag_y: self.drag[1]}
        # What cosine and sine are taken of.
        self.values[TURNED] = {phi: self.directions, NU: tail, ALPHA: clamp_direction}

    def _number(self) -> Fraction:
        return Fraction(self.draw.randint(1, 30), self.draw.randint(1, 30))

    def _direction(self) -> Angle:
        return pythagorean(self._number())

    def accelerations(self) -> list[Fraction]:
        """Of joint 0 where it moves, then of the moving links."""
        system, values = joint_system(self.equations), dict(self.values)
        if self.links <= self.equations.hold.first_spring:  # no joint has a spring
            values[link_moment] = [Fraction(0)] * self.links
        for base, array in system.arrays.items():
            values.setdefault(base, _Lazy(array, values))
        self._solve(system, values)
        first = self.equations.hold.first
        links = range(first, self.links)
        turning = {q: evaluate(system.angular, {**values, i: q}) for q in links}
        values[alpha] = turning
        base = [evaluate(e, values) for e in system.base]
        return [*base, *(turning[q] for q in links)]

    def _solve(self, system: System, values: dict[Any, Any]) -> None:
        """Enter the solution of the system into the values."""
        low, high = (int(evaluate(e, values)) for e in (system.low, system.high))
        width, positions = len(system.unknowns), range(low, high + 1)
        size = width * len(positions)

        def block(matrix: Matrix, at: int) -> list[list[Fraction]]:
            here = {**values, system.index: at}
            return [[evaluate(e, here) for e in row] for row in matrix.tolist()]

        rows = [[Fraction(0)] * (size + 1) for _ in range(size)]
        solution = [dict[int, Fraction]() for _ in system.unknowns]
        given = [(low - 1, system.start), (high + 1, system.end)]
        for at, ends in given:
            for unknown, value in zip(solution, ends, strict=False):
                unknown[at] = evaluate(value, values)
        for at in positions:
            own, right = block(system.diagonal, at), block(system.right, at)
            neighbours = {at: own, at + 1: block(system.coupling, at)} if at < high else {at: own}
            if at < high or system.end:
                neighbours[at + 1] = block(system.coupling, at)
            if at > low or system.start:
                before = block(system.coupling, at - 1)
                neighbours[at - 1] = [list(column) for column in zip(*before, strict=True)]
            for r in range(width):
                row = rows[width * (at - low) + r]
                row[size] += right[r][0]
                for other, entries in neighbours.items():
                    for c in range(width):
                        if low <= other <= high:
                            row[width * (other - low) + c] += entries[r][c]
                        else:
                            row[size] -= entries[r][c] * solution[c][other]
        for place, value in enumerate(_gauss(rows)):
            solution[place % width][low + place // width] = value
        values |= dict(zip(system.unknowns, solution, strict=True))

    def residuals(self, accelerations: Sequence[Fraction]) -> Iterator[tuple[str, Fraction]]:
        """Rows of derivation 1 with these accelerations."""
        one, values = self.explicit, self.values
        loads: list[list[PolyElement]] = []
        if "follower" in self.terms:
            loads.append(one.follower)
        if "gravity" in self.terms:
            loads.append(one.gravity)
        if "tip_load" in self.terms:
            loads.append(one.tip_load)
        if "external_damping" in self.terms:
            loads.append([-e for e in one.external_damping])
        first = self.equations.hold.first
        moving = values[omega][first:]
        bent = values[phi] if one.bent is one.angles else [values[ALPHA], *values[phi]]
        for row, name in enumerate(one.coordinates):
            total = self._dot(one.mass_matrix[row], accelerations)
            total -= self._dot(one.velocity_matrix[row], [w * w for w in moving])
            total += self._dot(one.stiffness_matrix[row], bent)
            if "internal_damping" in self.terms:
                total += self._dot(one.internal_damping[row], moving)
            yield str(name), total - sum(self._value(load[row]) for load in loads)

    def _dot(self, row: Sequence[PolyElement], numbers: Sequence[Fraction]) -> Fraction:
        pairs = zip(row, numbers, strict=True)
        return sum((self._value(e) * x for e, x in pairs), start=Fraction(0))

    def _value(self, poly: PolyElement) -> Fraction:
        """A polynomial of derivation 1 at the point."""
        total = Fraction(0)
        for powers, coefficient in poly.terms():
            term = Fraction(int(QQ.numer(coefficient)), int(QQ.denom(coefficient)))
            for at, power in enumerate(powers):
                if power:
                    term *= self._generators[at] ** power
            total += term
        return total

    @cached_property
    def _generators(self) -> list[Fraction]:
        """Values of the generators of derivation 1."""
        one, values = self.explicit, self.values
        known: dict[Expr, Fraction] = {
            x: value for x, value in values.items() if isinstance(x, Symbol)
        }
        turned = dict(zip(one.angles, self.directions, strict=True)) | {NU: values[TURNED][NU]}
        for angle, direction in turned.items():
            known |= {cos(angle): direction.c, sin(angle): direction.s}
        known |= dict(zip(one.angles, values[phi], strict=True))
        known |= {a.diff(TIME): w for a, w in zip(one.angles, values[omega], strict=True)}
        for at, forces in enumerate(one.drag, start=one.first_joint):  # those that resist
            known |= {D: -drag[at] for D, drag in zip(forces, self.drag, strict=True)}
        # Nothing depends on where joint 0 is, nor on how fast it moves.
        return [known.get(meaning, Fraction(0)) for meaning in one.calculus.meaning]


class _Lazy:
    """Elements of an array, worked out when they are read."""

    def __init__(self, array: Array, values: dict[Any, Any]):
        self._array, self._values = array, values
        self._known: dict[int, Fraction] = {}

    def __getitem__(self, at: int) -> Fraction:
        if at not in self._known:
            here = {**self._values, self._array.index: at}
            self._known[at] = evaluate(self._array.value, here)
        return self._known[at]


def _gauss(rows: list[list[Fraction]]) -> list[Fraction]:
    """Solution of a positive definite system; the right-hand side is the last column."""
    size = len(rows)
    for at in range(size):
        pivot = rows[at]
        for other in range(size):
            if other != at and rows[other][at]:
                factor = rows[other][at] / pivot[at]
                rows[other] = [a - factor * b for a, b in zip(rows[other], pivot, strict=True)]
    return [row[size] / row[at] for at, row in enumerate(rows)]
