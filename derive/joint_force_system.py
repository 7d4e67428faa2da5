"""Derivation 3 for mass along the links: the forces in the joints as unknowns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property

from sympy import (
    Expr,
    IndexedBase,
    Integer,
    Matrix,
    S,
    Symbol,
    expand,
    simplify,
    symbols,
    trigsimp,
)
from sympy.physics.mechanics import dynamicsymbols

from .chain import OWN, Vector, combine, lever, normal_angle, side_lever
from .general import GeneralEquations
from .joint_system import (
    BlockSystem,
    blocks,
    collect_terms,
    constrained_equations,
    end_blocks,
    free_alpha,
    lambda_x,
    lambda_y,
    load_on,
    moment_on,
    piecewise_at_first,
    pull_x,
    pull_y,
    push_x,
    push_y,
    system_arrays,
    tail_load,
    weight_on,
)
from .link_properties import INERTIAS, Rod
from .polynomials import TIME
from .symbols import Array, alpha, eta, i, m, n, omega, other, phi, s, xi
from .tensions import TensionSystem


def joint_system(equations: GeneralEquations) -> BlockSystem:
    """The system of a chain: 2x2 blocks of joint forces or, where all mass of a link sits at its
    ends, a scalar one of tensions."""
    first, second = (equations.rod.mean(xi**power, other) for power in (1, 2))
    at_ends = second == first  # of xi in [0, 1] only 0 and 1 are their own squares
    return TensionSystem(equations).system if at_ends else JointForceSystem(equations, True).system


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
def _derive_link(rod: Rod, law: Callable[[Expr], Expr]) -> _Link:
    """Derive a link by LagrangesMethod on two, the end of the first held to the start of the
    second, both with the mass of the link ``other``; law: that of the inertia, so that another one
    is derived anew."""
    coordinates = dynamicsymbols("x_p y_p phi_p x_q y_q phi_q", real=True)
    p, q = coordinates[:3], coordinates[3:]
    length = rod.length(other)
    middle, aside = lever(OWN, rod.mean(xi, other), length), S.Zero
    if rod.has_offset_mass:
        aside = side_lever(OWN, rod.mean(eta, other), length)

    def point(link: list[Expr], fraction: Expr, beside: Expr = S.Zero) -> Vector:
        ways = [lever(OWN, fraction, length) - middle, side_lever(OWN, beside, length) - aside]
        return combine((link[0], link[1]), ways, [link[2], normal_angle(link[2])])

    energy = S.Zero
    for link in (p, q):
        v = [c.diff(TIME) for c in point(link, xi, eta if rod.has_offset_mass else S.Zero)]
        mean_square = rod.mean(expand(v[0] ** 2 + v[1] ** 2), other)
        energy += (
            rod.mass(other) / 2 * (expand(mean_square) if rod.has_offset_mass else mean_square)
        )
    gap = [a - b for a, b in zip(point(p, S.One), point(q, S.Zero), strict=True)]
    rows, right = constrained_equations(energy, coordinates, gap)
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


# Of a link with mass beside it: the inverses of its mass and of its moment of inertia, over that of
# m, and how the joints at its start and its end move from its centre as it turns.
light, nimble = (IndexedBase(name, real=True) for name in ("light", "nimble"))
start_turn, end_turn = (
    [IndexedBase(f"{where}_turn_{axis}", real=True) for axis in "xy"] for where in ("start", "end")
)


@dataclass(frozen=True)
class JointForceSystem:
    """The system of a chain of links with mass along them; forces at a joint act on the link that
    it ends. named: whether common parts of the entries of a link with mass beside it become
    arrays."""

    equations: GeneralEquations
    named: bool = False

    @property
    def _link(self) -> _Link:
        return _derive_link(self.equations.rod, INERTIAS[self.equations.inertia])

    @property
    def _cell(self) -> _Link:
        cell = self._link
        if not (self.named and self.equations.rod.has_offset_mass):
            return cell
        start, end, inverse = cell.start.copy(), cell.end.copy(), cell.inverse.copy()
        for jacobian, turn in ((start, start_turn), (end, end_turn)):
            for row, base in enumerate(turn):
                jacobian[row, 2] = base[other]
        for at, base in enumerate((light, light, nimble)):
            inverse[at, at] = base[other] / m
        return replace(cell, start=start, end=end, inverse=inverse)

    @property
    def _array_values(self) -> dict[IndexedBase, Expr]:
        """Values of the arrays for common parts, of link i."""
        if self._cell is self._link:
            return {}
        cell = self._link
        columns = [*cell.start[:, 2], *cell.end[:, 2]]
        masses = [(m * cell.inverse[at, at]).subs(other, i) for at in (0, 2)]
        values = [*masses, *self._substitute(Matrix(columns), i)]
        return dict(zip((light, nimble, *start_turn, *end_turn), values, strict=True))

    def _substitute(self, expression: Matrix, link: Expr) -> Matrix:
        cell = self._cell
        return expression.subs({cell.phi: phi[link], cell.omega: omega[link], other: link})

    def _accelerations_by(self, forces: Matrix, jacobian: Matrix, link: Expr) -> Matrix:
        """Accelerations of a link by forces in a joint, in units of the multipliers."""
        return self._substitute(m * self._cell.inverse * jacobian.T, link) * forces

    def _free_accelerations(self, link: Expr) -> Matrix:
        """Accelerations of a link without joint forces."""
        cell = self._cell
        weight = weight_on(self.equations, self.equations.rod.mass(link))
        own = Matrix([*weight, moment_on(self.equations, link)])
        load = Matrix(load_on(self.equations, link + 1, m))
        return self._substitute(cell.inverse, link) * own + self._accelerations_by(
            load, cell.end, link
        )

    def accelerations(self, link: Expr) -> Matrix:
        """Accelerations of a link, of its centre of gravity and of its angle, by all forces."""
        cell = self._cell
        start, end = (Matrix([lambda_x[at], lambda_y[at]]) for at in (link, link + 1))
        return (
            self._free_accelerations(link)
            + self._accelerations_by(start, cell.start, link)
            + self._accelerations_by(end, cell.end, link)
        )

    @property
    def inertia_ratio(self) -> Expr:
        """Moment of inertia of link i over that of a link of an even rod: with it in front, the
        equations of turning links have symmetric matrices."""
        inertia = self.equations.inertia
        even = _derive_link(Rod(inertia), INERTIAS[inertia])
        return (even.inverse[2, 2] / self._cell.inverse[2, 2]).subs(other, i)

    @property
    def multiplier_mass(self) -> Expr:
        """Mass by which joint forces are divided to give the multipliers."""
        return m

    def end_constraint(self, link: Expr) -> Matrix:
        """Part of a link in the constraint of the joint after it, its turning kept as alpha."""
        return self._constraint(self._cell.end, self._cell.end_rate, link)

    def start_constraint(self, link: Expr) -> Matrix:
        """Part of a link in the constraint of the joint before it, likewise."""
        return self._constraint(self._cell.start, self._cell.start_rate, link)

    def _constraint(self, jacobian: Matrix, rate: Matrix, link: Expr) -> Matrix:
        moving = self.accelerations(link)
        moving[2] = alpha[link]
        return self._substitute(jacobian, link) * moving - self._substitute(rate, link)

    def _right_side(self, jacobian: Matrix, rate: Matrix, link: Expr) -> tuple[Matrix, Matrix]:
        """Parts of a link in the right-hand side of a joint, by rotation and by translation."""
        jacobian, free = self._substitute(jacobian, link), self._free_accelerations(link)
        turning = self._substitute(rate, link) - jacobian[:, 2] * free_alpha[link]
        return turning, -jacobian[:, :2] * free[:2, :]

    def _block(self, left: Matrix, right: Matrix, link: Expr) -> Matrix:
        product = m * left * self._cell.inverse * right.T
        return self._substitute(product, link).applyfunc(collect_terms)

    @cached_property
    def system(self) -> BlockSystem:
        """System of 2x2 blocks, one for every joint between moving links and for a held joint."""
        cell, boundary = self._cell, self.equations.boundary_condition
        ends = self._block(cell.end, cell.end, i)
        starts = self._block(cell.start, cell.start, i)
        pull_end, end_moves = self._right_side(cell.end, cell.end_rate, i)
        pull_start, start_moves = self._right_side(cell.start, cell.start_rate, i)
        # A link that is alike at both ends has one block and one pull for both.
        alike = ends == starts and pull_end == pull_start
        if self.equations.rod.has_offset_mass == alike:
            raise ArithmeticError(f"a link is not alike at both ends, or is: {ends}, {starts}")
        own, pull = _symmetric_block(blocks), Matrix([pull_x, pull_y])
        before, push = (
            (own, pull) if alike else (_symmetric_block(end_blocks), Matrix([push_x, push_y]))
        )
        diagonal = _elements(before, s - 1) + _elements(own, s)
        moves = (end_moves.subs(i, s - 1) + start_moves.subs(i, s)).applyfunc(collect_terms)
        right = _elements(push, s - 1) + _elements(pull, s) + moves
        if not boundary.translates:
            first = Integer(boundary.first)
            alone = _elements(pull, first) + start_moves.subs(i, first)
            diagonal = piecewise_at_first(first, _elements(own, first), diagonal)
            right = piecewise_at_first(first, alone.applyfunc(collect_terms), right)
        link = Array(alpha, i, Integer(boundary.first), n - 1, S.Zero)
        values = self._array_values | dict(zip(blocks, _upper_entries(starts), strict=True))
        values |= dict(zip(pull, pull_start.applyfunc(collect_terms), strict=True))
        if not alike:
            values |= dict(zip(end_blocks, _upper_entries(ends), strict=True))
            values |= dict(zip(push, pull_end.applyfunc(collect_terms), strict=True))
        values[free_alpha] = collect_terms(self._free_accelerations(i)[2])
        arrays = {base: replace(link, base=base, value=value) for base, value in values.items()}
        start = tuple(-e for e in load_on(self.equations, Integer(0), m))
        held = self._accelerations_by(Matrix([lambda_x[i], lambda_y[i]]), cell.start, i)
        holding = self._accelerations_by(Matrix([lambda_x[i + 1], lambda_y[i + 1]]), cell.end, i)
        return BlockSystem(
            unknowns=(lambda_x, lambda_y),
            index=s,
            low=Integer(boundary.first_force),
            high=n - 1,
            diagonal=diagonal,
            coupling=self._coupling(starts, _elements(own, s)),
            right=right,
            start=start if boundary.translates else (),
            end=tail_load(self.equations, m),
            arrays=system_arrays(self.equations) | arrays,
            angular=free_alpha[i] + collect_terms((held + holding)[2]),
            base=self._base(held + holding, start) if boundary.translates else (),
        )

    def _coupling(self, starts: Matrix, own: Matrix) -> Matrix:
        """Block that couples the joints at both ends of link s; where it differs from the block of
        the link by terms without its angle, as the sum of that block and these."""
        cell = self._cell
        coupling = self._block(cell.start, cell.end, s)
        if self.equations.rod.has_offset_mass:
            return coupling
        difference = (coupling - starts.subs(i, s)).applyfunc(simplify)
        return coupling if difference.has(phi) else own + difference

    def _base(self, forced: Matrix, start: tuple[Expr, ...]) -> tuple[Expr, ...]:
        """Acceleration of joint 0, where link 0 starts."""
        cell, moving = self._cell, forced + self._free_accelerations(i)
        moving[2] = alpha[i]
        # The constraint has the start of a link with the sign of its Jacobian.
        sign = cell.start[0, 0]
        there = sign * (
            self._substitute(cell.start, i) * moving - self._substitute(cell.start_rate, i)
        )
        given = dict(zip((lambda_x[0], lambda_y[0]), start, strict=True))
        return tuple(collect_terms(e.subs(i, 0).xreplace(given)) for e in there)


def _upper_entries(block: Matrix) -> list[Expr]:
    """The entries of a symmetric block."""
    return [block[0, 0], block[0, 1], block[1, 1]]


def _symmetric_block(bases: tuple[IndexedBase, ...]) -> Matrix:
    """A symmetric block of arrays."""
    xx, xy, yy = bases
    return Matrix([[xx, xy], [xy, yy]])


def _elements(bases: Matrix, link: Expr) -> Matrix:
    """The elements of arrays for a link."""
    return Matrix(*bases.shape, [base[link] for base in bases])
