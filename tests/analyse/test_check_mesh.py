"""What an answer says of twice as many links."""

from __future__ import annotations

from typing import Any

import pytest

import rodgen
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.curves.mesh_check import add_mesh_doubts, cycle_doubts
from rodgen.analyse.cycles.periodic_motion import find_cycle
from rodgen.errors import AnalysisError
from rodgen.result import Note
from tests.analyse.rods import FORCE, ONES, THRUST, ZIEGLER, rod
from tests.told import numbers, refused

COLUMN = rod(4, "clamped", THRUST | {"material_damping": {"time": 0.01}}, **ONES)


@pytest.mark.slow
def test_a_branch_tells_of_a_hopf_point_that_moves() -> None:
    """To the critical forces of both meshes; of finer ones, where it does not, nothing."""
    branch = continue_equilibria(COLUMN, FORCE, (1.0, 20.0), check_mesh=True)
    (note,) = branch.rodgen.doubts
    due = [rodgen.critical_load(COLUMN.with_links(n)).value for n in (4, 8)]
    assert numbers(note) == pytest.approx([due[0], 4, due[1], 8], rel=1e-5)  # six digits are shown
    fine = continue_equilibria(COLUMN.with_links(24), FORCE, (1.0, 20.0), check_mesh=True)
    assert fine.rodgen.notes == ()


def test_what_is_of_another_kind_is_told() -> None:
    """The way cycles go, which points there are, what is unstable at the end, and that there is
    none at all."""
    branch = continue_equilibria(COLUMN, FORCE, (1.0, 20.0)).assign_attrs(supercritical=1)

    def notes(other: Any) -> tuple[Note, ...]:
        found: tuple[Note, ...] = add_mesh_doubts(branch, 4, lambda: other).rodgen.doubts
        return found

    assert notes(branch) == ()
    assert len(notes(branch.assign_attrs(supercritical=0))) == 1
    assert len(notes(branch.isel(special=slice(0, 0)))) == 1
    assert len(notes(branch.assign(unstable=branch["unstable"] + 2))) == 1

    def none() -> Any:
        raise AnalysisError("no state to start with")

    assert len(add_mesh_doubts(branch, 4, none).rodgen.doubts) == 1
    assert len(cycle_doubts(find_cycle(ZIEGLER), 3, none)) == 1


def test_a_cycle_tells_of_what_changes() -> None:
    """Three links against six, whose cycle is found by itself as well."""
    scene = ZIEGLER.replace({"initial.phi": "0.2*s"})
    found = find_cycle(scene, check_mesh=True)
    other = find_cycle(scene.with_links(6))
    due = [found.period, 3, other.period, 6]
    assert any(numbers(note) == pytest.approx(due, rel=1e-5) for note in found.notes)
    assert find_cycle(scene).notes == ()


@pytest.mark.parametrize("key", ["rod.links", "loads.internal_damping.coefficient"])
def test_a_key_of_the_mesh_is_refused(key: str) -> None:
    told = refused(continue_equilibria, ZIEGLER, key, (2, 4), check_mesh=True)
    assert told.field == "check_mesh"
