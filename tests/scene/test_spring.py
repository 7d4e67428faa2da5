"""The law of the springs in a scene: its numbers, and what is refused."""

from __future__ import annotations

from typing import Any

import pytest

from rodgen.scene import Scene
from tests.scene.tables import scene_of
from tests.told import refused


def _scene(*spring: Any, stiffness: float = 2.0, **tables: Any) -> Scene:
    rod = {"links": 3, "bending_stiffness": stiffness, "boundary": "clamped"}
    return scene_of(rod=rod | dict(zip(("spring",), spring, strict=False)), **tables)


def test_hookes_law_is_that_of_a_rod_that_names_none() -> None:
    plain = _scene()
    for text in ("k*d", " d * k"):
        assert _scene(text).structure == plain.structure
        assert _scene(text).parameters == plain.parameters


def test_numbers_of_a_law_are_parameters() -> None:
    five, six = _scene("k*(d + 5*d**3)"), _scene("k*(d+6*d**3)")
    assert five.structure == six.structure
    assert (five.parameters["spring_1"], six.parameters["spring_1"]) == (5.0, 6.0)
    assert five.replace({"rod.spring.0": 6.0}).parameters == six.parameters
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


def test_what_is_no_law_is_refused() -> None:
    for law in (
        *("k*phi", "k*d + t", "k*d + phi(0.5)", "__import__('os').getpid()", "k*d +", "log(d)"),
        *("k*d/0", "k*d*abs(d)**0.5", "interp(d, [-1, 1], [-2, 2])", 5.0),
    ):
        assert refused(_scene, law)[:2] == ("rod.spring", law)
    law = "k*d**c"
    assert refused(_scene, law, parameters={"c": 3})[:2] == ("rod.spring", law)
    law = "k*(d + d**3)"
    assert refused(_scene, law, stiffness=0.0)[:2] == ("rod.spring", law)
    for name, value in (("c", -1), ("spring_1", 1)):
        told = refused(_scene, "k*d - c" if name == "c" else "k*d", parameters={name: value})
        assert told.field == f"parameters.{name}"


def test_a_law_without_a_slope_is_allowed_and_said() -> None:
    assert _scene("k*d**3").has_no_tangent_stiffness
    assert _scene("-k*d + d**3").has_no_tangent_stiffness
    assert not _scene("k*sin(d)").has_no_tangent_stiffness
