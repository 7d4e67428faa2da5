"""Parameters along a number of a scene: their derivatives, and beyond both ends."""

from __future__ import annotations

import numpy as np
import pytest

from rodgen.system import ParameterRange, System
from tests.analyse.rods import ONES, rod

KEY = "supports.0.stiffness.1"


def along(supports: list[dict[str, object]], bounds: tuple[float, float]) -> ParameterRange:
    scene = rod(4, "clamped", {"follower": {"force": 1.0}}, supports=supports, **ONES)
    return ParameterRange(System(scene), KEY, bounds)


def support(stiffness: float, y: float) -> dict[str, object]:
    return {"at": 0.5, "stiffness": [0.0, stiffness], "to": [0.5, y]}


@pytest.mark.parametrize("count", [1, 2], ids=["linear", "not linear"])
@pytest.mark.parametrize("value", [0.0, 2.0, 3.999])
def test_derivatives_by_a_stiffness(count: int, value: float) -> None:
    """Two supports at one point act as one, at the mean of both fixed points by stiffness; at the
    ends of the range too, beyond which the scene refuses a stiffness."""
    numbers = along([support(2.0, 0.1), support(3.0, 0.4)][:count], (0.0, 4.0))
    found = sum(share * p for p, share in numbers.difference_points(value)) / numbers.unit
    step = 1e-4  # of a difference of second order
    first, second, third = (numbers.parameters(value + k * step) for k in range(3))
    due = (4 * second - 3 * first - third) / (2 * step)
    assert np.abs(due).max() > 0
    np.testing.assert_allclose(found, due, atol=1e-8)


def test_beyond_a_value_that_the_scene_refuses() -> None:
    numbers = along([support(2.0, 0.1)], (0.0, 4.0))
    low, high = (numbers.parameters(value) for value in (0.0, 4.0))
    np.testing.assert_allclose(numbers.parameters(-1.0), low - (high - low) / 4, atol=1e-14)
