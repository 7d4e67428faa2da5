"""Derivation 1: n links, explicitly, through LagrangesMethod.

Kinetic energy follows from the kinematics, the equations from LagrangesMethod, and the loads
from virtual work: a force F at r does the work F . dr/dq on a coordinate q.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import prod

from sympy import Add, Expr, Mul, S
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols
from sympy.polys.rings import PolyElement

from rodgen.model.rod import BOUNDARIES

from .calculus import TIME, Calculus, PolynomialMatrix
from .chain import position, spring_potential
from .loads import LOADS, loads_of
from .rod import Joint, Rod, centre, spread
from .symbols import ALPHA, eta, k, l, m, xi

PolyMatrix = list[list[PolyElement]]


@dataclass
class ExplicitDerivation:
    """The equations M v' = Q omega^2 - K phi + loads of a chain with n links.

    Rows are the coordinates that move: x0, y0 where joint 0 is free, then the angles of the
    moving links. Columns of M are the same, those of Q the moving links, those of K
    all links (a clamped angle has a column too).
    """

    n: int
    boundary: str = "free"
    inertia: str = "uniform"
    uneven: tuple[str, ...] = ()
    terms: tuple[str, ...] = ()  # beside one of each

    def __post_init__(self) -> None:
        hold = BOUNDARIES[self.boundary]
        moving = list(dynamicsymbols(f"phi{hold.first}:{self.n}", real=True))
        self.angles: list[Expr] = [ALPHA] * hold.first + moving
        # Every angle that a spring knows, and the springs between them.
        root, tail = ([size] if size else [] for size in (hold.root, hold.tail))
        self.bent = [ALPHA] * len(root) + self.angles + [ALPHA] * len(tail)
        self.rod = Rod(self.inertia, self.uneven)
        sizes = zip(hold.springs(self.n), [*root, *([1] * (self.n - 1)), *tail], strict=True)
        self.joints = [self.rod.joint(at, size) for at, size in sizes]
        self.base: list[Expr] = list(dynamicsymbols("x0 y0", real=True)) if hold.translates else []
        self.coordinates: list[Expr] = self.base + moving
        self.moving = moving
        self.first_joint = hold.first_joint
        held = [ALPHA] if hold.clamped else []
        constants, angles = [m, l, k, xi], [*moving, *held]
        constants += [eta] if self.rod.sided else []
        differing = [joint.stiffness for joint in self.joints]
        differing += map(self.rod.mass, range(self.n))
        if "bodies" in self.uneven or "points" in self.uneven:
            differing += [base[q] for q in range(self.n) for base in (*centre, *spread)]
        constants += [e for e in differing if e.is_Indexed]
        self.loads = LOADS | loads_of(self.terms)
        for load in self.loads.values():
            constants += load.constants(self.first_joint, self.n)
            angles += load.angles
        self.calculus = Calculus(self.coordinates, angles, constants)

    def point(
        self, link: int, fraction: Expr, beside: Expr = S.Zero
    ) -> tuple[PolyElement, PolyElement]:
        """Position of a point of the chain, or of one beside it, as polynomials."""
        origin = tuple(self.base) if self.base else (S.Zero, S.Zero)
        x, y = position(origin, self.angles, link, fraction, beside)
        return self.calculus.poly(x), self.calculus.poly(y)

    def joint(self, s: int) -> tuple[PolyElement, PolyElement]:
        """Position of joint s: the start of link s, for the tail the end of the last link."""
        return self.point(s, S.Zero) if s < self.n else self.point(self.n - 1, S.One)

    def rate(self, poly: PolyElement) -> PolyElement:
        """Time derivative."""
        return self.calculus.diff(poly, TIME)

    def over_link(self, poly: PolyElement, link: int) -> PolyElement:
        """Integral over the mass of a link."""
        return self.calculus.poly(self.rod.mass(link)) * self.mean(poly, link)

    def mean(self, poly: PolyElement, link: int = 0) -> PolyElement:
        """Mean over the mass of a link: powers of xi, and of eta beside it, become moments."""
        places = [xi, eta] if self.rod.sided else [xi]
        parts = self.calculus.coefficients(poly, places)
        return sum(
            (self._moment(powers, link) * c for powers, c in parts.items()),
            start=self.calculus.zero,
        )

    def _moment(self, powers: tuple[int, ...], link: int) -> PolyElement:
        product = prod((x**p for x, p in zip((xi, eta), powers, strict=False)), start=S.One)
        return self.calculus.poly(self.rod.mean(product, link))

    @cached_property
    def link_points(self) -> list[tuple[PolyElement, PolyElement]]:
        """The point at xi of every link, and at eta beside it where there is mass."""
        beside = eta if self.rod.sided else S.Zero
        return [self.point(link, xi, beside) for link in range(self.n)]

    @cached_property
    def kinetic_energy(self) -> PolyElement:
        """Half the squared velocity over all mass, link by link, collected."""
        total = self.calculus.zero
        for link, (x, y) in enumerate(self.link_points):
            total += self.over_link(self.rate(x) ** 2 + self.rate(y) ** 2, link)
        return self.calculus.normal(total) * self.calculus.poly(S.Half)

    @cached_property
    def spring_energy(self) -> PolyElement:
        """Energy of the springs in all joints."""
        energies = (spring_potential(a, b, joint.stiffness) for joint, a, b in self.springs)
        return self.calculus.poly(Add(*energies))

    @property
    def springs(self) -> list[tuple[Joint, Expr, Expr]]:
        """Joints with a spring, and the angles before and after them."""
        ends = pairwise(self.bent)
        return [(joint, *angles) for joint, angles in zip(self.joints, ends, strict=True)]

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
            split = self.calculus.coefficients(
                self.calculus.normal(row), rates + self.bending_angles
            )
            parts.append(self._sort(split, rates))
        return parts

    @cached_property
    def bending_angles(self) -> list[Expr]:
        """Angles that springs know, each once: the columns of K."""
        return list(dict.fromkeys(self.bent))

    def _sort(
        self, split: Mapping[tuple[int, ...], PolyElement], rates: list[Expr]
    ) -> dict[str, dict[Expr, PolyElement]]:
        out: dict[str, dict[Expr, PolyElement]] = {"squares": {}, "angles": {}, "other": {}}
        names = rates + self.bending_angles
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
        """K: minus the coefficient of phi_j in every row, a clamped angle included (once, where
        both ends are held at it)."""
        rows = [row["angles"] for row in self._forcing]
        return [[-row.get(a, self.calculus.zero) for a in self.bending_angles] for row in rows]

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

    def load(self, term: str) -> list[PolyElement]:
        """Generalised forces of a load, one for every coordinate; of a kind of damping too."""
        totals = [self.calculus.zero for _ in self.coordinates]
        for row in self.loads[term].rows(self):
            totals = [a + b for a, b in zip(totals, row, strict=True)]
        return [self.calculus.normal(e) for e in totals]

    def by_rates(self, column: list[PolyElement]) -> PolyMatrix:
        """Factors of the moving links' rates in generalised forces that are linear in them."""
        rates = [a.diff(TIME) for a in self.moving]
        unit = [tuple(int(a == b) for b in rates) for a in rates]
        split = [self.calculus.coefficients(e, rates) for e in column]
        return [[row.get(powers, self.calculus.zero) for powers in unit] for row in split]
