"""The derivations agree for rods that differ along their length: every joint or link its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from sympy import Expr

from rodgen.derive import generic_chain
from rodgen.derive.link_properties import Joint, Rod
from rodgen.derive.proofs import Comparison, DisagreementError, comparisons
from rodgen.derive.proofs.any_n import prove_any_n
from rodgen.derive.proofs.explicit_proof import prove_explicit
from rodgen.derive.proofs.joint_force_proof import prove_joint_forces
from rodgen.derive.proofs.rational_points import prove_at_points
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import THESIS_TERMS
from tests.palette import NONUNIFORM, carries, cases

# All that know the mass of a link or the stiffness of a joint.
LOADS = (*THESIS_TERMS, "material_damping")


@cases(
    "boundary, links, inertia, nonuniform",
    *(BOUNDARIES, (1, 3, 6), INERTIAS, NONUNIFORM),
    where=carries,
)
def test_all_derivations_agree(
    boundary: str, links: int, inertia: str, nonuniform: tuple[str, ...]
) -> None:
    held = list(comparisons(links, boundary, inertia, LOADS, links < 6, 6, nonuniform))
    assert {"M", "Q", "accelerations"} <= {c.name for c in held}


@pytest.mark.parametrize("boundary", ["clamped", "cantilever"])
def test_moments_of_springs_at_rest_are_compared(boundary: str) -> None:
    held = list(prove_explicit(3, boundary, "uniform", (), ("rest",)))
    assert [c.entries for c in held if c.name == "r"] == [3 - BOUNDARIES[boundary].first]


@pytest.mark.parametrize("what", ["stiffness", "rest"])
@pytest.mark.parametrize(
    ("prove", "links"), [(prove_any_n, ()), (prove_at_points, (70,)), (prove_joint_forces, (4,))]
)
def test_the_spring_of_another_joint_is_found(
    what: str,
    prove: Callable[..., Iterator[Comparison]],
    links: tuple[int, ...],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(generic_chain, "Rod", NextJoint)
    with pytest.raises(DisagreementError):
        list(prove(*links, "free", "uniform", (), (what,)))


class NextJoint(Rod):
    """A rod whose springs stand a joint too far."""

    def joint(self, at: Expr | int, size: int = 1) -> Joint:
        return super().joint(at + 1, size)
