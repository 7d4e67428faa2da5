"""Derivatives of the rates by the inputs of a module, against differences in 50 digits."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest

from rodgen.check.module_check import DIGITS, assemble
from rodgen.errors import InputError
from rodgen.loading import build
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built
from tests.palette import ENDS, PLACED, SMALL, short
from tests.sets import sets

# Laws of time and of the motion, each with a number that adds to its value.
LAWS = (
    ("follower_force", "20*exp(-t) + more"),
    ("follower_angle", "gimbal - 0.3*omega(0.4) + turned"),
    ("tip_force_y", "x(1)*phi(0) + lifted"),
)
ADDED = {"follower_force": "more", "follower_angle": "turned", "tip_force_y": "lifted"}
STEERED = Structure(
    3, "free", terms=ENDS, expressions=LAWS, states=(("gimbal", "(phi(1) - gimbal)/0.1"),)
)
ONE_AIR = ("fins@1+1/4+wind", "nose@0+1/3+wind", "axial_drag@wind")
FLYING = Structure(4, "free", terms=("follower", *ONE_AIR))


@pytest.mark.parametrize("form", ["chain", "dense"])
@pytest.mark.parametrize(
    "structure",
    sets([SMALL[1], SMALL[2], PLACED, STEERED, FLYING], slow=[*SMALL[4:], SMALL[0]]),
    ids=short,
)
def test_inputs_are_derivatives_in_fifty_digits(
    built: Built, point: type, structure: Structure, form: str
) -> None:
    """Every column to 1e-10 of its largest entry; of the two sides of a difference the third
    derivatives add 4e-17 of theirs."""
    module = built(structure, "numpy", form)
    at, h = point(module), 2.0**-26
    found = module.inputs(at.t, at.y, at.p)
    assert found.shape == (len(module.STATE), len(module.INPUTS))
    assert np.isfinite(found).all()
    for name, column in zip(module.INPUTS, found.T, strict=True):
        number = ADDED.get(name, name) if structure is STEERED else name
        with mpmath.workdps(DIGITS):
            sides = (
                assemble(
                    module,
                    at.values | {number: mpmath.mpf(at.values[number]) + way * h},
                    at.t,
                    at.y,
                ).rhs()
                for way in (1, -1)
            )
            exact = [float((a - b) / (2 * h)) for a, b in zip(*sides, strict=True)]
        # No input is far below the others: where nothing turns, what cancels is rounding.
        scale = max(np.abs(exact).max(), 1e-5 * np.abs(found).max())
        np.testing.assert_allclose(column, exact, atol=1e-10 * scale)


@pytest.mark.parametrize(
    "structure", sets([STEERED, FLYING, PLACED], slow=[SMALL[1], SMALL[6]]), ids=short
)
def test_outputs_are_derivatives_in_fifty_digits(
    built: Built, point: type, structure: Structure
) -> None:
    """What may be measured, along a direction of the state and by every input, to 1e-10."""
    module = built(structure, "numpy")
    at, h = point(module), 2.0**-26
    found = module.outputs(at.t, at.y, at.p)
    way = at.draw.choice([-1.0, 1.0], len(at.y))
    with mpmath.workdps(DIGITS):
        up, down = (_measures(module, at.values, at.t, at.y + x * h * way) for x in (1, -1))
        assert up.keys() == found.keys()
        for name, (by_state, _) in found.items():
            exact = [float((a - b) / (2 * h)) for a, b in zip(up[name], down[name], strict=True)]
            scale = max(1.0, np.abs(by_state).max())
            np.testing.assert_allclose(np.ravel(by_state @ way), exact, atol=1e-10 * scale)
        for number, given in enumerate(module.INPUTS):
            key = ADDED.get(given, given) if structure is STEERED else given
            up, down = (
                _measures(module, at.values | {key: mpmath.mpf(at.values[key]) + x * h}, at.t, at.y)
                for x in (1, -1)
            )
            for name, (_, by_inputs) in found.items():
                exact = [
                    float((a - b) / (2 * h)) for a, b in zip(up[name], down[name], strict=True)
                ]
                np.testing.assert_allclose(np.atleast_2d(by_inputs)[:, number], exact, atol=1e-10)


def _measures(module: Any, values: dict[str, Any], t: float, y: np.ndarray) -> dict[str, list[Any]]:
    """What may be measured, by the closed form in the present precision."""
    exact = assemble(module, values, t, y)
    x, y_ = ([joint[axis] for joint in exact.joints()] for axis in (0, 1))
    centre = exact.centre_of_gravity()
    found = {"joint_x": x, "joint_y": y_, "centre_x": [centre[0]], "centre_y": [centre[1]]}
    found["bending"] = exact.bending_moments()
    flow = exact.air()
    for along in (name for name in flow if name.startswith("along_")):
        load = along.removeprefix("along_")
        v, w = flow[along], flow[f"across_{load}"]
        found[f"airspeed_{load}"] = [mpmath.hypot(v, w)]
        found[f"attack_{load}"] = [mpmath.atan2(-w, -v)]
    return found


def test_a_rod_without_loads_has_no_inputs(built: Built) -> None:
    module = built(Structure(3, "free", terms=()), "numpy")
    assert module.INPUTS == ()
    y = np.zeros(len(module.STATE))
    values = {"mass": 1.0, "length": 1.0, "bending_stiffness": 1.0}
    assert module.inputs(0.0, y, module.parameters(**values)).shape == (len(y), 0)


def test_inputs_are_no_part_of_a_compiled_module() -> None:
    with pytest.raises(InputError, match="parts"):
        build(Structure(2, "pinned", terms=("gravity",)), "c", parts=("inputs",))
