"""True equations of the free, uniform rod of n links, from derivation 1: nothing is retyped.

Energies, their derivatives, matrices and loads are those of derive.explicit, written in plain
real letters: x0, y0, phi_i, their rates vx0, vy0, omega_i, and the rates of those.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache, cached_property

from sympy import Expr, S, Symbol, symbols
from sympy.polys.rings import PolyElement

from rodgen.derive.explicit import ExplicitDerivation
from rodgen.derive.loads import external_damping, follower, gravity, internal_damping
from rodgen.derive.polynomials import TIME
from rodgen.derive.symbols import PARAMETERS, l, m, vx0, vy0, x0, xi, y0
from rodgen.model.rod import BOUNDARIES

MOST = 6  # links
phi = symbols(f"phi_0:{MOST}", real=True)
omega = symbols(f"omega_0:{MOST}", real=True)
domega = symbols(f"omegadot_0:{MOST}", real=True)  # angular accelerations
ax0, ay0 = symbols("vdot_x0 vdot_y0", real=True)  # accelerations of joint 0
D_x = symbols(f"D_x0:{MOST + 1}", real=True)  # resisting forces of the medium at the joints
D_y = symbols(f"D_y0:{MOST + 1}", real=True)
r = Symbol("r", nonnegative=True)  # way along a link
P, nu, g, c_int, c_ext = symbols("P nu g c_int c_ext", real=True)
M, L, EI = symbols("M L EI", positive=True)

LETTERS: dict[Expr, Expr] = {
    PARAMETERS["follower_force"]: P,
    PARAMETERS["follower_angle"]: nu,
    PARAMETERS["gravity"]: g,
    PARAMETERS["internal_damping"]: c_int,
    PARAMETERS["external_damping"]: c_ext,
    xi: r / l,
    PARAMETERS["mass"]: M,
    PARAMETERS["length"]: L,
    PARAMETERS["bending_stiffness"]: EI,
}

Matrix = list[list[Expr]]
Column = list[Expr]
Acting = tuple[PolyElement, PolyElement]  # a force or moment, and the rate along which it acts


class TrueEquations:
    """Derived entries for n links; rows are x0, y0, phi_0 .. phi_{n-1}."""

    def __init__(self, n: int) -> None:
        self.n = n
        self.derived = ExplicitDerivation(n)
        self.positions = [x0, y0, *phi[:n]]
        self.rates = [vx0, vy0, *omega[:n]]
        self.accelerations = [ax0, ay0, *domega[:n]]
        self._letters = {**LETTERS}
        # The thesis has the forces that resist: those of the derivation, turned round.
        for base, resisting in zip(external_damping.LOAD.bases, (D_x, D_y), strict=True):
            self._letters |= {base[s]: -resisting[s] for s in range(n + 1)}
        for q, *plain in zip(
            self.derived.coordinates,
            self.positions,
            self.rates,
            self.accelerations,
            strict=True,
        ):
            rate = q.diff(TIME)
            self._letters |= dict(zip((q, rate, rate.diff(TIME)), plain, strict=True))

    def letters(self, poly: PolyElement) -> Expr:
        """A polynomial of the derivation in plain letters."""
        return self.derived.calculus.expr(poly).xreplace(self._letters)

    def _column(self, polys: list[PolyElement]) -> Column:
        return [self.letters(p) for p in polys]

    def _matrix(self, rows: list[list[PolyElement]]) -> Matrix:
        return [self._column(row) for row in rows]

    # Kinematics and energies -----------------------------------------------------------------

    def velocity(self, link: int) -> tuple[Expr, Expr]:
        """Velocity of the point at r of a link."""
        x, y = (self.derived.time_derivative(p) for p in self.derived.link_points[link])
        return self.letters(x), self.letters(y)

    def _squared_speed(self, link: int) -> PolyElement:
        x, y = (self.derived.time_derivative(p) for p in self.derived.link_points[link])
        return self.derived.calculus.normal_form(x**2 + y**2)

    def energy_density(self, link: int) -> Expr:
        """Kinetic energy per length at r of a link [J/m]: dE = (m/2) v^2 d(r/l)."""
        return m / (2 * l) * self.letters(self._squared_speed(link))

    def link_energy(self, link: int) -> Expr:
        """Kinetic energy of one link."""
        return m / 2 * self.letters(self.derived.mean(self._squared_speed(link)))

    @cached_property
    def kinetic_energy(self) -> Expr:
        return self.letters(self.derived.kinetic_energy)

    @cached_property
    def spring_energy(self) -> Expr:
        return self.letters(self.derived.spring_energy)

    @cached_property
    def lagrangian(self) -> Expr:
        """Lagrangian from which the equations were derived."""
        # LagrangesMethod has no public name for it.
        ((poly,),) = self.derived.lagranges_method._L.rows
        return self.letters(poly)

    def _slopes(self, poly: PolyElement, order: int) -> list[PolyElement]:
        """Derivatives by the coordinates (order 0) or by their rates (order 1)."""
        by = [q.diff(TIME) if order else q for q in self.derived.coordinates]
        return [self.derived.calculus.diff(poly, q) for q in by]

    @cached_property
    def momenta(self) -> Column:
        """dE_k/du."""
        return self._column(self._slopes(self.derived.kinetic_energy, 1))

    @cached_property
    def momentum_rates(self) -> Column:
        """d/dt dE_k/du."""
        momenta = self._slopes(self.derived.kinetic_energy, 1)
        return self._column([self.derived.time_derivative(p) for p in momenta])

    @cached_property
    def kinetic_slopes(self) -> Column:
        """dE_k/dq."""
        return self._column(self._slopes(self.derived.kinetic_energy, 0))

    @cached_property
    def spring_slopes(self) -> Column:
        """dE_p/dq."""
        return self._column(self._slopes(self.derived.spring_energy, 0))

    @cached_property
    def lagrange_rows(self) -> Column:
        """d/dt dL/du - dL/dq: zero where no load acts."""
        parts = zip(self.momentum_rates, self.kinetic_slopes, self.spring_slopes, strict=True)
        return [rate - kinetic + spring for rate, kinetic, spring in parts]

    # Matrices and loads ----------------------------------------------------------------------

    @cached_property
    def M(self) -> Matrix:
        return self._matrix(self.derived.mass_matrix)

    @cached_property
    def Q(self) -> Matrix:
        return self._matrix(self.derived.velocity_matrix)

    @cached_property
    def K(self) -> Matrix:
        return self._matrix(self.derived.stiffness_matrix)

    @cached_property
    def D_i(self) -> Matrix:
        return [
            [-e for e in row]
            for row in self._matrix(
                self.derived.rate_coefficients(self.derived.load("internal_damping"))
            )
        ]

    @cached_property
    def F(self) -> Column:
        """Follower force."""
        return self._column(self.derived.load("follower"))

    @cached_property
    def A(self) -> Column:
        """Gravity."""
        return self._column(self.derived.load("gravity"))

    @cached_property
    def D_e(self) -> Column:
        """External damping, from the resisting forces D_x, D_y at the joints."""
        return [-e for e in self._column(self.derived.load("external_damping"))]

    # Loads by a second route -----------------------------------------------------------------

    @cached_property
    def forces(self) -> dict[str, Column]:
        """Generalised forces of every load, with the sign of what acts on the rod: from the laws
        of derive.loads by virtual power, where F, A, D_i and D_e are by virtual work."""
        d, poly = self.derived, self.derived.calculus.poly
        tail = zip(follower.LOAD.force(d.angles[-1]), d.joint(self.n), strict=True)
        weights = [
            (poly(f), d.mean(d.time_derivative(c)))
            for point in d.link_points
            for f, c in zip(gravity.LOAD.weight(m, BOUNDARIES["free"]), point, strict=True)
        ]
        dampers = [
            (
                poly(internal_damping.LOAD.moment(a.diff(TIME), b.diff(TIME), joint)),
                d.time_derivative(poly(b - a)),
            )
            for joint, a, b in d.springs
        ]
        drag = [
            (poly(base[s]), d.time_derivative(c))
            for s in range(self.n + 1)
            for base, c in zip(external_damping.LOAD.bases, d.joint(s), strict=True)
        ]
        return {
            "follower": self._by_power((poly(f), d.time_derivative(c)) for f, c in tail),
            "gravity": self._by_power(weights),
            "internal_damping": self._by_power(dampers),
            "external_damping": self._by_power(drag),
        }

    def _by_power(self, loads: Iterable[Acting]) -> Column:
        """Force times d(rate)/du, for every u."""
        totals = [self.derived.calculus.zero for _ in self.rates]
        for force, along in loads:
            slopes = self._slopes(along, 1)
            totals = [a + force * slope for a, slope in zip(totals, slopes, strict=True)]
        return self._column(totals)


@cache
def truth(n: int) -> TrueEquations:
    """The truth for n links; truth.cache_clear() after a change of what derive/ says."""
    return TrueEquations(n)


def product(matrix: Matrix, vector: list[Expr]) -> Column:
    """Matrix times vector."""
    return [sum((a * b for a, b in zip(row, vector, strict=True)), S.Zero) for row in matrix]


def flat(matrix: Matrix) -> Column:
    """The entries of a matrix, row by row."""
    return [entry for row in matrix for entry in row]


def total(term: Callable[[int], Expr], low: int, high: int) -> Expr:
    """Sum of term(i) over low <= i <= high; an empty one is zero."""
    return sum((term(i) for i in range(low, high + 1)), S.Zero)
