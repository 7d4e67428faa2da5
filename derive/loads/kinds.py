"""Kinds of loads, and what follows from the law of each in every derivation.

    PointForce    a force on a point of a link, dead or turning with the link (point_force.py)
    PointMoment   a moment on the link of a point, which has a potential (point_moment.py)
    LinkForce     a force on every link, at one share of each (link_force.py)
    MassForce     a force on all mass, in proportion to it; a potential while it does not change
    JointMoment   a moment across every joint, in proportion to the rate at which it opens
    JointLaw      a moment across joints, by their bend and its rate (joint_law.py)
    JointDrag     a force on every joint that moves, by its velocity (joint_drag.py)
    Foundation    springs and dampers from every joint that moves to the ground (foundation.py)
    Supports      springs and dampers from a point of every link to the ground (supports.py)
    PointLaw      a force on a point of a link, by its motion (point_law.py)
    Contact       what pushes while it is pressed, beside one of these (contact.py)

A load is an object of one of these classes and has its law. Its kind derives from that the
generalised forces by virtual work with n links (derivation 1) and for any n (derivation 2), the
forces on joints and links for derivation 3, power or potential, and the generalised forces
assembled by hand, which proofs and the check of a module compare with.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from typing import Any, Self

from sympy import Expr, IndexedBase, Integer, S, Sum, Symbol
from sympy.polys.rings import PolyElement

from rodgen.model.rod import Boundary
from rodgen.model.term import JOINTS, LINKS, Parameter
from rodgen.model.terms import TERMS

from ..chain import Vector
from ..closed_form import ClosedForm, Num, Pair
from ..explicit_chain import ExplicitChain
from ..generic_chain import AtSprings, GenericChain
from ..link_properties import Joint, Rod
from ..polynomials import TIME
from ..symbols import PARAMETERS, joint, joint_vx, joint_vy, n, omega, s

# Number of a symbol, an array or an expression in the arithmetic of a proof.
Value = Callable[[Any], Any]
NOTHING: Vector = (S.Zero, S.Zero)


@dataclass(frozen=True)
class GeneralisedForces:
    """Generalised forces of a load: on x0 and y0, and on the angle of link i."""

    base: Vector
    link: Expr


@dataclass(frozen=True)
class AppliedForces:
    """A load as forces [N] on the joints from ``low`` to ``high``, which may be one joint."""

    low: Expr
    high: Expr
    force: Vector


class Load(ABC):
    """Base class of loads and kinds of damping; methods not overridden have no effect.

    letter: of its generalised forces, in proofs; by_velocity, by_position: it follows those of the
    joints; by_momentum: its power is its force on a unit of mass times the momentum of the rod;
    across_joints: it is a moment between the links that a spring joins;
    array_name: what the arrays of its forces on joints are called after, by default its
    term.
    """

    letter: str
    array_name = ""
    by_velocity = False
    by_position = False
    by_momentum = False
    across_joints = False

    rod = Rod()  # on which it acts
    _term = ""
    _given = ""  # key of an optional parameter

    @property
    def term(self) -> str:
        """Name in scenes and modules: that of its file, with a number if it is not the first."""
        return self._term or type(self).__module__.rpartition(".")[2]

    def at_place(self, name: str, place: str) -> Self:
        """Copy of the load with another name and a place, as `load_places` has them."""
        found = copy(self)
        found._term, found._given = name, place
        return found

    def on(self, rod: Rod) -> Self:
        """Copy of the load on a rod; itself where that is its own."""
        if rod == self.rod:
            return self
        found = copy(self)
        found.rod = rod
        return found

    @property
    def _rows(self) -> tuple[Parameter, ...]:
        return TERMS[self.term].parameters_with(self._given)

    @property
    def parameters(self) -> tuple[Symbol, ...]:
        """Symbols of the numbers in its law, without arrays."""
        return tuple(PARAMETERS[row.name] for row in self._rows if not row.is_array)

    def number(self, *keys: str) -> Expr | None:
        """Symbol of a parameter by its keys in the scene; None where a module has none."""
        rows = TERMS[self.term].parameters_with(self._given)
        return next((PARAMETERS[row.name] for row in rows if row.key_path == keys), None)

    @property
    def angles(self) -> tuple[Symbol, ...]:
        """Parameters whose cosine and sine are taken."""
        return tuple(PARAMETERS[row.name] for row in self._rows if row.is_angle)

    @property
    def bases(self) -> tuple[IndexedBase, IndexedBase]:
        """Components of the forces on the joints."""
        name = self.array_name or f"joint_{self.term}"
        x, y = (IndexedBase(f"{name}_{axis}", real=True) for axis in "xy")
        return x, y

    @property
    def force_arrays(self) -> tuple[IndexedBase, ...]:
        """Arrays of its forces and moments, where the proofs of its work take them as given."""
        return ()

    @property
    def per_joint(self) -> tuple[IndexedBase, ...]:
        """Parameters with a number for every joint."""
        return tuple(PARAMETERS[row.name] for row in self._rows if row.each == JOINTS)

    @property
    def per_link(self) -> tuple[IndexedBase, ...]:
        """Parameters with a number for every link."""
        return tuple(PARAMETERS[row.name] for row in self._rows if row.each == LINKS)

    # Derivation 1 -----------------------------------------------------------------------------

    def constants(self, first_joint: int, links: int) -> list[Expr]:
        """Constants in which its generalised forces are polynomials, with coordinates and rates."""
        single = [p for p in self.parameters if p not in self.angles]
        return [*single, *(base[link] for base in self.per_link for link in range(links))]

    @abstractmethod
    def explicit_forces(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        """Generalised forces by virtual work, in parts to be added up."""

    # Derivations 2 and 3 ----------------------------------------------------------------------

    def generalised_forces(self, chain: GenericChain) -> GeneralisedForces | None:
        """Generalised forces for any n; None for a moment across the joints."""
        return None

    def weight(self, mass: Expr, boundary: Boundary) -> Vector:
        """Force on a mass [N]."""
        return NOTHING

    def joint_force(self, at: Expr, boundary: Boundary) -> Vector:
        """Force on a joint [N], without forces that act on the tail alone."""
        return NOTHING

    def start_force(self, link: Expr, boundary: Boundary) -> Vector:
        """Part [N] of the force on the joint where a link starts that acts on this link; the rest
        acts on the link before."""
        return NOTHING

    def link_moment(self, link: Expr, boundary: Boundary) -> Expr:
        """Moment on a link [N m], besides those across its joints."""
        return S.Zero

    def tail_force(self) -> Vector:
        """Force that acts on the tail alone [N]."""
        return NOTHING

    def joint_arrays(self, chain: GenericChain) -> dict[IndexedBase, Expr]:
        """Arrays that joint_force refers to, over the joints that move."""
        return {}

    def link_arrays(self, boundary: Boundary) -> dict[IndexedBase, Expr]:
        """Arrays that forces and moments refer to, over the links that move."""
        return {}

    def link_laws(self) -> dict[Expr, Expr]:
        """Laws of moments on link i that depend on the state, by element of an array."""
        return {}

    def joint_laws(
        self, at: Expr, before: Expr | None, after: Expr | None, chain: GenericChain
    ) -> dict[Expr, Expr]:
        """Laws of forces on a joint that depend on the state, by element of an array, in the angles
        of the links before and after it (None where there is no link)."""
        return {}

    def moments(self, chain: GenericChain) -> AtSprings:
        """Moments on the link, or the clamp of the tail, after each joint."""
        return AtSprings(S.Zero, S.Zero, S.Zero)

    def spring_arrays(self, chain: GenericChain) -> dict[IndexedBase, Expr]:
        """Arrays that its moments refer to, over the joints s with a spring."""
        return {}

    def spring_laws(
        self, at: Expr, chain: GenericChain, root: bool, tail: bool
    ) -> dict[Expr, Expr]:
        """Laws of moments in a joint that depend on the state, by element of an array; root, tail:
        whether it is that of a clamp."""
        return {}

    # What a run is looked at by -----------------------------------------------------------------

    def applied_forces(self, boundary: Boundary) -> AppliedForces | None:
        """Forces on joints that are shown; None where there are none."""
        return None

    def power(self, chain: GenericChain) -> Expr:
        """Power [W] of a load without potential that is not on mass."""
        raise NotImplementedError  # one with a potential has none

    def potential(self, chain: GenericChain) -> Expr:
        """Potential [J] of a load that is not on mass."""
        return S.Zero

    def energy(self, chain: GenericChain) -> Expr:
        """Energy of its springs [J]."""
        return S.Zero

    # Assembled by hand ------------------------------------------------------------------------

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        """Generalised forces on x0 and y0."""
        raise NotImplementedError  # of a moment across joints, see column_by_hand

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        """Generalised force on the angle of link i."""
        raise NotImplementedError  # of a moment across joints, see column_by_hand

    def potential_by_hand(self, rod: ClosedForm, value: Value) -> Num:
        """Potential [J] of a load that is not on mass."""
        return 0 * rod.l

    def column_by_hand(self, rod: ClosedForm, value: Value) -> list[Num]:
        """Generalised forces on all coordinates, of a given number of links."""
        base = self.base_by_hand(rod, value) if rod.boundary.translates else ()
        return [*base, *(self.link_by_hand(rod, i, value) for i in rod.links)]


class MassForce(Load):
    """A force on all mass that depends on nothing else."""

    by_momentum = True

    def explicit_forces(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        fx, fy = (chain.calculus.poly(f) for f in self.weight(S.One, chain.boundary_condition))
        rows = [chain.virtual_work(point, (fx, fy)) for point in chain.link_points]
        return [[chain.integrate_over_link(e, link) for e in row] for link, row in enumerate(rows)]

    def generalised_forces(self, chain: GenericChain) -> GeneralisedForces:
        force = self.weight(S.One, chain.boundary_condition)
        x, y = (chain.lever_moment([], []) * f for f in force)
        return GeneralisedForces((x, y), chain.angle_force_of_mass(force))

    def potential_of_mass(self, mass: Expr, boundary: Boundary, x: Expr, y: Expr) -> Expr:
        """Minus the work on a mass on its way from the origin [J]."""
        force = self.weight(mass, boundary)
        return -force[0] * x - force[1] * y

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        x, y = (rod.total_mass * value(f) for f in self.weight(S.One, rod.boundary))
        return x, y

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        x, y = map(value, self.weight(S.One, rod.boundary))
        along, across = rod.first_moment(i)
        return along * rod.force_moment(i, (x, y)) + across * rod.force_moment(i, (y, -x))


class JointMoment(Load):
    """A moment across every joint with a spring, in proportion to the rate at which it opens and
    to how large the spring is: by the size or the stiffness of the joint."""

    across_joints = True

    @abstractmethod
    def moment(self, before: Expr, after: Expr, joint: Joint) -> Expr:
        """Moment across a joint [N m] on the link after it, at the rates of both links; the link
        before it, or the clamp, gets the opposite."""

    def explicit_forces(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        poly, rows = chain.calculus.poly, []
        for spring, before, after in chain.springs:
            moment = poly(self.moment(before.diff(TIME), after.diff(TIME), spring))
            opening = poly(after - before)
            rows.append([moment * chain.calculus.diff(opening, q) for q in chain.coordinates])
        return rows

    def moments(self, chain: GenericChain) -> AtSprings:
        return chain.at_springs(self.moment, omega)

    def power(self, chain: GenericChain) -> Expr:
        inner, root, tail = self.moments(chain)
        held = chain.base_motion.angle[1]
        ends = root * (omega[0] - held) - tail * (omega[n - 1] - held)
        return ends + Sum(inner * (omega[s] - omega[s - 1]), (s, 1, n - 1))

    @abstractmethod
    def coefficient_by_hand(self, rod: ClosedForm, value: Value, at: Num, size: int) -> Num:
        """Damping coefficient of a joint: minus its moment where it opens at the rate of one."""


class JointLoad(Load):
    """A load that acts as a force on every joint that moves."""

    def joint_force(self, at: Expr, boundary: Boundary) -> Vector:
        x, y = self.bases
        return x[at], y[at]

    def applied_forces(self, boundary: Boundary) -> AppliedForces:
        return AppliedForces(Integer(boundary.first_joint), n, self.joint_force(joint, boundary))

    def power(self, chain: GenericChain) -> Expr:
        x, y = self.bases
        power = x[joint] * joint_vx[joint] + y[joint] * joint_vy[joint]
        return Sum(power, (joint, chain.boundary_condition.first_joint, n))
