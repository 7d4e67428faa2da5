"""The derivations against the closed form, against each other, and against plain SymPy."""

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from rodgen.derive import explicit, general, inertia
from rodgen.derive.calculus import TIME
from rodgen.derive.chain import BOUNDARIES
from rodgen.derive.closed_form import ClosedForm
from rodgen.derive.comparison import DisagreementError
from rodgen.derive.explicit import ExplicitDerivation
from rodgen.derive.general import Equations
from rodgen.derive.loads import TERMS, damper_moment
from rodgen.derive.points import prove_at_points
from rodgen.derive.proof_any_n import prove_any_n
from rodgen.derive.proof_explicit import prove_explicit
from rodgen.derive.symbols import PARAMETERS, i, j, later, m, n, phi, xi
from sympy import Matrix, S, Sum, expand, simplify
from sympy.physics.mechanics import LagrangesMethod

from rodgen.scene import structure

CHAINS = [(b, links) for b in BOUNDARIES for links in range(1, 6) if links > BOUNDARIES[b].first]
EVERY = pytest.mark.parametrize("inertia", inertia.INERTIAS)


@EVERY
@pytest.mark.parametrize(("boundary", "links"), CHAINS)
def test_explicit_derivation_equals_the_closed_form(
    boundary: str, links: int, inertia: str
) -> None:
    hold = BOUNDARIES[boundary]
    held = {c.name: c.entries for c in prove_explicit(links, boundary, inertia)}
    moving = links - hold.first
    size = moving + 2 * hold.translates
    assert held["M"] == size**2
    assert held["Q"] == held["D_i"] == size * moving
    assert held["K"] == size * (links + (hold.root > 0))
    assert held["F"] == held["A"] == held["D_e"] == held["T"] == size


@EVERY
@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_any_n_equals_the_closed_form(boundary: str, inertia: str) -> None:
    names = {c.name for c in prove_any_n(boundary, inertia)}
    assert names == {"M", "Q", "K", "joints", "F", "T", "A", "D_i", "D_e", "D_e force law"}


@pytest.mark.parametrize("term", TERMS)
@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_every_term_is_proven_where_it_is_alone(boundary: str, term: str) -> None:
    name = {"follower": "F", "tip_load": "T", "gravity": "A"}.get(term, f"D_{term[0]}")
    for proof in (
        prove_any_n(boundary, "lumped", (term,)),
        prove_explicit(2, boundary, "lumped", (term,)),
    ):
        names = {c.name for c in proof} - {"D_e force law"}
        assert names == {"M", "Q", "K", "joints", name}


@pytest.mark.parametrize(
    ("boundary", "links", "inertia"),
    [
        ("free", 1, "uniform"),
        ("free", 61, "uniform"),
        ("cantilever", 200, "lumped"),
        ("clamped", 1, "lumped"),
        ("clamped", 80, "uniform"),
        ("pinned", 1, "uniform"),
        ("pinned", 100, "lumped"),
    ],
)
def test_rational_points_equal_the_closed_form(boundary: str, links: int, inertia: str) -> None:
    held = {c.name: c.entries for c in prove_at_points(links, boundary, inertia)}
    assert set(held) >= {"M", "Q", "F", "T", "A", "D_e"}
    assert ("K" in held) == (links > 1 or boundary == "clamped")
    # Two of its links are drawn for an entry of Q.
    assert all(count or (name, links) == ("Q", 1) for name, count in held.items())


@EVERY
@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_polynomial_matrices_give_what_plain_lagranges_method_gives(
    boundary: str, inertia: str
) -> None:
    derived = ExplicitDerivation(3, boundary, inertia)
    expr = derived.calculus.expr
    lagrangian = expr(derived.kinetic_energy - derived.spring_energy)
    plain = LagrangesMethod(lagrangian, derived.coordinates)
    plain.form_lagranges_equations()
    polynomial = derived.lagranges_method
    mass = Matrix([[expr(e) for e in row] for row in polynomial.mass_matrix.rows])
    forcing = Matrix([[expr(e) for e in row] for row in polynomial.forcing.rows])
    assert (mass - plain.mass_matrix).applyfunc(simplify).is_zero_matrix
    assert (forcing - plain.forcing).applyfunc(simplify).is_zero_matrix


