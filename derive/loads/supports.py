"""Supports: springs and dampers from points of the rod to fixed points, and against turning."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sympy import Expr, IndexedBase, S, Sum, symbols
from sympy.polys.rings import PolyElement

from rodgen.model.rod import Boundary

from ..chain import Vector, link_step
from ..closed_form import ClosedForm, Num, Pair
from ..explicit_chain import ExplicitChain
from ..generic_chain import GenericChain
from ..symbols import (
    i,
    joint,
    joint_vx,
    joint_vy,
    joint_x,
    joint_y,
    n,
    omega,
    other,
    parameters,
    phi,
)
from .kinds import GeneralisedForces, JointLoad, Value

ANGLE = parameters("supports")[0]
PLACE = symbols("x y angle", real=True)  # of a link, of which energies are differentiated


@dataclass(frozen=True)
class LinkMotion:
    """Motion of a link, as a support needs it: position of its point and angle, how fast they
    change, and its per_link parameters."""

    place: tuple[Any, ...]
    velocity: tuple[Any, ...]
    factors: tuple[Any, ...]


class Supports(JointLoad):
    """Springs and dampers on a point of every link: a force and a moment by position and velocity.

    Energy: (k_x (x - x_0)^2 + k_y (y - y_0)^2 + kappa (phi - phi_0)^2)/2. The first parameter of
    every link is the share of it before the point; on the joints at both ends of a rigid link the
    parts of the force do what the whole does there.
    """

    letter = "R"
    by_velocity = by_position = True

    def spring_energy(self, link: LinkMotion) -> Expr:
        """Energy of the springs of a link [J]."""
        _, x0, y0, kx, ky, _, _, kappa, _ = link.factors
        x, y, angle = link.place
        return (kx * (x - x0) ** 2 + ky * (y - y0) ** 2 + kappa * (angle - ANGLE) ** 2) / 2

    def damper_forces(self, link: LinkMotion) -> tuple[Expr, ...]:
        """Force of the dampers of a link [N] and their moment [N m]."""
        *_, cx, cy, _, chi = link.factors
        return tuple(-c * v for c, v in zip((cx, cy, chi), link.velocity, strict=True))

    @property
    def share(self) -> IndexedBase:
        """Share of every link before its point."""
        return self.per_link[0]

    @property
    def force_arrays(self) -> tuple[IndexedBase, ...]:
        names = ("pull_x", "pull_y", "turn")
        return tuple(IndexedBase(f"{self.term}_{name}", real=True) for name in names)

    def _motion(self, link: Expr, at: Expr, way: Expr) -> LinkMotion:
        """Motion of a link whose point is a share ``way`` of it behind joint ``at``."""
        x, y, vx, vy = link_step(link, way, self.rod.length(link))
        return LinkMotion(
            (joint_x[at] + x, joint_y[at] + y, phi[link]),
            (joint_vx[at] + vx, joint_vy[at] + vy, omega[link]),
            tuple(base[link] for base in self.per_link),
        )

    def _forces(self, motion: LinkMotion) -> list[Expr]:
        energy = self.spring_energy(LinkMotion(PLACE, motion.velocity, motion.factors))
        there = dict(zip(PLACE, motion.place, strict=True))
        forces = zip(self.damper_forces(motion), PLACE, strict=True)
        return [damped - energy.diff(x).xreplace(there) for damped, x in forces]

    def constants(self, first_joint: int, links: int) -> list[Expr]:
        pulls = [base[link] for base in self.force_arrays for link in range(links)]
        return [*super().constants(first_joint, links), *pulls]

    def explicit_forces(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        calculus, rows = chain.calculus, []
        for link in range(chain.n - len(chain.moving), chain.n):
            fx, fy, turn = (calculus.poly(base[link]) for base in self.force_arrays)
            rows.append(chain.virtual_work(chain.point(link, self.share[link]), (fx, fy)))
            angle = calculus.poly(chain.angles[link])
            rows.append([turn * calculus.diff(angle, q) for q in chain.coordinates])
        return rows

    def generalised_forces(self, chain: GenericChain) -> GeneralisedForces:
        x, y, turn = self.force_arrays

        def force_from(low: Expr) -> Vector:
            return Sum(x[other], (other, low, n - 1)), Sum(y[other], (other, low, n - 1))

        lean = chain.angle_force(force_from(i + 1)) + self.share[i] * chain.angle_force(
            (x[i], y[i])
        )
        return GeneralisedForces(
            force_from(chain.boundary_condition.first_in_motion),
            chain.joint_lever * lean + turn[i],
        )

    def link_moment(self, link: Expr, boundary: Boundary) -> Expr:
        return self.force_arrays[2][link]

    def start_force(self, link: Expr, boundary: Boundary) -> Vector:
        x, y = ((1 - self.share[link]) * pull[link] for pull in self.force_arrays[:2])
        return x, y

    def link_arrays(self, boundary: Boundary) -> dict[IndexedBase, Expr]:
        laws = self._forces(self._motion(i, i, self.share[i]))
        return dict(zip(self.force_arrays, laws, strict=True))

    def joint_arrays(self, chain: GenericChain) -> dict[IndexedBase, Expr]:
        found = {}
        for base, pull in zip(self.bases, self.force_arrays, strict=False):
            start = (1 - self.share[joint]) * pull[joint]
            end = self.share[joint - 1] * pull[joint - 1]
            found[base] = chain.piecewise_at_ends(start, end, start + end)
        return found

    def joint_laws(
        self, at: Expr, before: Expr | None, after: Expr | None, chain: GenericChain
    ) -> dict[Expr, Expr]:
        laws = []
        if after is not None:
            share = self.share[at]
            laws.append((1 - share, self._forces(self._motion(at, at, share))))
        if before is not None:
            share = self.share[at - 1]
            laws.append((share, self._forces(self._motion(at - 1, at, share - 1))))
        totals = (sum((share * law[axis] for share, law in laws), S.Zero) for axis in (0, 1))
        return {base[at]: total for base, total in zip(self.bases, totals, strict=True)}

    def link_laws(self) -> dict[Expr, Expr]:
        turn = self._forces(self._motion(i, i, self.share[i]))[2]
        return {self.force_arrays[2][i]: turn}

    def power(self, chain: GenericChain) -> Expr:
        motion = self._motion(i, i, self.share[i])
        pairs = zip(self.damper_forces(motion), motion.velocity, strict=True)
        power = sum(f * v for f, v in pairs)
        return Sum(power, (i, chain.boundary_condition.first_in_motion, n - 1))

    def energy(self, chain: GenericChain) -> Expr:
        stored = self.spring_energy(self._motion(i, i, self.share[i]))
        return Sum(stored, (i, chain.boundary_condition.first_in_motion, n - 1))

    # Assembled by hand ------------------------------------------------------------------------

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        x, y, _ = (
            rod.total(value(base), rod.boundary.first_in_motion, rod.n - 1)
            for base in self.force_arrays
        )
        return x, y

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        x, y, turn = map(value, self.force_arrays)
        behind = rod.total(x, i + 1, rod.n - 1), rod.total(y, i + 1, rod.n - 1)
        own = value(self.share)[i] * rod.force_moment(i, (x[i], y[i]))
        return rod.force_moment(i, behind) + own + turn[i]

    def spring_by_hand(self, link: LinkMotion, value: Value, functions: Any) -> tuple[Num, ...]:
        """Force of the springs of a link, and their moment: -k times the displacement from rest."""
        _, _, _, kx, ky, _, _, kappa, _ = link.factors
        rest = self.rest_by_hand(link, value, functions)
        ways = zip((kx, ky, kappa), link.place, rest, strict=True)
        return tuple(-k * (at - there) for k, at, there in ways)

    def damper_by_hand(self, link: LinkMotion, value: Value, functions: Any) -> tuple[Num, ...]:
        """Force of the dampers of a link, and their moment: -c times the velocity."""
        _, _, _, _, _, cx, cy, _, chi = link.factors
        vx, vy, rate = link.velocity
        return -cx * vx, -cy * vy, -chi * rate

    def rest_by_hand(self, link: LinkMotion, value: Value, functions: Any) -> tuple[Num, ...]:
        """Position without a force of the springs of a link, and angle without a moment."""
        return link.factors[1], link.factors[2], value(ANGLE)


LOAD = Supports()
