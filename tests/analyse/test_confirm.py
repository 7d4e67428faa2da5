"""Verdicts of stability against all eigenvalues: right ones pass, those made wrong do not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.eigenvalue_check import (
    FullSpectrum,
    find_contradiction,
    find_onset_contradiction,
    is_contradiction,
)
from rodgen.analyse.load_family import BASIS, LoadFamily
from rodgen.analyse.modal import ModalMotions
from rodgen.analyse.onset import LoadSearch, Onset
from rodgen.analyse.scene_family import load_family
from rodgen.analyse.small_motions import SmallMotions
from tests.analyse.rods import FORCE, ONES, THRUST, rod

DAMPED: dict[str, Any] = {"material_damping": {"time": 1e-3}}
DRAGGED: dict[str, Any] = {"external_damping": {"coefficient": 0.5}}
GROWING, CALM = 30.0, 5.0  # EI/L^2: Beck's column of a few links flutters between them
RODS = {
    "undamped": rod(4, "clamped", THRUST, **ONES),
    "damped": rod(4, "clamped", THRUST | DAMPED, **ONES),
    "many links": rod(220, "clamped", THRUST | DAMPED, **ONES),
}


def said(found: ModalMotions, growth: float) -> ModalMotions:
    """The same motions, of which the first grows so much and no other."""
    return ModalMotions(found.s, np.where(np.arange(len(found.s)) == 0, growth, 0.0))


@pytest.mark.parametrize("name", RODS)
def test_what_is_made_wrong_is_doubted(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Calm where a motion grows, and growing where none does."""
    family = load_family(RODS[name])
    search = LoadSearch(family, np.array([CALM, GROWING]), BASIS, elastic=False)
    assert find_contradiction(search, [CALM, GROWING]) == ""
    each = LoadFamily.iterate_motions
    for load, growth in ((GROWING, 0.0), (CALM, 3.0)):

        def wrong(self: LoadFamily, *args: Any, growth: float = growth) -> Any:
            return (said(found, growth) for found in each(self, *args))

        monkeypatch.setattr(LoadFamily, "iterate_motions", wrong)
        assert find_contradiction(search, [load])


@pytest.mark.parametrize("name", RODS)
def test_an_onset_in_the_wrong_place_is_doubted(name: str) -> None:
    found = rodgen.critical_load(RODS[name])
    onset = Onset(found.value, 2j * np.pi * found.frequency, found.error)
    search = LoadSearch(
        load_family(RODS[name]), np.array([0.0, 2 * found.value]), BASIS, elastic=False
    )
    assert find_onset_contradiction(search, onset, begins=True) == ""
    assert find_onset_contradiction(search, onset, begins=False)
    assert find_onset_contradiction(search, replace(onset, force=0.9 * found.value), begins=True)


def test_zeros_of_the_whole_rod_are_no_growth() -> None:
    """Translation and turning of a free rod, whose matrix has blocks of up to four zeros, which
    rounding splits."""
    for loads in (THRUST, THRUST | DAMPED, THRUST | DRAGGED):
        family = load_family(rod(5, "free", loads, **ONES))
        for load in (0.0, 1.0, 50.0):
            assert (
                FullSpectrum.of(family.dense_pencil(load), family.lowest_frequency).n_growing == 0
            )


def test_the_lowest_modes_of_a_dragged_free_rod_do() -> None:
    """They are those of the rod without drag and two of the whole: 16 give what all do."""
    family = load_family(rod(30, "free", THRUST | DRAGGED, **ONES))
    loads = np.array([100.0, 115.0])
    few, whole = (family.motions(loads, modes).growth.max(axis=1) for modes in (16, family.n_modes))
    assert few[0] == whole[0] == 0.0
    # Of the shape that grows 14 elastic modes leave out less than a hundredth.
    assert few[1] == pytest.approx(whole[1], rel=1e-2)


def test_a_free_rod_turns_over_under_any_dead_push() -> None:
    """Against its motion, however small; and under none that pulls."""
    for links in (2, 5):
        scene = rod(links, "free", {"tip": {"x": -1.0}}, **ONES)
        assert rodgen.critical_load(scene, load="tip").value == 0.0
        family = load_family(scene, load="tip")
        pulled = FullSpectrum.of(family.dense_pencil(-1.0), family.lowest_frequency)
        assert pulled.n_growing == 0
        assert not is_contradiction(
            pulled, next(family.iterate_motions(np.array([-1.0]))), family.lowest_frequency
        )


def test_a_branch_that_is_counted_wrongly_has_no_stability(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    motions = SmallMotions.motions
    monkeypatch.setattr(
        SmallMotions, "motions", lambda self, state: said(motions(self, state), 0.0)
    )
    branch = continue_equilibria(RODS["damped"], FORCE, (CALM, GROWING), step=0.2)
    assert (branch["unstable"] == -1).all()
    assert any("stability" in note for note in map(str, branch.rodgen.doubts))
