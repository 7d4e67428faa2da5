"""Motions with tangents in compiled steps: derivatives of the steps themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rodgen
from rodgen.integrate.stepper import StepError
from rodgen.integrate.variations import METHODS, PARTS, StepSettings, Variations
from rodgen.scene import Scene

SPAN, JUMP = 0.4, 0.13


@pytest.fixture(scope="module")
def scene(missile: Scene) -> Scene:
    """A thrust that jumps at a time, and dampings."""
    force = {"parameters.P": 40.0, "parameters.jump": JUMP, "parameters.new": -60.0}
    tight = {"span": [0.0, SPAN], "rtol": 1e-12, "atol": 1e-13}
    return missile.replace({**force, "rod.bending_stiffness": 300.0, "integrate": tight})


def _with(
    scene: Scene, y: np.ndarray | None = None, tangents: np.ndarray | None = None, **steps: object
) -> Variations:
    """In C, from the scene's state in all directions if not told otherwise."""
    model = rodgen.build(scene, "c", parts=PARTS)  # which is kept
    p, y = model.parameters(**scene.parameters), scene.initial_state() if y is None else y
    along = np.eye(len(y)) if tangents is None else tangents
    return Variations(model, p, 0.0, y, along, replace(StepSettings.of(scene), **steps))


def _moved(scene: Scene, at: int, by: float, **steps: object) -> np.ndarray:
    """The end of a motion that begins beside that of the scene."""
    y = scene.initial_state()
    y[at] += by
    on = _with(scene, y, np.empty((0, len(y))), **steps)
    on.advance_to(SPAN)
    return on.y


@pytest.mark.parametrize("method", METHODS)
def test_tangents_are_derivatives_of_the_steps(scene: Scene, method: str) -> None:
    """Of equal steps, differences are exact but for h^2 and rounding over h; where steps are
    chosen, the motion beside takes others, to the tolerance over h."""
    chosen = method in ("dop853", "radau")
    steps = {"method": method, "step": 0.0 if chosen else 0.0005}
    on, h = _with(scene, **steps), 1e-5
    assert on.advance_to(SPAN)
    for at, tangent in enumerate(on.tangents):
        ends = [_moved(scene, at, by, **steps) for by in (h, -h)]
        off = np.abs((ends[0] - ends[1]) / (2 * h) - tangent).max()
        assert off < (1e-6 if chosen else 1e-8) * np.abs(on.tangents).max()


def test_motion_is_that_of_a_run(scene: Scene) -> None:
    """The tangents have no part in the error control: as many steps, of which one ends where the
    load jumps, and the same state but for the rounding of another order of sums."""
    on = _with(scene)
    on.advance_to(SPAN)
    sol = rodgen.simulate(scene, target="c", method="dop853")
    assert on.counts[0] == sol.stats.nsteps
    np.testing.assert_allclose(on.y, sol.y[-1], rtol=1e-11, atol=1e-12)


def test_tangents_go_on_from_others(scene: Scene) -> None:
    """Exchanged on the way, they go on as their combinations do: the equations are linear."""
    whole, cut = _with(scene), _with(scene)
    whole.advance_to(SPAN)
    assert not cut.advance_to(SPAN, most=5)
    q, r = np.linalg.qr(cut.tangents.T)
    cut.tangents = q.T
    assert cut.advance_to(SPAN)
    np.testing.assert_array_equal(cut.y, whole.y)
    size = np.abs(whole.tangents).max()
    np.testing.assert_allclose(r.T @ cut.tangents, whole.tangents, atol=1e-12 * size)


def test_steps_of_scipy_agree(scene: Scene) -> None:
    """Where there is no compiler. The derivative of the external damping jumps inside of steps, and
    tangents have no error control: what is left is some 1e-7, not the tolerance."""
    here = _with(scene)
    model = rodgen.build(scene, "numpy")
    there = Variations.of(scene, model=model)
    assert not there.advance_to(0.2, most=3)
    there.tangents = there.tangents
    for on in (here, there):
        on.advance_to(SPAN)
    np.testing.assert_allclose(there.y, here.y, atol=1e-9)
    size = np.abs(here.tangents).max()
    np.testing.assert_allclose(there.tangents, here.tangents, atol=1e-6 * size)


def test_what_cannot_go_on_says_when(scene: Scene) -> None:
    on = _with(scene)
    on.tangents = np.full_like(on.tangents, 1e308)
    with pytest.raises(StepError, match=r"t = \d"):
        on.advance_to(SPAN)


def test_directions_are_as_long_as_the_state(scene: Scene) -> None:
    with pytest.raises(ValueError, match=r"tangents .*\(2, 2\)"):
        Variations.of(scene, np.eye(2))
