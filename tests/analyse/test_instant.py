"""When loads that change with time are taken: by default at the start, never outside the span."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.scene import Scene
from rodgen.system.freezing import load_time
from tests.analyse.rods import rod

BURN = "300 if t < 5 else 0"  # a burn of 5 s in a span of 8 s


def timed(loads: dict[str, Any], span: tuple[float, float] = (0.0, 8.0)) -> Scene:
    return rod(5, "clamped", loads, integrate={"span": list(span)})


def test_loads_are_those_at_the_start() -> None:
    """The thrust of a burn is there; a load given as a number is the other route."""
    changing = timed({"tip": {"x": "-2 if t < 5 else 0", "y": "3 - t/8"}})
    constant = rod(5, "clamped", {"tip": {"x": -2.0, "y": 3.0}})
    found = rodgen.static_equilibrium(changing)
    np.testing.assert_array_equal(found.phi, rodgen.static_equilibrium(constant).phi)
    assert found.t == 0
    modes = rodgen.natural_modes(changing, 2)
    np.testing.assert_array_equal(modes.frequencies, rodgen.natural_modes(constant, 2).frequencies)
    pushed = {"follower": {"force": "t"}}
    begun = rodgen.critical_load(timed(pushed | {"tip": {"x": "2 + t"}}, (-1.0, 1.0)))
    given = rodgen.critical_load(rod(5, "clamped", pushed | {"tip": {"x": 1.0}}))
    assert (begun.value, begun.t) == (given.value, -1.0)
    asked = rodgen.natural_modes(timed({"follower": {"force": "t"}}), 2, t=3.0)
    pushed = rod(5, "clamped", {"follower": {"force": 3.0}})
    np.testing.assert_array_equal(asked.frequencies, rodgen.natural_modes(pushed, 2).frequencies)


def test_both_ends_of_the_span_are_in_it() -> None:
    scene = timed({}, (2.0, 8.0))
    assert [load_time(scene, t) for t in (None, 2, np.float64(8.0))] == [2.0, 2.0, 8.0]


@pytest.mark.parametrize(
    ("force", "t", "names"),
    [
        (BURN, 0.0, False),
        (BURN, 6.0, True),
        ("min(t/0.5, 1)*300", 0.0, True),
        ("1 if abs(t - 3.14159) < 1e-4 else 0", 0.0, True),  # between two of a thousand samples
        ("0*t", 0.0, False),
        (0.0, 0.0, False),
        (7.0, 0.0, False),
    ],
)
def test_loads_that_rest_then_alone_are_named(force: Any, t: float, names: bool) -> None:
    found = rodgen.natural_modes(timed({"follower": {"force": force}}), t=t)
    assert found.inactive_loads == (("loads.follower.force",) if names else ())
    assert ("loads.follower.force" in str(found)) is names
