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

from .calculus import TIME
from .chain import OWN, Vector, across, combine, lever, side
from .general import Equations
from .inertia import INERTIAS
from .joint_system import (
    System,
    alpha,
    arrays_of,
    at_first,
    blocks,
    end_blocks,
    free_alpha,
    lagrange,
    lambda_x,
    lambda_y,
    load_on,
    moment_on,
    pull_x,
    pull_y,
    push_x,
    push_y,
    short,
    tail_load,
    weight_on,
)
from .rod import Rod
from .symbols import Array, eta, i, m, n, omega, other, phi, s, xi
from .tensions import Tensions


def joint_system(equations: Equations) -> System:
    """The system of a chain: 2x2 blocks of joint forces or, where all mass of a link sits at its
    ends, a scalar one of tensions."""
    first, second = (equations.rod.mean(xi**power, other) for power in (1, 2))
    at_ends = second == first  # of xi in [0, 1] only 0 and 1 are their own squares
    return Tensions(equations).system if at_ends else JointForces(equations, True).system


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
def _two_links(rod: Rod, law: Callable[[Expr], Expr]) -> _Link:
    """LagrangesMethod on two links, the end of the first held to the start of the second, both
    with the mass of the link ``other``; law: that of the inertia, so that another one is derived
    anew."""
    coordinates = dynamicsymbols("x_p y_p phi_p x_q y_q phi_q", real=True)
    p, q = coordinates[:3], coordinates[3:]
    middle, aside = lever(OWN, rod.mean(xi, other)), S.Zero
    if rod.sided:
        aside = side(OWN, rod.mean(eta, other))

    def point(link: list[Expr], fraction: Expr, beside: Expr = S.Zero) -> Vector:
        ways = [lever(OWN, fraction) - middle, side(OWN, beside) - aside]
        return combine((link[0], link[1]), ways, [link[2], across(link[2])])

    energy = S.Zero
    for link in (p, q):
        v = [c.diff(TIME) for c in point(link, xi, eta if rod.sided else S.Zero)]
        mean_square = rod.mean(expand(v[0] ** 2 + v[1] ** 2), other)
        energy += rod.mass(other) / 2 * (expand(mean_square) if rod.sided else mean_square)
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


# Of a link with mass beside it: the inverses of its mass and of its moment of inertia, over that of
# m, and how the joints at its start and its end move from its centre as it turns.
light, nimble = (IndexedBase(name, real=True) for name in ("light", "nimble"))
start_turn, end_turn = (
    [IndexedBase(f"{where}_turn_{axis}", real=True) for axis in "xy"] for where in ("start", "end")
)


