"""Derivation 3 with the joint forces kept as unknowns, for implicit methods.

Every moving link is a cell of three unknowns: its angular acceleration and the force in the joint
before it, over the mass of a link. The residual of a cell follows from the angles, rates and
unknowns of its own and of the cells before and after it, so that its derivatives are
block-tridiagonal: an index-1 differential-algebraic equation whose Newton steps cost O(n).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from sympy import Add, And, Eq, Expr, Indexed, IndexedBase, Matrix, Mul, Piecewise, S, Symbol

from .chain import link_step
from .general import GeneralEquations
from .joint_force_system import JointForceSystem
from .joint_system import collect_terms, lambda_x, lambda_y, link_moment, load_on, tail_load
from .loads.joint_drag import divisor
from .symbols import alpha, i, joint_vx, joint_vy, joint_x, joint_y, n, omega, phi, s

UNKNOWNS = (alpha, lambda_x, lambda_y)
# What is differentiated by, in cells, and at the joints at the start and at the end of a link.
CELLS = {"angle": (phi,), "rate": (omega,), "unknown": UNKNOWNS}
JOINTS = {"velocity": (joint_vx, joint_vy), "position": (joint_x, joint_y)}


@dataclass(frozen=True)
class _Place:
    """Place of a link: whether it is the first of the moving ones, and whether the last."""

    first: bool
    last: bool


@dataclass(frozen=True)
class ImplicitForm:
    """Residual of the cell of link i (rows: turning, and the joint before it in x and y), and its
    derivatives by those around it: columns of angles and rates (3x1), of unknowns
    (3x3), and of joint velocities and positions (3x2, by which only forces on joints change)."""

    equations: GeneralEquations

    @cached_property
    def residual(self) -> Matrix:
        """Residual, zero for the accelerations and joint forces of the chain."""
        return self._piecewise(list(self._residuals.values()))

    @cached_property
    def derivatives(self) -> dict[str, list[Matrix]]:
        """Derivatives of the residual: by angles, rates and unknowns of the cells before, own and
        after, by velocities and positions of the joints i and i + 1."""
        found = {
            kind: [self._derivative([of[i + d] for of in bases], d) for d in (-1, 0, 1)]
            for kind, bases in CELLS.items()
        }
        return found | {
            kind: [self._derivative([of[i + d] for of in bases], 0) for d in (0, 1)]
            for kind, bases in JOINTS.items()
        }

    @cached_property
    def link_velocity_derivatives(self) -> tuple[Matrix, Matrix]:
        """Derivatives of the velocity that link i adds from start to end, by angle and by rate."""
        _, _, *velocity = link_step(i, S.One, self.equations.rod.length(i))
        return Matrix(velocity).diff(phi[i]), Matrix(velocity).diff(omega[i])

    def by_number(self, number: Symbol) -> Matrix:
        """Derivative by a number in the loads."""
        return self._derivative([number], 0)

    def base_by_number(self, number: Symbol, links: int) -> Matrix:
        """Derivative of the acceleration of joint 0 by a number in the loads."""
        return self.base_acceleration(links).applyfunc(lambda e: self._partial(e, number))

    def base_acceleration(self, links: int) -> Matrix:
        """Acceleration of joint 0 of a chain that translates."""
        place = _Place(first=True, last=links == 1)
        chain = JointForceSystem(self.equations)
        rows = self._with_tail(-chain.start_constraint(i), chain, place)
        return self._with_laws(rows, place)

    def base_derivatives(self, links: int) -> dict[str, list[Matrix]]:
        """Derivatives of `base_acceleration` by angles, rates and unknowns of the cells 0 and 1 and
        by the velocities and positions of joints 0 and 1."""
        rows = self.base_acceleration(links)
        return {
            kind: [
                Matrix([[self._partial(e, base[i + d]) for base in bases] for e in rows])
                for d in (0, 1)
            ]
            for kind, bases in (CELLS | JOINTS).items()
        }

    # Cases ------------------------------------------------------------------------------------

    @property
    def _places(self) -> tuple[_Place, ...]:
        return _Place(True, True), _Place(True, False), _Place(False, True), _Place(False, False)

    def _piecewise(self, values: Sequence[Matrix]) -> Matrix:
        """Matrix of Piecewise entries, from one matrix for every place."""
        first, last = Eq(i, self.equations.boundary_condition.first), Eq(i, n - 1)
        conditions = (And(first, last), first, last, S.true)
        entries = zip(*values, strict=True)
        cases = [Piecewise(*zip(entry, conditions, strict=True)) for entry in entries]
        return Matrix(*values[0].shape, cases)

    def _derivative(self, variables: Sequence[Expr], offset: int) -> Matrix:
        """Derivative of the residual by variables at an offset; none beyond the ends."""
        values = []
        for place, residual in self._residuals.items():
            beyond = (place.first and offset < 0) or (place.last and offset > 0)
            columns = [
                [S.Zero if beyond else self._partial(e, x) for x in variables] for e in residual
            ]
            values.append(Matrix(columns))
        return self._piecewise(values)

    def _partial(self, expression: Expr, variable: Expr) -> Expr:
        """Partial derivative, through the speed that drag divides by as well: that is one at rest,
        where its factor vanishes. Arrays of loads do not depend on numbers here: their laws stand
        in their place."""
        total = _differentiate(expression, variable)
        if isinstance(variable, Indexed) and variable.base in (joint_vx, joint_vy):
            speed = divisor[variable.indices[0]]
            total += expression.diff(speed) * variable / speed if expression.has(speed) else 0
        return total  # what its parts share is found later

    # The residual -----------------------------------------------------------------------------

    @cached_property
    def _residuals(self) -> dict[_Place, Matrix]:
        return {place: self._residual(place) for place in self._places}

    def _residual(self, place: _Place) -> Matrix:
        chain = JointForceSystem(self.equations)
        turning = alpha[i] - chain.accelerations(i)[2]
        if chain.inertia_ratio != 1:
            turning = collect_terms(chain.inertia_ratio * turning)
        joint_rows = self._joint_rows(chain, place)
        rows = Matrix([turning, *joint_rows]).xreplace({link_moment[i]: self._link_moment(place)})
        return self._with_laws(self._with_tail(rows, chain, place), place)

    def _with_tail(self, rows: Matrix, chain: JointForceSystem, place: _Place) -> Matrix:
        """Rows with the load at the tail in place of the force in the joint there."""
        if not place.last:
            return rows
        tail = tail_load(self.equations, chain.multiplier_mass)
        given = dict(zip((lambda_x[i + 1], lambda_y[i + 1]), tail, strict=True))
        return rows.xreplace(given).subs(phi[n - 1], phi[i])

    def _joint_rows(self, chain: JointForceSystem, place: _Place) -> Sequence[Expr]:
        """Rows of the joint before link i: its constraint or, at a free start, the given force."""
        boundary = self.equations.boundary_condition
        if place.first and boundary.translates:
            given = load_on(self.equations, i, chain.multiplier_mass)
            return lambda_x[i] + given[0], lambda_y[i] + given[1]
        total = chain.start_constraint(i)
        if not place.first:
            total += chain.end_constraint(i - 1)
        return tuple(total)

    def _link_moment(self, place: _Place) -> Expr:
        """Moment on link i of the joints at both its ends."""
        inner, root, tail = self.equations.moments
        start, end = (inner.subs(s, at) for at in (i, i + 1))
        if place.first and not self.equations.boundary_condition.first:
            start = root.xreplace({of[0]: of[i] for of in (phi, omega, *self._spring_arrays)})
        if place.last:
            end = tail.subs(n, i + 1)
        return start - end

    @property
    def _spring_arrays(self) -> tuple[IndexedBase, ...]:
        """Arrays of the loads over the joints with a spring."""
        loads = self.equations.loads.values()
        return tuple(base for load in loads for base in load.spring_arrays(self.equations))

    def _with_laws(self, rows: Matrix, place: _Place) -> Matrix:
        """Rows with the laws of the loads in place of their forces on the joints of a link."""
        starts = place.first and self.equations.boundary_condition.translates
        ends = {i: (None if starts else phi[i - 1], phi[i])}
        ends[i + 1] = (phi[i], None if place.last else phi[i + 1])
        laws: dict[Expr, Expr] = {}
        for load in self.equations.loads.values():
            laws |= load.link_laws()
            root = place.first and not self.equations.boundary_condition.first
            laws |= load.spring_laws(i, self.equations, root=root, tail=False)
            laws |= load.spring_laws(i + 1, self.equations, root=False, tail=place.last)
            for at, angles in ends.items():
                laws |= load.joint_laws(at, *angles, self.equations)
        return rows.xreplace(laws)


def _differentiate(e: Expr, x: Expr) -> Expr:
    """Differentiate e by x, skipping all that is free of x, which SymPy's own way goes through."""
    if not e.has(x):
        return S.Zero
    if e.is_Add:
        return Add(*(_differentiate(term, x) for term in e.args))
    if e.is_Mul:
        parts = [(at, _differentiate(one, x)) for at, one in enumerate(e.args)]
        return Add(*(Mul(*e.args[:at], d, *e.args[at + 1 :]) for at, d in parts if d != 0))
    return e.diff(x)
