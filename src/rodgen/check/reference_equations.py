"""Hand-assembled equations at one state and quantities that follow, in 50-digit numbers."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from itertools import pairwise
from types import ModuleType
from typing import Any

import numpy as np
from mpmath import mp, mpf, mpmathify
from sympy import Dummy, Indexed, IndexedBase, Symbol, lambdify

from rodgen.derive.base_motion import ORDERS
from rodgen.derive.closed_form import Arithmetic, ClosedForm, LinkMasses, link_masses, link_sizes
from rodgen.derive.loads import loads_of
from rodgen.derive.loads.foundation import Foundation
from rodgen.derive.loads.joint_drag import JointDrag, JointMotion
from rodgen.derive.loads.kinds import JointMoment, Load, MassForce
from rodgen.derive.loads.link_force import LinkForce
from rodgen.derive.loads.point_force import PointForce
from rodgen.derive.loads.supports import LinkMotion, Supports
from rodgen.derive.symbols import bend, k, l, m, n, phi
from rodgen.emit.spring_expression import law_of
from rodgen.loading.generated_module import structure_of
from rodgen.model.rod import BOUNDARIES
from rodgen.model.terms import EMPTYING, MOVING_BASE, PARAMETERS
from rodgen.scene import grammar, spring_law
from rodgen.scene.expression import Expression
from rodgen.scene.grammar import LINEAR, TABLE, Sensor, TableData

FIFTY_DIGITS = Arithmetic(
    mp.cos,
    mp.sin,
    mpf(1) / 2,
    lambda term, low, high: mp.fsum(term(q) for q in range(low, high + 1)),
)


def _table(table: TableData, x: Any, kind: str) -> Any:
    """Value of a table of numbers; of straight lines, in the present precision."""
    knots, values = table.knots, table.values
    if kind != LINEAR or not knots[0] < x < knots[-1]:
        return mpf(float(table.at(float(x), kind)))
    i = bisect_right(knots, x) - 1
    (a, b), (u, v) = (map(mpf, pair[i : i + 2].tolist()) for pair in (knots, values))
    return u + (v - u) * (x - a) / (b - a)


# Functions of the grammar of expressions.
FUNCTIONS = {name: getattr(mp, name) for name in grammar.FUNCTIONS if hasattr(mp, name)}
FUNCTIONS |= {TABLE: _table}


def base_by_hand(number: Mapping[str, Any]) -> tuple[Any, ...]:
    """Place, velocity and acceleration of what holds a rod, each (x, y), and the angle of its clamp
    over clamp_angle with its two derivatives; zero for what is not among the numbers."""
    x, y, angle = (
        [number.get(f"{MOVING_BASE}_{key}{order}", mpf(0)) for order in ORDERS]
        for key in ("x", "y", "angle")
    )
    return *zip(x, y, strict=True), *angle


class ReferenceEquations:
    """The hand-assembled equations of a module at one state, in mpmath numbers of the present
    precision. emptying: power of masses that change with time, where there are any."""

    emptying: Any = None

    def __init__(self, module: ModuleType, values: dict[str, Any], y: np.ndarray):
        self.n, self.acting = module.N, loads_of(module.TERMS)
        self.structure = structure_of(module)
        boundary = self.structure.boundary_condition
        number: dict[str, Any] = {
            name: [mpmathify(v) for v in value] if np.ndim(value) else mpmathify(value)
            for name, value in values.items()
        }
        self.number = number
        M, L = number["mass"], number["length"]
        self.m, self.l, self.k = link_sizes(M, L, number.get("bending_stiffness", mpf(0)), self.n)
        joints = boundary.spring_joints(self.n)
        stiffness, rest = (
            dict(zip(joints, number[name], strict=True)) if name in number else None
            for name in ("joint_stiffness", "rest_angle")
        )
        added = getattr(module, "STATES", {})
        half, base = (len(y) - len(added)) // 2, 2 * boundary.translates
        q, u, z = ([mpmathify(v) for v in part] for part in np.split(y, [half, 2 * half]))
        self.signals: dict[str, Any] = dict(zip(added, z, strict=True))
        self.rates: list[Any] = []
        held = boundary.first
        self.u, self.boundary = u, boundary
        self.base = base_by_hand(number)
        self.origin, self.v0 = ((q[0], q[1]), (u[0], u[1])) if base else self.base[:2]
        self.clamp = [number.get("clamp_angle", 0) + self.base[3], *self.base[4:]]
        self.phi = [self.clamp[0]] * held + q[base:]
        self.omega = [self.clamp[1]] * held + u[base:]
        self.lumped = module.INERTIA == "lumped"
        sizes = self.n, self.m, self.l, self.k, self.phi
        half, nonuniform = FIFTY_DIGITS.half, getattr(module, "NONUNIFORM", ())
        links = link_masses(nonuniform, number.__getitem__, self.lumped, half)
        how = boundary, FIFTY_DIGITS, self.lumped
        self.closed = ClosedForm(*sizes, *how, stiffness, links, rest)
        # Every angle that a spring knows; stiffness and rest angle between it and the next.
        root, tail = (
            [size] if size else [] for size in (self.closed.root_size, self.closed.tail_size)
        )
        clamp = [self.clamp[0]] if boundary.is_clamped else []
        self.bent = clamp * len(root) + self.phi + clamp * len(tail)
        inner = (*root, *[1] * (self.n - 1), *tail)
        self.stiffness = list(map(self.closed.spring_stiffness, joints, inner))
        self.rest = [mpf(0)] * len(joints) if rest is None else list(rest.values())

    def rhs(self) -> list[Any]:
        closed, moving = self.closed, self.omega[self.boundary.first :]
        total = _add(_matrix_vector(closed.Q(), [w**2 for w in moving]), self._bending_forces())
        for load in self.loads().values():
            total = _add(total, load)
        rates = mp.lu_solve(mp.matrix(closed.M()), mp.matrix(total))
        return [*self.u, *rates, *self.rates]

    def apply_laws(self, laws: Mapping[str, Expression], t: float) -> None:
        """Set numbers that follow the motion and rates of added states by their laws at t [s]."""
        for sensor in {sensor for law in laws.values() for sensor in law.sensors}:
            self.signals[sensor.text] = self.sensor_value(sensor)
        for name, law in laws.items():
            value = mpf(0) + law.evaluate(mpf(t), self.signals, FUNCTIONS)
            if name in PARAMETERS:
                self.number[name] = value
            else:
                self.rates.append(value)

    def sensor_value(self, sensor: Sensor) -> Any:
        """Value that a sensor measures."""
        at = mpf(repr(sensor.at)) * self.n
        link = min(int(at), self.n - 1)
        if sensor.what in ("phi", "omega"):
            return (self.phi if sensor.what == "phi" else self.omega)[link]
        if sensor.what in ("x", "y"):
            starts, way = self.joints(), self.closed.joint_step(link)
        else:
            starts, way = self._velocities, self.closed.velocity_step(link, self.omega[link])
        axis = int(sensor.what[-1] == "y")
        return starts[link][axis] + (at - link) * way[axis]

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
        found = [-e for e in _matrix_vector(matrix, self.omega[self.boundary.first :])]
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

    def value(self, of: Any) -> Any:
        """A parameter, forces at the joints, or an expression in parameters and angles."""
        if isinstance(of, IndexedBase):
            return self.number[str(of)] if str(of) in self.number else self.force_values[of]
        if isinstance(of, Symbol):
            return self._number(of)
        expression = of.subs(n, self.n)
        known = {x: self._number(x) for x in expression.atoms(Symbol, Indexed)}
        known = {x: number for x, number in known.items() if number is not None}
        letters = {x: Dummy() for x in known}
        function = lambdify(letters.values(), expression.xreplace(letters), "mpmath")
        return mpf(0) + function(*known.values())

    def _number(self, of: Any) -> Any:
        """Value of a symbol; None of the name of an array."""
        if isinstance(of, Indexed):
            return (self.phi if of.base == phi else self.number[str(of.base)])[int(of.indices[0])]
        number = self.number.get(str(of))
        return {m: self.m, l: self.l, k: self.k}.get(
            of, None if isinstance(number, list) else number
        )

    @cached_property
    def force_values(self) -> dict[IndexedBase, dict[int, Any]]:
        """Forces and moments of loads that follow the motion, by joint or link."""
        forces: dict[IndexedBase, dict[int, Any]] = {}
        for load in self.acting.values():
            forces |= {base: {} for base in load.force_arrays}
            for at, motion in self._motions(load).items():
                for base, component in zip(
                    load.force_arrays, self._force(load, motion), strict=True
                ):
                    forces[base][at] = component
        return forces

    def _force(self, load: Any, motion: Any) -> tuple[Any, ...]:
        if isinstance(load, JointDrag):
            return load.force_by_hand(motion, self.value, mp)
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
        return {}

    @cached_property
    def _velocities(self) -> list[tuple[Any, Any]]:
        return self._running_sums(self.v0, self.closed.velocity_step, self.omega)

    def _joint_motion(self, load: JointDrag, s: int) -> JointMotion:
        links = [self.phi[q] for q in (s - 1, s) if 0 <= q < self.n]
        share, angle = mpf(len(links)) / 2, sum(links) / len(links)
        v, place = self._velocities[s], (*self.joints()[s], share * self.l)
        own = tuple(self.number[str(base)][s] for base in load.per_joint)
        return JointMotion(*v, mp.hypot(*v) or mpf(1), angle, share * self.m, own, *place)

    def _link_motion(self, load: Supports, q: int) -> LinkMotion:
        own = tuple(self.number[str(base)][q] for base in load.per_link)
        steps = self.closed.joint_step(q), self.closed.velocity_step(q, self.omega[q])
        starts = self.joints()[q], self._velocities[q]
        place, velocity = (
            tuple(a + own[0] * d for a, d in zip(start, step, strict=True))
            for start, step in zip(starts, steps, strict=True)
        )
        return LinkMotion((*place, self.phi[q]), (*velocity, self.omega[q]), own)

    def _anchor_energy(self, load: Any) -> Any:
        """Energy of the springs of a load: half their force times the displacement from rest, as
        the force is in proportion to that."""
        total = mpf(0)
        for motion in self._motions(load).values():
            force = load.spring_by_hand(motion, self.value, mp)
            rest = load.rest_by_hand(motion, self.value, mp)
            total -= sum(f * (x - x0) for f, x, x0 in zip(force, motion.place, rest, strict=True))
        return total / 2

    def energy(self) -> list[Any]:
        kinetic = _dot(self._rates, _matrix_vector(self._whole.M(), self._rates)) / 2
        spring = mp.fsum(self._spring_energy(k, b) for k, b in self._springs())
        anchors = (load for load in self.acting.values() if load.by_position)
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

    def joints(self) -> list[tuple[Any, Any]]:
        """Positions of the joints."""
        return self._running_sums(self.origin, self.closed.joint_step)

    @cached_property
    def links(self) -> LinkMasses:
        """Mass, centre and spread of every link; of an even rod, all alike."""
        kept = link_masses(("mass",), lambda _: [self.m] * self.n, self.lumped, FIFTY_DIGITS.half)
        assert kept is not None
        return self.closed.links_differ or kept

    def centre_of_gravity(self) -> tuple[Any, Any]:
        """Mean of the centres of the links, by their mass."""
        masses = [self.links.mass(q) for q in range(self.n)]
        x, y = zip(*self._centres(), strict=True)
        return _dot(masses, x) / mp.fsum(masses), _dot(masses, y) / mp.fsum(masses)

    def inertia(self) -> list[Any]:
        """Moments and product of inertia: those of the links about their centres, turned with
        them, and of the centres (Steiner)."""
        X, Y = self.centre_of_gravity()
        x, y, xy = mpf(0), mpf(0), mpf(0)
        for q, (a, b) in enumerate(self._centres()):
            m, c, s = self.links.mass(q), mp.cos(self.phi[q]), mp.sin(self.phi[q])
            along, across, mixed = (m * self.l**2 * of for of in self._spread(q))
            x += along * s**2 + across * c**2 + 2 * mixed * s * c + m * (b - Y) ** 2
            y += along * c**2 + across * s**2 - 2 * mixed * s * c + m * (a - X) ** 2
            xy += (along - across) * s * c + mixed * (c**2 - s**2) + m * (a - X) * (b - Y)
        return [x, y, xy]

    def _spread(self, q: int) -> tuple[Any, Any, Any]:
        """Mean squares and product of the mass of a link about its centre, over l^2."""
        if "link_spread_along" in self.number:
            along, across, mixed = (
                self.number[f"link_spread_{way}"][q] for way in ("along", "across", "mixed")
            )
            return along, across, mixed
        return self.links.second(q) - self.links.along(q) ** 2, mpf(0), mpf(0)

    def _centres(self) -> list[tuple[Any, Any]]:
        """Centres of gravity of the links."""
        found = []
        for q, (x, y) in enumerate(self.joints()[:-1]):
            a, b = self.l * self.links.along(q), self.l * self.links.across(q)
            c, s = mp.cos(self.phi[q]), mp.sin(self.phi[q])
            found.append((x + a * c - b * s, y + a * s + b * c))
        return found

    def _running_sums(
        self, start: tuple[Any, Any], step: Any, *of_link: Sequence[Any]
    ) -> list[tuple[Any, Any]]:
        """Running sums from the start over the steps of the links, one for every joint."""
        values = [start]
        for link in range(self.n):
            dx, dy = step(link, *(of[link] for of in of_link))
            values.append((values[-1][0] + dx, values[-1][1] + dy))
        return values

    def bending_moments(self) -> list[Any]:
        """Moments of the springs in all joints; zero where there is none."""
        moments = [mpf(0)] * (self.n + 1)
        for s, (stiffness, angle) in zip(
            self.boundary.spring_joints(self.n), self._springs(), strict=True
        ):
            moments[s] = self._spring_law(stiffness, angle)
        return moments

    def _springs(self) -> list[tuple[Any, Any]]:
        """Stiffness of every spring, and the angle by which it is bent."""
        ends = zip(pairwise(self.bent), self.rest, strict=True)
        return list(zip(self.stiffness, (b - a - rest for (a, b), rest in ends), strict=True))

    @cached_property
    def _spring_law(self) -> Any:
        """Law of the springs: moment by stiffness and angle."""
        numbers = [*self.structure.numbers]
        law = lambdify((k, bend, *numbers), law_of(self.structure), "mpmath")
        return lambda *of: law(*of, *(self.number[name] for name in numbers))

    def _spring_energy(self, stiffness: Any, angle: Any) -> Any:
        """Energy of a spring: k d^2/2 by Hooke's law, else the integral of its moment, in parts
        between the angles at which it is not smooth."""
        if not self.structure.spring:
            return stiffness * angle**2 / 2
        values = {name: float(self.number[name]) for name in self.structure.numbers}
        law = self.structure.spring_law.with_values(
            values | {spring_law.STIFFNESS: float(stiffness)}
        )
        low, high = sorted((0.0, float(angle)))
        ends = [0, *law.breaks(low, high)[:: 1 if angle > 0 else -1], angle]
        return mp.quad(lambda d: self._spring_law(stiffness, d), ends)

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

    def point_force(self, link: int, share: float, force: tuple[float, float]) -> list[Any]:
        """Generalised forces of a force at a share of a link: the force times the derivatives of
        its point by the coordinates."""
        fx, fy = map(mpf, force)
        arms = [mpf(1)] * link + [mpf(share)] + [mpf(0)] * (self.n - link - 1)
        turning = [
            arm * self.l * (fy * mp.cos(angle) - fx * mp.sin(angle))
            for arm, angle in zip(arms, self.phi, strict=True)
        ]
        return [*([fx, fy] if self.boundary.translates else []), *turning[self.boundary.first :]]

    def power(self) -> dict[str, Any]:
        power = {term: self._power_by_hand(load) for term, load in self.acting.items()}
        for term, load in self.acting.items():
            if isinstance(load, Foundation | Supports):  # of its dampers
                motions = self._motions(load).values()
                forces = ((m, load.damper_by_hand(m, self.value, mp)) for m in motions)
                power[term] = mp.fsum(_dot(force, m.velocity) for m, force in forces)
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
            return _dot(load.column_by_hand(self.closed, self.value), self.u)
        return _dot(self._whole_column(load), self._rates)

    def _whole_column(self, load: Load) -> list[Any]:
        """Generalised forces of a load on a rod that is free where its base moves."""
        links = (load.link_by_hand(self.closed, q, self.value) for q in range(self.n))
        return [*load.base_by_hand(self.closed, self.value), *links]

    def _base_power(self) -> Any:
        """Power of what holds the rod: what is missing in the rows of its coordinates, times their
        rates; of a clamp by a spring its moment times its rate."""
        accelerations = self.rhs()[len(self.u) :][: len(self.u)]
        growth = [self.clamp[2]] * self.boundary.first
        inertia = _matrix_vector(self._whole.M(), [*self.base[2], *growth, *accelerations])
        inertia = [
            a - b
            for a, b in zip(
                inertia, _matrix_vector(self._whole.Q(), [w**2 for w in self.omega]), strict=True
            )
        ]
        moments = self.bending_moments()
        for load in self.acting.values():
            if isinstance(load, JointMoment):
                moments = _add(moments, self._damper_moments(load))
            elif load.term != MOVING_BASE:
                inertia = [a - b for a, b in zip(inertia, self._whole_column(load), strict=True)]
        holding = inertia[2] - moments[1] if self.boundary.first else -moments[0]
        return _dot(inertia[:2], self.v0) + holding * self.clamp[1]


def _matrix_vector(matrix: list[list[Any]], vector: Sequence[Any]) -> list[Any]:
    return [_dot(row, vector) for row in matrix]


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return mp.fsum(x * y for x, y in zip(a, b, strict=True))


def _add(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    return [x + y for x, y in zip(a, b, strict=True)]
