"""Derivation 3 for mass at the ends of the links: tensions as unknowns.

The moment on a massless link fixes the force across it; what is left to find is its tension.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

from sympy import (
    Add,
    And,
    Eq,
    Expr,
    Integer,
    Matrix,
    Piecewise,
    S,
    Symbol,
    expand,
    eye,
    solve,
    symbols,
    trigsimp,
    zeros,
)
from sympy.physics.mechanics import dynamicsymbols

from .chain import BEFORE, combine, direction, lever
from .general import GeneralEquations
from .joint_system import (
    BlockSystem,
    add_to_cases,
    collect_terms,
    constrained_equations,
    free_ax,
    free_ay,
    joint_ax,
    joint_ay,
    lightness,
    load_on,
    moment_on,
    system_arrays,
    tail_load,
    tension,
    weight_on,
)
from .polynomials import TIME
from .symbols import Array, i, joint, m, n, omega, other, phi, xi


@dataclass(frozen=True)
class _Bar:
    """A massless link at the angle phi with the rate omega between two masses, and the force in
    it, with which it pulls the mass before it and pushes the mass after it.

    along: direction of the tension; across: the part of the force across the link, by ``moment``
    on it; stretch: along times the acceleration of the mass before it less that of the mass after
    it; lean: times the opposite difference, the angular acceleration.
    """

    phi: Symbol
    omega: Symbol
    moment: Symbol
    along: Matrix
    across: Matrix
    stretch: Expr
    lean: Matrix


@cache
def _derive_bar(length: Expr) -> _Bar:
    """Derive a bar by LagrangesMethod on two masses and a massless link of this length from one to
    the other."""
    x_a, y_a, turned, x_b, y_b = q = dynamicsymbols("x_a y_a phi x_b y_b", real=True)
    masses = symbols("m_a m_b", positive=True)
    ends = ((x_a, y_a), (x_b, y_b))
    squares = [sum(c.diff(TIME) ** 2 for c in end) for end in ends]
    energy = Add(*(mass / 2 * square for mass, square in zip(masses, squares, strict=True)))
    reach = combine(ends[0], [lever(BEFORE, xi, length)], [turned])
    rows, right = constrained_equations(
        energy, list(q), [a - b for a, b in zip(reach, ends[1], strict=True)]
    )
    jacobian = rows[5:, :]
    if jacobian[:, :2] != eye(2) or jacobian[:, 3:] != -eye(2) or not rows[2, :5].is_zero_matrix:
        raise ArithmeticError(f"two masses are not held as assumed: {rows}")
    along = Matrix(direction(turned))
    normal = along.diff(turned)
    tau, T, V = symbols("tau T V", real=True)

    def product(a: Matrix, b: Matrix) -> Expr:
        return trigsimp(expand((a.T * b)[0]))

    # A link without inertia: what the force in it does to its angle balances the moment on it.
    (across,) = solve(product(jacobian[:, 2], T * along + V * normal) + tau, V)
    reach_rate = product(normal, jacobian[:, 2])
    if product(along, jacobian[:, 2]) != 0 or product(normal, right) != 0:
        raise ArithmeticError(f"turning a link changes its length: {jacobian}, {right}")
    angle, rate = symbols("phi omega", real=True)
    names = {turned.diff(TIME): rate, turned: angle}
    return _Bar(
        phi=angle,
        omega=rate,
        moment=tau,
        along=along.subs(names),
        across=(across * normal).subs(names),
        stretch=product(along, right).subs(names),
        lean=(normal / reach_rate).subs(names),
    )


@dataclass(frozen=True)
class TensionSystem:
    """The system of a chain of massless links between masses in the joints."""

    equations: GeneralEquations

    @property
    def _bar(self) -> _Bar:
        return _derive_bar(self.equations.rod.length(other))

    def _substitute(self, expression: Any, link: Expr) -> Any:
        bar = self._bar
        return expression.subs({bar.phi: phi[link], bar.omega: omega[link], other: link})

    def _end_masses(self, link: Expr) -> tuple[Expr, Expr]:
        """Parts of a link in the mass of the joint before it and of the joint after it."""
        rod = self.equations.rod
        mass, after = rod.mass(link), rod.mean(xi, link)
        return mass * (1 - after), mass * after

    def _mass_ratio(self, at: Expr) -> Expr:
        """m over the mass gathered in a joint."""
        if self.equations.rod.has_link_masses:
            return lightness[at]
        return m / self._mass_at(at)

    def _mass_at(self, at: Expr) -> Expr:
        starts = self._end_masses(at)[0] if at != n else S.Zero
        ends = self._end_masses(at - 1)[1] if at != 0 else S.Zero
        return ends + starts

    def _at_joint(
        self, link: Callable[[Expr], Matrix], other: Callable[[Expr], Matrix], held: Matrix
    ) -> Matrix:
        """Acceleration of a joint by forces in the links at it and by other forces, both over m,
        with its cases; ``held``: that of a joint that is held."""
        boundary = self.equations.boundary_condition

        def scale(at: Expr, force: Matrix) -> Matrix:
            return (force * self._mass_ratio(at)).applyfunc(collect_terms)

        inner = scale(joint, link(joint) - link(joint - 1) + other(joint))
        tail = scale(n, other(n) - link(n - 1))
        start = scale(S.Zero, link(Integer(0)) + other(Integer(0)))
        first, last = Eq(joint, boundary.first), Eq(joint, n)
        rows = zip(start if boundary.translates else held, tail, inner, strict=True)
        return Matrix([Piecewise((a, first), (b, last), (c, True)) for a, b, c in rows])

    def _load(self, at: Expr) -> Matrix:
        """Forces on a joint over m, without its weight."""
        tail = Matrix(tail_load(self.equations, m)) if at == n else zeros(2, 1)
        return Matrix(load_on(self.equations, at, m)) + tail

    def _free_fall(self) -> Matrix:
        """Acceleration of free fall, relative to which those of joints are taken, so that gravity
        is only seen where a joint is held."""
        return Matrix(weight_on(self.equations, S.One))

    def _free_acceleration(self) -> Matrix:
        """Acceleration of a joint without tensions."""
        bar = self._bar

        def across(link: Expr) -> Matrix:
            return (
                self._substitute(bar.across.subs(bar.moment, moment_on(self.equations, link)), link)
                / m
            )

        return self._at_joint(across, self._load, -self._free_fall())

    @cached_property
    def system(self) -> BlockSystem:
        """System of the tensions, one equation for every moving link."""
        bar, boundary = self._bar, self.equations.boundary_condition
        first = Integer(boundary.first)
        along = self._substitute(bar.along, i)
        free = Matrix([free_ax[i] - free_ax[i + 1], free_ay[i] - free_ay[i + 1]])
        right = self._substitute(bar.stretch, i) - (along.T * free)[0]
        near = self._mass_ratio(S.Zero) if boundary.translates else S.Zero
        before, after, far = map(self._mass_ratio, (i, i + 1, n))
        diagonal = Piecewise(
            (near + far, And(Eq(i, first), Eq(i, n - 1))),
            (near + after, Eq(i, first)),
            (before + far, Eq(i, n - 1)),
            (before + after, True),
        )
        coupling = -after * (along.T * self._substitute(bar.along, i + 1))[0]

        def pull(link: Expr) -> Matrix:
            return self._substitute(bar.along, link) * tension[link]

        moves = self._at_joint(pull, lambda _: zeros(2, 1), zeros(2, 1))
        moves = [
            add_to_cases(e, base[joint]) for e, base in zip(moves, (free_ax, free_ay), strict=True)
        ]
        over = Array(joint_ax, joint, first, n, S.Zero)
        arrays = {
            base: replace(over, base=base, value=value)
            for base, value in zip(
                (free_ax, free_ay, joint_ax, joint_ay),
                (*self._free_acceleration(), *moves),
                strict=True,
            )
        }
        if self.equations.rod.has_link_masses:
            low, high = (m / self._mass_at(at) for at in (S.Zero, n))
            inside = m / self._mass_at(joint)
            value = self.equations.piecewise_at_ends(low, high, inside)
            moving = Integer(boundary.first_joint)
            arrays[lightness] = Array(lightness, joint, moving, n, value)
        base = Matrix([joint_ax[0], joint_ay[0]]) + self._free_fall()
        opening = Matrix([joint_ax[i + 1] - joint_ax[i], joint_ay[i + 1] - joint_ay[i]])
        return BlockSystem(
            unknowns=(tension,),
            index=i,
            low=first,
            high=n - 1,
            diagonal=Matrix([diagonal]),
            coupling=Matrix([collect_terms(coupling)]),
            right=Matrix([right]),
            start=(),
            end=(),
            arrays=system_arrays(self.equations) | arrays,
            angular=collect_terms((self._substitute(bar.lean, i).T * opening)[0]),
            base=tuple(base) if boundary.translates else (),
        )
