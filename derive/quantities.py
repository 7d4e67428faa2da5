"""Energies, power and geometry for every n, as sums over the links and joints.

They follow from the same kinematics and laws as the equations, and enter generated modules beside
them: what a run is judged and looked at by.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from sympy import Eq, Expr, Integer, Piecewise, S, Sum, collect, cos, expand, sin
from sympy.physics.mechanics import dynamicsymbols

from .calculus import TIME
from .chain import OWN, Vector, combine, lever
from .general import (
    Equations,
    arm_x,
    arm_y,
    drag_x,
    drag_y,
    joint,
    joint_vx,
    joint_vy,
    joint_x,
    joint_y,
    reach_x,
    reach_y,
)
from .inertia import mean
from .loads import (
    NON_CONSERVATIVE,
    damper_moment,
    follower_force,
    spring_potential,
    tip_force,
    weight,
)
from .symbols import ALPHA, i, k, m, n, omega, phi, s, xi


@dataclass(frozen=True)
class Acting:
    """A load as forces [N] on the joints from ``low`` to ``high``; on one joint where these are the
    same."""

    low: Expr
    high: Expr
    force: Vector


@dataclass(frozen=True)
class Quantities:
    """What is asked of a chain besides its rates."""

    equations: Equations

    def _link_mean(
        self, origin: Vector, angle: Expr, function: Callable[[Expr, Expr], Expr]
    ) -> Expr:
        """Mean over the mass of one link of a function of the point at xi."""
        point = combine(origin, [lever(OWN, xi)], [angle])
        return mean(self.equations.inertia, expand(function(*point)))

    @cached_property
    def kinetic_energy(self) -> Expr:
        """Half the mean square velocity times the mass, summed over the moving links [J]."""
        x, y, angle = dynamicsymbols("x y phi", real=True)
        squared = self._link_mean((x, y), angle, lambda a, b: a.diff(TIME) ** 2 + b.diff(TIME) ** 2)
        collected = expand(expand(squared).subs(sin(angle) ** 2, 1 - cos(angle) ** 2))
        values = {x.diff(TIME): joint_vx[i], y.diff(TIME): joint_vy[i]}
        values[angle.diff(TIME)] = omega[i]
        per_mass = collected.subs(values).subs(angle, phi[i])
        return Sum(m / 2 * per_mass, (i, self.equations.hold.first, n - 1))

    @cached_property
    def spring_energy(self) -> Expr:
        """Energy of all springs [J]."""
        root = self.equations.hold.root * spring_potential(ALPHA, phi[0])
        return root + Sum(spring_potential(phi[s - 1], phi[s]), (s, 1, n - 1))

    @cached_property
    def bending_moment(self) -> Expr:
        """Moment of the spring in a joint [N m]: the derivative of its energy by the angle of the
        link after it, which is what it does to the link before; zero without a spring."""

        def moment(energy: Expr, angle: Expr) -> Expr:
            return collect(expand(energy.diff(angle)), k)

        inner = moment(spring_potential(phi[joint - 1], phi[joint]), phi[joint])
        root = moment(self.equations.hold.root * spring_potential(ALPHA, phi[0]), phi[0])
        return Piecewise((root, Eq(joint, 0)), (S.Zero, Eq(joint, n)), (inner, True))

    @cached_property
    def forces(self) -> dict[str, Acting]:
        """Loads that act as forces on joints, by term."""
        moving = Integer(self.equations.hold.first_joint)
        acting = {
            "follower": Acting(n, n, follower_force(phi[n - 1])),
            "tip_load": Acting(n, n, tip_force()),
            "external_damping": Acting(moving, n, (drag_x[joint], drag_y[joint])),
        }
        return {term: acting[term] for term in self.equations.terms if term in acting}

    @cached_property
    def gravity_energy(self) -> Expr:
        """Minus the work of gravity from the origin to every link."""
        force = weight(m)
        origin = (joint_x[i], joint_y[i])
        fall = self._link_mean(origin, phi[i], lambda x, y: -force[0] * x - force[1] * y)
        return Sum(fall, (i, 0, n - 1))

    @cached_property
    def power(self) -> dict[str, Expr]:
        """Power of each load that is not a potential [W]: force times velocity of its point."""
        force, dead = follower_force(phi[n - 1]), tip_force()
        opening = omega[s] - omega[s - 1]
        moment = damper_moment(omega[s - 1], omega[s])
        low = self.equations.hold.first_joint
        powers = {
            "follower": force[0] * joint_vx[n] + force[1] * joint_vy[n],
            "tip_load": dead[0] * joint_vx[n] + dead[1] * joint_vy[n],
            "internal_damping": self.equations.root_damper * omega[0]
            + Sum(moment * opening, (s, 1, n - 1)),
            "external_damping": Sum(
                drag_x[joint] * joint_vx[joint] + drag_y[joint] * joint_vy[joint], (joint, low, n)
            ),
        }
        return {term: powers[term] for term in self.equations.terms if term in NON_CONSERVATIVE}

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
        return Sum(x, (i, 0, n - 1)) / n, Sum(y, (i, 0, n - 1)) / n

    @cached_property
    def second_moments(self) -> tuple[Expr, Expr, Expr]:
        """Integrals of y^2, x^2 and xy over the mass, about the centre of gravity: the moments
        of inertia about the x and y axes and the product of inertia."""
        origin = (arm_x[i], arm_y[i])
        products = (lambda x, y: y**2, lambda x, y: x**2, lambda x, y: x * y)
        means = (self._link_mean(origin, phi[i], f) for f in products)
        first, second, third = (Sum(m * value, (i, 0, n - 1)) for value in means)
        return first, second, third
