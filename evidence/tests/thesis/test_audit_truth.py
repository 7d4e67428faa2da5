"""The truth of the audit by a second route: velocities integrated over the links by SymPy."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import pytest
from sympy import (
    Expr,
    Function,
    Integer,
    Matrix,
    Rational,
    Symbol,
    atan,
    cos,
    integrate,
    sin,
    symbols,
)

from rodgen.derive.symbols import l, m
from rodgen_evidence.thesis.audit.truth import D_x, D_y, P, c_int, flat, g, nu, omega, phi, r, truth

TIME = Symbol("t", real=True)


class Direct:
    """A chain of n links, written down without derive/."""

    def __init__(self, n: int):
        self.n = n
        names = ["x0", "y0", *(f"phi{i}" for i in range(n))]
        self.q = [Function(name, real=True)(TIME) for name in names]
        t = truth(n)
        self.letters: dict[Expr, Expr] = {}
        plain = zip(self.q, t.positions, t.rates, t.accelerations, strict=True)
        for q, *letters in plain:
            self.letters |= {q.diff(TIME, k): x for k, x in enumerate(letters)}

    def plain(self, expression: Expr) -> Expr:
        return expression.xreplace(self.letters)  # derivatives before what they are of

    def point(self, link: int, way: Expr) -> Matrix:
        x, y, *angles = self.q
        out = Matrix([x, y])
        for angle in angles[:link]:
            out += l * Matrix([cos(angle), sin(angle)])
        return out + way * Matrix([cos(angles[link]), sin(angles[link])])

    def joint(self, s: int) -> Matrix:
        return self.point(s, Integer(0)) if s < self.n else self.point(self.n - 1, l)

    def link_energy(self, link: int) -> Expr:
        v = self.point(link, r).diff(TIME)
        return integrate((v.dot(v) * m / (2 * l)).expand(), (r, 0, l))

    @cached_property
    def energy(self) -> Expr:
        return sum((self.link_energy(i) for i in range(self.n)), Integer(0))

    @cached_property
    def springs(self) -> Expr:
        angles, k = self.q[2:], symbols("k", positive=True)
        return sum((k * (b - a) ** 2 / 2 for a, b in pairwise(angles)), Integer(0))

    def work(self, point: Matrix, force: tuple[Expr, Expr]) -> list[Expr]:
        return [point.diff(q).dot(Matrix(force)) for q in self.q]


def same(one: Expr, two: Expr) -> bool:
    """Exactly equal at two rational points: angles are twice the arctangents of rationals, whose
    cosines and sines are rational."""
    for seed in (1, 2):
        letters = sorted((one - two).free_symbols, key=str)
        values: dict[Expr, Expr] = {}
        for at, x in enumerate(letters, start=1):
            value = Rational(3 * at + seed, 2 * at + 5 * seed + 1)
            values[x] = 2 * atan(value) if str(x).startswith("phi") or x == nu else value
        rational = {f: f.subs(values).expand(trig=True) for f in (one - two).atoms(cos, sin)}
        if (one - two).xreplace(rational).subs(values).expand() != 0:
            return False
    return True


@pytest.mark.parametrize("n", [1, 2, 3])
def test_energies_against_integration(n: int) -> None:
    direct, t = Direct(n), truth(n)
    for link in range(n):
        assert same(direct.plain(direct.link_energy(link)), t.link_energy(link))
    assert same(direct.plain(direct.energy), t.kinetic_energy)
    assert same(direct.plain(direct.springs), t.spring_energy)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_derivatives_and_matrices_against_integration(n: int) -> None:
    direct, t = Direct(n), truth(n)
    rates = [q.diff(TIME) for q in direct.q]
    momenta = [direct.energy.diff(u) for u in rates]
    slopes = [direct.energy.diff(q) for q in direct.q]
    rows = [
        p.diff(TIME) - slope + direct.springs.diff(q)
        for p, slope, q in zip(momenta, slopes, direct.q, strict=True)
    ]
    for one, two in ((momenta, t.momenta), (slopes, t.kinetic_slopes), (rows, t.lagrange_rows)):
        assert all(same(direct.plain(a), b) for a, b in zip(one, two, strict=True))
    masses = [direct.plain(p.diff(u)) for p in momenta for u in rates]
    assert all(same(a, b) for a, b in zip(masses, flat(t.M), strict=True))
    # The squares of the angular velocities, and nothing else, are left of the rows at rest.
    still = dict.fromkeys((*t.accelerations, *phi[:0]), 0)
    spring = dict.fromkeys([Symbol("k", positive=True)], 0)
    for row, factors in zip(rows, t.Q, strict=True):
        left = direct.plain(row).subs(still).subs(spring)
        assert same(left, -sum(f * w**2 for f, w in zip(factors, omega[:n], strict=True)))


@pytest.mark.parametrize("n", [1, 2, 3])
def test_loads_against_virtual_work(n: int) -> None:
    direct, t = Direct(n), truth(n)
    tail = direct.q[-1] + nu
    thrust = direct.work(direct.joint(n), (-P * cos(tail), -P * sin(tail)))
    centres = [direct.work(direct.point(i, l / 2), (Integer(0), -m * g)) for i in range(n)]
    weight = [sum(rows) for rows in zip(*centres, strict=True)]
    joints = [direct.work(direct.joint(s), (D_x[s], D_y[s])) for s in range(n + 1)]
    drag = [sum(rows) for rows in zip(*joints, strict=True)]
    resisting = [-e for e in t.forces["external_damping"]]
    for one, two in (
        (thrust, t.F),
        (thrust, t.forces["follower"]),
        (weight, t.A),
        (weight, t.forces["gravity"]),
        (drag, t.D_e),
        (drag, resisting),
    ):
        assert all(same(direct.plain(a), b) for a, b in zip(one, two, strict=True))


@pytest.mark.parametrize("n", [1, 2, 3])
def test_dampers_against_dissipation(n: int) -> None:
    """Moments of internal damping: minus the slope of half the power that they take."""
    t = truth(n)
    half = sum((c_int * m * (b - a) ** 2 / 2 for a, b in pairwise(omega[:n])), Integer(0))
    for one, two in zip(t.forces["internal_damping"], t.rates, strict=True):
        assert same(one, -half.diff(two))


def test_the_second_route_can_tell_a_difference() -> None:
    t = truth(2)
    assert not same(t.kinetic_energy, t.kinetic_energy + l**2 * m * omega[0] * sin(phi[0]) ** 9)
    assert not same(t.F[0], -t.F[0])
