"""Derivation 1: n links, explicitly, through LagrangesMethod.

Kinetic energy follows from the kinematics, the equations from LagrangesMethod, and the loads
from virtual work: a force F at r does the work F . dr/dq on a coordinate q.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from sympy import Add, Expr, Mul, S
from sympy.physics.mechanics import LagrangesMethod
from sympy.polys.rings import PolyElement

from .chain import spring_potential
from .explicit_chain import ExplicitChain
from .loads import LOADS, loads_of
from .polynomials import TIME, PolynomialMatrix

PolyMatrix = list[list[PolyElement]]


@dataclass
class ExplicitDerivation(ExplicitChain):
    """The equations M v' = Q omega^2 - K phi + rest + loads of a chain with n links.

    Rows are the coordinates that move: x0, y0 where joint 0 is free, then the angles of the
    moving links. Columns of M are the same, those of Q the moving links, those of K
    all links (a clamped angle has a column too).
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        every = dict(zip(LOADS, (load.on(self.rod) for load in LOADS.values()), strict=True))
        self.loads = every | loads_of(self.terms, self.rod)  # beside one of each
        for load in self.loads.values():
            self.constants += load.constants(self.first_joint, self.n)
            self.turning += load.angles

    @cached_property
    def kinetic_energy(self) -> PolyElement:
        """Kinetic energy: half the squared velocity over all mass, link by link, in normal form."""
        total = self.calculus.zero
        for link, (x, y) in enumerate(self.link_points):
            total += self.integrate_over_link(
                self.time_derivative(x) ** 2 + self.time_derivative(y) ** 2, link
            )
        return self.calculus.normal_form(total) * self.calculus.poly(S.Half)

    @cached_property
    def spring_energy(self) -> PolyElement:
        """Energy of the springs in all joints."""
        energies = (
            spring_potential(joint.bend(*ends), joint.stiffness) for joint, *ends in self.springs
        )
        return self.calculus.poly(Add(*energies))

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
        return [[self.calculus.normal_form(e) for e in row] for row in rows]

    @cached_property
    def _forcing(self) -> list[dict[str, dict[Expr, PolyElement]]]:
        """Rows of the loadless forcing, split into factors of omega_j^2, of phi_j, what depends on
        neither, and all else."""
        rates = [q.diff(TIME) for q in self.coordinates]
        parts = []
        for row in self._forcing_rows:
            split = self.calculus.coefficients(self._at_rest(row), rates + self.spring_angles)
            parts.append(self._sort_terms(split, rates))
        return parts

    @cached_property
    def _forcing_rows(self) -> list[PolyElement]:
        """Rows of the loadless forcing, in normal form."""
        rows = self.lagranges_method.forcing.rows
        return [self.calculus.normal_form(row) for (row,) in rows]

    def _at_rest(self, row: PolyElement) -> PolyElement:
        """Row of a rod whose base does not move."""
        still = [(self.calculus.generator[e], 0) for e in self._given_derivatives]
        return row.subs(still) if row and still else row

    @property
    def _given_derivatives(self) -> list[Expr]:
        """Rates and accelerations that are given as functions of time."""
        return [q.diff(TIME, order) for q in self.courses for order in (1, 2)]

    def forces_by_base(self) -> list[PolyElement]:
        """Part of the loadless forcing that there is because the base moves, by row."""
        return [row - self._at_rest(row) for row in self._forcing_rows]

    @cached_property
    def spring_angles(self) -> list[Expr]:
        """Angles at the ends of springs, each once: the columns of K."""
        return list(dict.fromkeys(self.bent))

    def _sort_terms(
        self, split: Mapping[tuple[int, ...], PolyElement], rates: list[Expr]
    ) -> dict[str, dict[Expr, PolyElement]]:
        kinds = "squares", "angles", "constant", "other"
        out: dict[str, dict[Expr, PolyElement]] = {kind: {} for kind in kinds}
        names = rates + self.spring_angles
        for powers, coefficient in split.items():
            factors = [(name, power) for name, power in zip(names, powers, strict=True) if power]
            match factors:
                case [(name, 2)] if name in rates:
                    out["squares"][name] = coefficient
                case [(name, 1)] if name not in rates:
                    out["angles"][name] = coefficient
                case []:
                    out["constant"][S.One] = coefficient
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
        return [[-row.get(a, self.calculus.zero) for a in self.spring_angles] for row in rows]

    @cached_property
    def rest_moments(self) -> list[PolyElement]:
        """Moments of springs that are bent at rest, where all angles are zero, by row."""
        return [row["constant"].get(S.One, self.calculus.zero) for row in self._forcing]

    @cached_property
    def remainder(self) -> list[dict[Expr, PolyElement]]:
        """Terms of the loadless forcing in none of these, by row: must be empty."""
        return [row["other"] for row in self._forcing]

    def load(self, term: str) -> list[PolyElement]:
        """Generalised forces of a load or a kind of damping, one for every coordinate."""
        totals = [self.calculus.zero for _ in self.coordinates]
        for row in self.loads[term].explicit_forces(self):
            totals = [a + b for a, b in zip(totals, row, strict=True)]
        return [self.calculus.normal_form(e) for e in totals]

    def rate_coefficients(self, column: list[PolyElement]) -> PolyMatrix:
        """Factors of the moving links' rates in generalised forces that are linear in them."""
        rates = [a.diff(TIME) for a in self.moving]
        unit = [tuple(int(a == b) for b in rates) for a in rates]
        split = [self.calculus.coefficients(e, rates) for e in column]
        return [[row.get(powers, self.calculus.zero) for powers in unit] for row in split]
