"""Energies, power and geometry for every n, as sums over the links and joints.

They follow from the same kinematics and laws as the equations; generated modules have them beside
the equations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

from sympy import Add, Eq, Expr, Piecewise, S, Sum, Symbol, collect, cos, expand, sin
from sympy.physics.mechanics import dynamicsymbols

from .chain import (
    LINEAR,
    OWN,
    Vector,
    combine,
    lever,
    normal_angle,
    side_lever,
    spring_moment,
    spring_potential,
)
from .general import GeneralEquations
from .generic_chain import AtSprings
from .link_properties import Joint
from .loads import supports
from .loads.base import Base
from .loads.kinds import AppliedForces, Load, MassForce
from .polynomials import TIME
from .symbols import (
    alpha,
    arm_x,
    arm_y,
    eta,
    i,
    joint,
    joint_vx,
    joint_vy,
    joint_x,
    joint_y,
    k,
    moved_ax,
    moved_ay,
    n,
    omega,
    phi,
    reach_x,
    reach_y,
    s,
    xi,
)

SUPPORTS = supports.LOAD.term


@dataclass(frozen=True)
class Quantities:
    """Energies, power, momenta and geometry of a chain. potentials: loads that have a potential."""

    equations: GeneralEquations
    potentials: tuple[str, ...] = ()

    def _link_mean(
        self, origin: Vector, angle: Expr, function: Callable[[Expr, Expr], Expr]
    ) -> Expr:
        """Mean over the mass of link i of a function of the point at xi."""
        rod, length = self.equations.rod, self.equations.rod.length(i)
        levers = [lever(OWN, xi, length)]
        levers += [side_lever(OWN, eta, length)] if rod.has_offset_mass else []
        point = combine(origin, levers, [angle, normal_angle(angle)][: len(levers)])
        return rod.mean(expand(function(*point)), i)

    def _integrate_over_mass(
        self,
        function: Callable[[Expr, Expr], Expr],
        origin: Vector = (S.Zero, S.Zero),
        part: Expr = S.One,
    ) -> Expr:
        """Integral over the mass of the links that move of ``part`` times a function of the point
        at xi, whose coordinates depend on time; origin: the joint before link i."""
        whole = part * self.equations.rod.mass(i) * self._on_link(function, origin)
        return Sum(whole, (i, self.equations.boundary_condition.first_in_motion, n - 1))

    def _on_link(self, function: Callable[[Expr, Expr], Expr], origin: Vector) -> Expr:
        """Mean over the mass of link i of a function of the point at xi, whose coordinates depend
        on time."""
        x, y, angle = dynamicsymbols("x y phi", real=True)
        mean = expand(self._link_mean((x, y), angle, function))
        collected = expand(mean.subs(sin(angle) ** 2, 1 - cos(angle) ** 2))
        growing = zip((x, y, angle), (moved_ax, moved_ay, alpha), strict=True)
        moving = zip((x, y, angle), (joint_vx, joint_vy, omega), strict=True)
        values = {of.diff(TIME, 2): base[i] for of, base in growing}
        values |= {of.diff(TIME): base[i] for of, base in moving}
        there = {x: origin[0], y: origin[1], angle: phi[i]}
        return collected.subs(values).subs(there)

    @cached_property
    def inertia(self) -> tuple[Vector, tuple[Expr, Expr, Expr]]:
        """Force [N] that the accelerations of the links with angles of their own need; that of the
        held link, and its moment [N m] about joint 0; zero where there is none."""
        equations = self.equations
        first, mass = equations.boundary_condition.first, equations.rod.mass(i)
        needs = [
            mass * self._on_link(function, (S.Zero, S.Zero))
            for function in (
                lambda x, _: x.diff(TIME, 2),
                lambda _, y: y.diff(TIME, 2),
                lambda x, y: x * y.diff(TIME, 2) - y * x.diff(TIME, 2),
            )
        ]
        x, y = (Sum(need, (i, first, n - 1)) for need in needs[:2])
        motion = equations.base_motion
        growing = zip((moved_ax, moved_ay), motion.of_start(2), strict=True)
        known = {base[0]: a for base, a in growing} | {alpha[0]: motion.angle[2]}
        held = [need.subs(i, 0).xreplace(known) if first else S.Zero for need in needs]
        return (x, y), (held[0], held[1], held[2])

    @cached_property
    def kinetic_energy(self) -> Expr:
        """Kinetic energy [J]: half the squared velocity, integrated over the moving mass."""
        return self._integrate_over_mass(
            lambda x, y: x.diff(TIME) ** 2 + y.diff(TIME) ** 2, part=S.Half
        )

    @cached_property
    def momentum(self) -> Vector:
        """Momentum of the rod with its bodies [N s]."""
        x, y = (
            self._integrate_over_mass(of)
            for of in (lambda x, _: x.diff(TIME), lambda _, y: y.diff(TIME))
        )
        return x, y

    @cached_property
    def velocities(self) -> tuple[Expr, ...]:
        """Velocities [m/s] of the start, the tail and the centre of gravity, x and y of each."""
        rod, all_links = self.equations.rod, (i, 0, n - 1)
        mass = Sum(rod.mass(i), all_links) if rod.has_link_masses else n * rod.mass(i)
        ends = (base[at] for at in (0, n) for base in (joint_vx, joint_vy))
        return (*ends, *(momentum / mass for momentum in self.momentum))

    @cached_property
    def angular_momentum(self) -> Expr:
        """Angular momentum [N m s], of a rod that moves freely about its centre of gravity, else
        about the start of the first link that moves."""
        boundary, origin = self.equations.boundary_condition, (arm_x[i], arm_y[i])
        if boundary.is_held:
            first = boundary.first_in_motion
            origin = (reach_x[i] - reach_x[first], reach_y[i] - reach_y[first])
        return self._integrate_over_mass(lambda x, y: x * y.diff(TIME) - y * x.diff(TIME), origin)

    @cached_property
    def reaction_moment(self) -> Expr:
        """Moment [N m] of the clamps on the links that move, by springs and dampers."""
        inner, root, tail = self.equations.moments
        first = self.equations.boundary_condition.first
        return (inner.subs(s, first) if first else root) - tail

    @cached_property
    def support_forces(self) -> tuple[Expr, ...]:
        """Force of the support of link i on it [N], and its moment [N m]; none without supports."""
        supports = self.equations.loads.get(SUPPORTS)
        return (
            ()
            if supports is None
            else tuple(supports.link_arrays(self.equations.boundary_condition).values())
        )

    @cached_property
    def start_loads(self) -> tuple[Expr, ...]:
        """Forces [N] of the loads on link i at its start; empty where there are none."""
        boundary, loads = self.equations.boundary_condition, self.equations.loads.values()
        parts = zip(
            (S.Zero, S.Zero), *(load.start_force(i, boundary) for load in loads), strict=True
        )
        total = tuple(_piecewise_by_link(Add(*part)) for part in parts)
        return total if any(total) else ()

    @cached_property
    def curvature(self) -> Expr:
        """Curvature at the spring in joint s [1/m]: in an even rod that is straight at rest, its
        moment over the bending stiffness."""

        def curvature_of(before: Expr, after: Expr, spring: Joint) -> Expr:
            return spring_moment(after - before, 1 / spring.length)

        return _piecewise_at_ends(self.equations.at_springs(curvature_of, phi), s)

    @cached_property
    def spring_energy(self) -> Expr:
        """Energy of all springs [J]."""

        def energy_of(before: Expr, after: Expr, spring: Joint) -> Expr:
            bent = spring.bend(before, after)
            return spring_potential(bent, spring.stiffness, self.equations.law)

        inner, root, tail = self.equations.at_springs(energy_of, phi)
        return root + tail + Sum(inner, (s, 1, n - 1))

    @cached_property
    def bending_moment(self) -> Expr:
        """Moment of the spring in a joint on the link before it [N m]; zero without a spring."""
        law = self.equations.law

        def moment_of(before: Expr, after: Expr, spring: Joint) -> Expr:
            moment = spring_moment(spring.bend(before, after), spring.stiffness, law)
            return collect(expand(moment), k) if law == LINEAR else moment

        return _piecewise_at_ends(self.equations.at_springs(moment_of, phi, joint), joint)

    @cached_property
    def anchor_energy(self) -> Expr:
        """Energy of the springs to the ground, of supports and the foundation [J]."""
        return sum((x.energy(self.equations) for x in self.equations.loads.values()), S.Zero)

    @cached_property
    def forces(self) -> dict[str, AppliedForces]:
        """Loads that act as forces on joints, by term."""
        loads = self.equations.loads.items()
        acting = {
            term: load.applied_forces(self.equations.boundary_condition) for term, load in loads
        }
        return {term: load for term, load in acting.items() if load is not None}

    @cached_property
    def load_energy(self) -> Expr:
        """Potential of the loads [J]; zero where none has one."""
        loads = (self.equations.loads[name] for name in self.potentials)
        others = (load.potential(self.equations) for load in loads)
        return self.weight_energy + sum(others, S.Zero)

    @cached_property
    def weight_energy(self) -> Expr:
        """Potential of the loads that act on mass [J]: minus their work from the origin to every
        link; zero where none has one."""
        origin, total = (joint_x[i], joint_y[i]), S.Zero
        for name in self.potentials:
            if isinstance(load := self.equations.loads[name], MassForce):
                of = self.equations.rod.mass(i), self.equations.boundary_condition
                potential = partial(load.potential_of_mass, *of)
                fall = self._link_mean(origin, phi[i], potential)
                total += Sum(fall, (i, 0, n - 1))
        return total

    @cached_property
    def power(self) -> dict[str, Expr]:
        """Power of each load that has no potential [W], by term."""
        loads = self.equations.loads.items()
        return {t: self._power_of(load) for t, load in loads if t not in self.potentials}

    def _power_of(self, load: Load) -> Expr:
        if isinstance(load, Base):
            return load.power_of(self.equations, *self.inertia)
        if not load.by_momentum:
            return load.power(self.equations)
        force = load.weight(S.One, self.equations.boundary_condition)
        parts = zip(force, self.momentum, strict=True)
        return Add(*(force * momentum for force, momentum in parts if force))

    @cached_property
    def centre(self) -> Vector:
        """Centre of gravity."""
        return self._centre((joint_x[i], joint_y[i]))

    @cached_property
    def centre_from_start(self) -> Vector:
        """Centre of gravity relative to joint 0: no digits are lost far from the origin."""
        return self._centre((reach_x[i], reach_y[i]))

    def _centre(self, origin: Vector) -> Vector:
        x = self._link_mean(origin, phi[i], lambda x, y: x)
        y = self._link_mean(origin, phi[i], lambda x, y: y)
        rod = self.equations.rod
        if not rod.has_link_masses:
            return Sum(x, (i, 0, n - 1)) / n, Sum(y, (i, 0, n - 1)) / n
        mass = rod.mass(i)
        sums = [Sum(value, (i, 0, n - 1)) for value in (mass * x, mass * y, mass)]
        return sums[0] / sums[2], sums[1] / sums[2]

    @cached_property
    def second_moments(self) -> tuple[Expr, Expr, Expr]:
        """Integrals of y^2, x^2 and xy over the mass, about the centre of gravity: the moments
        of inertia about the x and y axes and the product of inertia."""
        origin = (arm_x[i], arm_y[i])
        products = (lambda x, y: y**2, lambda x, y: x**2, lambda x, y: x * y)
        means = (self._link_mean(origin, phi[i], f) for f in products)
        mass = self.equations.rod.mass(i)
        first, second, third = (Sum(mass * value, (i, 0, n - 1)) for value in means)
        return first, second, third


def _piecewise_at_ends(of: AtSprings, index: Symbol) -> Expr:
    """Value for the spring in the joint of an index."""
    return Piecewise((of.root, Eq(index, 0)), (of.tail, Eq(index, n)), (of.inner, True))


def _piecewise_by_link(total: Expr) -> Expr:
    """Piecewise of a sum whose terms differ at single links: at each of these, and elsewhere."""
    named = sorted({equality.rhs for equality in total.atoms(Eq)})
    elsewhere = total.replace(
        lambda e: isinstance(e, Piecewise) and e.has(Eq), lambda e: e.args[-1][0]
    )
    return Piecewise(*((total.subs(i, link), Eq(i, link)) for link in named), (elsewhere, True))
