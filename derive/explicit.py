"""Derivation 1: n links, explicitly, through LagrangesMethod.

Kinetic energy follows from the kinematics, the equations from LagrangesMethod, and the loads
from virtual work: a force F at r does the work F . dr/dq on a coordinate q.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from sympy import Add, Expr, Mul, S, Symbol
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols
from sympy.polys.rings import PolyElement

from .calculus import TIME, Calculus, PolynomialMatrix
from .chain import BOUNDARIES, position
from .inertia import INERTIAS
from .loads import (
    damper_moment,
    follower_force,
    spring_potential,
    tip_force,
    weight,
)
from .symbols import ALPHA, C_INT, F_TIP, NU, G, P, k, l, m, xi

PolyMatrix = list[list[PolyElement]]


@dataclass
class ExplicitDerivation:
    """The equations M v' = Q omega^2 - K phi + loads of a chain with n links.

    Rows are the coordinates that move: x0, y0 where joint 0 is free, then the angles of the
    moving links. Columns of M are the same, those of Q and D_i the moving links, those of K
    all links (a clamped angle has a column too).
    """

    n: int
    boundary: str = "free"
    inertia: str = "uniform"

    def __post_init__(self) -> None:
        hold = BOUNDARIES[self.boundary]
        moving = list(dynamicsymbols(f"phi{hold.first}:{self.n}", real=True))
        self.angles: list[Expr] = [ALPHA] * hold.first + moving
        # Every angle that a spring knows; springs and dampers between them, in inner joints.
        self.bent = [ALPHA, *self.angles] if hold.root else self.angles
        self.joints = [*([hold.root] if hold.root else []), *([1] * (self.n - 1))]
        self.base: list[Expr] = list(dynamicsymbols("x0 y0", real=True)) if hold.translates else []
        self.coordinates: list[Expr] = self.base + moving
        self.moving = moving
        self.drag = [
            (Symbol(f"D_x{s}", real=True), Symbol(f"D_y{s}", real=True))
            for s in range(hold.first_joint, self.n + 1)
        ]
        self.first_joint = hold.first_joint
        forces = [component for force in self.drag for component in force]
        held = [ALPHA] if hold.clamped else []
        constants = [m, l, k, xi, P, G, C_INT, *F_TIP, *forces]
        self.calculus = Calculus(self.coordinates, [*moving, *held, NU], constants)

    def point(self, link: int, fraction: Expr) -> tuple[PolyElement, PolyElement]:
        """Position of a point of the chain, as polynomials."""
        origin = tuple(self.base) if self.base else (S.Zero, S.Zero)
        x, y = position(origin, self.angles, link, fraction)
        return self.calculus.poly(x), self.calculus.poly(y)

    def joint(self, s: int) -> tuple[PolyElement, PolyElement]:
        """Position of joint s: the start of link s, for the tail the end of the last link."""
        return self.point(s, S.Zero) if s < self.n else self.point(self.n - 1, S.One)

    def rate(self, poly: PolyElement) -> PolyElement:
        """Time derivative."""
        return self.calculus.diff(poly, TIME)

    def mean(self, poly: PolyElement) -> PolyElement:
        """Mean over the mass of a link: powers of xi become moments of the inertia model."""
        moments = INERTIAS[self.inertia]
        parts = self.calculus.coefficients(poly, [xi])
        return sum(
            (self.calculus.poly(moments(xi**p)) * c for (p,), c in parts.items()),
            start=self.calculus.zero,
        )

    @cached_property
    def link_points(self) -> list[tuple[PolyElement, PolyElement]]:
        """The point at xi of every link."""
        return [self.point(link, xi) for link in range(self.n)]

    @cached_property
    def kinetic_energy(self) -> PolyElement:
        """Half the mean square velocity times the mass, link by link, collected."""
        total = self.calculus.zero
        for x, y in self.link_points:
            total += self.mean(self.rate(x) ** 2 + self.rate(y) ** 2)
        return self.calculus.normal(total) * self.calculus.poly(m / 2)

    @cached_property
    def spring_energy(self) -> PolyElement:
        """Energy of the springs in all joints."""
        joints = zip(self.joints, pairwise(self.bent), strict=True)
        return self.calculus.poly(Add(*(size * spring_potential(*ends) for size, ends in joints)))

    @cached_property
    def lagranges_method(self) -> LagrangesMethod:
        """SymPy's LagrangesMethod after it has formed the equations of the loadless rod."""
        lagrangian = self.kinetic_energy - self.spring_energy
        method = LagrangesMethod(self.calculus.expr(lagrangian), self.coordinates)
        # The same Lagrangian as a polynomial: every derivative below is exact ring arithmetic.
        if not hasattr(method, "_L"):
            raise RuntimeError("this SymPy keeps the Lagrangian of LagrangesMethod elsewhere")
        method._L = PolynomialMatrix(self.calculus, [[lagrangian]])
        method.form_lagranges_equations()
        return method

    @cached_property
    def mass_matrix(self) -> PolyMatrix:
        rows = self.lagranges_method.mass_matrix.rows
        return [[self.calculus.normal(e) for e in row] for row in rows]

    @cached_property
    def _forcing(self) -> list[dict[str, dict[Expr, PolyElement]]]:
        """Rows of the loadless forcing, split into omega_j^2, phi_j and what must not be left."""
        rates = [q.diff(TIME) for q in self.coordinates]
        parts = []
        for (row,) in self.lagranges_method.forcing.rows:
            split = self.calculus.coefficients(self.calculus.normal(row), rates + self._all_angles)
            parts.append(self._sort(split, rates))
        return parts

    @cached_property
    def _all_angles(self) -> list[Expr]:
        return list(dict.fromkeys(self.bent))

    def _sort(
        self, split: Mapping[tuple[int, ...], PolyElement], rates: list[Expr]
    ) -> dict[str, dict[Expr, PolyElement]]:
        out: dict[str, dict[Expr, PolyElement]] = {"squares": {}, "angles": {}, "other": {}}
        names = rates + self._all_angles
        for powers, coefficient in split.items():
            factors = [(name, power) for name, power in zip(names, powers, strict=True) if power]
            match factors:
                case [(name, 2)] if name in rates:
                    out["squares"][name] = coefficient
                case [(name, 1)] if name not in rates:
                    out["angles"][name] = coefficient
                case _:
                    out["other"][Mul(*(name**power for name, power in factors))] = coefficient
        return out

    @cached_property
    def velocity_matrix(self) -> PolyMatrix:
        """Q: the coefficient of omega_j^2 in every row."""
        squares = [row["squares"] for row in self._forcing]
        return [[row.get(a.diff(TIME), self.calculus.zero) for a in self.moving] for row in squares]

    @cached_property
    def stiffness_matrix(self) -> PolyMatrix:
        """K: minus the coefficient of phi_j in every row, a clamped angle included."""
        rows = [row["angles"] for row in self._forcing]
        return [[-row.get(a, self.calculus.zero) for a in self.bent] for row in rows]

    @cached_property
    def remainder(self) -> list[dict[Expr, PolyElement]]:
        """What of the loadless forcing is in neither Q nor K: must be empty."""
        return [row["other"] for row in self._forcing]

    def virtual_work(
        self, point: tuple[PolyElement, PolyElement], force: tuple[PolyElement, PolyElement]
    ) -> list[PolyElement]:
        """Generalised forces F . dr/dq of a force at a point, one for every coordinate."""
        diff = self.calculus.diff
        (x, y), (fx, fy) = point, force
        return [diff(x, q) * fx + diff(y, q) * fy for q in self.coordinates]

    def _sum(self, rows: list[list[PolyElement]]) -> list[PolyElement]:
        totals = [self.calculus.zero for _ in self.coordinates]
        for row in rows:
            totals = [a + b for a, b in zip(totals, row, strict=True)]
        return [self.calculus.normal(e) for e in totals]

    @cached_property
    def follower(self) -> list[PolyElement]:
        """F: virtual work of the follower force at the tail."""
        fx, fy = (self.calculus.poly(f) for f in follower_force(self.angles[-1]))
        return self._sum([self.virtual_work(self.joint(self.n), (fx, fy))])

    @cached_property
    def tip_load(self) -> list[PolyElement]:
        """T: virtual work of the dead force at the tail."""
        fx, fy = (self.calculus.poly(f) for f in tip_force())
        return self._sum([self.virtual_work(self.joint(self.n), (fx, fy))])

    @cached_property
    def gravity(self) -> list[PolyElement]:
        """A: virtual work of gravity on the mass of every link."""
        fx, fy = (self.calculus.poly(f) for f in weight(m))
        rows = [self.virtual_work(point, (fx, fy)) for point in self.link_points]
        return self._sum([[self.mean(e) for e in row] for row in rows])

    @cached_property
    def internal_damping(self) -> PolyMatrix:
        """D_i: minus the virtual work of the damping moments across the joints, by rate."""
        poly, rows = self.calculus.poly, []
        for size, (before, after) in zip(self.joints, pairwise(self.bent), strict=True):
            moment = poly(size * damper_moment(before.diff(TIME), after.diff(TIME)))
            opening = poly(after - before)
            rows.append([moment * self.calculus.diff(opening, q) for q in self.coordinates])
        rates = [a.diff(TIME) for a in self.moving]
        unit = [tuple(int(a == b) for b in rates) for a in rates]
        split = [self.calculus.coefficients(-e, rates) for e in self._sum(rows)]
        return [[row.get(powers, self.calculus.zero) for powers in unit] for row in split]

    @cached_property
    def external_damping(self) -> list[PolyElement]:
        """D_e: minus the virtual work of the forces D_x, D_y that resist at the joints."""
        rows = []
        for at, (dx, dy) in enumerate(self.drag):
            force = (-self.calculus.generator[dx], -self.calculus.generator[dy])
            rows.append(self.virtual_work(self.joint(self.first_joint + at), force))
        return [-e for e in self._sum(rows)]
