"""The derivations against the closed form, against each other, and against plain SymPy."""

import pytest
from rodgen.derive import inertia
from rodgen.derive.calculus import TIME
from rodgen.derive.chain import BOUNDARIES
from rodgen.derive.closed_form import ClosedForm
from rodgen.derive.explicit import ExplicitDerivation
from rodgen.derive.general import Equations
from rodgen.derive.loads import BOUNDARY_PARAMETERS, TERM_PARAMETERS, TERMS
from rodgen.derive.points import prove_at_points
from rodgen.derive.proof import DisagreementError, prove_any_n, prove_explicit
from rodgen.derive.symbols import i, j, later, m, n, phi, xi
from sympy import Matrix, expand, simplify
from sympy.physics.mechanics import LagrangesMethod

from rodgen.scene import structure

CHAINS = [(b, links) for b in BOUNDARIES for links in range(1, 6) if links > BOUNDARIES[b].first]


@pytest.mark.parametrize(("boundary", "links"), CHAINS)
def test_explicit_derivation_equals_the_closed_form(boundary: str, links: int) -> None:
    held = {c.name: c.entries for c in prove_explicit(links, boundary, "uniform")}
    moving = links - BOUNDARIES[boundary].first
    size = moving + 2 * BOUNDARIES[boundary].translates
    assert held["M"] == size**2
    assert held["Q"] == held["D_i"] == size * moving
    assert held["K"] == size * links
    assert held["F"] == held["A"] == held["D_e"] == size


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_any_n_equals_the_closed_form(boundary: str) -> None:
    names = {c.name for c in prove_any_n(boundary, "uniform")}
    assert names == {"M", "Q", "K", "F", "A", "D_i", "D_e", "D_e force law"}


@pytest.mark.parametrize(("boundary", "links"), [("free", 61), ("cantilever", 200), ("free", 1)])
def test_rational_points_equal_the_closed_form(boundary: str, links: int) -> None:
    assert sum(c.entries for c in prove_at_points(links, boundary, "uniform")) >= 8


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_polynomial_matrices_give_what_plain_lagranges_method_gives(boundary: str) -> None:
    derived = ExplicitDerivation(3, boundary)
    expr = derived.calculus.expr
    lagrangian = expr(derived.kinetic_energy - derived.spring_energy)
    plain = LagrangesMethod(lagrangian, derived.coordinates)
    plain.form_lagranges_equations()
    polynomial = derived.lagranges_method
    mass = Matrix([[expr(e) for e in row] for row in polynomial.mass_matrix.rows])
    forcing = Matrix([[expr(e) for e in row] for row in polynomial.forcing.rows])
    assert (mass - plain.mass_matrix).applyfunc(simplify).is_zero_matrix
    assert (forcing - plain.forcing).applyfunc(simplify).is_zero_matrix


@pytest.mark.parametrize("links", [1, 2, 3])
def test_kinetic_energy_is_that_of_points_along_the_links(links: int) -> None:
    """Energy by integrating over each link directly, without Calculus or collecting."""
    derived = ExplicitDerivation(links, "free")
    total = 0
    for link in range(links):
        x, y = (derived.calculus.expr(c) for c in derived.point(link, xi))
        squared = expand(x.diff(TIME) ** 2 + y.diff(TIME) ** 2)
        total += m / 2 * squared.integrate((xi, 0, 1))
    assert simplify(total - derived.calculus.expr(derived.kinetic_energy)) == 0


@pytest.mark.parametrize(("boundary", "links"), [("free", 4), ("cantilever", 5)])
def test_general_entries_are_the_explicit_ones(boundary: str, links: int) -> None:
    """Derivation 2 at a given n against derivation 1, entry by entry, without the closed form."""
    one, two = ExplicitDerivation(links, boundary), Equations(boundary, "uniform", TERMS)
    first, base = BOUNDARIES[boundary].first, 2 * BOUNDARIES[boundary].translates
    angles = dict(enumerate(one.angles))
    for a in range(first, links):
        for b in range(first, links):
            entry = two.mass_link if a == b else two.mass_link_link
            at = {phi[i]: angles[a], phi[j]: angles[b], i: a, j: b, later: max(a, b), n: links}
            here = entry.subs(at)
            there = one.calculus.expr(one.mass_matrix[base + a - first][base + b - first])
            assert simplify(here - there) == 0


