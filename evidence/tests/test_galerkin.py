"""Beck's column with a tip mass in a few shapes: known loads of the continuum, and the normal form
of the rods of links."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rodgen
from rodgen_evidence.figures.cycle_figures import onset, rod
from rodgen_evidence.galerkin import GalerkinColumn, bare, own, polynomials

SCENES = Path(__file__).parents[2] / "scenes"
COLUMN = (0.3, 0.1, 70.0, 0.01)  # mass, inertia, external and internal damping of tip_mass.toml


def test_flutter_begins_where_that_of_becks_column_does() -> None:
    """At 20.0509 EI/L^2 (Beck 1952), with a little damping that all modes share alike."""
    assert GalerkinColumn(polynomials(8), 0, 0, 1e-4, 0).onset().force == pytest.approx(
        20.0509, abs=1e-4
    )


@pytest.mark.nightly
def test_rods_of_many_links_turn_as_the_column_does() -> None:
    """By two normal forms that share nothing. Errors of the links fall as 1/n^2, those that are
    left of 20 and 40 links as 1/n^3."""
    scene = rodgen.Scene.from_toml(SCENES / "tip_mass.toml")
    column = GalerkinColumn(polynomials(8), 0.3, 0.03, 1.0, 0.001)
    found = [onset(rod(scene, links, column), (7.0, 12.0)) for links in (20, 40)]
    coarse, fine = (np.array([one.force, one.frequency, one.turn]) for one in found)
    there = column.onset()
    np.testing.assert_allclose(
        (4 * fine - coarse) / 3, [there.force, there.frequency, there.turn], rtol=1e-3
    )


@pytest.mark.nightly
def test_much_external_damping_turns_flutter() -> None:
    """Supercritical with 10, subcritical with 70: eight shapes, ten, and the scene's rod agree."""
    few, many = (
        GalerkinColumn(polynomials(8), *COLUMN[:2], c, COLUMN[3]).onset() for c in (10.0, 70.0)
    )
    assert few.turn > 0 > many.turn
    more = GalerkinColumn(polynomials(10), *COLUMN).onset()
    assert more.turn == pytest.approx(many.turn, rel=1e-3)  # what two more shapes change: 1.4e-4
    scene = rodgen.Scene.from_toml(SCENES / "tip_mass.toml")
    calmer = rod(scene, 10, GalerkinColumn(polynomials(8), *COLUMN[:2], 10.0, COLUMN[3]))
    assert onset(scene).turn < 0 < onset(calmer).turn


def test_two_shapes_of_the_bare_column_turn_too_early() -> None:
    """Subcritical for little external damping, where two shapes with the tip mass are not."""
    numbers = (0.3, 0.03, 1.0, 0.001)
    assert GalerkinColumn(bare(2), *numbers).onset().turn < 0
    for shapes in (own(2, *numbers[:2]), own(6, *numbers[:2]), polynomials(8)):
        assert GalerkinColumn(shapes, *numbers).onset().turn > 0
