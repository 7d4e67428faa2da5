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
from rodgen.integrate.reductions import checked
from rodgen.scene import Scene, SceneError
from rodgen.scene.examples import about, copies, example, examples
from rodgen.scene.integration import Integrate
from rodgen.scene.keys import with_value
from tests.scene.tables import ROD

LENGTHWISE = {"mass_per_length": 2.0, **{key: ROD[key] for key in ROD if key != "mass"}}
PHI = [0.0, 0.1, 0.2, 0.3, 0.4]


def scene(**tables: Any) -> Scene:
    return Scene.from_dict({"name": "test", "rod": ROD, **tables})


@pytest.mark.parametrize("name", examples())
def test_an_example_copied_anywhere_is_the_same_scene(name: str, tmp_path: Path) -> None:
    given = Scene.example(name)
    assert given == Scene.from_toml(example(name))
    assert given.name == name
    path = tmp_path / "mine.toml"
    path.write_text(copies(example(name), "mine")["mine.toml"], encoding="utf-8")
    assert Scene.from_toml(path) == given.replace({"name": "mine"})
    path.write_text(given.to_toml(), encoding="utf-8")
    again = Scene.from_toml(path)
    assert again == given
    assert hash(again) == hash(given)


def test_examples_say_what_they_are_in_a_sentence() -> None:
    said = {name: about(path) for name, path in examples().items()}
    assert said["hanging_chain"].endswith("(D. Bernoulli, 1732).")
    assert said["missile"].startswith("A slender missile on its way up:")
    assert all(text.endswith(".") and text.count(". ") <= 1 for text in said.values())


def test_an_unknown_example_names_those_there_are() -> None:
    with pytest.raises(SceneError, match=r"example = 'rocket': must be one of .*missile"):
        Scene.example("rocket")


REPLACED: list[tuple[dict[str, Any], dict[str, Any]]] = [
    ({"loads.gravity.g": 1.6}, {"loads": {"gravity": {"g": 1.6}}}),
    ({"loads.gravity": {"g": 1.6}}, {"loads": {"gravity": {"g": 1.6}}}),
    ({"initial.phi": PHI}, {"initial": {"phi": PHI}}),
    ({"name": "other"}, {"name": "other"}),
    ({"rod.mass": None, "rod.mass_per_length": 2.0}, {"rod": LENGTHWISE}),
    ({"events": [{"quantity": "tip_x", "value": 1.0}]},) * 2,
]


@pytest.mark.parametrize(("changes", "tables"), REPLACED, ids=lambda x: "-".join(x))
def test_replaced_keys_are_those_of_a_file(changes: dict[str, Any], tables: dict[str, Any]) -> None:
    before = scene()
    copy = before.to_dict()
    assert before.replace(changes) == scene(**tables)
    assert before.to_dict() == copy


def test_bodies_go_by_name_and_number() -> None:
    body = {"name": "payload", "at": 0.5, "mass": 1.0}
    given = scene(bodies=[body, {**body, "name": "engine"}])
    heavier = given.replace({"bodies.engine.mass": 7.0})
    assert heavier == given.replace({"bodies.1.mass": 7.0})
    assert [one.mass for one in heavier.bodies] == [1.0, 7.0]
    assert given.replace({"bodies.payload": None}) == scene(bodies=[{**body, "name": "engine"}])
    with pytest.raises(SceneError, match=r"bodies has payload, engine"):
        given.replace({"bodies.tank.mass": 1.0})


