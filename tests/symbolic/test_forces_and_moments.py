"""Moments and forces of derivation 2 against derivation 1: derivatives of its potential, and its
virtual work at points of the chain."""

import pytest
from rodgen.derive import general
from rodgen.derive.chain import BOUNDARIES
from rodgen.derive.explicit import ExplicitDerivation
from rodgen.derive.general import Equations, joint
from rodgen.derive.loads import TERMS
from rodgen.derive.quantities import Quantities
from rodgen.derive.symbols import P, i, k, n, phi, xi
from sympy import Integer, Symbol, simplify

CHAINS = pytest.mark.parametrize(
    ("boundary", "links"),
    [(b, links) for b in BOUNDARIES for links in (1, 2, 4) if links > BOUNDARIES[b].first],
)
CARRIER = Symbol("carrier", integer=True)


@CHAINS
def test_bending_moments_are_derivatives_of_the_potential(boundary: str, links: int) -> None:
    explicit = ExplicitDerivation(links, boundary)
    angles = {phi[q]: angle for q, angle in enumerate(explicit.angles)}
    moment = Quantities(Equations(boundary, "uniform", TERMS)).bending_moment
    at = [moment.subs(n, links).subs(joint, s).subs(angles) for s in range(links + 1)]
    energy = explicit.calculus.expr(explicit.spring_energy)
    for angle, before, after in zip(explicit.angles, at, at[1:], strict=False):
        if angle in explicit.moving:
            assert simplify(before - after - energy.diff(angle)) == 0
    assert at[links] == 0
    if links > 1:  # the sign: positive where the angle grows from link to link
        assert simplify(at[-2].coeff(k) - (explicit.angles[-1] - explicit.angles[-2])) == 0


@CHAINS
def test_force_at_a_point_does_the_virtual_work_of_derivation_1(boundary: str, links: int) -> None:
    explicit, equations = ExplicitDerivation(links, boundary), Equations(boundary, "uniform", TERMS)
    hold, poly, expr = BOUNDARIES[boundary], explicit.calculus.poly, explicit.calculus.expr
    force = (Integer(3) * P, Integer(-7) * P)
    work = equations.point_force(force, CARRIER, xi)
    base = list(work.base) if hold.translates else []
    angles = {phi[q]: angle for q, angle in enumerate(explicit.angles)}
    for link in range(links):
        by_link = [
            work.link.subs({CARRIER: link, i: q}).subs(angles) for q in range(hold.first, links)
        ]
        rows = explicit.virtual_work(explicit.point(link, xi), (poly(force[0]), poly(force[1])))
        for here, row in zip([*base, *by_link], rows, strict=True):
            assert simplify(here - expr(row)) == 0


@CHAINS
def test_forces_on_joints_do_the_work_of_the_loads(boundary: str, links: int) -> None:
    explicit = ExplicitDerivation(links, boundary)
    loads = Quantities(Equations(boundary, "uniform", TERMS)).forces
    assert set(loads) == {"follower", "external_damping", "tip_load"}
    expr = explicit.calculus.expr
    values = {phi[q]: angle for q, angle in enumerate(explicit.angles)}
    for s, drag in enumerate(explicit.drag, start=explicit.first_joint):
        for base, resisting in zip((general.drag_x, general.drag_y), drag, strict=True):
            values[base[s]] = -resisting
    for term, load in loads.items():
        rows = [Integer(0) for _ in explicit.coordinates]
        low, high = (int(end.subs(n, links)) for end in (load.low, load.high))
        for s in range(low, high + 1):
            force = [f.subs(n, links).subs(joint, s).subs(values) for f in load.force]
            x, y = map(expr, explicit.joint(s))
            for at, q in enumerate(explicit.coordinates):
                rows[at] += force[0] * x.diff(q) + force[1] * y.diff(q)
        sign = -1 if term == "external_damping" else 1  # D_e resists
        for row, whole in zip(rows, getattr(explicit, term), strict=True):
            assert simplify(row - sign * expr(whole)) == 0
