"""Thrust from a table that is shorter than the run."""

from __future__ import annotations

import warnings

import pytest

import rodgen
from rodgen import Scene
from tests.scene.tables import scene_of


def told(force: str, field: str = "force") -> list[str]:
    """What a run of 4 s warns of."""
    loads = {"follower": {"force": 1.0} | {field: force}}
    rod = {"links": 2, "boundary": "free"}
    scene: Scene = scene_of(rod=rod, loads=loads, integrate={"span": [0.0, 4.0], "rtol": 1e-3})
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        rodgen.simulate(scene, target="numpy", progress=False)
    assert all(issubclass(one.category, rodgen.DoubtWarning) for one in found)
    return [str(one.message) for one in found]


@pytest.mark.parametrize(
    ("force", "numbers"),
    [
        ("interp(t, [0, 1, 2], [0, 5, 3])", ("2 to 4 s", "3 N")),
        ("2*interp(t, [0.5, 1, 2], [-4, 5, 0])", ("0 to 0.5 s", "-8 N")),
        ("interp(t - 1, [0, 1, 2], [0, 5, 3])", ("3 to 4 s", "3 N")),
        ("interp(2*t, [1, 2, 3], [2, 5, 0])", ("0 to 0.5 s", "2 N")),
    ],
)
def test_what_a_table_keeps_is_warned_of(force: str, numbers: tuple[str, str]) -> None:
    (said,) = told(force)
    assert said.startswith("loads.follower.force")
    assert all(number in said for number in numbers)


def test_nothing_is_said_of_what_ends_or_goes_on() -> None:
    for force in (
        "interp(t, [0, 1, 2], [0, 5, 0])",
        "interp(t, [0, 1, 2], [0, 5, 3]) if t <= 2 else 0",
        "interp(t, [0, 4], [1, 3])",
        "interp(t - 1, [0, 1, 2], [0, 5, 0])",
        "interp(t, [0, 1, 2], [0, 5, 3])*t",
        "3*min(t, 1)",
    ):
        assert not told(force)
    assert not told("interp(t, [0, 1], [0, 0.1])", "angle")