def test_another_number_of_links_converts_damping() -> None:
    given = scene(loads={"internal_damping": {"coefficient": 2.0}})
    finer = given.replace({"rod.links": 2 * given.rod.links, "loads.gravity.g": 1.0})
    assert finer == given.with_links(2 * given.rod.links).replace({"loads.gravity.g": 1.0})
    assert finer.loads.internal_damping.coefficient == 8.0  # grows as n^2


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"rod.mass": -1.0}, "rod.mass = -1"),
        ({"rod.links": "many"}, r"rod\.links = 'many'"),
        ({"rod.links": None}, r"rod\.links = \(missing\)"),
        ({"loads.graviti": None}, r"loads\.graviti = None.*did you mean gravity"),
        ({"lods.follower.force": None}, "lods = None.*did you mean loads"),
        ({"rod.mass.x": 1.0}, "rod.mass is 1"),
        ({"lods.follower": 1.0}, "not a known key"),
        ({"": 1.0}, "not a known key"),
        ([("rod.mass", 1.0)], "a dictionary"),
    ],
    ids=str,
)
def test_what_cannot_be_replaced_is_said(changes: Any, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        scene().replace(changes)


def test_a_scene_says_that_it_does_not_change() -> None:
    given = scene()
    with pytest.raises(AttributeError, match=r"Rod.length cannot be set.*scene.replace\("):
        given.rod.length = 3.0
    with pytest.raises(AttributeError, match=r"Scene.name cannot be deleted.*scene.replace\("):
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


@pytest.mark.parametrize("change", CHANGES)
def test_lists_and_dictionaries_of_a_scene_do_not_change(change: Callable[[Scene], object]) -> None:
    """Else two equal scenes had two hashes; copies of them change, and tables are plain."""
    given = scene(bodies=[{"name": "a", "at": 0.5, "mass": 1.0}], parameters={"a": 3.0})
    before = hash(given)
    with pytest.raises(TypeError, match=r"a (list|dictionary) of a scene.*scene.replace\("):
        change(given)
    assert hash(given) == before
    for again in (deepcopy(given), pickle.loads(pickle.dumps(given))):
        assert (again, hash(again)) == (given, before)
        with pytest.raises(TypeError, match="scenes do not change"):
            change(again)
    table = given.to_dict()
    table["bodies"].append({"name": "b", "at": 0.5, "mass": 1.0})
    assert len(given.replace({"bodies": [*given.bodies]}).bodies) == 1 < len(table["bodies"])


@pytest.mark.parametrize("function", [rodgen.simulate, rodgen.simulate_many, Scene.with_integrate])
def test_keywords_of_integration_are_in_signatures(function: Callable[..., object]) -> None:
    """Notebooks and editors complete what they find there."""
    assert set(inspect.signature(function).parameters) >= set(Integrate.model_fields)


def test_equal_scenes_have_one_hash() -> None:
    """Zero has two signs, which are equal; a dictionary has no order."""
    zeros = [scene(initial={"phi": zero}) for zero in (0.0, -0.0)]
    orders = [
        scene(parameters=dict(pairs)) for pairs in ([("a", 1), ("b", 2)], [("b", 2), ("a", 1)])
    ]
    for one, other in (zeros, orders):
        assert one == other
        assert hash(one) == hash(other)
    assert len({*zeros, *orders, scene(initial={"phi": PHI})}) == 3


def test_a_scene_that_is_not_there_but_comes_with_rodgen(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="rodgen new missile --from missile"):
        Scene.from_toml(tmp_path / "missile.toml")
    with pytest.raises(SceneError, match="can be read"):
        Scene.from_toml(tmp_path / "none_such.toml")


@pytest.mark.parametrize(
    ("made", "near"),
    [
        (lambda scene: scene.replace({"rod.lenght": 3.0}), "length"),
        (lambda scene: scene.replace({"load": {}}), "loads"),
        (lambda scene: scene.replace({"integrate.method": "dopp853"}), "dop853"),
        (lambda scene: scene.replace({"events": [{"quantity": "tipx", "value": 0}]}), "tip_x"),
        (lambda scene: Scene.example("missil"), "missile"),
        (lambda scene: with_value(scene, "loads.followr.force", 1.0), "follower"),
        (lambda scene: checked(["last(tipx)"], ["tip_y", "tip_x"]), "tip_x"),
    ],
)
def test_of_a_misspelt_name_the_nearest_is_told(made: Callable[[Scene], Any], near: str) -> None:
    with pytest.raises(SceneError) as raised:
        made(Scene.example("missile"))
    assert near in raised.value.allowed.rpartition(";")[2]


def test_nothing_is_told_where_nothing_is_near() -> None:
    with pytest.raises(SceneError) as raised:
        Scene.example("missile").replace({"zzz": 1})
    assert ";" not in raised.value.allowed
