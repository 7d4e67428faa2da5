"""A force on any point of the rod or on every link, dead or turning, needs its law and no more."""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType

import pytest
from sympy import Expr, Indexed, IndexedBase, Integer, Rational, S, Symbol, cos, sin

from rodgen.derive import symbols
from rodgen.derive.general import GeneralEquations
from rodgen.derive.loads import LOADS
from rodgen.derive.loads.link_force import LinkForce
from rodgen.derive.loads.point_force import LinkPoint, PointForce
from rodgen.derive.proofs import DisagreementError, comparisons
from rodgen.derive.symbols import joint, l, n, phi
from rodgen.model import terms
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.term import LINKS, Parameter
from tests.palette import cases

SIZE = Symbol("side_force", real=True)
EACH = IndexedBase("side_pull", real=True)
PARAMETERS = (
    Parameter("side_force", "force", "side force", "", "", "at a point"),
    Parameter("side_pull", "pull", "side pull", "", "", "", each=LINKS),
)
POINTS = MappingProxyType(
    {
        "joint 0": LinkPoint(Integer(0), S.Zero),
        "joint 1": LinkPoint(Integer(0)),
        "joint before the tail": LinkPoint(n - 1, S.Zero),
        "a third of link 1": LinkPoint(Integer(1), Rational(1, 3)),
        "a third of the last link": LinkPoint(n - 1, Rational(1, 3)),
    }
)
PLACES = (*POINTS, "every link")
LAWS: dict[str, Callable[[Expr], tuple[Expr, Expr]]] = {
    "dead": lambda angle: (2 * SIZE, -SIZE),
    "turning": lambda angle: (SIZE * cos(angle), 3 * SIZE * sin(angle)),
}


class SidePull(LinkForce):
    """Turns with its link, and pulls at a third of it along and across."""

    letter = "S"
    share = Rational(1, 3)
    term = "side_load"

    def force(self, angle: Expr, link: Expr) -> tuple[Expr, Expr]:
        return EACH[link] * l * cos(angle) + SIZE, 2 * EACH[link] * l * sin(angle)


Give = Callable[[str, str], None]


@pytest.fixture
def give(monkeypatch: pytest.MonkeyPatch) -> Give:
    """Gives rods a load of one more term, side_load, at a place and of a law that are named."""

    def load(place: str, law: str) -> None:
        class SideLoad(PointForce):
            letter = "S"
            term = "side_load"
            point = POINTS.get(place)

            def force(self, angle: Expr) -> tuple[Expr, Expr]:
                return LAWS[law](angle)

        row = terms.Term(
            "side_load",
            "side",
            "side load",
            "",
            terms.FORCE if place in POINTS else terms.SPREAD,
            "a force",
            parameters=PARAMETERS[: 1 if place in POINTS else 2],
        )
        monkeypatch.setitem(terms.TERMS, "side_load", row)
        monkeypatch.setitem(symbols.PARAMETERS, "side_force", SIZE)
        monkeypatch.setitem(symbols.PARAMETERS, "side_pull", EACH)
        monkeypatch.setitem(LOADS, "side_load", SideLoad() if place in POINTS else SidePull())

    return load


def has(place: str, law: str, *_: object) -> bool:
    return place in POINTS or law == "turning"


@cases(
    "place, law, boundary, inertia, explicit",
    *(PLACES, LAWS, BOUNDARIES, INERTIAS, (True, False)),
    where=has,
)
def test_derivations_agree_on_it(
    give: Give, place: str, law: str, boundary: str, inertia: str, explicit: bool
) -> None:
    give(place, law)
    held = [c.name for c in comparisons(3, boundary, inertia, ("side_load",), explicit, 3)]
    assert held.count("S") == 2
    assert "accelerations" in held


@cases("place, law", POINTS, LAWS)
def test_a_wrong_share_is_caught(
    give: Give, place: str, law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Derivation 3 with the whole force a joint too far."""
    give(place, law)
    right = LinkPoint.parts.fget
    assert right is not None
    monkeypatch.setattr(
        LinkPoint, "parts", property(lambda self: [(a + 1, x) for a, x in right(self)])
    )
    with pytest.raises(DisagreementError, match="joint forces"):
        list(comparisons(3, "free", "uniform", ("side_load",), False, 3))


@pytest.mark.parametrize(
    ("method", "where"),
    [
        ("_force_at_joint", "joint forces"),
        ("generalised_forces", "any n"),
        ("explicit_forces", "explicit n"),
    ],
)
def test_a_force_on_another_place_of_its_link_is_caught(
    give: Give, method: str, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In one derivation, the force stands in the middle of its link."""
    give("every link", "turning")
    right: Callable[..., object] = getattr(SidePull, method)

    def spoilt(self: SidePull, *of: object) -> object:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(SidePull, "share", Rational(1, 2))
            return right(self, *of)

    monkeypatch.setattr(SidePull, method, spoilt)
    with pytest.raises(DisagreementError, match=where):
        list(comparisons(3, "free", "uniform", ("side_load",), True, 3))


@cases("place, law, boundary", PLACES, LAWS, ["free", "clamped"], where=has)
def test_newton_sees_how_it_turns(give: Give, place: str, law: str, boundary: str) -> None:
    """On every joint, the law in the angles next to it is the force of derivation 3 there."""
    give(place, law)
    links, load = 4, LOADS["side_load"]
    chain = GeneralEquations(boundary, "uniform", ("side_load",))
    for at in range(chain.boundary_condition.first_joint, links + 1):

        def there(element: Indexed, at: int = at) -> Expr:
            return chain.arrays[element.base].value.subs(n, links).subs(joint, at)

        before, after = phi[at - 1] if at else None, phi[at] if at < links else None
        laws = load.joint_laws(Integer(at), before, after, chain)
        assert bool(laws) == (law == "turning" and bool(load.joint_arrays(chain)))
        for force, near in laws.items():
            shares = [e for e in near.atoms(Indexed) if e.base in chain.arrays]
            found = near.subs(n, links).xreplace({e: there(e) for e in shares})
            assert found - there(force) == 0
