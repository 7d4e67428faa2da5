"""The law of the springs in a scene: its numbers, and what is refused."""

from __future__ import annotations

from typing import Any

import pytest

from rodgen.scene import Scene, SceneError
from rodgen.scene.overrides import with_parameters

ROD = {"links": 3, "length": 1.0, "bending_stiffness": 2.0, "mass": 1.0, "boundary": "clamped"}


def _scene(spring: Any, rod: dict[str, Any] | None = None, **tables: Any) -> Scene:
    return Scene.from_dict({"name": "law", "rod": ROD | {"spring": spring} | (rod or {}), **tables})


@pytest.mark.parametrize("text", ["k*d", " d * k"])
def test_hookes_law_is_that_of_a_rod_that_names_none(text: str) -> None:
    plain = Scene.from_dict({"name": "law", "rod": ROD})
    assert _scene(text).structure == plain.structure
    assert _scene(text).parameters == plain.parameters


def test_numbers_of_a_law_are_parameters() -> None:
    five, six = _scene("k*(d + 5*d**3)"), _scene("k*(d+6*d**3)")
    assert five.structure == six.structure
    assert (five.parameters["spring_1"], six.parameters["spring_1"]) == (5.0, 6.0)
    assert with_parameters(five, {"spring_1": 6.0}).parameters == six.parameters
    named = _scene("k*(d + c*d**3)", parameters={"c": 5})
    assert named.parameters["c"] == 5.0
    assert len({s.structure.stem for s in (five, named, _scene("k*d"))}) == 3


@pytest.mark.parametrize("links", [1, 7])
def test_with_links_keeps_the_moment_of_a_curvature(links: int) -> None:
    scene = _scene("k*(d + 5*d**3) - 0.1*sin(d)")
    other = scene.with_links(links)
    assert scene.spring_law is not None
    assert other.spring_law is not None
    for curvature in (-3.0, 0.5):
        moments = []
        for one in (scene, other):
            k, d = 2.0 * one.rod.links, curvature / one.rod.links
            moments.append(float(one.spring_law.with_values({"k": k})(d)))
        assert moments[0] == pytest.approx(moments[1], rel=1e-14)


@pytest.mark.parametrize(
    ("spring", "rod", "tables", "field"),
    [
        ("k*phi", {}, {}, "rod.spring"),
        ("k*d + t", {}, {}, "rod.spring"),
        ("k*d + phi(0.5)", {}, {}, "rod.spring"),
        ("__import__('os').getpid()", {}, {}, "rod.spring"),
        ("k*d +", {}, {}, "rod.spring"),
        ("log(d)", {}, {}, "rod.spring"),
        ("k*d/0", {}, {}, "rod.spring"),
        ("k*d*abs(d)**0.5", {}, {}, "rod.spring"),
        ("k*d**c", {}, {"parameters": {"c": 3}}, "rod.spring"),
        ("interp(d, [-1, 1], [-2, 2])", {}, {}, "rod.spring"),
        ("k*d - c", {}, {"parameters": {"c": -1}}, "parameters.c"),
        ("k*(d + d**3)", {"bending_stiffness": 0.0}, {}, "rod.spring"),
        (5.0, {}, {}, "rod.spring"),
        ("k*d", {}, {"parameters": {"spring_1": 1}}, "parameters.spring_1"),
    ],
)
def test_what_is_no_law_is_refused(
    spring: Any, rod: dict[str, Any], tables: dict[str, Any], field: str
) -> None:
    with pytest.raises(SceneError) as caught:
        _scene(spring, rod, **tables)
    assert caught.value.field == field


def test_a_law_without_a_slope_is_allowed_and_said() -> None:
    assert _scene("k*d**3").slack
    assert _scene("-k*d + d**3").slack
    assert not _scene("k*sin(d)").slack
