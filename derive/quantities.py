"""Energies, power and geometry for every n, as sums over the links and joints.

They follow from the same kinematics and laws as the equations, and enter generated modules beside
them: what a run is judged and looked at by.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

from sympy import Eq, Expr, Piecewise, S, Sum, collect, cos, expand, sin
from sympy.physics.mechanics import dynamicsymbols

from .calculus import TIME
from .chain import (
    LINEAR,
    OWN,
    Vector,
    across,
    combine,
    lever,
    side,
    spring_moment,
    spring_potential,
)
from .general import Equations
from .loads.kinds import Acting, MassForce
from .symbols import (
    ALPHA,
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
    n,
    omega,
    phi,
    reach_x,
    reach_y,
    s,
    xi,
)


@dataclass(frozen=True)
class Quantities:
    """What is asked of a chain besides its rates."""

    equations: Equations

    def _link_mean(
        self, origin: Vector, angle: Expr, function: Callable[[Expr, Expr], Expr]
    ) -> Expr:
        """Mean over the mass of link i of a function of the point at xi."""
        rod = self.equations.rod
        beside = [side(OWN, eta)] if rod.sided else []
        point = combine(
            origin, [lever(OWN, xi), *beside], [angle, across(angle)][: 1 + len(beside)]
        )
        return rod.mean(expand(function(*point)), i)

    @cached_property
    def kinetic_energy(self) -> Expr:
        """Half the mean square velocity times the mass, summed over the moving links [J]."""
        x, y, angle = dynamicsymbols("x y phi", real=True)
        squared = self._link_mean((x, y), angle, lambda a, b: a.diff(TIME) ** 2 + b.diff(TIME) ** 2)
        collected = expand(expand(squared).subs(sin(angle) ** 2, 1 - cos(angle) ** 2))
        values = {x.diff(TIME): joint_vx[i], y.diff(TIME): joint_vy[i]}
        values[angle.diff(TIME)] = omega[i]
        per_mass = collected.subs(values).subs(angle, phi[i])
        return Sum(self.equations.rod.mass(i) / 2 * per_mass, (i, self.equations.hold.first, n - 1))

    @cached_property
    def spring_energy(self) -> Expr:
        """Energy of all springs [J]."""
        root, tail, inner = self._springs(s, spring_potential)
        return root + tail + Sum(inner, (s, 1, n - 1))

    def _springs(self, at: Expr, of: Callable[..., Expr]) -> list[Expr]:
        """What the springs in the root, in the tail and in a joint between two links have."""
        hold, rod = self.equations.hold, self.equations.rod
        springs = (
            (ALPHA, phi[0], rod.stiffness(0, hold.root)),
            (phi[n - 1], ALPHA, rod.stiffness(n, hold.tail)),
            (phi[at - 1], phi[at], rod.stiffness(at)),
        )
        return [of(*spring, self.equations.law) for spring in springs]

    @cached_property
    def bending_moment(self) -> Expr:
        """Moment of the spring in a joint on the link before it [N m]; zero without a spring."""
        moments = self._springs(joint, spring_moment)
        if self.equations.law == LINEAR:
            moments = [collect(expand(moment), k) for moment in moments]
        root, tail, inner = moments
        return Piecewise((root, Eq(joint, 0)), (tail, Eq(joint, n)), (inner, True))

    @cached_property
    def held_energy(self) -> Expr:
        """Energy of the springs of the loads [J]."""
        return sum((x.energy(self.equations) for x in self.equations.loads.values()), S.Zero)

    @cached_property
    def forces(self) -> dict[str, Acting]:
        """Loads that act as forces on joints, by term."""
        loads = self.equations.loads.items()
        acting = {term: load.acting(self.equations.hold) for term, load in loads}
        return {term: load for term, load in acting.items() if load is not None}

    @cached_property
    def load_energy(self) -> Expr:
        """Potential of the loads that act on mass [J]: minus their work from the origin to every
        link; zero where there are none."""
        origin, total = (joint_x[i], joint_y[i]), S.Zero
        for load in self.equations.loads.values():
            if isinstance(load, MassForce):
                potential = partial(load.potential, self.equations.rod.mass(i))
                fall = self._link_mean(origin, phi[i], potential)
                total += Sum(fall, (i, 0, n - 1))
        return total

    @cached_property
    def power(self) -> dict[str, Expr]:
        """Power of each load that has no potential [W], by term."""
        loads = {t: load for t, load in self.equations.loads.items() if not load.conservative}
        return {term: load.power(self.equations) for term, load in loads.items()}

    @cached_property
    def centre(self) -> Vector:
        """Centre of gravity."""
        return self._centre((joint_x[i], joint_y[i]))

    @cached_property
    def centre_from_start(self) -> Vector:
        """Centre of gravity from joint 0, wherever that is: no digits are lost far from home."""
        return self._centre((reach_x[i], reach_y[i]))

    def _centre(self, origin: Vector) -> Vector:
        x = self._link_mean(origin, phi[i], lambda x, y: x)
        y = self._link_mean(origin, phi[i], lambda x, y: y)
        rod = self.equations.rod
        if not rod.heavy:
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
