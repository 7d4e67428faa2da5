"""A force on every link, wherever on it and however it turns, needs its law and no more."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from sympy import Expr, IndexedBase, Integer, Rational, Symbol, cos, sin

from rodgen.derive import symbols
from rodgen.derive.general import Equations
from rodgen.derive.loads import LOADS
from rodgen.derive.loads.link_force import LinkForce
from rodgen.derive.proofs import DisagreementError, comparisons
from rodgen.derive.symbols import joint, l, n, phi
from rodgen.model import terms
from rodgen.model.parameter import LINKS, Parameter
from rodgen.model.rod import BOUNDARIES, INERTIAS
from tests.palette import cases

Q = IndexedBase("side_pull", real=True)
F = Symbol("side_push", real=True)


class SidePull(LinkForce):
    """Turns with its link, and pulls at a third of it along and across."""

    letter = "S"
    share = Rational(1, 3)

    @property
    def term(self) -> str:
        return "side_pull"

    def force(self, angle: Expr, link: Expr) -> tuple[Expr, Expr]:
        return Q[link] * l * cos(angle) + F, 2 * Q[link] * l * sin(angle)


@pytest.fixture(autouse=True)
def side_pull(monkeypatch: pytest.MonkeyPatch) -> None:
    """Gives rods a load of one more term."""
    sizes = (
        Parameter(name="side_pull", key="force", label="", description="", each=LINKS),
        Parameter(name="side_push", key="push", label="", description=""),
    )
    row = terms.Term(
        name="side_pull",
        table="side_pull",
        kind=terms.SPREAD,
        label="side pull",
        description="force on every link",
        parameters=sizes,
    )
    monkeypatch.setitem(terms.TERMS, "side_pull", row)
    monkeypatch.setitem(symbols.PARAMETERS, "side_pull", Q)
    monkeypatch.setitem(symbols.PARAMETERS, "side_push", F)
    monkeypatch.setitem(LOADS, "side_pull", SidePull())


@cases("boundary, inertia, explicit", BOUNDARIES, INERTIAS, (True, False))
def test_derivations_agree_on_it(boundary: str, inertia: str, explicit: bool) -> None:
    held = [c.name for c in comparisons(3, boundary, inertia, ("side_pull",), explicit, 3)]
    assert held.count("S") == 2
    assert "accelerations" in held


@pytest.mark.parametrize(
    ("method", "where"),
    [("_law", "joint forces"), ("work", "any n"), ("rows", "explicit n")],
)
def test_a_force_on_another_place_is_caught(
    method: str, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In one derivation, the force stands in the middle of its link."""
    right: Callable[..., object] = getattr(SidePull, method)

    def spoilt(self: SidePull, *of: object) -> object:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(SidePull, "share", Rational(1, 2))
            return right(self, *of)

    monkeypatch.setattr(SidePull, method, spoilt)
    with pytest.raises(DisagreementError, match=where):
        list(comparisons(3, "free", "uniform", ("side_pull",), True, 3))


@pytest.mark.parametrize("boundary", ["free", "clamped"])
def test_newton_sees_how_it_turns(boundary: str) -> None:
    """On every joint, the law in the angles next to it is the force of derivation 3 there."""
    chain, links = Equations(boundary, "uniform", ("side_pull",)), 4
    for at in range(chain.hold.first_joint, links + 1):
        before, after = phi[at - 1] if at else None, phi[at] if at < links else None
        for force, near in LOADS["side_pull"].near(Integer(at), before, after, chain).items():
            there = chain.arrays[force.base].value.subs(n, links).subs(joint, at)
            assert near.subs(n, links) - there == 0
