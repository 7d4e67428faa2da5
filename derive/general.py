"""Derivation 2: the equations for every n at once, as indexed expressions.

The Euler-Lagrange operator is linear and a squared velocity couples links only in pairs, so one
mass point carried by two generic links (at the levers a_i and a_j) has every kind of entry.
Summing the products of levers over the mass of all links gives the weights, for symbolic n.
Sums over links stay SymPy sums: they become loops in generated code.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import prod

from sympy import (
    Eq,
    Expr,
    IndexedBase,
    Integer,
    Matrix,
    Piecewise,
    Poly,
    S,
    Sum,
    Symbol,
    expand,
    factor,
    factor_terms,
    simplify,
    summation,
    symbols,
    trigsimp,
)
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from .calculus import TIME
from .chain import AFTER, BEFORE, BOUNDARIES, OWN, Boundary, Vector, combine, lever
from .inertia import mean
from .loads import (
    JointDrag,
    damper_moment,
    drag_divisor,
    drag_force,
    follower_force,
    joint_angle,
    joint_mass,
    spring_potential,
    tip_force,
    weight,
)
from .symbols import (
    ALPHA,
    fin_factor,
    i,
    j,
    later,
    m,
    n,
    omega,
    phi,
    s,
    vx0,
    vy0,
    x0,
    xi,
    y0,
)

# Index of a joint, and of the links that carry mass. Sums run over i (links), joint, s (springs).
joint, other = symbols("joint other", integer=True, nonnegative=True)

joint_x, joint_y = IndexedBase("joint_x", real=True), IndexedBase("joint_y", real=True)
joint_vx, joint_vy = IndexedBase("joint_vx", real=True), IndexedBase("joint_vy", real=True)
rod_angle, mass_at = IndexedBase("rod_angle", real=True), IndexedBase("joint_mass", positive=True)
drag_x, drag_y = IndexedBase("drag_x", real=True), IndexedBase("drag_y", real=True)
joint_moment = IndexedBase("joint_moment", real=True)
divisor = IndexedBase("drag_divisor", positive=True)
# Joints from joint 0, and from the centre of gravity.
reach_x, reach_y = IndexedBase("reach_x", real=True), IndexedBase("reach_y", real=True)
arm_x, arm_y = IndexedBase("arm_x", real=True), IndexedBase("arm_y", real=True)
centre_x, centre_y = symbols("centre_x centre_y", real=True)


@dataclass(frozen=True)
class Array:
    """A quantity with a value for every low <= index <= high."""

    base: IndexedBase
    index: Symbol
    low: Expr
    high: Expr
    value: Expr


@dataclass(frozen=True)
class Work:
    """Generalised forces of a load: on x0 and y0, and on the angle of link i."""

    base: Vector
    link: Expr


@dataclass(frozen=True)
class _TwoLinks:
    """A mass point mu carried by links i < j at the levers a_i, a_j, its equations formed."""

    a: tuple[Symbol, Symbol]
    mu: Symbol
    angles: tuple[Expr, Expr]
    mass: list[list[Expr]]
    velocity: list[list[Expr]]
    partial: list[Vector]


@cache
def _two_links() -> _TwoLinks:
    a = symbols("a_i a_j", positive=True)
    mu = Symbol("mu", positive=True)
    x, y, phi_i, phi_j = q = dynamicsymbols("x y phi_i phi_j", real=True)
    r = combine((x, y), a, (phi_i, phi_j))
    v = [c.diff(TIME) for c in r]
    method = LagrangesMethod(mu / 2 * (v[0] ** 2 + v[1] ** 2), q)
    method.form_lagranges_equations()
    rates = [phi_i.diff(TIME), phi_j.diff(TIME)]
    forcing = [expand(e) for e in method.forcing]
    velocity = [[e.coeff(rate, 2) for rate in rates] for e in forcing]
    left = [
        simplify(e - sum(c * u**2 for c, u in zip(row, rates, strict=True)))
        for e, row in zip(forcing, velocity, strict=True)
    ]
    mass = [[trigsimp(e) for e in row] for row in method.mass_matrix.tolist()]
    partial = [(r[0].diff(p), r[1].diff(p)) for p in (phi_i, phi_j)]
    # What the blocks of M and Q below take for granted.
    nothing = [*left, mass[0][1], mass[0][0] - mass[1][1], velocity[2][0], velocity[3][1]]
    if any(nothing) or Matrix(mass) != Matrix(mass).T:
        raise ArithmeticError(
            f"M or Q of a mass point is not of the form assumed: {mass}, {nothing}"
        )
    return _TwoLinks(a, mu, (phi_i, phi_j), mass, velocity, partial)


@dataclass(frozen=True)
class Equations:
    """M v' = Q omega^2 + moments across the joints + work of the loads, for any n.

    Entries are functions of the indices i, j (links), later = max(i, j), s (inner joints); the
    diagonal of M is `mass_link`, that of Q is zero. Rows of the base exist where it translates.
    """

    boundary: str
    inertia: str
    terms: tuple[str, ...]

    @cached_property
    def hold(self) -> Boundary:
        """How the start of the rod is held."""
        return BOUNDARIES[self.boundary]

    # Inertia ---------------------------------------------------------------------------------

    @cached_property
    def _generic(self) -> _TwoLinks:
        return _two_links()

    def _lever_mass(self, links: Sequence[Expr], powers: Sequence[int]) -> Expr:
        """Sum over the mass of all links of the product of levers**powers; links ascend."""

        def moment(places: Sequence[str]) -> Expr:
            levers = [lever(p, xi) ** power for p, power in zip(places, powers, strict=True)]
            return m * mean(self.inertia, prod(levers, start=S.One))

        total = S.Zero
        for at in range(len(links) + 1):
            passed, ahead = [BEFORE] * at, [AFTER] * (len(links) - at)
            low = links[at - 1] + 1 if at else 0
            high = links[at] - 1 if at < len(links) else n - 1
            total += summation(moment([*passed, *ahead]), (other, low, high))
            if ahead:
                total += moment([*passed, OWN, *ahead[1:]])
        return factor_terms(expand(total))

    def _over_mass(self, entry: Expr) -> Expr:
        """An entry of the generic mass point, summed over the mass of the chain."""
        generic, total = self._generic, S.Zero
        poly = Poly(expand(entry / generic.mu), *generic.a)
        for powers, coefficient in poly.terms():
            used = [(link, p) for link, p in zip((i, j), powers, strict=True) if p]
            weight_ = self._lever_mass([link for link, _ in used], [p for _, p in used])
            total += weight_ * coefficient
        return total.xreplace(dict(zip(generic.angles, (phi[i], phi[j]), strict=True)))

    def _symmetric(self, matrix: list[list[Expr]], offset: int) -> Expr:
        """The entry of two links as one expression in i, j and the later of them."""
        upper = self._over_mass(matrix[2][offset + 1])
        lower = self._over_mass(matrix[3][offset])
        swap = {i: j, j: i}
        one = _relabel(upper, {j: later})
        two = _relabel(lower.xreplace(swap), {i: later})
        if expand(one - two) != 0:
            raise ArithmeticError(f"entries above and below the diagonal differ: {one}, {two}")
        return one

    @cached_property
    def mass_base(self) -> Expr:
        """M_00 = M_11."""
        return self._over_mass(self._generic.mass[0][0])

    @cached_property
    def mass_base_link(self) -> Vector:
        """M_0i and M_1i."""
        return self._over_mass(self._generic.mass[0][2]), self._over_mass(self._generic.mass[1][2])

    @cached_property
    def mass_link(self) -> Expr:
        """M_ii."""
        return self._over_mass(self._generic.mass[2][2])

    @cached_property
    def mass_link_link(self) -> Expr:
        """M_ij for two links, in i, j and the later of them."""
        return self._symmetric(self._generic.mass, 2)

    @cached_property
    def velocity_base_link(self) -> Vector:
        """Q_0i and Q_1i."""
        x, y = (self._over_mass(self._generic.velocity[row][0]) for row in (0, 1))
        return x, y

    @cached_property
    def velocity_link_link(self) -> Expr:
        """Q_ij for two links, in i, j and the later of them."""
        return self._symmetric(self._generic.velocity, 0)

    # Moments across the joints ----------------------------------------------------------------

    @cached_property
    def spring(self) -> Expr:
        """Moment of the spring in joint s on the link after it; that before gets the opposite."""
        before, after = phi[s - 1], phi[s]
        potential = spring_potential(before, after)
        on_before, on_after = -potential.diff(before), -potential.diff(after)
        if expand(on_before + on_after) != 0:
            raise ArithmeticError(f"the spring's moments {on_before}, {on_after} are not opposite")
        return factor(on_after)

    @cached_property
    def damper(self) -> Expr:
        """Moment of internal damping in joint s on the link after it."""
        return damper_moment(omega[s - 1], omega[s])

    @cached_property
    def root_spring(self) -> Expr:
        """Moment of the root spring on link 0; zero where there is none."""
        potential = self.hold.root * spring_potential(ALPHA, phi[0])
        return factor(-potential.diff(phi[0]))

    @cached_property
    def root_damper(self) -> Expr:
        """Moment of internal damping in the root on link 0, whose clamp does not turn; zero where
        no spring holds it."""
        return self.hold.root * damper_moment(S.Zero, omega[0])

    @cached_property
    def inner_moment(self) -> Expr:
        """The moments of this scene in joint s, between two links, on the link after it."""
        return self.spring + (self.damper if self._damped else S.Zero)

    @cached_property
    def root_moment(self) -> Expr:
        """The moments of this scene in joint 0 on link 0."""
        return self.root_spring + (self.root_damper if self._damped else S.Zero)

    @property
    def _damped(self) -> bool:
        return "internal_damping" in self.terms

    @cached_property
    def joint_moment(self) -> Expr:
        """The moments of this scene in joint s on the link after it."""
        if not self.hold.root:
            return self.inner_moment
        return Piecewise((self.root_moment, Eq(s, 0)), (self.inner_moment, True))

    @cached_property
    def link_moment(self) -> Expr:
        """What the joints at both ends of link i do to it, by virtual work of their moments."""
        start, end = joint_moment[i], -joint_moment[i + 1]
        cases = [(start, Eq(i, n - 1)), (start + end, True)]
        if self.hold.first < self.hold.first_spring:
            cases.insert(0, (end, Eq(i, 0)))
        return Piecewise(*cases)

    # Loads ------------------------------------------------------------------------------------

    def _lean(self, force: Vector) -> Expr:
        """Virtual work of a force on the angle of link i, for a lever of one."""
        (a_i, _), (dx, dy) = self._generic.a, self._generic.partial[0]
        work = (dx * force[0] + dy * force[1]).subs(a_i, 1)
        return work.xreplace({self._generic.angles[0]: phi[i]})

    @cached_property
    def _reach(self) -> Expr:
        """Lever of link i at the joint that ends it and at every joint behind: one and the same."""
        own, beyond = (lever(place, S.One) for place in (OWN, BEFORE))
        if own != beyond:
            raise ArithmeticError(f"levers {own} and {beyond} at the joints behind a link differ")
        return own

    @cached_property
    def follower(self) -> Work:
        """F: the follower force at the tail."""
        force = follower_force(phi[n - 1])
        return Work(force, self._reach * self._lean(force))

    @cached_property
    def tip_load(self) -> Work:
        """T: the dead force at the tail."""
        force = tip_force()
        return Work(force, self._reach * self._lean(force))

    @cached_property
    def gravity(self) -> Work:
        """A: gravity on the mass of every link."""
        force = weight(S.One)
        x, y = (self._lever_mass([], []) * f for f in force)
        return Work((x, y), self._lever_mass([i], [1]) * self._lean(force))

    @cached_property
    def external_damping(self) -> Work:
        """-D_e: the forces on the joints, as sums over those behind a link."""
        low = self.hold.first_joint
        x, y = (Sum(d[joint], (joint, low, n)) for d in (drag_x, drag_y))
        after = tuple(Sum(d[joint], (joint, i + 1, n)) for d in (drag_x, drag_y))
        return Work((x, y), self._reach * self._lean((after[0], after[1])))

    def point_force(self, force: Vector, carrier: Expr, share: Expr) -> Work:
        """A force on the point at the fraction ``share`` of link ``carrier``."""
        reach = Piecewise(
            (lever(BEFORE, share), i < carrier),
            (lever(OWN, share), i <= carrier),
            (lever(AFTER, share), True),
        )
        return Work(force, reach * self._lean(force))

    @cached_property
    def works(self) -> dict[str, Work]:
        """The loads of this scene that act as forces, by term."""
        forces = ("follower", "gravity", "external_damping", "tip_load")
        return {term: getattr(self, term) for term in self.terms if term in forces}

    # Quantities along the chain ---------------------------------------------------------------

    @cached_property
    def arrays(self) -> dict[IndexedBase, Array]:
        """Positions and velocities of the joints, and external damping there."""
        hold = self.hold
        angle, time_angle = phi[i], dynamicsymbols("phi", real=True)
        ends = combine((S.Zero, S.Zero), [lever(BEFORE, xi)], [time_angle])
        rates = [e.diff(TIME).subs(time_angle.diff(TIME), omega[i]) for e in ends]
        steps = [e.subs(time_angle, angle) for e in (*ends, *rates)]
        origin = (x0, y0, vx0, vy0) if hold.translates else (S.Zero,) * 4
        firsts = (0, 0, hold.first, hold.first)
        sums = [
            start + Sum(step, (i, first, joint - 1))
            for start, step, first in zip(origin, steps, firsts, strict=True)
        ]
        drag = drag_force(
            JointDrag(
                joint_vx[joint],
                joint_vy[joint],
                divisor[joint],
                rod_angle[joint],
                mass_at[joint],
                fin_factor[joint],
            )
        )
        zero, first, moving = map(Integer, (0, hold.first, hold.first_joint))
        values = {
            joint_x: (zero, sums[0]),
            joint_y: (zero, sums[1]),
            joint_vx: (first, sums[2]),
            joint_vy: (first, sums[3]),
            reach_x: (zero, sums[0] - origin[0]),
            reach_y: (zero, sums[1] - origin[1]),
            arm_x: (zero, reach_x[joint] - centre_x),
            arm_y: (zero, reach_y[joint] - centre_y),
            divisor: (moving, drag_divisor(joint_vx[joint], joint_vy[joint])),
            mass_at: (moving, self._at_joint(joint_mass(1), joint_mass(1), joint_mass(2))),
            rod_angle: (moving, self.rod_angle),
            drag_x: (moving, drag[0]),
            drag_y: (moving, drag[1]),
        }
        arrays = {base: Array(base, joint, low, n, value) for base, (low, value) in values.items()}
        low = Integer(hold.first_spring)
        arrays[joint_moment] = Array(joint_moment, s, low, n - 1, self.joint_moment)
        return arrays

    @cached_property
    def rod_angle(self) -> Expr:
        """Angle of the rod at a joint: mean of the links that meet there."""
        start, end = joint_angle([phi[0]]), joint_angle([phi[n - 1]])
        return self._at_joint(start, end, joint_angle([phi[joint - 1], phi[joint]]))

    def _at_joint(self, start: Expr, end: Expr, inner: Expr) -> Expr:
        cases = [(end, Eq(joint, n)), (inner, True)]
        if self.hold.translates:
            cases.insert(0, (start, Eq(joint, 0)))
        return Piecewise(*cases)


def _relabel(expression: Expr, indices: dict[Symbol, Symbol]) -> Expr:
    """Rename indices in the weights, not in the angles that they number."""
    angles = {phi[at]: Symbol(f"_{at}") for at in (i, j)}
    back = {symbol: angle for angle, symbol in angles.items()}
    return expression.xreplace(angles).xreplace(indices).xreplace(back)
