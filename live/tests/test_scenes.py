"""Scenes as the page takes and gives them: in a list, edited, and in an address that holds all."""

from __future__ import annotations

import base64
import json
import pickle
import re
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import rodgen
from live.tests.conftest import SCENE, SCENES, varied
from live.tests.runs import does
from rodgen.errors import InputError
from rodgen.loading.generated_module import call_module
from rodgen.model.rod import BOUNDARIES
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.system import System
from rodgen_live.page.pulls import usual_spring
from rodgen_live.page.thumbnail import SIZE, joints_at_start, thumbnail
from rodgen_live.run.link import Link, apply_link, make_link
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.scene_edits import (
    LARGEST,
    StructureForm,
    fields_of,
    initial_labels,
    reshape,
    slider_scale,
    structure_form,
)
from rodgen_live.run.scene_text import SceneFolder
from tests.palette import ENDS, ROD
from tests.told import refused


def changed(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """As a slider does it."""
    return System(scene).at(changes).scene


FILES = sorted(SCENES.glob("*.toml"))
MISSILE = SCENES / "missile.toml"


def test_folder_gives_its_own_scenes_alone(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    good = MISSILE.read_text()
    (inside / "good.toml").write_text(good)
    (tmp_path / "outside.toml").write_text(good)
    (inside / "link.toml").symlink_to(tmp_path / "outside.toml")
    (inside / "folder.toml").mkdir()
    folder = SceneFolder(inside)
    assert folder.names() == ["good"]
    assert folder.scene("good").name == "missile"
    for name in ("link", "folder", "../outside", "/etc/passwd", "good.toml", "", "*"):
        with pytest.raises(InputError, match=r"^scene = "):
            folder.scene(name)


def test_every_number_of_a_scene_has_a_field() -> None:
    """Of its tables of what is modelled; but for counts, names, and what is chosen in the panel of
    the structure, where the initial state is too. Of one with what scenes of the package lack, and
    of that which has most of all else."""
    table = {
        **varied(bending_stiffness=[5.0, 6.0, 5.0, 6.0, 5.0, 6.0]),
        "loads": {
            "follower": [{"force": 2.0}, {"force": "3*t", "at": 0.4}],
            "distributed_follower": {"force_per_length": [1.0, 2.0, 3.0, 4.0, 5.0]},
        },
        "foundation": {"stiffness": "3 + s"},
        "supports": [{"at": 0.5, "to": [1.0, 0.0], "rotation": 3.0, "damping": [0.0, 2.0]}],
    }
    rocket = Scene.from_toml(SCENES / "sounding_rocket.toml")

    def leaves(table: object, *path: str) -> Iterator[str]:
        if isinstance(table, dict | list):
            for key, inner in table.items() if isinstance(table, dict) else enumerate(table):
                yield from leaves(inner, *path, str(key))
        else:
            yield ".".join(path)

    for scene in (Scene.from_dict(table), rocket):
        modelled = scene.model_dump(exclude_none=True, exclude={"name", "initial", "integrate"})
        fields = {field.key for field in fields_of(scene)}
        starts = {*initial_labels(scene)}
        names = {f"bodies.{k}.name" for k in range(len(scene.bodies))}
        chosen = {"rod.links", "rod.boundary", "rod.inertia", *names}
        assert set(leaves(modelled)) - fields - starts == chosen


def test_form_that_cannot_be_is_refused() -> None:
    scene = Scene.from_toml(MISSILE)
    for form, field in (
        (StructureForm(0, "free", "uniform", ()), "rod.links"),
        (StructureForm(1, "cantilever", "uniform", ()), "rod.links"),
        (StructureForm(3, "glued", "uniform", ()), "rod.boundary"),
    ):
        assert refused(reshape, scene, form, {}).field == field
    with pytest.raises(InputError, match=r"initial\.phi"):
        reshape(scene, structure_form(scene), {"initial.phi": "__import__('os')"})


def test_amplitude_of_a_load_has_the_slider_of_its_key() -> None:
    """Before the expression, whose other numbers follow; all else of the text stays as written, and
    what two sliders of one text change meanwhile is kept."""
    scene = Scene.from_toml(MISSILE)
    fields = [one for one in fields_of(scene) if one.key.startswith("loads.follower.force")]
    assert [field.value for field in fields] == [300.0, None, 0.5, 1.0]
    assert fields[0].slider_range(slider_scale(fields[0])) == (0.0, 900.0)
    other = changed(scene, fields[0].changes(320.0) | fields[2].changes(0.25))
    assert other.loads.follower is not None
    assert other.loads.follower.force == "320*min(t/0.25, 1)"
    assert other.structure == scene.structure
    for value in ("abc", float("nan")):
        with pytest.raises(InputError, match=r"^loads\.follower\.force"):
            changed(scene, fields[0].changes(value))


def test_supports_can_be_moved() -> None:
    """The fixed point of one is where the rod was until it is moved."""
    table = Scene.from_toml(SCENES / "foundation.toml").model_dump(exclude_none=True)
    table["supports"] = [{"at": 0.5}, {"at": 1.0, "stiffness": [5.0, 20.0]}]
    scene = Scene.from_dict(table)
    fields = {field.key: field for field in fields_of(scene)}
    other = changed(scene, fields["supports.1.stiffness.1"].changes(33.0))
    assert other.structure == scene.structure
    assert other.parameters["support_stiffness_y"][-1] == 33.0
    x, y = (fields[f"supports.1.to.{part}"] for part in range(2))
    assert (x.value, y.value) == (scene.rod.length, 0.0)
    other = changed(scene, y.changes(0.3))
    assert other.supports[1].to == [x.value, 0.3]
    (x,) = (field for field in fields_of(other) if field.key == x.key)
    assert changed(other, x.changes(0.7)).supports[1].to == [0.7, 0.3]


def test_terms_that_anchor_a_rod_and_states_can_be_chosen() -> None:
    scene = Scene.from_dict(ROD)
    form = structure_form(scene)
    held = reshape(scene, replace(form, terms=(*form.terms, "foundation", "supports")), {})
    assert held.anchors.terms == ("foundation", "supports")
    assert max(held.parameters["support_stiffness_y"]) > 0
    assert reshape(held, form, {}) == scene
    scene = Scene.from_toml(SCENES / "sounding_rocket.toml")
    key = "states.gimbal.initial"
    assert key in initial_labels(scene)
    other = reshape(scene, structure_form(scene), {key: 0.05})
    assert (other.structure, other.initial_state()[-1]) == (scene.structure, 0.05)


def test_link_brings_back_the_scene_its_plots_and_the_view(run: LiveRun, other: LiveRun) -> None:
    """And which scene it was before it was changed."""
    run.submit(lambda: run.add_plot({"kind": "time", "y": ["phi_4"], "window": 3.0})).result()
    heavier = SCENE.replace({"rod.mass": 4.0})
    does(run, lambda: run.change(heavier, "rod.mass = 4"))
    link = Link.unpack(run.submit(lambda: make_link(run, "axes")).result().pack())
    assert (link.scene, link.view) == (heavier, "axes")
    does(other, lambda: other.switch_to(link.scene), lambda: apply_link(other, link))
    assert other.undo.file == SCENE
    ((name, plot),) = other.plots.items()
    assert plot.spec == run.plots["p1"].spec.model_copy(update={"id": name})


def packed(text: str) -> str:
    return base64.urlsafe_b64encode(zlib.compress(text.encode())).decode()


def test_other_addresses_are_refused() -> None:
    """What is no scene, a bomb, and pages that are none."""
    for text in (
        *("", "é", "!!!!", "AAAA", "../../etc/passwd", "a" * 100_000, packed("name = 3")),
        *(packed(" " * (LARGEST + 10)), packed("a = " + "[" * 10_000)),
    ):
        with pytest.raises(InputError):
            Link.unpack(text)
    page = {"scene": SCENE.to_dict(), "plots": [], "view": "", "file": None}
    assert Link.unpack(packed(json.dumps(page))).scene == SCENE
    for other in ({"plots": 3}, {"plots": [3]}, {"view": 3}, {"file": 3}, {"scene": {}}):
        with pytest.raises(InputError):
            Link.unpack(packed(json.dumps(page | other)))


@pytest.mark.parametrize(
    "changes",
    [{}, {"rod.boundary": "cantilever", "base": {"x": "2 + t", "angle": "0.5*cos(t)"}}],
    ids=["free", "moved"],
)
def test_joints_at_the_start_are_those_of_the_module(changes: dict[str, Any]) -> None:
    scene = Scene.from_dict(ROD).replace(changes)
    model = rodgen.build(scene, target="numpy")
    of = scene.initial_state(), model.parameters(**scene.parameters)
    found = call_module(model, "joints", 0.0, *of)
    assert joints_at_start(scene) == pytest.approx(found, abs=1e-14)  # rounding of lengths of 2 m


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_scenes_of_the_package_can_be_edited_packed_and_drawn(path: Path) -> None:
    """What is moved of parameters arrives in the scene, under its name in the module, and stays in
    its module; but for values along the rod. Rods can be held in every way; what an address or a
    text holds of them comes back. They are in their pictures whole, whatever holds them, and with
    an arrow for each force and weight."""
    scene, by = Scene.from_toml(path), 0.01  # less than between two knots of any table there
    fixed = {"mass"} if scene.rod.mass is None else {}  # it follows from the mass per length
    given = {name: v for name, v in scene.parameters.items() if isinstance(v, float)}
    reached = {name: v for name, v in given.items() if name not in fixed}
    moved = dict(reached)
    for field in fields_of(scene):
        if field.value is None or "fin_factor" in field.key:
            continue
        low, high = field.slider_range(slider_scale(field))
        assert low <= field.value <= high
        if field.of.fixed:
            continue
        other = changed(scene, field.changes(min(field.value + by, field.of.most or float("inf"))))
        if "ends" in other.structure.nonuniform and "ends" not in scene.structure.nonuniform:
            continue  # a body at the tail begins to resist turning: the rod bends up to it
        assert other.structure == scene.structure
        for name, value in other.parameters.items():
            if name in reached and value != reached[name]:
                assert value == pytest.approx(reached[name] + by)
                del moved[name]
    assert moved == {}
    for boundary in BOUNDARIES:
        forms = [
            StructureForm(5, boundary, "lumped", ()),
            StructureForm(6, boundary, "uniform", ENDS),
        ]
        # Massless links carry no body that has inertia.
        for form in forms[any(body.inertia for body in scene.bodies) :]:
            other = reshape(scene, form, {})
            assert structure_form(other) == form
            moving = form.links - (boundary == "cantilever") + 2 * (boundary == "free")
            assert other.initial_state().size == 2 * moving + len(scene.states)
    assert SceneFolder(SCENES).parse(scene.to_toml()) == scene
    sent = pickle.loads(pickle.dumps(scene.structure))  # to another process
    assert {sent} == {scene.structure}
    stiffness, damping = usual_spring(scene)  # of the spring of a pull
    assert stiffness > 0 <= damping
    text = Link(scene).pack()
    assert (text.isascii(), text.replace("-", "").replace("_", "").isalnum()) == (True, True)
    assert Link.unpack(text) == Link(scene)
    root = ElementTree.fromstring(thumbnail(scene))
    for marks in root.iter("{http://www.w3.org/2000/svg}defs"):
        marks.clear()  # they have places of their own
    shapes = " ".join(shape.get("d", "") for shape in root.iter())
    points = np.reshape(re.findall(r"-?\d[\d.]*", shapes), (-1, 2)).astype(float)
    # What goes on beyond, as a wall, is cut off a point beside the picture.
    assert np.all((points >= -1) & (points <= SIZE + 1))
    styles = " ".join(shape.get("style", "") for shape in root.iter())
    forces = [TERMS[name] for name in scene.loads.terms if not TERMS[name].is_damping]
    every = {term.colours[0] for term in TERMS.values()}
    assert {one for one in every if one in styles} == {term.colours[0] for term in forces}


def test_fin_factors_can_be_moved_and_nonsense_leaves_a_scene_as_it_was() -> None:
    """Factors by part as by joint."""
    scene = Scene.from_toml(MISSILE)
    factor = "loads.external_damping.fin_factor"
    assert changed(scene, {f"{factor}.tail": 7.0}).parameters["fin_factor"][-1] == 7.0
    listed = changed(scene, {factor: [1.0] * 21})
    assert changed(listed, {f"{factor}.3": 9.0}).parameters["fin_factor"][3] == 9.0
    for value in (float("nan"), float("inf"), -1.0, 0.0, "1 kg", None):
        with pytest.raises(InputError, match=r"rod\.mass"):
            changed(scene, {"rod.mass": value})
    assert scene == Scene.from_toml(MISSILE)
