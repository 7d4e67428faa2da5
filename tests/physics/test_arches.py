"""Rods in the shape of an arch: what their symmetry, and the circle that they lie on, say of the
forces and the curvature in their joints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from rodgen.integrate.catalogue import Piece

Make = Callable[..., Scene]


def piece_of(scene: Scene) -> Piece:
    model = rodgen.build(scene, "numpy")
    p = model.parameters(**scene.parameters)
    return Piece(model, p, scene.initial_state(), np.array(0.0))


@pytest.mark.parametrize("inertia", ["uniform", "lumped"])
def test_no_shear_in_the_middle_of_an_arch_that_folds(make_scene: Make, inertia: str) -> None:
    """Half the arch pushes the other, of which it is the mirror image, along the line that both
    lie even to, whatever the angles of their links."""
    start = {"phi": [0.7, -0.7], "omega": [2.0, -2.0]}
    piece = piece_of(make_scene(2, "free", (), {"inertia": inertia}, start))
    (axial,), (shear,) = piece.values("axial_force"), piece.values("shear_force")
    assert abs(axial) > 1.0
    assert shear == pytest.approx(0.0, abs=1e-12 * abs(axial))


def test_a_circle_has_one_curvature_from_the_root_on(make_scene: Make) -> None:
    """Links that are chords of a circle turn by the angle of one from each to the next, and by half
    of it from the tangent in the clamp to the first."""
    links, length, curvature, clamp = 3, 2.0, -0.8, 0.3
    turns = clamp + curvature * length / links * (np.arange(links) + 0.5)
    rod = {"clamp_angle": clamp, "length": length}
    piece = piece_of(make_scene(links, "clamped", (), rod, {"phi": turns.tolist(), "omega": 0.0}))
    np.testing.assert_allclose(piece.values("curvature"), curvature, rtol=1e-12)
