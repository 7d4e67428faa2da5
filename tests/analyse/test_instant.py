"""When loads that change with time are taken: by default at the start, never outside the span."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.system import in_words, instant, silent
from rodgen.scene import Scene, SceneError

Rod = Callable[..., Scene]
BURN = "300 if t < 5 else 0"  # a burn of 5 s in a span of 8 s


def timed(rod: Rod, loads: dict[str, Any], span: tuple[float, float] = (0.0, 8.0)) -> Scene:
    table = rod(5, "clamped", loads).model_dump(exclude_none=True)
    return Scene.from_dict(table | {"integrate": {"span": list(span)}})


def test_loads_are_those_at_the_start(rod: Rod) -> None:
    """The thrust of a burn is there; a load given as a number is the other route."""
    changing = timed(rod, {"tip": {"x": "-2 if t < 5 else 0", "y": "3 - t/8"}})
    constant = rod(5, "clamped", {"tip": {"x": -2.0, "y": 3.0}})
    found = rodgen.static_equilibrium(changing)
    np.testing.assert_array_equal(found.phi, rodgen.static_equilibrium(constant).phi)
    assert found.t == 0
    modes = rodgen.natural_modes(changing, 2)
    np.testing.assert_array_equal(modes.frequencies, rodgen.natural_modes(constant, 2).frequencies)
    pushed = {"follower": {"force": "t"}}
    begun = rodgen.critical_force(timed(rod, pushed | {"tip": {"x": "2 + t"}}, (-1.0, 1.0)))
    given = rodgen.critical_force(rod(5, "clamped", pushed | {"tip": {"x": 1.0}}))
    assert (begun.force, begun.t) == (given.force, -1.0)
    asked = rodgen.natural_modes(timed(rod, {"follower": {"force": "t"}}), 2, t=3.0)
    pushed = rod(5, "clamped", {"follower": {"force": 3.0}})
    np.testing.assert_array_equal(asked.frequencies, rodgen.natural_modes(pushed, 2).frequencies)


@pytest.mark.parametrize("t", [-0.1, 8.1, np.nan, np.inf, "1", True])
def test_times_outside_the_span_are_refused(rod: Rod, t: Any) -> None:
    scene = timed(rod, {"follower": {"force": BURN}})
    for analysis in (rodgen.natural_modes, rodgen.static_equilibrium, rodgen.critical_force):
        with pytest.raises(SceneError, match="a time in the span of the scene, 0 to 8 s"):
            analysis(scene, t=t)


def test_both_ends_of_the_span_are_in_it(rod: Rod) -> None:
    scene = timed(rod, {}, (2.0, 8.0))
    assert [instant(scene, t) for t in (None, 2, np.float64(8.0))] == [2.0, 2.0, 8.0]


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
def test_loads_that_rest_then_alone_are_named(rod: Rod, force: Any, t: float, names: bool) -> None:
    scene = timed(rod, {"follower": {"force": force}})
    assert silent(scene, t) == (("loads.follower.force",) if names else ())
    assert ("loads.follower.force is 0" in in_words(scene, t)) is names
