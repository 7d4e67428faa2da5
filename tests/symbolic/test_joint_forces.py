"""Derivation 3 against derivation 1, exactly; and that the comparison sees what is wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from sympy import S, diff, zeros

from rodgen.derive import joint_force_system, tensions
from rodgen.derive.general import GeneralEquations
from rodgen.derive.joint_force_system import JointForceSystem, joint_system
from rodgen.derive.joint_system import BlockSystem, joint_ax, pull_x
from rodgen.derive.link_properties import INERTIAS, Rod
from rodgen.derive.loads import TERMS
from rodgen.derive.proofs import DisagreementError
from rodgen.derive.proofs import joint_force_proof as proof_joint_forces
from rodgen.derive.proofs.joint_force_proof import prove_joint_forces
from rodgen.derive.symbols import Array, l, m
from rodgen.derive.tensions import TensionSystem
from rodgen.model.rod import BOUNDARIES
from rodgen.model.terms import THESIS_TERMS
from tests.palette import can_move, cases


@cases("boundary, links, inertia", BOUNDARIES, (1, 2, 3), INERTIAS, where=can_move)
def test_accelerations_are_those_of_derivation_1(boundary: str, links: int, inertia: str) -> None:
    boundary_condition = BOUNDARIES[boundary]
    # Loads enter joint by joint: one alone is seen with one link (both ends at once) and with
    # three (an inner link between two), the links beyond repeat it; with either inertia in turn.
    odd = links == 3, inertia == "lumped"
    single = [(term,) for at, term in enumerate(TERMS) if links != 2 and (at + sum(odd)) % 2]
    for terms in ((), *single, TERMS):
        (held,) = prove_joint_forces(links, boundary, inertia, terms)
        assert held.entries == links - boundary_condition.first + 2 * boundary_condition.translates


Change = Callable[[BlockSystem], BlockSystem]


def _half_of(base: object) -> Change:
    def change(system: BlockSystem) -> BlockSystem:
        array: Array = system.arrays[base]
        half = replace(array, value=array.value / 2)
        return replace(system, arrays={**system.arrays, base: half})

    return change


WRONG_SYSTEMS: dict[str, tuple[str, Change]] = {
    "coupling turned round": ("uniform", lambda s: replace(s, coupling=-s.coupling)),
    "coupling of tensions": ("lumped", lambda s: replace(s, coupling=-s.coupling)),
    "no right-hand side": ("uniform", lambda s: replace(s, right=zeros(2, 1))),
    "diagonal": ("uniform", lambda s: replace(s, diagonal=2 * s.diagonal)),
    "diagonal of tensions": ("lumped", lambda s: replace(s, diagonal=2 * s.diagonal)),
    "tail not pulled": ("uniform", lambda s: replace(s, end=(S.Zero, S.Zero))),
    "start not pulled": ("uniform", lambda s: replace(s, start=(S.Zero, S.Zero))),
    "pull of the links": ("uniform", _half_of(pull_x)),
    "acceleration of joints": ("lumped", _half_of(joint_ax)),
    "turning": ("lumped", lambda s: replace(s, angular=-s.angular)),
    "base": ("uniform", lambda s: replace(s, base=tuple(2 * e for e in s.base))),
}


@pytest.mark.parametrize("wrong", WRONG_SYSTEMS)
def test_wrong_system_is_caught(wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    inertia, change = WRONG_SYSTEMS[wrong]
    monkeypatch.setattr(proof_joint_forces, "joint_system", lambda e: change(joint_system(e)))
    with pytest.raises(DisagreementError, match=r"accelerations\[\d\].*joint forces"):
        list(prove_joint_forces(3, "free", inertia, THESIS_TERMS))


WRONG_LAWS = {
    "no drag": ("load_on", "external_damping", lambda e: 0 * e),
    "tail load twice": ("tail_load", "tip_load", lambda e: 2 * e),
    "gravity upwards": ("weight_on", "gravity", lambda e: -e),
}


@cases("boundary, inertia, wrong", BOUNDARIES, INERTIAS, WRONG_LAWS)
def test_wrong_load_is_caught_where_the_scene_has_it(
    boundary: str, inertia: str, wrong: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What takes the place of a load in the forces on the joints, for either inertia."""
    name, term, change = WRONG_LAWS[wrong]
    for module in (joint_force_system, tensions):
        right = getattr(module, name)
        monkeypatch.setattr(
            module, name, lambda *a, right=right: tuple(change(e) for e in right(*a))
        )
    assert list(prove_joint_forces(2, boundary, inertia, ()))
    with pytest.raises(DisagreementError, match="joint forces"):
        list(prove_joint_forces(2, boundary, inertia, (term,)))


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_wrong_mass_of_a_joint_is_caught(boundary: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A third of a link's mass at its start."""
    monkeypatch.setattr(TensionSystem, "_end_masses", lambda self, link: (m / 3, m / 2))
    with pytest.raises(DisagreementError, match="joint forces"):
        list(prove_joint_forces(3, boundary, "lumped", ()))


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_wrong_centrifugal_terms_are_caught(boundary: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The rates of a cell without its squared velocity, in both forms."""
    link, bar = joint_force_system._derive_link, tensions._derive_bar
    uniform = link(Rod("uniform"), INERTIAS["uniform"])
    still = replace(uniform, end_rate=zeros(2, 1), start_rate=zeros(2, 1))
    monkeypatch.setattr(joint_force_system, "_derive_link", lambda *_: still)
    monkeypatch.setattr(tensions, "_derive_bar", lambda of: replace(bar(of), stretch=S.Zero))
    assert diff(bar(l).stretch, bar(l).omega) != 0
    for inertia in INERTIAS:
        with pytest.raises(DisagreementError, match="joint forces"):
            list(prove_joint_forces(3, boundary, inertia, ()))


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_lumped_links_have_joint_forces_too(boundary: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tensions are the shorter way, 2x2 blocks a third one to the same accelerations."""
    equations = GeneralEquations(boundary, "lumped", TERMS)
    assert joint_system(equations).unknowns == TensionSystem(equations).system.unknowns
    monkeypatch.setattr(proof_joint_forces, "joint_system", lambda e: JointForceSystem(e).system)
    assert list(prove_joint_forces(3, boundary, "lumped"))
