"""Hand-assembled equations at one state and quantities that follow, in 50-digit numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

from mpmath import mp, mpf
from sympy import IndexedBase

from rodgen.check.reference_chain import FUNCTIONS, ReferenceChain, add, dot, matrix_vector
from rodgen.derive.closed_form import ClosedForm
from rodgen.derive.loads.air_force import AirForce
from rodgen.derive.loads.contact import Contact
from rodgen.derive.loads.foundation import Foundation
from rodgen.derive.loads.joint_drag import JointDrag, JointMotion
from rodgen.derive.loads.joint_law import BendMotion, JointLaw
from rodgen.derive.loads.joint_stop import JointStop
from rodgen.derive.loads.kinds import JointMoment, Load, MassForce
from rodgen.derive.loads.link_force import LinkForce
from rodgen.derive.loads.point_force import PointForce
from rodgen.derive.loads.point_law import PointLaw
from rodgen.derive.loads.supports import LinkMotion, Supports
from rodgen.derive.symbols import n
from rodgen.model.rod import BOUNDARIES
from rodgen.model.terms import EMPTYING, MOVING_BASE, PARAMETERS
from rodgen.scene.contact_terms import stop_name
from rodgen.scene.expression import Expression
from rodgen.scene.grammar import OF_STOPS


class ReferenceEquations(ReferenceChain):
    """The hand-assembled equations of a module at one state, in mpmath numbers of the present
    precision. emptying: power of masses that change with time, where there are any."""

    emptying: Any = None

    def rhs(self) -> list[Any]:
        closed, moving = self.closed, self.omega[self.boundary.first :]
        total = add(matrix_vector(closed.Q(), [w**2 for w in moving]), self._bending_forces())
        for load in self.loads().values():
            total = add(total, load)
        rates = mp.lu_solve(mp.matrix(closed.M()), mp.matrix(total))
        return [*self.u, *rates, *self.rates]

    def apply_laws(self, laws: Mapping[str, Expression], t: float) -> None:
        """Set numbers that follow the motion and rates of added states by their laws at t [s]."""
        for sensor in {sensor for law in laws.values() for sensor in law.sensors}:
            if sensor.what in OF_STOPS:
                (push,) = self.contacts()[f"push_{stop_name(sensor)}"]
                self.signals[sensor.text] = push
            else:
                self.signals[sensor.text] = self.sensor_value(sensor)
        for name, law in laws.items():
            value = mpf(0) + law.evaluate(mpf(t), self.signals, FUNCTIONS)
            if name in PARAMETERS:
                self.number[name] = value
            else:
                self.rates.append(value)

    def _bending_forces(self) -> list[Any]:
        """Moments of the springs at both ends of the moving links on them; none on joint 0."""
        moments = self.bending_moments()
        on_links = [b - a for a, b in pairwise(moments)][self.boundary.first :]
        return [mpf(0)] * (2 * self.boundary.translates) + on_links

    def loads(self) -> dict[str, list[Any]]:
        """Generalised forces by term."""
        return {term: self._generalised_forces(load) for term, load in self.acting.items()}

    def _generalised_forces(self, load: Load) -> list[Any]:
        if not isinstance(load, JointMoment):
            return load.column_by_hand(self.closed, self.value)
        factor = partial(load.coefficient_by_hand, self.closed, self.value)
        matrix = self.closed.damping(factor)
        found = [-e for e in matrix_vector(matrix, self.omega[self.boundary.first :])]
        rows = 2 * self.boundary.translates, -1
        for row, (at, size) in zip(rows, self._held_joints, strict=True):
            found[row] += factor(at, size) * self.clamp[1] if size else 0
        return found

    @property
    def _held_joints(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """Joints between what moves and a clamp, or a held link, at the start and at the tail, each
        with the size of its spring."""
        first = self.boundary.first
        start = 1 if first else self.closed.root_size
        return (first, start), (self.n, self.closed.tail_size)

    def _damper_moments(self, load: JointMoment) -> list[Any]:
        """Moments of a load in all joints on the link before; zero where there is none."""
        root, tail = self.closed.root_size, self.closed.tail_size
        sizes = [root, *[1] * (self.n - 1), tail]
        rates = [self.clamp[1], *self.omega, self.clamp[1]]
        factor = partial(load.coefficient_by_hand, self.closed, self.value)
        return [
            factor(at, size) * (after - before) if size else mpf(0)
            for at, (size, (before, after)) in enumerate(zip(sizes, pairwise(rates), strict=True))
        ]

    @cached_property
    def force_values(self) -> dict[IndexedBase, dict[int, Any]]:  # type: ignore[override]
        """Forces and moments of loads that follow the motion, by joint or link."""
        forces: dict[IndexedBase, dict[int, Any]] = {}
        for load in self.acting.values():
            joints = self.boundary.spring_joints(self.n) if isinstance(load, JointLaw) else ()
            forces |= {base: dict.fromkeys(joints, mpf(0)) for base in load.force_arrays}
            for at, motion in self._motions(load).items():
                for base, component in zip(
                    load.force_arrays, self._force(load, motion), strict=True
                ):
                    forces[base][at] = component
        return forces

    def _force(self, load: Any, motion: Any) -> tuple[Any, ...]:
        if isinstance(load, JointDrag | PointLaw):
            return load.force_by_hand(motion, self.value, mp)
        if isinstance(load, JointLaw):
            return (load.moment_by_hand(motion, self.value, mp),)
        spring = load.spring_by_hand(motion, self.value, mp)
        damper = load.damper_by_hand(motion, self.value, mp)
        return tuple(a + b for a, b in zip(spring, damper, strict=True))

    def _motions(self, load: Load) -> dict[int, Any]:
        """Motions, by number, of the moving joints or links on which such a load acts."""
        if isinstance(load, JointDrag):
            return {
                s: self._joint_motion(load, s) for s in range(self.boundary.first_joint, self.n + 1)
            }
        if isinstance(load, Supports):
            first = self.boundary.first_in_motion
            return {q: self._link_motion(load, q) for q in range(first, self.n)}
        if isinstance(load, PointLaw):
            link = int(load.point.link.subs(n, self.n))
            return {link: self._link_motion(load, link, self._share(load))}
        if isinstance(load, JointStop):
            at = int(load.point.link.subs(n, self.n))
            return {at: self._bend_motions()[at]}
        return self._bend_motions() if isinstance(load, JointLaw) else {}

    def contacts(self) -> dict[str, list[Any]]:
        """Depths, pushes and openings of contacts, by name, of a wall at every
        joint that moves."""
        out: dict[str, list[Any]] = {}
        for name, load in self.acting.items():
            if isinstance(load, Contact):
                of = (load.state_by_hand(m, self.value, mp) for m in self._motions(load).values())
                for what, found in zip(
                    ("depth", "push", "opening"), zip(*of, strict=True), strict=True
                ):
                    out[f"{what}_{name}"] = list(found)
        return out

    def air(self) -> dict[str, Any]:
        """Velocities against the air along the link and across it, by name."""
        out: dict[str, Any] = {}
        for name, load in self.acting.items():
            if isinstance(load, AirForce):
                (motion,) = self._motions(load).values()
                flow = load.flow_by_hand(motion, self.value, mp)
                out |= {f"{of}_{name}": x for of, x in zip(("along", "across"), flow, strict=True)}
        return out

    @staticmethod
    def _share(load: PointLaw) -> Any:
        """Share of its link before the point on which a load acts."""
        return mpf(load.point.share.p) / load.point.share.q

    def _bend_motions(self) -> dict[int, BendMotion]:
        """Motions of the joints with a spring, by number."""
        rates = [self.clamp[1], *self.omega, self.clamp[1]]
        found = {}
        joints = self.boundary.spring_joints(self.n)
        for s, (_, bend) in zip(joints, self._springs(), strict=True):
            halves = [self.closed.length(q) / 2 for q in (s - 1, s) if 0 <= q < self.n]
            bent = self.number.get("bent_length")
            length = sum(halves) if bent is None else bent[s - joints.start]
            found[s] = BendMotion(s, bend, rates[s + 1] - rates[s], length)
        return found

    def _joint_motion(self, load: JointDrag, s: int) -> JointMotion:
        links = [q for q in (s - 1, s) if 0 <= q < self.n]
        lengths = [self.closed.length(q) for q in links]
        angle = dot(lengths, [self.phi[q] for q in links]) / sum(lengths)
        v, place = self._velocities[s], (*self.joints()[s], sum(lengths) / 2)
        own = tuple(self.number[str(base)][s] for base in load.per_joint)
        return JointMotion(*v, mp.hypot(*v) or mpf(1), angle, len(links) * self.m / 2, own, *place)

    def _link_motion(self, load: Load, q: int, share: Any = None) -> LinkMotion:
        """Motion of a point of a link: at a share of it, by default that of its support."""
        own = tuple(self.number[str(base)][q] for base in load.per_link)
        share = own[0] if share is None else share
        steps = self.closed.joint_step(q), self.closed.velocity_step(q, self.omega[q])
        starts = self.joints()[q], self._velocities[q]
        place, velocity = (
            tuple(a + share * d for a, d in zip(start, step, strict=True))
            for start, step in zip(starts, steps, strict=True)
        )
        return LinkMotion((*place, self.phi[q]), (*velocity, self.omega[q]), own)

    def _anchor_energy(self, load: Any) -> Any:
        """Energy of the springs of a load: half their force times the displacement from rest, where
        the force is in proportion to that."""
        total = mpf(0)
        if isinstance(load, Contact):
            motions = self._motions(load).values()
            return mp.fsum(load.energy_by_hand(one, self.value, mp) for one in motions)
        for motion in self._motions(load).values():
            force = load.spring_by_hand(motion, self.value, mp)
            rest = load.rest_by_hand(motion, self.value, mp)
            total -= sum(f * (x - x0) for f, x, x0 in zip(force, motion.place, rest, strict=True))
        return total / 2

    def energy(self) -> list[Any]:
        kinetic = dot(self._rates, matrix_vector(self._whole.M(), self._rates)) / 2
        spring = mp.fsum(self._spring_energy(k, b) for k, b in self._springs())
        anchors = (x for x in self.acting.values() if x.by_position or isinstance(x, Contact))
        spring += mp.fsum(map(self._anchor_energy, anchors))
        others = (self.acting[name] for name in self.structure.potentials)
        potential = mp.fsum(one.potential_by_hand(self.closed, self.value) for one in others)
        return [kinetic, spring, self.weight_energy() + potential]

    @cached_property
    def _whole(self) -> ClosedForm:
        """The rod, free where its base moves: what that does is among its coordinates."""
        free = BOUNDARIES["free"]
        return replace(self.closed, boundary=free) if self.boundary.moves else self.closed

    @property
    def _rates(self) -> list[Any]:
        """Rates of the coordinates of the rod, those of a base that moves included."""
        return [*self.v0, *self.omega] if self.boundary.moves else self.u

    def weight_energy(self) -> Any:
        """Energy of the loads on mass that have a potential."""
        loads = (self.acting[name] for name in self.structure.potentials)
        masses = [load for load in loads if isinstance(load, MassForce)]
        weights = [load.base_by_hand(self.closed, self.value) for load in masses]
        # What is lost of tanks that are empty has neither weight nor centre.
        X, Y = self.centre_of_gravity() if any(map(any, weights)) else (mpf(0), mpf(0))
        return -mp.fsum(x * X + y * Y for x, y in weights)

    def forces(self) -> dict[str, list[tuple[Any, Any]]]:
        """Forces on every joint, by the term of every load that acts on joints."""
        out = {}
        for term, load in self.acting.items():
            if isinstance(load, JointDrag):
                x, y = (self.force_values[base] for base in load.bases)
            elif isinstance(load, Supports):
                x, y, _ = (self.force_values[base] for base in load.force_arrays)
                shares = self.number[str(load.share)]
                x, y = (self._on_joints(of, shares) for of in (x, y))
            elif isinstance(load, LinkForce):
                on_joints = enumerate(load.joints_by_hand(self.closed, self.value))
                moving = {s: force for s, force in on_joints if s >= self.boundary.first_joint}
                x, y = ({s: force[axis] for s, force in moving.items()} for axis in (0, 1))
            elif isinstance(load, PointForce):
                whole = load.base_by_hand(self.closed, self.value)
                parts = [(int(at.subs(n, self.n)), self.value(x)) for at, x in load.point.parts]
                x, y = ({at: share * f for at, share in parts} for f in whole)
            else:
                continue
            out[term] = [(x.get(s, mpf(0)), y.get(s, mpf(0))) for s in range(self.n + 1)]
        return out

    def _on_joints(self, forces: dict[int, Any], shares: Any) -> dict[int, Any]:
        """Components on the joints that move of forces on links."""
        found = dict.fromkeys(range(self.boundary.first_joint, self.n + 1), mpf(0))
        for q, force in forces.items():
            for at, share in ((q, 1 - shares[q]), (q + 1, shares[q])):
                if at in found:
                    found[at] += share * force
        return found

    def power(self) -> dict[str, Any]:
        power = {term: self._power_by_hand(load) for term, load in self.acting.items()}
        for term, load in self.acting.items():
            if isinstance(load, Foundation | Supports):  # of its dampers
                motions = self._motions(load).values()
                forces = ((m, load.damper_by_hand(m, self.value, mp)) for m in motions)
                power[term] = mp.fsum(dot(force, m.velocity) for m, force in forces)
            elif isinstance(load, Contact | JointLaw):  # of dampers and friction
                motions = self._motions(load).values()
                power[term] = mp.fsum(load.lost_by_hand(m, self.value, mp) for m in motions)
        if self.boundary.moves:
            power[MOVING_BASE] = self._base_power()
        return power if self.emptying is None else power | {EMPTYING: self.emptying}

    def _power_by_hand(self, load: Load) -> Any:
        """Power of the force of a load: times the rates of all that moves."""
        if isinstance(load, JointMoment):
            rates = [self.clamp[1], *self.omega, self.clamp[1]]
            moments = zip(self._damper_moments(load), pairwise(rates), strict=True)
            return -mp.fsum(moment * (after - before) for moment, (before, after) in moments)
        if not self.boundary.moves or load.term == MOVING_BASE:
            return dot(load.column_by_hand(self.closed, self.value), self.u)
        return dot(self._whole_column(load), self._rates)

    def _whole_column(self, load: Load) -> list[Any]:
        """Generalised forces of a load on a rod that is free where its base moves."""
        links = (load.link_by_hand(self.closed, q, self.value) for q in range(self.n))
        return [*load.base_by_hand(self.closed, self.value), *links]

    def _base_power(self) -> Any:
        """Power of what holds the rod: what is missing in the rows of its coordinates, times their
        rates; of a clamp by a spring its moment times its rate."""
        accelerations = self.rhs()[len(self.u) :][: len(self.u)]
        growth = [self.clamp[2]] * self.boundary.first
        inertia = matrix_vector(self._whole.M(), [*self.base[2], *growth, *accelerations])
        inertia = [
            a - b
            for a, b in zip(
                inertia, matrix_vector(self._whole.Q(), [w**2 for w in self.omega]), strict=True
            )
        ]
        moments = self.bending_moments()
        for load in self.acting.values():
            if isinstance(load, JointMoment):
                moments = add(moments, self._damper_moments(load))
            elif isinstance(load, JointLaw):
                found = self.force_values[load.force_arrays[0]]
                moments = [a - found.get(at, 0) for at, a in enumerate(moments)]
            elif load.term != MOVING_BASE:
                inertia = [a - b for a, b in zip(inertia, self._whole_column(load), strict=True)]
        holding = inertia[2] - moments[1] if self.boundary.first else -moments[0]
        return dot(inertia[:2], self.v0) + holding * self.clamp[1]
