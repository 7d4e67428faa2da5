"""Scenes that come with rodgen, scenes as text, and scenes made of scenes."""

from __future__ import annotations

import inspect
import pickle
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

import rodgen
from rodgen.errors import Missing
from rodgen.integrate.reductions import parse_all
from rodgen.scene import Scene
from rodgen.scene.examples import copy_texts, examples, find_example
from rodgen.scene.integration import IntegrationSettings, IntegrationTable
from tests.scene.tables import ROD, table_of
from tests.scene.tables import scene_of as scene
from tests.told import refused

LENGTHWISE = {"mass_per_length": 2.0, **{key: ROD[key] for key in ROD if key != "mass"}}
PHI = [0.0, 0.1, 0.2, 0.3, 0.4]


def test_an_example_copied_anywhere_is_the_same_scene(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    for name in examples():
        given = Scene.example(name)
        assert given == Scene.from_toml(find_example(name))
        assert given.name == name
        path.write_text(copy_texts(find_example(name), "mine")["mine.toml"], encoding="utf-8")
        assert Scene.from_toml(path) == given.replace({"name": "mine"})
        path.write_text(given.to_toml(), encoding="utf-8")
        again = Scene.from_toml(path)
        assert again == given
        assert hash(again) == hash(given)


REPLACED: list[tuple[dict[str, Any], dict[str, Any]]] = [
    ({"loads.gravity.g": 1.6}, {"loads": {"gravity": {"g": 1.6}}}),
    ({"loads.gravity": {"g": 1.6}}, {"loads": {"gravity": {"g": 1.6}}}),
    ({"initial.phi": PHI}, {"initial": {"phi": PHI}}),
    ({"name": "other"}, {"name": "other"}),
    ({"rod.mass": None, "rod.mass_per_length": 2.0}, {"rod": LENGTHWISE}),
    ({"events": [{"quantity": "tip_x", "value": 1.0}]},) * 2,
]


def test_replaced_keys_are_those_of_a_file() -> None:
    before = scene()
    copy = before.to_dict()
    for changes, tables in REPLACED:
        assert before.replace(changes) == Scene.from_dict(table_of() | tables)
        assert before.to_dict() == copy


def test_bodies_go_by_name_and_number() -> None:
    body = {"name": "payload", "at": 0.5, "mass": 1.0}
    given = scene(bodies=[body, {**body, "name": "engine"}])
    heavier = given.replace({"bodies.engine.mass": 7.0})
    assert heavier == given.replace({"bodies.1.mass": 7.0})
    assert [one.mass for one in heavier.bodies] == [1.0, 7.0]
    assert given.replace({"bodies.payload": None}) == scene(bodies=[{**body, "name": "engine"}])
    assert "payload, engine" in refused(given.replace, {"bodies.tank.mass": 1.0}).allowed


def test_another_number_of_links_converts_damping() -> None:
    given = scene(loads={"internal_damping": {"coefficient": 2.0}})
    finer = given.replace({"rod.links": 2 * given.rod.links, "loads.gravity.g": 1.0})
    assert finer == given.with_links(2 * given.rod.links).replace({"loads.gravity.g": 1.0})
    assert finer.loads.internal_damping.coefficient == 8.0  # grows as n^2


def test_what_cannot_be_replaced_is_said() -> None:
    for changes, field, value in (
        ({"rod.mass": -1.0}, "rod.mass", -1.0),
        ({"rod.links": "many"}, "rod.links", "many"),
        ({"rod.links": None}, "rod.links", Missing),
        ({"lods.follower.force": None}, "lods", None),
        ({"rod.mass.x": 1.0}, "key", "rod.mass.x"),
        ({"lods.follower": 1.0}, "lods", {"follower": 1.0}),
        ({"": 1.0}, "", 1.0),
        ([("rod.mass", 1.0)], "changes", [("rod.mass", 1.0)]),
    ):
        assert refused(scene().replace, changes)[:2] == (field, value)


def test_a_scene_says_that_it_does_not_change() -> None:
    given = scene()
    with pytest.raises(AttributeError, match=r"^Rod.length.*scene.replace\("):
        given.rod.length = 3.0
    with pytest.raises(AttributeError, match=r"^Scene.name.*scene.replace\("):
        del given.name
    assert given == scene()


CHANGES: list[Callable[[Scene], object]] = [
    lambda given: given.bodies.append(given.bodies[0]),
    lambda given: given.bodies.sort(),
    lambda given: given.integrate.span.__setitem__(0, 0.5),
    lambda given: given.integrate.span.__iadd__([0.5]),
    lambda given: given.numbers.update(a=4.0),
    lambda given: given.numbers.__ior__({"a": 4.0}),
    lambda given: given.numbers.__delitem__("a"),
]


def test_lists_and_dictionaries_of_a_scene_do_not_change() -> None:
    """Else two equal scenes had two hashes; copies of them change, and tables are plain."""
    given = scene(bodies=[{"name": "a", "at": 0.5, "mass": 1.0}], parameters={"a": 3.0})
    before = hash(given)
    for again in (given, deepcopy(given), pickle.loads(pickle.dumps(given))):
        for change in CHANGES:
            with pytest.raises(TypeError, match=r"scene.replace\("):
                change(again)
        assert (again, hash(again)) == (given, before)
    table = given.to_dict()
    table["bodies"].append({"name": "b", "at": 0.5, "mass": 1.0})
    assert len(given.replace({"bodies": [*given.bodies]}).bodies) == 1 < len(table["bodies"])


def test_keywords_of_integration_are_in_signatures() -> None:
    """Notebooks and editors complete what they find there."""
    for function in (rodgen.simulate, rodgen.simulate_many, Scene.with_integrate):
        assert set(inspect.signature(function).parameters) >= set(IntegrationTable.model_fields)
    assert set(IntegrationSettings.__annotations__) == set(IntegrationTable.model_fields)


def test_equal_scenes_have_one_hash() -> None:
    """Zero has two signs, which are equal; a dictionary has no order."""
    zeros = [scene(initial={"phi": zero}) for zero in (0.0, -0.0)]
    orders = [scene(parameters=pairs) for pairs in ({"a": 1, "b": 2}, {"b": 2, "a": 1})]
    for one, other in (zeros, orders):
        assert one == other
        assert hash(one) == hash(other)
    assert len({*zeros, *orders, scene(initial={"phi": PHI})}) == 3


def test_a_scene_that_is_not_there_but_comes_with_rodgen(tmp_path: Path) -> None:
    told = refused(Scene.from_toml, tmp_path / "missile.toml")
    assert told[:2] == ("scene", str(tmp_path / "missile.toml"))
    assert "rodgen new missile --like missile" in told.allowed
    assert "rodgen new" not in refused(Scene.from_toml, tmp_path / "none_such.toml").allowed


def test_of_a_misspelt_name_the_nearest_is_told() -> None:
    given = Scene.example("missile")
    watched = {"events": [{"quantity": "tipx", "value": 0}]}
    for near, make, *of in (
        ("length", given.replace, {"rod.lenght": 3.0}),
        ("loads", given.replace, {"lods.follower.force": None}),
        ("gravity", given.replace, {"loads.graviti": None}),
        ("dop853", given.replace, {"integrate.method": "dopp853"}),
        ("tip_x", given.replace, watched),
        ("missile", Scene.example, "missil"),
        ("follower", given.value_of, "loads.followr.force"),
        ("tip_x", parse_all, ["last(tipx)"], ["tip_y", "tip_x"]),
    ):
        assert near in refused(make, *of).allowed.rpartition(";")[2]
    # Where nothing is near, nothing is told.
    assert ";" not in refused(given.replace, {"zzz": 1}).allowed
    told = refused(Scene.example, "rocket")
    assert told[:2] == ("example", "rocket")
    assert all(name in told.allowed for name in examples())
