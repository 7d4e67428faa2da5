"""The derivations against the closed form, against each other, and against plain SymPy."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import pytest
from sympy import Matrix, S, Sum, expand, simplify
from sympy.physics.mechanics import LagrangesMethod

from rodgen.derive import symbols
from rodgen.derive.closed_form import ClosedForm
from rodgen.derive.explicit import ExplicitDerivation
from rodgen.derive.general import GeneralEquations
from rodgen.derive.generic_chain import AtSprings, GenericChain
from rodgen.derive.link_properties import INERTIAS
from rodgen.derive.loads import LOADS, TERMS
from rodgen.derive.loads.air_force import AirForce
from rodgen.derive.loads.base import Base
from rodgen.derive.loads.contact import Contact
from rodgen.derive.loads.distributed_follower import DistributedFollower
from rodgen.derive.loads.follower import Follower
from rodgen.derive.loads.foundation import Foundation
from rodgen.derive.loads.gravity import Gravity
from rodgen.derive.loads.internal_damping import InternalDamping
from rodgen.derive.loads.joint_drag import JointDrag
from rodgen.derive.loads.joint_law import JointLaw
from rodgen.derive.loads.kinds import JointMoment, MassForce
from rodgen.derive.loads.link_force import LinkForce
from rodgen.derive.loads.point_force import PointForce
from rodgen.derive.loads.point_moment import PointMoment
from rodgen.derive.loads.supports import Supports
from rodgen.derive.polynomials import TIME
from rodgen.derive.proofs import DisagreementError
from rodgen.derive.proofs import any_n as proof_any_n
from rodgen.derive.proofs.any_n import prove_any_n
from rodgen.derive.proofs.explicit_proof import prove_explicit
from rodgen.derive.proofs.joint_force_proof import prove_joint_forces
from rodgen.derive.proofs.rational_points import prove_at_points
from rodgen.derive.symbols import l, m, omega, xi
from rodgen.model import rod, terms
from rodgen.model.rod import BOUNDARIES
from tests.palette import can_move, cases

RODS = cases("boundary, inertia", BOUNDARIES, INERTIAS)


@cases("boundary, links, inertia", BOUNDARIES, (1, 2, 3), INERTIAS, where=can_move)
def test_explicit_derivation_equals_the_closed_form(
    boundary: str, links: int, inertia: str
) -> None:
    boundary_condition = BOUNDARIES[boundary]
    held = {c.name: c.entries for c in prove_explicit(links, boundary, inertia)}
    moving = links - boundary_condition.first
    size = moving + 2 * boundary_condition.translates
    assert held["M"] == size**2
    assert held["Q"] == held["D_i"] == held["D_m"] == size * moving
    assert held["K"] == size * (links + (boundary_condition.root > 0))
    assert held["F"] == held["A"] == held["D_e"] == held["T"] == size


@RODS
def test_any_n_equals_the_closed_form(boundary: str, inertia: str) -> None:
    names = {c.name for c in prove_any_n(boundary, inertia)}
    letters = {LOADS[term].letter for term in TERMS}
    laws = {"D_e force law", "W force law", "D_w force law", "D_v force law"}
    assert names == {"sizes", "M", "Q", "K", "joints", *letters, *laws}


@cases("boundary, term", BOUNDARIES, (*TERMS, "distributed_follower@angle", "gravity@acceleration"))
def test_every_term_is_proven_where_it_is_alone(boundary: str, term: str) -> None:
    name = LOADS[term.partition("@")[0]].letter
    for proof in (
        prove_any_n(boundary, "lumped", (term,)),
        prove_explicit(2, boundary, "lumped", (term,)),
    ):
        names = {c.name for c in proof} - {"sizes", f"{name} force law"}
        assert names == {"M", "Q", "K", "joints", name}


@pytest.mark.parametrize("keys", ["x", "x+y", "angle", "x+y+angle"])
@pytest.mark.parametrize("boundary", ["pinned", "clamped", "cantilever"])
@pytest.mark.parametrize("inertia", INERTIAS)
def test_a_moving_base_is_proven_in_all_derivations(boundary: str, keys: str, inertia: str) -> None:
    """Derivation 1 has its coordinates as given functions of time; with a damper, whose rates
    count from that of the clamp."""
    if "angle" in keys and not BOUNDARIES[boundary].is_clamped:
        return
    terms_ = ("material_damping", f"base@{keys}")
    for proof in (
        prove_any_n(boundary, inertia, terms_),
        prove_explicit(2, boundary, inertia, terms_),
        prove_at_points(20, boundary, inertia, terms_),
    ):
        assert "B" in {c.name for c in proof}
    assert list(prove_joint_forces(3, boundary, inertia, terms_))


@cases("boundary, links, inertia", BOUNDARIES, (1, 20), INERTIAS, where=can_move)
def test_rational_points_equal_the_closed_form(boundary: str, links: int, inertia: str) -> None:
    held = {c.name: c.entries for c in prove_at_points(links, boundary, inertia)}
    assert set(held) >= {"M", "Q", "F", "T", "A", "D_e"}
    assert ("K" in held) == (links > 1 or boundary == "clamped")
    # Two of its links are drawn for an entry of Q.
    assert all(count or (name, links) == ("Q", 1) for name, count in held.items())


@pytest.mark.slow
def test_rational_points_of_a_long_rod() -> None:
    """Of eighty links, pairs are drawn."""
    held = {c.name: c.entries for c in prove_at_points(80, "cantilever", "lumped")}
    assert all(held.values())


@RODS
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


@cases("links, inertia", (1, 2), INERTIAS)
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


def _times(factor: int) -> Callable[[Any], Any]:
    """A method that gives a multiple of what the right one gives."""

    def change(right: Any) -> Any:
        def wrong(self: Any, *arguments: Any) -> Any:
            value = right(self, *arguments)
            return tuple(factor * v for v in value) if isinstance(value, tuple) else factor * value

        return wrong

    return change


# What is spoilt (methods of the closed form, and of loads whose entries are written by hand), the
# entry that proofs then name, and the loads that a rod has.
WRONG = [
    *((ClosedForm, f"M_{of}", "M", ()) for of in ("base", "base_link", "link", "link_link")),
    *((ClosedForm, method, "Q", ()) for method in ("Q_base_link", "Q_link_link")),
    (ClosedForm, "bending_row", "K", ()),
    *(
        (kind, method, LOADS[term].letter, (term,))
        for term, kind in {
            "follower": Follower,
            "tip_load": PointForce,
            "gravity": Gravity,
            "external_damping": JointDrag,
            "viscous_drag": JointDrag,
        }.items()
        for method in ("base_by_hand", "link_by_hand")
    ),
    (PointMoment, "link_by_hand", LOADS["moment"].letter, ("moment@1",)),
    (DistributedFollower, "link_by_hand", "F_q", ("distributed_follower@angle",)),
    *((Gravity, f"{of}_by_hand", "A", ("gravity@acceleration",)) for of in ("base", "link")),
]
FREE, HELD = ("free", "uniform"), ("clamped", "lumped")
PROOFS = {
    "explicit": partial(prove_explicit, 3),
    "any n": prove_any_n,
    "points": partial(prove_at_points, 7),
}


@pytest.mark.parametrize("proof", PROOFS)
def test_every_proof_catches_every_wrong_entry(proof: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for kind, method, entry, loads in WRONG:
        with monkeypatch.context() as patch:
            patch.setattr(kind, method, _times(3)(getattr(kind, method)))
            with pytest.raises(DisagreementError, match=rf"^{entry}\b"):
                list(PROOFS[proof](*FREE, loads))


def _wrong_root(patch: pytest.MonkeyPatch) -> None:
    """Three inner springs in the table of boundaries, where half a link has two."""
    patch.setitem(BOUNDARIES, "clamped", replace(BOUNDARIES["clamped"], root=3))


def _wrong_root_damper(patch: pytest.MonkeyPatch) -> None:
    """As damped as an inner joint, in both derivations."""
    moments = JointMoment.moments

    def as_inside(self: JointMoment, chain: GenericChain) -> AtSprings:
        root = self.moment(S.Zero, omega[0], chain.rod.joint(0))
        return moments(self, chain)._replace(root=root)

    patch.setattr(JointMoment, "moments", as_inside)
    right = JointMoment.explicit_forces

    def wrong(self: JointMoment, chain: ExplicitDerivation) -> Any:
        chain.joints = [chain.rod.joint(at) for at in range(chain.n)]  # K has been compared by then
        return right(self, chain)

    patch.setattr(JointMoment, "explicit_forces", wrong)


def _wrong_inertia(patch: pytest.MonkeyPatch) -> None:
    patch.setitem(INERTIAS, "lumped", INERTIAS["uniform"])


def _wrong_law(patch: pytest.MonkeyPatch) -> None:
    """K is right, D_i is not: its law is changed in the derivation."""
    right = InternalDamping.moment
    patch.setattr(InternalDamping, "moment", lambda *given: -2 * right(*given))


# What is wrong, with which rod, and the entry that proofs then name.
WRONG_TABLES = [
    (_wrong_root, HELD, "K"),
    (_wrong_root_damper, HELD, "D_i"),
    (_wrong_inertia, HELD, "M"),
    (_wrong_law, FREE, "D_i"),
]


@pytest.mark.parametrize("proof", PROOFS)
def test_every_proof_catches_a_wrong_clamp_wrong_masses_and_a_wrong_law(
    proof: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for wrong, rod_of, entry in WRONG_TABLES:
        with monkeypatch.context() as patch:
            wrong(patch)
            with pytest.raises(DisagreementError, match=rf"^{entry}\b"):
                list(PROOFS[proof](*rod_of, ("internal_damping",)))


def test_a_wrong_size_of_a_link_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """As k = EI l for EI / l would be: the matrices only know k."""
    right = symbols.discretisation()
    for size in ("m", "l", "k"):
        wrong = {x: value * (l**2 if str(x) == size else 1) for x, value in right.items()}
        monkeypatch.setattr(proof_any_n, "discretisation", lambda wrong=wrong: wrong)
        with pytest.raises(DisagreementError, match=r"^sizes\b"):
            list(PROOFS["any n"](*FREE, ()))


@pytest.mark.parametrize("quantity", [symbols.joint_x, symbols.joint_vy])
def test_wrong_sums_along_the_chain_are_caught(
    quantity: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """rhs is emitted from the running sums of derivation 2: they are proven too."""
    right = GeneralEquations.arrays.func

    def wrong(self: GeneralEquations) -> Any:
        arrays = right(self)
        array = arrays[quantity]
        (total,) = array.value.atoms(Sum)
        doubled = array.value.subs(total, Sum(2 * total.function, *total.limits))
        return {**arrays, quantity: replace(array, value=doubled)}

    monkeypatch.setattr(GeneralEquations, "arrays", property(wrong))
    with pytest.raises(DisagreementError, match=str(quantity)):
        list(PROOFS["explicit"](*FREE, ()))
    with pytest.raises(DisagreementError, match="joints"):
        list(PROOFS["any n"](*FREE, ()))


def test_scene_and_derivation_offer_the_same() -> None:
    """Laws and rows stand apart, since a scene is read without SymPy: they go together."""
    assert tuple(INERTIAS) == tuple(rod.INERTIAS)
    kinds = {
        terms.FORCE: PointForce,
        terms.COUPLE: PointMoment,
        terms.WEIGHT: MassForce,
        terms.DAMPER: (JointMoment, JointLaw),
        terms.CONTACT: Contact,
        terms.DRAG: JointDrag,
        terms.AIR: AirForce,
        terms.ANCHOR: (Foundation, Supports),
        terms.SPREAD: LinkForce,
        terms.BASE: Base,
    }
    for term, row in terms.TERMS.items():
        assert isinstance(LOADS[term], kinds[row.kind])
        assert LOADS[term].term == term
