"""Branches of cycles that begin in the special points of others."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.cycles.cycle_continuation import continue_cycles
from rodgen.analyse.cycles.periodic_motion import find_cycle
from rodgen.errors import InputError
from rodgen.scene import Scene
from tests.analyse.rods import COLUMN, FORCE, ONES

AMPLITUDE = "parameters.a"
# A link on a spring that swings with 2.449 rad/s, pressed with twice that frequency: beyond a
# threshold it swings at its own, parametrically; a small side load makes it move below it too.
PRESSED: dict[str, Any] = {
    "name": "pressed",
    "rod": ONES | {"links": 1, "boundary": "clamped"},
    "loads": {"internal_damping": {"coefficient": 0.05}, "tip": {"x": "a*sin(4.9*t)", "y": 0.3}},
    "parameters": {"a": 0.45},
    "initial": {"phi": 0.1},
    "integrate": {"span": [0.0, 60.0]},
}


def _pressed(a: float) -> Scene:
    return Scene.from_dict(PRESSED | {"parameters": {"a": a}})


@pytest.fixture(scope="module")
def doubled() -> Any:
    return continue_cycles(
        _pressed(0.45), AMPLITUDE, (0.4, 0.7), start="run", branch_point=1, max_points=12
    )


@pytest.mark.slow
def test_cycles_of_twice_the_period_go_from_a_period_doubling(doubled: Any) -> None:
    assert list(doubled["special_kind"].values) == ["period doubling"]
    np.testing.assert_allclose(doubled["period"].values, 2 * 2 * np.pi / 4.9, rtol=1e-12)
    # Beyond the threshold, which is that of Mathieu's equation with damping but for what the side
    # load does to it: a k/2 > 4 zeta, k = 2, with zeta = 6 c / (2 w), to first order in both.
    begins = float(doubled["special_value"][0])
    assert begins == pytest.approx(4 * 2 * 0.05 * 3 / 2.449, rel=0.05)
    # Its square grows with the distance from there, by which it is a branch of its own.
    value, amplitude = (doubled[name].values for name in ("value", "amplitude"))
    assert (np.diff(value) > 0).all()
    assert amplitude[-1] > 3 * amplitude[0]
    assert (doubled["unstable"].values == 0).all()
    with pytest.raises(InputError, match=r"^branch_point = 1"):  # nothing doubles there
        continue_cycles(
            _pressed(0.45), AMPLITUDE, (0.44, 0.46), start="run", branch_point=1, max_points=3
        )


@pytest.mark.slow
def test_a_run_settles_on_the_doubled_cycle(doubled: Any) -> None:
    """Beyond the doubling the cycle of a single period is unstable, and nothing else is stable."""
    value = float(doubled["value"][-1])
    found = find_cycle(_pressed(value))
    assert found.period == pytest.approx(float(doubled["period"][-1]), rel=1e-12)
    mu = doubled["multipliers"].values[-1]
    expected = np.sort(np.abs(mu[:, 0] + 1j * mu[:, 1]))
    np.testing.assert_allclose(np.sort(np.abs(found.nontrivial)), expected, atol=1e-7)


@pytest.mark.slow
def test_cycles_begin_in_a_hopf_point_of_a_branch_of_equilibria() -> None:
    """That which the search along the equilibrium finds."""
    scene, ends = COLUMN, (8.0, 22.0)
    branch = continue_equilibria(scene, FORCE, ends)
    number = branch["special_kind"].values.tolist().index("hopf") + 1
    found = continue_cycles(scene, FORCE, ends, start=branch, point=number, max_points=3)
    expected = continue_cycles(scene, FORCE, ends, max_points=3)
    for name in ("special_value", "special_frequency"):
        assert float(found[name][0]) == pytest.approx(float(expected[name][0]), rel=1e-9)
    assert found.attrs["lyapunov"] == pytest.approx(expected.attrs["lyapunov"], rel=1e-6)
    np.testing.assert_allclose(found["period"].values, expected["period"].values, rtol=1e-7)
    for at in (number + 1, "first"):
        with pytest.raises(InputError, match=r"^point = "):
            continue_cycles(scene, FORCE, ends, start=branch, point=at)
    key = "loads.internal_damping.coefficient"
    with pytest.raises(InputError, match=rf"^start = '{FORCE}'"):
        continue_cycles(scene, key, (0.1, 0.4), start=branch, point=number)


@pytest.mark.nightly  # a branch of a free rod of ten links, twice
def test_a_free_rod_that_turns_with_every_period() -> None:
    """From the branch point at 95.097 N cycles go that turn either way: mirror images."""
    scene = Scene.example("free_rod_after_flutter")
    found = continue_cycles(
        scene, "loads.follower.force", (75.0, 110.0), branch_point=2, max_points=40
    )
    assert float(found["special_value"][0]) == pytest.approx(95.0972543, rel=1e-8)
    angle, value = found["angle"].values, found["value"].values
    at = int(np.abs(angle).argmin())
    assert abs(angle[at]) < 1e-6
    assert (np.diff(np.abs(angle[at : at + 20])) > 0).all()
    assert np.sign(angle[0]) == -np.sign(angle[-1])
    # As long a step, but not to the digit: the phase is that of the last point, which differs.
    np.testing.assert_allclose(value[:at][::-1][:4], value[at + 1 :][:4], rtol=1e-5)
    assert (found["unstable"].values[at + 1 : at + 20] == 0).all()