@dataclass(frozen=True)
class JointForces:
    """The system of a chain of links with mass along them; forces at a joint act on the link
    that it ends. named: whether what many entries of a link with mass beside it are made of are
    arrays."""

    equations: Equations
    named: bool = False

    @property
    def _derived(self) -> _Link:
        return _two_links(self.equations.rod, INERTIAS[self.equations.inertia])

    @property
    def _cell(self) -> _Link:
        cell = self._derived
        if not (self.named and self.equations.rod.sided):
            return cell
        start, end, inverse = cell.start.copy(), cell.end.copy(), cell.inverse.copy()
        for jacobian, turn in ((start, start_turn), (end, end_turn)):
            for row, base in enumerate(turn):
                jacobian[row, 2] = base[other]
        for at, base in enumerate((light, light, nimble)):
            inverse[at, at] = base[other] / m
        return replace(cell, start=start, end=end, inverse=inverse)

    @property
    def _parts(self) -> dict[IndexedBase, Expr]:
        """What the names stand for, of link i."""
        if self._cell is self._derived:
            return {}
        cell = self._derived
        columns = [*cell.start[:, 2], *cell.end[:, 2]]
        masses = [(m * cell.inverse[at, at]).subs(other, i) for at in (0, 2)]
        values = [*masses, *self._at(Matrix(columns), i)]
        return dict(zip((light, nimble, *start_turn, *end_turn), values, strict=True))

    def _at(self, expression: Matrix, link: Expr) -> Matrix:
        cell = self._cell
        return expression.subs({cell.phi: phi[link], cell.omega: omega[link], other: link})

    def _of(self, forces: Matrix, jacobian: Matrix, link: Expr) -> Matrix:
        """Accelerations of a link by forces in a joint, in units of the multipliers."""
        return self._at(m * self._cell.inverse * jacobian.T, link) * forces

    def _free(self, link: Expr) -> Matrix:
        """Accelerations of a link without joint forces."""
        cell = self._cell
        weight = weight_on(self.equations, self.equations.rod.mass(link))
        own = Matrix([*weight, moment_on(self.equations, link)])
        load = Matrix(load_on(self.equations, link + 1, m))
        return self._at(cell.inverse, link) * own + self._of(load, cell.end, link)

    def accelerations(self, link: Expr) -> Matrix:
        """Accelerations of a link, of its centre of gravity and of its angle, by all forces."""
        cell = self._cell
        start, end = (Matrix([lambda_x[at], lambda_y[at]]) for at in (link, link + 1))
        return self._free(link) + self._of(start, cell.start, link) + self._of(end, cell.end, link)

    @property
    def resistance(self) -> Expr:
        """Moment of inertia of link i over that of a link of an even rod: with it in front, the
        equations of turning links have symmetric matrices."""
        inertia = self.equations.inertia
        even = _two_links(Rod(inertia), INERTIAS[inertia])
        return (even.inverse[2, 2] / self._cell.inverse[2, 2]).subs(other, i)

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
        ends = self._block(cell.end, cell.end, i)
        starts = self._block(cell.start, cell.start, i)
        pull_end, end_moves = self._right(cell.end, cell.end_rate, i)
        pull_start, start_moves = self._right(cell.start, cell.start_rate, i)
        # A link that is alike at both ends has one block and one pull for both.
        alike = ends == starts and pull_end == pull_start
        if self.equations.rod.sided == alike:
            raise ArithmeticError(f"a link is not alike at both ends, or is: {ends}, {starts}")
        own, pull = _block_of(blocks), Matrix([pull_x, pull_y])
        before, push = (own, pull) if alike else (_block_of(end_blocks), Matrix([push_x, push_y]))
        diagonal = _of_link(before, s - 1) + _of_link(own, s)
        moves = (end_moves.subs(i, s - 1) + start_moves.subs(i, s)).applyfunc(short)
        right = _of_link(push, s - 1) + _of_link(pull, s) + moves
        if not hold.translates:
            first = Integer(hold.first)
            alone = _of_link(pull, first) + start_moves.subs(i, first)
            diagonal = at_first(first, _of_link(own, first), diagonal)
            right = at_first(first, alone.applyfunc(short), right)
        link = Array(alpha, i, Integer(hold.first), n - 1, S.Zero)
        values = self._parts | dict(zip(blocks, _upper(starts), strict=True))
        if not alike:
            values |= dict(zip(end_blocks, _upper(ends), strict=True))
        values[free_alpha] = short(self._free(i)[2])
        values |= dict(zip(pull, pull_start.applyfunc(short), strict=True))
        if not alike:
            values |= dict(zip(push, pull_end.applyfunc(short), strict=True))
        arrays = {base: replace(link, base=base, value=value) for base, value in values.items()}
        start = tuple(-e for e in load_on(self.equations, Integer(0), m))
        held = self._of(Matrix([lambda_x[i], lambda_y[i]]), cell.start, i)
        holding = self._of(Matrix([lambda_x[i + 1], lambda_y[i + 1]]), cell.end, i)
        return System(
            unknowns=(lambda_x, lambda_y),
            index=s,
            low=Integer(hold.first_force),
            high=n - 1,
            diagonal=diagonal,
            coupling=self._coupling(starts, _of_link(own, s)),
            right=right,
            start=start if hold.translates else (),
            end=tail_load(self.equations, m),
            arrays=arrays_of(self.equations) | arrays,
            angular=free_alpha[i] + short((held + holding)[2]),
            base=self._base(held + holding, start) if hold.translates else (),
        )

    def _coupling(self, starts: Matrix, own: Matrix) -> Matrix:
        """How the joints at both ends of link s are coupled; by its block, where it differs from
        that by what does not turn with the link."""
        cell = self._cell
        coupling = self._block(cell.start, cell.end, s)
        if self.equations.rod.sided:
            return coupling
        difference = (coupling - starts.subs(i, s)).applyfunc(simplify)
        return coupling if difference.has(phi) else own + difference

    def _base(self, forced: Matrix, start: tuple[Expr, ...]) -> tuple[Expr, ...]:
        """Acceleration of joint 0, where link 0 starts."""
        cell, moving = self._cell, forced + self._free(i)
        moving[2] = alpha[i]
        # The constraint has the start of a link with the sign of its Jacobian.
        sign = cell.start[0, 0]
        there = sign * (self._at(cell.start, i) * moving - self._at(cell.start_rate, i))
        given = dict(zip((lambda_x[0], lambda_y[0]), start, strict=True))
        return tuple(short(e.subs(i, 0).xreplace(given)) for e in there)


def _upper(block: Matrix) -> list[Expr]:
    """The entries of a symmetric block."""
    return [block[0, 0], block[0, 1], block[1, 1]]


def _block_of(bases: tuple[IndexedBase, ...]) -> Matrix:
    """A symmetric block of arrays."""
    xx, xy, yy = bases
    return Matrix([[xx, xy], [xy, yy]])


def _of_link(bases: Matrix, link: Expr) -> Matrix:
    """The elements of arrays for a link."""
    return Matrix(*bases.shape, [base[link] for base in bases])
