"""What turning a whole rod does to its motion, by the rates of the module itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import rodgen
from rodgen import Scene
from rodgen.analyse.cycles.symmetry import SymmetryReduction


def test_a_turned_free_rod_in_drag_moves_as_before_but_turned(
    make_scene: Callable[..., Scene],
) -> None:
    """In drag the velocity of joint 0 counts, and turns along. The rates of the turned state are
    those of the state itself, turned as a direction; so are derivatives of the turned states."""
    scene = make_scene(2, "free", ("external_damping", "follower"))
    model = rodgen.build(scene, "numpy")
    p, random, angle = model.parameters(**scene.parameters), np.random.default_rng(3), 0.7
    y = random.normal(size=len(model.STATE))
    quotient = SymmetryReduction.of(model, p, 0.0, y)
    assert quotient.turns
    assert len(quotient.velocity) == 2
    kept, x = quotient.kept, y[quotient.kept]

    def rates(x: np.ndarray) -> np.ndarray:
        return np.asarray(model.rhs(0.0, quotient.lift(x), p)[kept])

    here = quotient.rotate_columns(rates(x)[:, None], angle)[:, 0]
    np.testing.assert_allclose(
        rates(quotient.rotate(x, angle)), here, atol=1e-10 * np.abs(here).max()
    )
    # Velocities have turned by the angle that the links have.
    ahead, turned = (
        np.arctan2(*z[quotient.velocity][::-1]) for z in (x, quotient.rotate(x, angle))
    )
    assert np.isclose((turned - ahead) % (2 * np.pi), angle)
    v, h = random.normal(size=len(x)), 1e-6
    change = (quotient.rotate(x + h * v, angle) - quotient.rotate(x - h * v, angle)) / (2 * h)
    np.testing.assert_allclose(quotient.rotate_columns(v[:, None], angle)[:, 0], change, atol=1e-8)
