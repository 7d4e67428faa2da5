"""Several loads of one kind in a scene: names, places, refusals, and what they do together."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest

from rodgen.analyse.critical import critical_load
from rodgen.errors import Missing
from rodgen.scene import Scene
from rodgen.scene.rod_mesh import RodMesh
from rodgen.scene.structure import Structure
from rodgen.scene.term_texts import parse_terms
from tests.told import refused

ROD = {"links": 10, "length": 5.0, "mass": 20.0, "bending_stiffness": 100.0, "boundary": "clamped"}
THREE = {"rod": ROD | {"links": 3}}  # enough to flutter


def _rod(follower: Any, **tables: Any) -> Scene:
    return Scene.from_dict({"name": "rod", "rod": ROD, "loads": {"follower": follower}} | tables)


def test_one_at_the_tail_is_what_it_was() -> None:
    one, listed = _rod({"force": 3.0}), _rod([{"force": 3.0, "at": 1.0}])
    assert one.structure == listed.structure
    assert one.structure.terms == ("follower",)
    assert "at" not in one.model_dump(exclude_none=True)["loads"]["follower"]


def test_each_has_parameters_of_its_own() -> None:
    last = {"force": 5.0, "at": 0}
    scene = _rod([{"force": 3.0, "at": 0.25}, {"force": "4*t", "angle": 0.1}, last])
    assert scene.structure.terms == ("follower@2+1/2", "follower", "follower@0")
    assert scene.loads.terms == ("follower", "follower_2", "follower_3")
    given = scene.parameters
    assert (given["follower_force"], given["follower_3_force"]) == (3.0, 5.0)
    assert (given["follower_2_angle"], given["follower_2_force_1"]) == (0.1, 4.0)
    changed = scene.replace({"loads.follower.2.angle": 0.2, "loads.follower.1.force.0": 8.0})
    assert changed.parameters == given | {"follower_3_angle": 0.2, "follower_2_force_1": 8.0}
    assert changed.structure == scene.structure
    assert Scene.from_dict(changed.to_dict()) == changed


def test_a_place_is_a_link_and_a_share_of_it() -> None:
    for at, links, place in (
        (1, 7, ""),
        (0, 7, "0"),
        (0.3, 10, "3"),
        (1 / 3, 3, "1"),
        (0.5, 5, "2+1/2"),
        (0.99, 2, "1+49/50"),
    ):
        assert RodMesh(links).place_text(at) == place
        link, _, share = place.partition("+")
        if place:  # on the link on which s lies, to a part in 10^9 of it
            assert abs(int(link) + Fraction(share or 0) - Fraction(at) * links) < 1e-9


def test_what_is_no_place_is_refused() -> None:
    for table, key, value in (
        ({"force": 5.0, "at": 1.3}, "at", 1.3),
        ({"angle": 5.0}, "force", Missing),
        ({"force": "x"}, "force", "x"),
        ({"force": 3.0, "place": 0.3}, "place", 0.3),
    ):
        assert refused(_rod, [{"force": 3.0}, table])[:2] == (f"loads.follower.1.{key}", value)
    assert refused(_rod, {"force": 3.0, "at": "4*0.3"})[:2] == ("loads.follower.at", "4*0.3")
    for tables in ([{"force": 1.0}] * 101, 3):
        assert refused(_rod, tables)[:2] == ("loads.follower", tables)


def test_terms_at_no_place_are_refused() -> None:
    """The text that is parsed, or what is parsed, is not of a rod of ten links."""

    def make(text: str) -> Structure:
        return Structure(10, terms=parse_terms(text))

    others = "follower@10", "follower@", "follower@1+3/2", "tip_load@3", "gravity,gravity", "nix@3"
    for text in (*others, "distributed_follower@3", "follower@angle", "gravity@g"):
        assert refused(make, text).field == "terms"
    keyed = "distributed_follower@angle", "gravity@acceleration"
    for text in ("follower@9", "moment@9+1/2", *keyed):
        assert make(text).terms == (text,)


def test_two_halves_flutter_as_one() -> None:
    whole = critical_load(_rod({"force": 1.0}, **THREE))
    halves = _rod([{"force": 0.5}, {"force": 0.5}], **THREE)
    both = critical_load(halves, load="followers")
    assert both.value == pytest.approx(whole.value, rel=1e-9)
    assert both.unit == "times the loads"
    # Beside the half that stays, the other bears the rest.
    second = critical_load(halves, load="follower_2")
    assert second.value == pytest.approx(whole.value - 0.5, rel=1e-9)
    assert refused(critical_load, halves, load="follower_3")[:2] == ("loads.follower_3", Missing)
