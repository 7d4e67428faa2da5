"""Verdicts of stability against all eigenvalues: right ones pass, those made wrong do not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.confirm import Eigenvalues, contradiction, contradicts, onset_contradiction
from rodgen.analyse.family import BASIS, Family, family_of
from rodgen.analyse.modal import Motions
from rodgen.analyse.onset import Onset
from rodgen.analyse.search import Search
from rodgen.analyse.small_motions import Growing
from tests.analyse.rods import FORCE, ONES, THRUST, rod

DAMPED: dict[str, Any] = {"material_damping": {"time": 1e-3}}
DRAGGED: dict[str, Any] = {"external_damping": {"coefficient": 0.5}}
GROWING, CALM = 30.0, 5.0  # EI/L^2: Beck's column of a few links flutters between them
RODS = {
    "undamped": rod(4, "clamped", THRUST, **ONES),
    "damped": rod(4, "clamped", THRUST | DAMPED, **ONES),
    "many links": rod(220, "clamped", THRUST | DAMPED, **ONES),
}


def said(found: Motions, growth: float) -> Motions:
    """The same motions, of which the first grows so much and no other."""
    return Motions(found.s, np.where(np.arange(len(found.s)) == 0, growth, 0.0))


@pytest.mark.parametrize("name", RODS)
def test_what_is_made_wrong_is_doubted(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Calm where a motion grows, and growing where none does."""
    family = family_of(RODS[name])
    search = Search(family, np.array([CALM, GROWING]), BASIS, elastic=False)
    assert contradiction(search, [CALM, GROWING]) == ""
    each = Family.each
    for load, growth in ((GROWING, 0.0), (CALM, 3.0)):

        def wrong(self: Family, *args: Any, growth: float = growth) -> Any:
            return (said(found, growth) for found in each(self, *args))

        monkeypatch.setattr(Family, "each", wrong)
        assert contradiction(search, [load])


@pytest.mark.parametrize("name", RODS)
def test_an_onset_in_the_wrong_place_is_doubted(name: str) -> None:
    found = rodgen.critical_load(RODS[name])
    onset = Onset(found.value, 2j * np.pi * found.frequency, found.error)
    search = Search(family_of(RODS[name]), np.array([0.0, 2 * found.value]), BASIS, elastic=False)
    assert onset_contradiction(search, onset, begins=True) == ""
    assert onset_contradiction(search, onset, begins=False)
    assert onset_contradiction(search, replace(onset, force=0.9 * found.value), begins=True)


def test_zeros_of_the_whole_rod_are_no_growth() -> None:
    """Translation and turning of a free rod, whose matrix has blocks of up to four zeros, which
    rounding splits."""
    for loads in (THRUST, THRUST | DAMPED, THRUST | DRAGGED):
        family = family_of(rod(5, "free", loads, **ONES))
        for load in (0.0, 1.0, 50.0):
            assert Eigenvalues.of(family.equations(load), family.lowest).count == 0


def test_the_lowest_modes_of_a_dragged_free_rod_do() -> None:
    """They are those of the rod without drag and two of the whole: 16 give what all do."""
    family = family_of(rod(30, "free", THRUST | DRAGGED, **ONES))
    loads = np.array([100.0, 115.0])
    few, whole = (family.motions(loads, modes).growth.max(axis=1) for modes in (16, family.whole))
    assert few[0] == whole[0] == 0.0
    # Of the shape that grows 14 elastic modes leave out less than a hundredth.
    assert few[1] == pytest.approx(whole[1], rel=1e-2)


def test_a_free_rod_turns_over_under_any_dead_push() -> None:
    """Against its motion, however small; and under none that pulls."""
    for links in (2, 5):
        scene = rod(links, "free", {"tip": {"x": -1.0}}, **ONES)
        assert rodgen.critical_load(scene, load="tip").value == 0.0
        family = family_of(scene, load="tip")
        pulled = Eigenvalues.of(family.equations(-1.0), family.lowest)
        assert pulled.count == 0
        assert not contradicts(pulled, next(family.each(np.array([-1.0]))), family.lowest)


def test_a_branch_that_is_counted_wrongly_has_no_stability(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    motions = Growing.motions
    monkeypatch.setattr(Growing, "motions", lambda self, state: said(motions(self, state), 0.0))
    branch = continue_equilibria(RODS["damped"], FORCE, (CALM, GROWING), step=0.2)
    assert (branch["unstable"] == -1).all()
    assert any("stability" in note for note in map(str, branch.rodgen.doubts))