WRONG = {
    "M": ("M_link_link", lambda self, i, j, later: 2 * _right_mass(self, i, j, later)),
    "Q": ("Q_link_link", lambda self, i, j, later: -_right_velocity(self, i, j, later)),
    "F": ("F_link", lambda self, i, P, nu: -P * self.l * self.sin(self.phi[i])),
    "A": ("A_link", lambda self, i, g: -g * self.m * self.l * self.w(i) * self.cos(self.phi[i])),
    "D_e": ("D_e_link", lambda self, i, D: self.l * D[0][self.n] * self.cos(self.phi[i])),
}
_right_mass, _right_velocity = ClosedForm.M_link_link, ClosedForm.Q_link_link


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_a_wrong_closed_form_is_caught(
    name: str, boundary: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    method, wrong = WRONG[name]
    monkeypatch.setattr(ClosedForm, method, wrong)
    with pytest.raises(DisagreementError) as explicit:
        list(prove_explicit(4, boundary, "uniform"))
    assert explicit.value.entry.startswith(f"{name}[")
    with pytest.raises(DisagreementError, match=name):
        list(prove_any_n(boundary, "uniform"))
    with pytest.raises(DisagreementError, match=name):
        list(prove_at_points(70, boundary, "uniform"))


@pytest.mark.parametrize("name", ["K", "D_i"])
def test_a_wrong_stiffness_is_caught(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    right = getattr(ClosedForm, name)

    def wrong(self: ClosedForm, *arguments: object) -> list[list[object]]:
        rows = right(self, *arguments)
        rows[-1][-1] = 2 * rows[-1][-1]
        return rows

    monkeypatch.setattr(ClosedForm, name, wrong)
    with pytest.raises(DisagreementError, match=name):
        list(prove_explicit(3, "free", "uniform"))


def test_a_printed_sign_of_the_thesis_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """Thesis 2.46 has the follower force with the other sign."""
    right = ClosedForm.F_base
    monkeypatch.setattr(ClosedForm, "F_base", lambda s, P, nu: tuple(-f for f in right(s, P, nu)))
    with pytest.raises(DisagreementError) as error:
        list(prove_explicit(2, "free", "uniform"))
    assert error.value.entry == "F[0,0]"


def test_other_inertia_changes_the_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    """All that is derived follows the mass distribution: the closed form no longer fits."""
    monkeypatch.setitem(inertia.INERTIAS, "uniform", lambda f: f.subs(xi, 1))
    with pytest.raises(DisagreementError, match="M"):
        list(prove_explicit(2, "free", "uniform"))
    with pytest.raises(DisagreementError, match="M"):
        list(prove_any_n("free", "uniform"))


def test_scene_and_derivation_offer_the_same() -> None:
    """Names stand twice, since a scene is read without SymPy; here they are held together."""
    assert tuple(BOUNDARIES) == structure.BOUNDARIES
    assert tuple(inertia.INERTIAS) == structure.INERTIAS
    assert TERMS == structure.TERMS
    for boundary, hold in BOUNDARIES.items():
        assert hold.least_links == structure.LEAST_LINKS[boundary]
        names = tuple(str(p) for p in BOUNDARY_PARAMETERS[boundary])
        assert names == structure.BOUNDARY_PARAMETERS[boundary]
    for term in TERMS:
        names = tuple(str(p) for p in TERM_PARAMETERS[term])
        fins = ("fin_factor",) if term == "external_damping" else ()
        assert names + fins == structure.TERM_PARAMETERS[term]