@EVERY
@pytest.mark.parametrize("links", [1, 2, 3])
def test_kinetic_energy_is_that_of_points_along_the_links(links: int, inertia: str) -> None:
    """Energy by integrating over each link directly, or by summing over the masses in the
    joints, without Calculus or collecting."""
    derived = ExplicitDerivation(links, "free", inertia)

    def squared(point: Any) -> Any:
        x, y = (derived.calculus.expr(c) for c in point)
        return expand(x.diff(TIME) ** 2 + y.diff(TIME) ** 2)

    if inertia == "uniform":
        along = (squared(derived.point(link, xi)) for link in range(links))
        total = sum(m / 2 * energy.integrate((xi, 0, 1)) for energy in along)
    else:
        masses = [m / 2, *[m] * (links - 1), m / 2]
        total = sum(mass / 2 * squared(derived.joint(s)) for s, mass in enumerate(masses))
    assert simplify(total - derived.calculus.expr(derived.kinetic_energy)) == 0


@pytest.mark.parametrize(
    ("boundary", "links", "inertia"),
    [
        ("free", 4, "uniform"),
        ("cantilever", 5, "uniform"),
        ("clamped", 3, "lumped"),
        ("pinned", 4, "uniform"),
    ],
)
def test_general_entries_are_the_explicit_ones(boundary: str, links: int, inertia: str) -> None:
    """Derivation 2 at a given n against derivation 1, entry by entry, without the closed form."""
    one, two = ExplicitDerivation(links, boundary, inertia), Equations(boundary, inertia, TERMS)
    first, base = BOUNDARIES[boundary].first, 2 * BOUNDARIES[boundary].translates
    angles = {phi[q]: angle for q, angle in enumerate(one.angles)}
    drag = {general.drag_x[q]: -x for q, (x, _) in enumerate(one.drag, start=one.first_joint)} | {
        general.drag_y[q]: -y for q, (_, y) in enumerate(one.drag, start=one.first_joint)
    }

    def same(entry: Any, at: dict[Any, int], polynomial: Any) -> bool:
        here = entry.subs({**at, n: links}).doit().subs({**angles, **drag})
        return bool(simplify(here - one.calculus.expr(polynomial)) == 0)

    for a in range(first, links):
        row = base + a - first
        for b in range(first, links):
            at = {i: a, j: b, later: max(a, b)}
            mass = two.mass_link if a == b else two.mass_link_link
            velocity = two.velocity_link_link if a != b else mass * 0
            assert same(mass, at, one.mass_matrix[row][base + b - first])
            assert same(velocity, at, one.velocity_matrix[row][b - first])
        for term in ("follower", "gravity", "tip_load"):
            assert same(getattr(two, term).link, {i: a}, getattr(one, term)[row])
        assert same(two.external_damping.link, {i: a}, -one.external_damping[row])
    for axis in range(base):
        for b in range(first, links):
            at = {i: b}
            assert same(two.mass_base_link[axis], at, one.mass_matrix[axis][base + b - first])
            assert same(two.velocity_base_link[axis], at, one.velocity_matrix[axis][b - first])
        assert same(two.gravity.base[axis], {}, one.gravity[axis])
        assert same(two.external_damping.base[axis], {}, -one.external_damping[axis])


def _times(factor: int) -> Callable[[Any], Any]:
    """A method that gives a multiple of what the right one gives."""

    def change(right: Any) -> Any:
        def wrong(self: ClosedForm, *arguments: Any) -> Any:
            value = right(self, *arguments)
            return tuple(factor * v for v in value) if isinstance(value, tuple) else factor * value

        return wrong

    return change


WRONG = {
    "M_base": "M",
    "M_base_link": "M",
    "M_link": "M",
    "M_link_link": "M",
    "Q_base_link": "Q",
    "Q_link_link": "Q",
    "bending_row": "K",
    "F_base": "F",
    "F_link": "F",
    "T_base": "T",
    "T_link": "T",
    "A_base": "A",
    "A_link": "A",
    "D_e_base": "D_e",
    "D_e_link": "D_e",
}
PROOFS = {
    "explicit": lambda terms: prove_explicit(4, "free", "uniform", terms),
    "any n": lambda terms: prove_any_n("free", "uniform", terms),
    "points": lambda terms: prove_at_points(70, "free", "uniform", terms),
}


