"""Derivation 3 for mass along the links: the forces in the joints as unknowns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property

from sympy import Expr, Integer, Matrix, S, Symbol, expand, simplify, symbols, trigsimp
from sympy.physics.mechanics import dynamicsymbols

from .calculus import TIME
from .chain import OWN, Vector, combine, lever
from .general import Array, Equations
from .inertia import INERTIAS, mean
from .joint_system import (
    System,
    alpha,
    arrays_of,
    at_first,
    block_xx,
    block_xy,
    block_yy,
    drag_at,
    free_alpha,
    lagrange,
    lambda_x,
    lambda_y,
    link_moment,
    pull_x,
    pull_y,
    short,
    tail_load,
    weight_on,
)
from .symbols import i, m, n, omega, phi, s, xi
from .tensions import Tensions


def joint_system(equations: Equations) -> System:
    """The system of a chain: 2x2 blocks of joint forces or, where all mass of a link sits at its
    ends, a scalar one of tensions."""
    first, second = (mean(equations.inertia, xi**power) for power in (1, 2))
    at_ends = second == first  # of xi in [0, 1] only 0 and 1 are their own squares
    return Tensions(equations).system if at_ends else JointForces(equations).system


@dataclass(frozen=True)
class _Link:
    """A link at the angle phi with the rate omega, taken out of a cell of two.

    inverse: of its mass matrix (centre of gravity, angle); end, start: Jacobians of the
    constraints in the joints after and before it; end_rate, start_rate: what the constraints on
    the accelerations have on their right.
    """

    phi: Symbol
    omega: Symbol
    inverse: Matrix
    end: Matrix
    start: Matrix
    end_rate: Matrix
    start_rate: Matrix


@cache
def _two_links(inertia: str, law: Callable[[Expr], Expr]) -> _Link:
    """LagrangesMethod on two links, the end of the first held to the start of the second; law:
    that of the inertia, so that another one is derived anew."""
    coordinates = dynamicsymbols("x_p y_p phi_p x_q y_q phi_q", real=True)
    p, q = coordinates[:3], coordinates[3:]
    middle = lever(OWN, mean(inertia, xi))

    def point(link: list[Expr], fraction: Expr) -> Vector:
        return combine((link[0], link[1]), [lever(OWN, fraction) - middle], [link[2]])

    energy = S.Zero
    for link in (p, q):
        v = [c.diff(TIME) for c in point(link, xi)]
        energy += m / 2 * mean(inertia, expand(v[0] ** 2 + v[1] ** 2))
    gap = [a - b for a, b in zip(point(p, S.One), point(q, S.Zero), strict=True)]
    rows, right = lagrange(energy, coordinates, gap)
    mass = rows[:6, :].applyfunc(trigsimp)
    angle, rate = symbols("phi omega", real=True)
    names = {p[2]: angle, q[2]: angle}
    # One and the same link: p is seen from the joint after it, q from that before it.
    if mass[:3, :3] != mass[3:, 3:] or not mass.is_diagonal():
        raise ArithmeticError(f"the mass matrix of two links is not of the form assumed: {mass}")
    rates = {link[2].diff(TIME): rate for link in (p, q)}
    end_rate, start_rate = (right.subs(other[2].diff(TIME), 0).subs(rates) for other in (q, p))
    return _Link(
        phi=angle,
        omega=rate,
        inverse=mass[:3, :3].inv(),
        end=rows[6:, :3].subs(names),
        start=rows[6:, 3:].subs(names),
        end_rate=end_rate.subs(names),
        start_rate=start_rate.subs(names),
    )


@dataclass(frozen=True)
class JointForces:
    """The system of a chain of links with mass along them; forces at a joint act on the link
    that it ends."""

    equations: Equations

    @property
    def _cell(self) -> _Link:
        inertia = self.equations.inertia
        return _two_links(inertia, INERTIAS[inertia])

    def _at(self, expression: Matrix, link: Expr) -> Matrix:
        cell = self._cell
        return expression.subs({cell.phi: phi[link], cell.omega: omega[link]})

    def _of(self, forces: Matrix, jacobian: Matrix, link: Expr) -> Matrix:
        """Accelerations of a link by forces in a joint, in units of the multipliers."""
        return m * self._cell.inverse * self._at(jacobian.T, link) * forces

    def _free(self, link: Expr) -> Matrix:
        """Accelerations of a link without joint forces."""
        cell = self._cell
        own = Matrix([*weight_on(self.equations, m), link_moment[link]])
        drag = Matrix(drag_at(self.equations, link + 1, m))
        return cell.inverse * own + self._of(drag, cell.end, link)

    def accelerations(self, link: Expr) -> Matrix:
        """Accelerations of a link, of its centre of gravity and of its angle, by all forces."""
        cell = self._cell
        start, end = (Matrix([lambda_x[at], lambda_y[at]]) for at in (link, link + 1))
        return self._free(link) + self._of(start, cell.start, link) + self._of(end, cell.end, link)

    @property
    def unit(self) -> Expr:
        """What the multipliers are forces over."""
        return m

    def ends(self, link: Expr) -> Matrix:
        """Part of a link in the constraint of the joint after it, its angular acceleration as it
        is."""
        return self._constraint(self._cell.end, self._cell.end_rate, link)

    def starts(self, link: Expr) -> Matrix:
        """Part of a link in the constraint of the joint before it."""
        return self._constraint(self._cell.start, self._cell.start_rate, link)

    def _constraint(self, jacobian: Matrix, rate: Matrix, link: Expr) -> Matrix:
        moving = self.accelerations(link)
        moving[2] = alpha[link]
        return self._at(jacobian, link) * moving - self._at(rate, link)

    def _right(self, jacobian: Matrix, rate: Matrix, link: Expr) -> tuple[Matrix, Matrix]:
        """What a link adds to the right-hand side of a joint: by turning, and by moving."""
        jacobian, free = self._at(jacobian, link), self._free(link)
        turning = self._at(rate, link) - jacobian[:, 2] * free_alpha[link]
        return turning, -jacobian[:, :2] * free[:2, :]

    def _block(self, left: Matrix, right: Matrix, link: Expr) -> Matrix:
        product = m * left * self._cell.inverse * right.T
        return self._at(product, link).applyfunc(short)

    @cached_property
    def system(self) -> System:
        """2x2 blocks, one for every joint between moving links and for a joint that is held."""
        cell, hold = self._cell, self.equations.hold
        before = self._block(cell.end, cell.end, s - 1)
        after = self._block(cell.start, cell.start, s)
        (pull, end_moves), (other, start_moves) = (
            self._right(cell.end, cell.end_rate, s - 1),
            self._right(cell.start, cell.start_rate, s),
        )
        if pull.subs(s, s + 1) != other:
            raise ArithmeticError(f"a link does not pull at both ends alike: {pull}, {other}")
        pulls = Matrix([pull_x[s - 1] + pull_x[s], pull_y[s - 1] + pull_y[s]])
        if before.subs(s, s + 1) != after:
            raise ArithmeticError(f"a link is not alike at both ends: {before}, {after}")
        own = Matrix(2, 2, [block_xx[s], block_xy[s], block_xy[s], block_yy[s]])
        diagonal = own.subs(s, s - 1) + own
        right = pulls + (end_moves + start_moves).applyfunc(short)
        if not hold.translates:
            first = Integer(hold.first)
            alone = Matrix([pull_x[first], pull_y[first]]) + start_moves.subs(s, first)
            diagonal = at_first(first, own.subs(s, first), diagonal)
            right = at_first(first, alone.applyfunc(short), right)
        link = Array(alpha, i, Integer(hold.first), n - 1, S.Zero)
        entries = [after.subs(s, i)[at] for at in (0, 1, 3)]
        arrays = {
            base: replace(link, base=base, value=value)
            for base, value in zip((block_xx, block_xy, block_yy), entries, strict=True)
        }
        arrays |= {
            free_alpha: replace(link, base=free_alpha, value=short(self._free(i)[2])),
            pull_x: replace(link, base=pull_x, value=short(other[0].subs(s, i))),
            pull_y: replace(link, base=pull_y, value=short(other[1].subs(s, i))),
        }
        start = tuple(-e for e in drag_at(self.equations, Integer(0), m))
        held = self._of(Matrix([lambda_x[i], lambda_y[i]]), cell.start, i)
        holding = self._of(Matrix([lambda_x[i + 1], lambda_y[i + 1]]), cell.end, i)
        return System(
            unknowns=(lambda_x, lambda_y),
            index=s,
            low=Integer(hold.first_force),
            high=n - 1,
            diagonal=diagonal,
            coupling=_by_block(self._block(cell.start, cell.end, s), after, own),
            right=right,
            start=start if hold.translates else (),
            end=tail_load(self.equations, m),
            arrays=arrays_of(self.equations) | arrays,
            angular=free_alpha[i] + short((held + holding)[2]),
            base=self._base(held + holding, start) if hold.translates else (),
        )

    def _base(self, forced: Matrix, start: tuple[Expr, ...]) -> tuple[Expr, ...]:
        """Acceleration of joint 0, where link 0 starts."""
        cell, moving = self._cell, forced + self._free(i)
        moving[2] = alpha[i]
        # The constraint has the start of a link with the sign of its Jacobian.
        sign = cell.start[0, 0]
        there = sign * (self._at(cell.start, i) * moving - self._at(cell.start_rate, i))
        given = dict(zip((lambda_x[0], lambda_y[0]), start, strict=True))
        return tuple(short(e.subs(i, 0).xreplace(given)) for e in there)


def _by_block(coupling: Matrix, after: Matrix, own: Matrix) -> Matrix:
    """The coupling of two joints by what their link adds to the diagonal, from which it differs by
    numbers alone."""
    difference = (coupling - after).applyfunc(simplify)
    if difference.free_symbols:
        return coupling
    return own + difference
