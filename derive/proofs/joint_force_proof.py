"""Derivation 3 compared with derivation 1: accelerations at a random rational point, exactly.

The system of joint forces is solved in rational numbers, and its accelerations are put into M v' =
Q omega^2 - K phi + rest + loads of derivation 1: the residual must be zero.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

from sympy import QQ, Expr, Matrix, Symbol, cos, sin
from sympy.polys.rings import PolyElement

from ..comparison import JOINTS, Comparison, DisagreementError
from ..explicit import ExplicitDerivation
from ..general import GeneralEquations
from ..joint_force_system import joint_system
from ..joint_system import BlockSystem, link_moment
from ..link_properties import joint_stiffness, link_parameters, rest_angle
from ..loads import TERMS
from ..polynomials import TIME
from ..symbols import ALPHA, PARAMETERS, Array, alpha, i, k, l, m, n, omega, phi
from .exact import TURNED, Angle, evaluate, pythagorean


def prove_joint_forces(
    links: int,
    boundary: str,
    inertia: str,
    terms: Sequence[str] = TERMS,
    nonuniform: Sequence[str] = (),
) -> Iterator[Comparison]:
    """Compare accelerations of derivations 3 and 1 at n links; raises DisagreementError."""
    explicit = ExplicitDerivation(links, boundary, inertia, tuple(nonuniform), tuple(terms))
    equations = GeneralEquations(boundary, inertia, tuple(terms), tuple(nonuniform))
    point = _Point(explicit, equations)
    accelerations = point.accelerations()
    for row, (name, residual) in enumerate(point.residuals(accelerations)):
        if residual != 0:
            raise DisagreementError(JOINTS, f"accelerations[{row}], {name}", residual, 0)
    yield Comparison("accelerations", JOINTS, len(accelerations))


class _Point:
    """A random state of a chain in rational numbers; angles and their directions are drawn apart,
    since the equations are polynomials in both."""

    def __init__(self, explicit: ExplicitDerivation, equations: GeneralEquations):
        links = self.links = explicit.n
        self.draw = random.Random(1)
        self.explicit, self.equations = explicit, equations
        boundary_condition = self.equations.boundary_condition
        held = range(boundary_condition.first)
        clamp, clamp_direction = self._number(), self._direction()
        angles = [clamp if q in held else self._number() for q in range(links)]
        self.directions = [
            clamp_direction if q in held else self._direction() for q in range(links)
        ]
        rates = [Fraction(0) if q in held else self._number() for q in range(links)]
        self.values: dict[Any, Any] = {x: self._number() for x in (m, l, k)}
        self.values |= {n: links, ALPHA: clamp, phi: angles, omega: rates}
        if "stiffness" in equations.nonuniform:
            self.values[joint_stiffness] = [self._number() for _ in range(links + 1)]
        if "rest" in equations.nonuniform:
            self.values[rest_angle] = [self._number() for _ in range(links + 1)]
        for name in link_parameters(equations.nonuniform):
            share = Fraction(name == "link_centre_along", 31)  # of what may be 30, to stay below 1
            self.values[PARAMETERS[name]] = [self._number() * (share or 1) for _ in range(links)]
        # What cosine and sine are taken of.
        turned: dict[Any, Any] = {phi: self.directions, ALPHA: clamp_direction}
        for load in self.equations.loads.values():
            turned |= {x: self._direction() for x in load.angles}
            for base in load.per_link:
                self.values[base] = [self._number() for _ in range(links)]
            self.values |= {x: self._number() for x in load.parameters}
            for base in load.force_arrays:
                self.values[base] = [self._number() for _ in range(links + 1)]
        motion = equations.base_motion
        for q in held:
            angles[q] = evaluate(motion.clamp_angle, self.values)
            rates[q] = evaluate(motion.angle[1], self.values)
            self.directions[q] = evaluate(motion.clamp_angle, turned)
        self.values[TURNED] = turned

    def _number(self) -> Fraction:
        return Fraction(self.draw.randint(1, 30), self.draw.randint(1, 30))

    def _direction(self) -> Angle:
        return pythagorean(self._number())

    def accelerations(self) -> list[Fraction]:
        """Accelerations of joint 0 where it moves, then of the moving links."""
        system, values = joint_system(self.equations), dict(self.values)
        if not self.equations.boundary_condition.spring_joints(self.links):
            values[link_moment] = [Fraction(0)] * self.links
        for base, array in system.arrays.items():
            values.setdefault(base, _Lazy(array, values))
        self._solve(system, values)
        first = self.equations.boundary_condition.first
        links = range(first, self.links)
        turning = {q: evaluate(system.angular, {**values, i: q}) for q in links}
        values[alpha] = turning
        base = [evaluate(e, values) for e in system.base]
        return [*base, *(turning[q] for q in links)]

    def _solve(self, system: BlockSystem, values: dict[Any, Any]) -> None:
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
            neighbours, right = {at: block(system.diagonal, at)}, block(system.right, at)
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
        for place, value in enumerate(_solve_gauss(rows)):
            solution[place % width][low + place // width] = value
        values |= dict(zip(system.unknowns, solution, strict=True))

    def residuals(self, accelerations: Sequence[Fraction]) -> Iterator[tuple[str, Fraction]]:
        """Residuals of the rows of derivation 1 with these accelerations, by coordinate."""
        one, values = self.explicit, self.values
        loads = [one.load(name) for name in self.equations.loads]
        moving = values[omega][self.equations.boundary_condition.first :]
        known = {ALPHA: values[ALPHA], **dict(zip(one.angles, values[phi], strict=True))}
        known |= {q: evaluate(course[0], values) for q, course in one.courses.items()}
        bent = [known[angle] for angle in one.spring_angles]
        for row, name in enumerate(one.coordinates):
            total = self._dot(one.mass_matrix[row], accelerations)
            total -= self._dot(one.velocity_matrix[row], [w * w for w in moving])
            total += self._dot(one.stiffness_matrix[row], bent) - self._value(one.rest_moments[row])
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
        # The angles of links, and what else cosine and sine are taken of.
        turned = dict(zip(one.angles, self.directions, strict=True))
        turned |= {a: d for a, d in values[TURNED].items() if isinstance(a, Symbol)}
        for angle, direction in turned.items():
            known |= {cos(angle): direction.c, sin(angle): direction.s}
        known |= dict(zip(one.angles, values[phi], strict=True))
        known |= {a.diff(TIME): w for a, w in zip(one.angles, values[omega], strict=True)}
        known |= {q: evaluate(of, values) for of, q in one.given.items()}
        if (held := one.given.get(one.motion.clamp_angle)) is not None:
            direction = evaluate(one.motion.clamp_angle, values[TURNED])
            known |= {cos(held): direction.c, sin(held): direction.s}
        # Forces of drag, and what differs along the rod.
        differing = [e for e in one.calculus.meaning if e.is_Indexed and e.base in values]
        known |= {e: values[e.base][int(e.indices[0])] for e in differing}
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


def _solve_gauss(rows: list[list[Fraction]]) -> list[Fraction]:
    """Solution of a positive definite system; the right-hand side is the last column."""
    size = len(rows)
    for at in range(size):
        pivot = rows[at]
        for other in range(size):
            if other != at and rows[other][at]:
                factor = rows[other][at] / pivot[at]
                rows[other] = [a - factor * b for a, b in zip(rows[other], pivot, strict=True)]
    return [row[size] / row[at] for at, row in enumerate(rows)]
