"""Forces on the joints that depend on their velocities."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any

from sympy import Eq, Expr, IndexedBase, Integer, Piecewise, S, Sum, sqrt
from sympy.polys.rings import PolyElement

from rodgen.model.rod import Boundary

from ..chain import Vector
from ..closed_form import ClosedForm, Num, Pair
from ..explicit_chain import ExplicitChain
from ..generic_chain import GenericChain
from ..symbols import i, joint, joint_vx, joint_vy, joint_x, joint_y, m, n, phi
from .kinds import NOTHING, GeneralisedForces, JointLoad, Value

# At a joint: angle of the rod, mass and length gathered there, and the speed to divide by.
rod_angle, mass_at = IndexedBase("rod_angle", real=True), IndexedBase("joint_mass", positive=True)
length_at = IndexedBase("joint_length", positive=True)
divisor = IndexedBase("drag_divisor", positive=True)


@dataclass(frozen=True)
class JointMotion:
    """Motion of a joint, as drag needs it: its velocity, the speed to divide by, the angle of the
    rod there (mean of the links that meet), the mass gathered there, its per_joint parameters; its
    position, and the length gathered there (half of each link)."""

    vx: Any
    vy: Any
    divisor: Any
    angle: Any
    mass: Any
    factors: tuple[Any, ...] = ()
    x: Any = None
    y: Any = None
    length: Any = None

    @property
    def place(self) -> tuple[Any, Any]:
        """Position of the joint."""
        return self.x, self.y

    @property
    def velocity(self) -> tuple[Any, Any]:
        """Velocity of the joint."""
        return self.vx, self.vy


def drag_divisor(vx: Expr, vy: Expr) -> Expr:
    """Speed of a joint; one at rest, where nothing goes across and any divisor gives no force."""
    speed = sqrt(vx**2 + vy**2)
    return Piecewise((speed, speed > 0), (1, True))


def joint_mass(links: int) -> Expr:
    """Mass gathered at a joint where this many links meet: half of each."""
    return links * m / 2


class JointDrag(JointLoad):
    """A force on every joint that moves, by its velocity."""

    by_velocity = True

    @property
    def force_arrays(self) -> tuple[IndexedBase, ...]:
        return self.bases

    @property
    def wind(self) -> Vector:
        """Velocity of the medium."""
        return NOTHING

    @abstractmethod
    def force(self, joint: JointMotion) -> Vector:
        """The force on a joint [N]."""

    def constants(self, first_joint: int, links: int) -> list[Expr]:
        return [base[at] for at in range(first_joint, links + 1) for base in self.bases]

    def explicit_forces(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        x, y = self.bases
        generator = chain.calculus.generator
        return [
            chain.virtual_work(chain.joint(at), (generator[x[at]], generator[y[at]]))
            for at in range(chain.first_joint, chain.n + 1)
        ]

    def generalised_forces(self, chain: GenericChain) -> GeneralisedForces:
        def total(low: Expr) -> Vector:
            x, y = (Sum(base[joint], (joint, low, n)) for base in self.bases)
            return x, y

        base, after = total(chain.boundary_condition.first_joint), total(i + 1)
        return GeneralisedForces(base, chain.joint_lever * chain.angle_force(after))

    def motion(self, chain: GenericChain) -> JointMotion:
        """Motion of a joint, in symbols."""
        return JointMotion(
            *(joint_vx[joint], joint_vy[joint]),
            *(divisor[joint], rod_angle[joint], mass_at[joint]),
            tuple(base[joint] for base in self.per_joint),
            *(joint_x[joint], joint_y[joint], length_at[joint]),
        )

    def start_force(self, link: Expr, boundary: Boundary) -> Vector:
        """The share of the force of a joint that this link has of the rod gathered there; the whole
        at a start that moves, and the force of the wind at one that does not."""
        first, start = Integer(boundary.first), boundary.first_joint
        parts = tuple(self.rod.share_after(link) * base[link] for base in self.bases)
        if start < first:
            x, y = parts
            return x, y
        whole = tuple(base[link] for base in self.bases)
        there = whole if start == first else self._wind_on_held_start(first)
        pairs = zip(there, parts, strict=True)
        x, y = (Piecewise((e, Eq(link, first)), (part, True)) for e, part in pairs)
        return x, y

    def _wind_on_held_start(self, at: Expr) -> Vector:
        """Force of the wind on a joint that does not move, by the half link behind it."""
        if self.wind == NOTHING:
            return NOTHING
        factors = tuple(base[at] for base in self.per_joint)
        place = joint_x[at], joint_y[at]
        gathered = joint_mass(1), factors, *place, self.rod.length_at(at, inside=False)
        return self.force(JointMotion(S.Zero, S.Zero, S.One, phi[at], *gathered))

    def joint_arrays(self, chain: GenericChain) -> dict[IndexedBase, Expr]:
        force = self.force(self.motion(chain))
        inner = self.rod.mean_angle(phi[joint - 1], phi[joint], joint)
        half, whole, gathered = joint_mass(1), joint_mass(2), self.rod.length_at
        lengths = gathered(0, inside=False), gathered(n, inside=False), gathered(joint)
        return {
            divisor: drag_divisor(joint_vx[joint], joint_vy[joint]),
            mass_at: chain.piecewise_at_ends(half, half, whole),
            length_at: chain.piecewise_at_ends(*lengths),
            rod_angle: chain.piecewise_at_ends(phi[0], phi[n - 1], inner),
            **dict(zip(self.bases, force, strict=True)),
        }

    def joint_laws(
        self, at: Expr, before: Expr | None, after: Expr | None, chain: GenericChain
    ) -> dict[Expr, Expr]:
        angle = self.rod.mean_angle(before, after, at)
        arrays = self.joint_arrays(chain)
        laws = {base: arrays[base].subs(joint, at) for base in self.bases}
        return {base[at]: law.xreplace({rod_angle[at]: angle}) for base, law in laws.items()}

    @abstractmethod
    def force_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """The force on a joint that is not at rest, in the arithmetic of ``functions``."""

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        """Sum of the forces on all joints that move (thesis 2.60)."""
        x, y = (rod.total(value(base), rod.boundary.first_joint, rod.n) for base in self.bases)
        return x, y

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        """l (cos phi_i sum F_y - sin phi_i sum F_x) over the joints after link i (thesis 2.60)."""
        x, y = (rod.total(value(base), i + 1, rod.n) for base in self.bases)
        return rod.force_moment(i, (x, y))
