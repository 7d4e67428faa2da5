"""A force on any point of the rod, dead or turning with its link, needs its law and no more."""

from collections.abc import Callable
from types import MappingProxyType

import pytest
from sympy import Expr, Indexed, Integer, Rational, S, Symbol, cos, sin

from rodgen.derive import symbols
from rodgen.derive.general import Equations
from rodgen.derive.loads import LOADS
from rodgen.derive.loads.point_force import Point, PointForce
from rodgen.derive.proofs import DisagreementError, comparisons
from rodgen.derive.symbols import joint, n, phi
from rodgen.model import terms
from rodgen.model.parameter import Parameter
from rodgen.model.rod import BOUNDARIES, INERTIAS
from tests.palette import cases

SIZE = Symbol("side_force", real=True)
POINTS = MappingProxyType(
    {
        "joint 0": Point(Integer(0), S.Zero),
        "joint 1": Point(Integer(0)),
        "joint before the tail": Point(n - 1, S.Zero),
        "a third of link 1": Point(Integer(1), Rational(1, 3)),
        "a third of the last link": Point(n - 1, Rational(1, 3)),
    }
)


def _dead(angle: Expr) -> tuple[Expr, Expr]:
    return 2 * SIZE, -SIZE


def _turning(angle: Expr) -> tuple[Expr, Expr]:
    return SIZE * cos(angle), 3 * SIZE * sin(angle)


LAWS = {"dead": _dead, "turning": _turning}


@pytest.fixture
def side_load(monkeypatch: pytest.MonkeyPatch) -> Callable[[str, str], str]:
    """Gives rods a load of one more term, at a point and of a law that are named."""

    def give(point_name: str, law: str) -> str:
        class SideLoad(PointForce):
            letter = "S"
            term = "side_load"
            point = POINTS[point_name]

            def force(self, angle: Expr) -> tuple[Expr, Expr]:
                return LAWS[law](angle)

        size = Parameter(
            name="side_force", key="force", label="side force", description="at a point"
        )
        row = terms.Term(
            name="side_load",
            table="side",
            kind=terms.FORCE,
            label="side load",
            description="force at a point",
            parameters=(size,),
        )
        monkeypatch.setitem(terms.TERMS, "side_load", row)
        monkeypatch.setitem(symbols.PARAMETERS, "side_force", SIZE)
        monkeypatch.setitem(LOADS, "side_load", SideLoad())
        return "side_load"

    return give


Give = Callable[[str, str], str]


@cases(
    "point, law, boundary, inertia, explicit",
    *(POINTS, LAWS, BOUNDARIES, INERTIAS, (True, False)),
)
def test_derivations_agree_on_it(
    side_load: Give, point: str, law: str, boundary: str, inertia: str, explicit: bool
) -> None:
    name = side_load(point, law)
    held = [c.name for c in comparisons(3, boundary, inertia, (name,), explicit, 3)]
    assert held.count("S") == 2
    assert "accelerations" in held


@cases("point, law", POINTS, LAWS)
def test_a_wrong_share_is_caught(
    side_load: Give, point: str, law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Derivation 3 with the whole force a joint too far."""
    name, right = side_load(point, law), Point.parts.fget
    assert right is not None
    monkeypatch.setattr(Point, "parts", property(lambda self: [(a + 1, x) for a, x in right(self)]))
    with pytest.raises(DisagreementError, match="joint forces"):
        list(comparisons(3, "free", "uniform", (name,), False, 3))


@cases("point, law, boundary", POINTS, LAWS, ["free", "clamped"])
def test_newton_sees_how_it_turns(side_load: Give, point: str, law: str, boundary: str) -> None:
    """On every joint, the law in the angles next to it is the force of derivation 3 there."""
    name, links = side_load(point, law), 4
    chain, load = Equations(boundary, "uniform", (name,)), LOADS[name]
    for at in range(chain.hold.first_joint, links + 1):

        def there(element: Indexed, at: int = at) -> Expr:
            return chain.arrays[element.base].value.subs(n, links).subs(joint, at)

        before, after = phi[at - 1] if at else None, phi[at] if at < links else None
        laws = load.near(Integer(at), before, after, chain)
        assert bool(laws) == (law == "turning" and bool(load.arrays(chain)))
        for force, near in laws.items():
            shares = [e for e in near.atoms(Indexed) if e.base in chain.arrays]
            assert near.subs(n, links).xreplace({e: there(e) for e in shares}) == there(force)