@pytest.mark.parametrize("proof", PROOFS)
@pytest.mark.parametrize("method", WRONG)
def test_every_proof_catches_every_wrong_entry(
    proof: str, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ClosedForm, method, _times(3)(getattr(ClosedForm, method)))
    with pytest.raises(DisagreementError) as error:
        list(PROOFS[proof](TERMS))
    assert re.match(rf"{WRONG[method]}\b", error.value.entry)


HELD = {
    "explicit": lambda: prove_explicit(4, "clamped", "lumped"),
    "any n": lambda: prove_any_n("clamped", "lumped"),
    "points": lambda: prove_at_points(70, "clamped", "lumped"),
}


def _wrong_root(patch: pytest.MonkeyPatch) -> None:
    """Three inner springs in the table of boundaries, where half a link has two."""
    patch.setitem(BOUNDARIES, "clamped", replace(BOUNDARIES["clamped"], root=3))


def _wrong_root_damper(patch: pytest.MonkeyPatch) -> None:
    """As damped as an inner joint, in both derivations."""
    one = property(lambda s: damper_moment(S.Zero, general.omega[0]))
    patch.setattr(Equations, "root_damper", one)
    right = ExplicitDerivation.internal_damping.func

    def wrong(self: ExplicitDerivation) -> Any:
        self.joints = [1] * self.n  # K has been compared by then
        return right(self)

    patch.setattr(ExplicitDerivation, "internal_damping", property(wrong))


def _wrong_mass(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(ClosedForm, "M_link", _times(3)(ClosedForm.M_link))


def _wrong_inertia(patch: pytest.MonkeyPatch) -> None:
    patch.setitem(inertia.INERTIAS, "lumped", inertia.INERTIAS["uniform"])


@pytest.mark.parametrize("proof", HELD)
@pytest.mark.parametrize(
    ("wrong", "entry"),
    [(_wrong_root, "K"), (_wrong_root_damper, "D_i"), (_wrong_mass, "M"), (_wrong_inertia, "M")],
)
def test_every_proof_catches_a_wrong_clamp_and_wrong_masses(
    proof: str,
    wrong: Callable[[pytest.MonkeyPatch], None],
    entry: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wrong(monkeypatch)
    with pytest.raises(DisagreementError, match=rf"^{entry}\b"):
        list(HELD[proof]())


@pytest.mark.parametrize("proof", PROOFS)
def test_every_proof_catches_wrong_internal_damping(
    proof: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """K is right, D_i is not: its law is changed in the derivation."""
    for module in (general, explicit):
        monkeypatch.setattr(module, "damper_moment", lambda a, b: -2 * damper_moment(a, b))
    with pytest.raises(DisagreementError, match=r"D_i"):
        list(PROOFS[proof](("internal_damping",)))


@pytest.mark.parametrize("quantity", [general.joint_x, general.joint_vy])
def test_wrong_sums_along_the_chain_are_caught(
    quantity: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """rhs is emitted from the running sums of derivation 2: they are proven too."""
    right = Equations.arrays.func

    def wrong(self: Equations) -> Any:
        arrays = right(self)
        array = arrays[quantity]
        (total,) = array.value.atoms(Sum)
        doubled = array.value.subs(total, Sum(2 * total.function, *total.limits))
        return {**arrays, quantity: replace(array, value=doubled)}

    monkeypatch.setattr(Equations, "arrays", property(wrong))
    with pytest.raises(DisagreementError, match=str(quantity)):
        list(PROOFS["explicit"](()))
    with pytest.raises(DisagreementError, match="joints"):
        list(PROOFS["any n"](()))


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
    assert tuple(BOUNDARIES) == tuple(structure.BOUNDARIES)
    assert tuple(inertia.INERTIAS) == structure.INERTIAS
    assert TERMS == structure.TERMS
    for boundary, hold in BOUNDARIES.items():
        offered = structure.BOUNDARIES[boundary]
        assert (hold.translates, hold.first) == (offered.translates, offered.first)
        assert bool(hold.root) == offered.root_spring
        assert hold.clamped == ("clamp_angle" in structure.BOUNDARY_PARAMETERS[boundary])
    offered_names = {*structure.ROD_PARAMETERS}
    for names in (structure.TERM_PARAMETERS | structure.BOUNDARY_PARAMETERS).values():
        offered_names |= set(names)
    assert offered_names - {"fin_factor"} == set(PARAMETERS)
