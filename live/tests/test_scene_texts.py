"""Texts of scenes: edited where values differ, refused at their lines."""

from __future__ import annotations

from dataclasses import replace
from difflib import ndiff
from pathlib import Path

import pytest

import rodgen
from live.tests.conftest import SCENES
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen.system import System
from rodgen_live.run.critical_search import critical_number
from rodgen_live.run.scene_edits import (
    StructureForm,
    conversions,
    fields_of,
    reshape,
    structure_form,
)
from rodgen_live.run.scene_text import SceneFolder, edited_text, refused_line
from tests.palette import ALL

FOLDER = SceneFolder(SCENES)


def differing(before: str, after: str) -> list[str]:
    return [line for line in ndiff(before.splitlines(), after.splitlines()) if line[0] in "+-"]


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_text_keeps_what_has_not_changed(path: Path) -> None:
    """A number changes its line alone; with all terms, or none, only those are others. No list is
    empty, and no place is what rounding makes of zero."""
    text = FOLDER.text(path.stem)
    scene = FOLDER.parse(text)
    assert edited_text(text, scene, scene) == text
    changed = System(scene).at({"rod.length": 7.25}).scene
    old, new = differing(text, edited_text(text, scene, changed))
    assert (old.startswith("- length ="), new.startswith("+ length = 7.25")) == (True, True)
    assert new.partition("#")[2] == old.partition("#")[2]
    form = structure_form(scene)
    base = tuple({*form.terms} - {*ALL})  # with which the words in its table would go
    for terms in (base, (*ALL, *base)):
        other = reshape(scene, StructureForm(form.links, form.boundary, form.inertia, terms), {})
        made = edited_text(text, scene, other)
        assert FOLDER.parse(made) == other
        assert "[]" not in made + other.to_toml()
        kept = {line for line in text.splitlines() if line.startswith("#")}
        assert kept <= {*made.splitlines()}
        for field in fields_of(other):
            assert field.value is None or not 0 < abs(field.value) < 1e-12, field.key


def test_refusals_stand_at_their_lines() -> None:
    """Also in a third body, or a support, that is written at the end."""
    text = FOLDER.text("sounding_rocket")
    body = '[[bodies]]\nname = "third"\nat = 0.5\nmass = 1.0\n'
    support = "[[supports]]\nat = 0.2\nstiffness = [3.0, 1.0]\n"
    text = f"{text}\n{body}\n{support}"
    FOLDER.parse(text)
    for wrong, right in (
        ("[rod", "[rod]"),
        ("[rud]", "[rod]"),
        ("lonks =", "links ="),
        ("inertia = -2.0", "inertia = 2.0"),
        ("at = 4.1", "at = 0.1"),
        ('force = "intorp', 'force = "interp'),
        ('phi = "up"', 'phi = "upright"'),
        ('phi = "at line 999"', 'phi = "upright"'),
        ("links\u00a0=", "links ="),
        ('name = "engine"', 'name = "third"'),
        ("mass = -1.0", "mass = 1.0"),
        ("[[loads.supports]]", "[[supports]]"),
        ("stiffness = [3.0, -1.0]", "stiffness = [3.0, 1.0]"),
        ("stiffness = [3.0, 1.0", "stiffness = [3.0, 1.0]"),
    ):
        lines = text.replace(right, wrong, 1)
        assert lines != text, right
        with pytest.raises(InputError) as refused:
            FOLDER.parse(lines)
        line = refused_line(lines, refused.value)
        assert line is not None
        # What is written twice is wrong where it stands last.
        assert line == lines[: lines.rindex(wrong)].count("\n") + 1


def test_another_number_of_links_is_the_same_rod() -> None:
    """As by `Scene.with_links`, which is told."""
    scene = Scene.example("missile")
    form = structure_form(scene)
    finer = StructureForm(40, form.boundary, form.inertia, form.terms)
    assert reshape(scene, finer, {}) == scene.with_links(40)
    key = "loads.internal_damping.coefficient"
    told = conversions(scene, 40)
    assert f"{key} {scene.value_of(key):.6g} to {4 * scene.value_of(key):.6g}" in told
    assert conversions(scene, scene.rod.links) == ""


def test_what_moves_the_base_is_kept_and_can_be_changed() -> None:
    """Its expressions and their numbers are fields; a term that is switched on stands still."""
    table = {"links": 4, "length": 2.0, "bending_stiffness": 1.0, "mass": 1.0, "boundary": "pinned"}
    still = Scene.from_dict({"name": "still", "rod": table})
    base = {"x": "0.2*sin(3*t)", "y": 0.5}
    scene = still.replace({"base": base})
    found = {field.key: field for field in fields_of(scene)}
    values = {key: found[key].value for key in found if key.startswith("base")}
    assert values == {"base.x": None, "base.x.0": 0.2, "base.x.1": 3.0, "base.y": 0.5}
    for key, to, text in (("base.x.1", 7.0, "0.2*sin(7*t)"), ("base.x", "t**2", "t**2")):
        assert System(scene).at(found[key].changes(to)).scene.to_dict()["base"]["x"] == text
    form = structure_form(scene)
    assert form.terms == ("base",)
    assert reshape(scene, replace(form, links=6), {}).to_dict()["base"] == base
    assert reshape(scene, replace(form, terms=()), {}) == still
    assert reshape(still, form, {}).to_dict()["base"] == {"x": 0.0}
    with pytest.raises(InputError, match="nothing holds"):
        reshape(scene, replace(form, boundary="free"), {})


def test_critical_value_is_that_of_the_number_on_the_slider() -> None:
    """Of a plain force, and of the factor of one that grows in half a second."""
    plain, grows = (System(Scene.example(name)) for name in ("flutter", "missile"))
    assert critical_number(plain, 10.7) == ("loads.follower.force", 10.7)
    assert critical_number(grows, 340.0) == ("loads.follower.force.0", 340.0)


def test_the_first_scene_flutters_within_the_range_of_its_slider() -> None:
    scene = Scene.example("flutter")
    (field,) = (one for one in fields_of(scene) if one.key == "loads.follower.force")
    critical = rodgen.critical_load(scene).value
    assert field.value is not None
    assert field.value < critical < field.slider_range(field.value)[1]
    assert f"{critical:.1f} N" in FOLDER.text("flutter").splitlines()[0]
