"""Derivation 2: the equations for every n at once, as indexed expressions.

The Euler-Lagrange operator is linear and a squared velocity couples links only in pairs, so one
mass point carried by two generic links (at the levers a_i and a_j) has every kind of entry.
Summing the products of levers over the mass of all links gives the weights, for symbolic n.
Sums over links stay SymPy sums: they become loops in generated code.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from sympy import (
    Add,
    Eq,
    Expr,
    IndexedBase,
    Integer,
    Piecewise,
    Poly,
    S,
    Sum,
    Symbol,
    expand,
    factor,
)

from .base_motion import link_growth
from .chain import (
    AFTER,
    BEFORE,
    LINEAR,
    OWN,
    Vector,
    lever,
    link_step,
    spring_moment,
)
from .generic_chain import AtSprings, GenericChain
from .link_properties import Joint
from .loads import loads_of
from .loads.kinds import GeneralisedForces, Load
from .symbols import (
    Array,
    arm_x,
    arm_y,
    centre_x,
    centre_y,
    i,
    j,
    joint,
    joint_moment,
    joint_vx,
    joint_vy,
    joint_x,
    joint_y,
    later,
    moved_ax,
    moved_ay,
    n,
    phi,
    reach_x,
    reach_y,
    s,
    vx0,
    vy0,
    x0,
    y0,
)


@dataclass(frozen=True)
class GeneralEquations(GenericChain):
    """M v' = Q omega^2 + moments across the joints + work of the loads, for any n.

    Entries are functions of the indices i, j (links), later = max(i, j), s (inner joints); the
    diagonal of M is `mass_link`, that of Q is zero. Rows of the base exist where it translates.
    law: moment of a spring, by its stiffness k and the angle d that bends it.
    """

    boundary: str
    inertia: str
    terms: tuple[str, ...]
    nonuniform: tuple[str, ...] = ()
    law: Expr = LINEAR

    @cached_property
    def loads(self) -> dict[str, Load]:
        """The loads of this scene, by term."""
        return loads_of(self.terms, self.rod)

    @property
    def has_velocity_loads(self) -> bool:
        """Whether a load depends on the velocities of the joints."""
        return any(load.by_velocity for load in self.loads.values())

    @property
    def has_position_loads(self) -> bool:
        """Whether a load depends on the positions of the joints."""
        return any(load.by_position for load in self.loads.values())

    # Inertia ---------------------------------------------------------------------------------

    def _integrate_over_mass(self, entry: Expr) -> Expr:
        """An entry of the generic mass point, summed over the mass of the chain."""
        generic, total = self._generic, S.Zero
        poly = Poly(expand(entry / generic.mu), *generic.a, *generic.b)
        for powers, coefficient in poly.terms():
            along, aside = powers[:2], powers[2:] or (0, 0)
            used = [of for of in zip((i, j), along, aside, strict=True) if any(of[1:])]
            columns = map(list, zip(*used, strict=True)) if used else ([], [])
            total += self.lever_moment(*columns) * coefficient
        return total.xreplace(dict(zip(generic.angles, (phi[i], phi[j]), strict=True)))

    def _pair_entry(self, matrix: list[list[Expr]], offset: int, sign: int = 1) -> Expr:
        """Entry of two links as one expression in i, j and the later of them; where links differ in
        mass, for links i < j alone, its mirror image being ``sign`` times it."""
        upper = self._integrate_over_mass(matrix[2][offset + 1])
        lower = self._integrate_over_mass(matrix[3][offset])
        if self.rod.has_link_masses:
            if expand(upper - sign * lower) != 0:
                raise ArithmeticError(f"entries {upper} and {lower} are no mirror images")
            return upper
        swap = {i: j, j: i}
        one = _rename_indices(upper, {j: later})
        two = _rename_indices(lower.xreplace(swap), {i: later})
        if expand(one - two) != 0:
            raise ArithmeticError(f"entries above and below the diagonal differ: {one}, {two}")
        return one

    @cached_property
    def mass_base(self) -> Expr:
        """M_00 = M_11."""
        return self._integrate_over_mass(self._generic.mass[0][0])

    @cached_property
    def mass_base_link(self) -> Vector:
        """M_0i and M_1i."""
        x, y = (self._integrate_over_mass(self._generic.mass[row][2]) for row in (0, 1))
        return x, y

    @cached_property
    def mass_link(self) -> Expr:
        """M_ii."""
        return self._integrate_over_mass(self._generic.mass[2][2])

    @cached_property
    def mass_link_link(self) -> Expr:
        """M_ij for two links, in i, j and the later of them."""
        return self._pair_entry(self._generic.mass, 2)

    @cached_property
    def velocity_base_link(self) -> Vector:
        """Q_0i and Q_1i."""
        x, y = (self._integrate_over_mass(self._generic.velocity[row][0]) for row in (0, 1))
        return x, y

    @cached_property
    def velocity_link_link(self) -> Expr:
        """Q_ij for two links, in i, j and the later of them."""
        return self._pair_entry(self._generic.velocity, 0, -1)

    # Moments across the joints ----------------------------------------------------------------

    @cached_property
    def springs(self) -> AtSprings:
        """Moments of springs on the link, or the clamp of the tail, after each joint, where that
        before gets the opposite; zero where there is no spring."""
        return self.at_springs(self._spring_moment, phi)

    def _spring_moment(self, before: Expr, after: Expr, spring: Joint) -> Expr:
        moment = -spring_moment(spring.bend(before, after), spring.stiffness, self.law)
        return factor(moment) if self.law == LINEAR else moment

    @cached_property
    def moments(self) -> AtSprings:
        """Total moments on the link, or the clamp of the tail, after each joint."""
        loads = (load.moments(self) for load in self.loads.values())
        parts = zip(self.springs, *loads, strict=True)
        return AtSprings(*(Add(*part) for part in parts))

    @cached_property
    def joint_moment(self) -> Expr:
        """Total moment in joint s on the link after it, or on the clamp of the tail."""
        inner, root, tail = self.moments
        ends = [(root, Eq(s, 0))] if self.boundary_condition.root else []
        ends += [(tail, Eq(s, n))] if self.boundary_condition.tail else []
        return Piecewise(*ends, (inner, True)) if ends else inner

    @cached_property
    def link_moment(self) -> Expr:
        """Moment of the joints at both ends of link i on it, by virtual work."""
        start, end = joint_moment[i], -joint_moment[i + 1]
        cases = [(start + end, True)]
        if not self.boundary_condition.tail:
            cases.insert(0, (start, Eq(i, n - 1)))
        if self.boundary_condition.first < self.boundary_condition.first_spring:
            cases.insert(0, (end, Eq(i, 0)))
        return Piecewise(*cases)

    # Loads ------------------------------------------------------------------------------------

    def point_force(self, force: Vector, carrier: Expr, share: Expr) -> GeneralisedForces:
        """Generalised forces of a force at the fraction ``share`` of link ``carrier``."""
        length = self.rod.length(i)
        reach = Piecewise(
            (lever(BEFORE, share, length), i < carrier),
            (lever(OWN, share, length), i <= carrier),
            (lever(AFTER, share, length), True),
        )
        return GeneralisedForces(force, reach * self.angle_force(force))

    @cached_property
    def generalised_forces(self) -> dict[str, GeneralisedForces]:
        """Generalised forces of the loads that act as forces, by term."""
        works = {term: load.generalised_forces(self) for term, load in self.loads.items()}
        return {term: work for term, work in works.items() if work is not None}

    # Quantities along the chain ---------------------------------------------------------------

    @cached_property
    def arrays(self) -> dict[IndexedBase, Array]:
        """Positions and velocities of the joints, moments across them, and arrays of the loads."""
        boundary_condition = self.boundary_condition
        base, first_link = self.base_motion, boundary_condition.first_in_motion
        origin = (x0, y0, vx0, vy0)
        if not boundary_condition.translates:
            origin = (*base.of_start(0), *base.of_start(1))
        firsts, steps = (0, 0, first_link, first_link), link_step(i, S.One, self.rod.length(i))
        sums = [
            start + Sum(step, (i, first, joint - 1))
            for start, step, first in zip(origin, steps, firsts, strict=True)
        ]
        zero, first, moving = map(Integer, (0, first_link, boundary_condition.first_joint))
        values = {
            joint_x: (zero, sums[0]),
            joint_y: (zero, sums[1]),
            joint_vx: (first, sums[2]),
            joint_vy: (first, sums[3]),
            reach_x: (zero, sums[0] - origin[0]),
            reach_y: (zero, sums[1] - origin[1]),
            arm_x: (zero, reach_x[joint] - centre_x),
            arm_y: (zero, reach_y[joint] - centre_y),
        }
        if boundary_condition.moves:
            values |= self._accelerations_of_joints()
        for load in self.loads.values():
            values |= {base: (moving, value) for base, value in load.joint_arrays(self).items()}
        arrays = {base: Array(base, joint, low, n, value) for base, (low, value) in values.items()}
        low, high = (
            Integer(boundary_condition.first_spring),
            n if boundary_condition.tail else n - 1,
        )
        arrays[joint_moment] = Array(joint_moment, s, low, high, self.joint_moment)
        for load in self.loads.values():
            for base, value in load.spring_arrays(self).items():
                arrays[base] = Array(base, s, low, high, value)
            for base, value in load.link_arrays(boundary_condition).items():
                arrays[base] = Array(base, i, first, n - 1, value)
        return arrays

    def _accelerations_of_joints(self) -> dict[IndexedBase, tuple[Expr, Expr]]:
        """Arrays of the accelerations of the joints from which links with angles of their own go
        on, by those of these links: their first index and their values."""
        first = Integer(self.boundary_condition.first)
        start = self.base_motion.of_first_joint(self.boundary_condition, self.rod)
        growth = link_growth(i, self.rod.length(i))
        parts = zip((moved_ax, moved_ay), start, growth, strict=True)
        return {base: (first, a + Sum(step, (i, first, joint - 1))) for base, a, step in parts}


def _rename_indices(expression: Expr, indices: dict[Symbol, Symbol]) -> Expr:
    """Rename indices in the weights, not in the angles that they number."""
    angles = {phi[at]: Symbol(f"_{at}") for at in (i, j)}
    back = {symbol: angle for angle, symbol in angles.items()}
    return expression.xreplace(angles).xreplace(indices).xreplace(back)
