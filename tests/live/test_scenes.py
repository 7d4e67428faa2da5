"""Scenes as the page takes and gives them: texts, addresses, files of a folder, edited ones."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from rodgen.live.run.link import Link
from rodgen.live.run.scenes import (
    LARGEST,
    Folder,
    Form,
    edit,
    fields_of,
    form_of,
    from_toml_text,
    reshape,
    scale_of,
    starts_of,
)
from rodgen.scene import Scene, SceneError
from tests.live.conftest import ROD

SCENES = Path(__file__).parents[2] / "scenes"
FILES = sorted(SCENES.glob("*.toml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_scene_survives_text_and_address(path: Path) -> None:
    scene = Scene.from_toml(path)
    assert from_toml_text(scene.to_toml().encode()) == scene
    text = Link(scene).pack()
    assert set(text) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_")
    assert Link.unpack(text) == Link(scene)


@pytest.mark.parametrize(
    "text",
    [
        *("", "é", "!!!!", "AAAA", "../../etc/passwd", "a" * 100_000),
        base64.urlsafe_b64encode(zlib.compress(b"name = 3")).decode(),
        base64.urlsafe_b64encode(zlib.compress(b" " * (LARGEST + 10))).decode(),  # a bomb
        base64.urlsafe_b64encode(zlib.compress(b"a = " + b"[" * 10_000)).decode(),
    ],
)
def test_other_addresses_are_refused(text: str) -> None:
    with pytest.raises(SceneError):
        Link.unpack(text)


def test_folder_gives_its_own_scenes_alone(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    good = (SCENES / "missile.toml").read_text()
    (inside / "good.toml").write_text(good)
    (tmp_path / "outside.toml").write_text(good)
    (inside / "link.toml").symlink_to(tmp_path / "outside.toml")
    (inside / "folder.toml").mkdir()
    folder = Folder(inside)
    assert folder.names() == ["good"]
    assert folder.scene("good").name == "missile"
    for name in ("link", "folder", "../outside", "/etc/passwd", "good.toml", "", "*"):
        with pytest.raises(SceneError, match="one of the folder"):
            folder.scene(name)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_parameter_of_the_module_can_be_moved(path: Path) -> None:
    """What is moved arrives in the scene, under its name in the module, and stays in its module;
    but for values along the rod."""
    scene, by = Scene.from_toml(path), 0.05  # less than between two knots of any table there
    fixed = {"mass"} if scene.rod.mass is None else {}  # it follows from the mass per length
    given = {name: v for name, v in scene.parameters.items() if isinstance(v, float)}
    reached = {name: v for name, v in given.items() if name not in fixed}
    moved = dict(reached)
    for field in fields_of(scene):
        if field.value is None or "fin_factor" in field.path:
            continue
        low, high = field.reach(scale_of(field))
        assert low <= field.value <= high
        if field.of.fixed:
            continue
        most = field.of.most or float("inf")
        other = edit(scene, field.changes(min(field.value + by, most)))
        assert other.structure == scene.structure
        for name, value in other.parameters.items():
            if name in reached and value != reached[name]:
                assert value == pytest.approx(reached[name] + by)
                del moved[name]
    assert moved == {}


def test_amplitude_of_a_load_has_the_slider_of_its_key() -> None:
    """Before the expression, whose other numbers follow; all else of the text stays as written, and
    what two sliders of one text change meanwhile is kept."""
    scene = Scene.from_toml(SCENES / "missile.toml")
    fields = [
        field for field in fields_of(scene) if field.path[:3] == ("loads", "follower", "force")
    ]
    assert [(field.label, field.value) for field in fields] == [
        ("follower force P", 300.0),
        ("follower force P, expression", None),
        ("follower force P: ·*min(t/□, ·)", 0.5),
        ("follower force P: ·*min(t/·, □)", 1.0),
    ]
    assert fields[0].reach(scale_of(fields[0])) == (0.0, 900.0)
    other = edit(scene, (*fields[0].changes(320.0), *fields[2].changes(0.25)))
    assert other.loads.follower is not None
    assert other.loads.follower.force == "320*min(t/0.25, 1)"
    assert other.structure == scene.structure
    for value, said in (("abc", "a number"), (float("nan"), "an expression of numbers")):
        with pytest.raises(SceneError, match=said):
            edit(scene, fields[0].changes(value))


def test_what_anchors_a_rod_can_be_moved() -> None:
    table = Scene.from_toml(SCENES / "foundation.toml").model_dump(exclude_none=True)
    table["supports"] = [{"at": 0.5}, {"at": 1.0, "stiffness": [5.0, 20.0]}]
    scene = Scene.from_dict(table)
    paths = {field.path for field in fields_of(scene)}
    changes: list[tuple[tuple[str, ...], float]] = [
        (("foundation", "damping"), 2.0),
        (("supports", "1", "stiffness", "1"), 33.0),
        (("supports", "0", "rotation"), 4.0),
    ]
    assert paths >= {path for path, _ in changes}
    other = edit(scene, changes)
    assert other.structure == scene.structure
    assert other.parameters["support_stiffness_y"][-1] == 33.0
    assert max(other.parameters["support_rotation"]) == 4.0
    assert other.parameters["foundation_damping"][1] == pytest.approx(2.0 / 40)


def test_fixed_point_of_a_support_is_where_the_rod_was_until_it_is_moved() -> None:
    table = Scene.from_toml(SCENES / "foundation.toml").model_dump(exclude_none=True)
    scene = Scene.from_dict({**table, "supports": [{"at": 0.5, "stiffness": [5.0, 20.0]}]})
    fields = {field.key: field for field in fields_of(scene)}
    x, y = (fields[f"supports.0.to.{part}"] for part in range(2))
    assert (x.value, y.value) == (0.5 * scene.rod.length, 0.0)
    other = edit(scene, y.changes(0.3))
    assert other.supports[0].to == [x.value, 0.3]
    (x,) = (field for field in fields_of(other) if field.key == x.key)
    assert edit(other, x.changes(0.7)).supports[0].to == [0.7, 0.3]


def test_every_number_of_a_scene_has_a_field() -> None:
    """Of its tables of what is modelled; but for counts, names, and what is chosen in the panel of
    the structure, where the initial state is too."""
    table = {
        **ROD,
        "bodies": [
            {"name": "tank", "at": 0.5, "mass": "2 - 0.1*t", "offset": [0.1, 0.2]},
            {"name": "tip", "at": 1.0, "mass": 1.0, "inertia": 0.1},
        ],
        "supports": [{"at": 0.5, "to": [1.0, 0.0], "rotation": 3.0, "damping": [0.0, 2.0]}],
        "foundation": {"stiffness": "3 + s"},
        "states": {"valve": {"rate": "-valve", "initial": 2.0}},
        "parameters": {"gain": 3.0},
    }
    table["loads"] = {
        **ROD["loads"],
        "follower": [{"force": 2.0}, {"force": "gain*t", "at": 0.4}],
        "distributed_follower": {"force_per_length": [1.0, 2.0, 3.0, 4.0, 5.0]},
        "drag": {"normal": 1.0, "wind": ["t", 0.0]},
    }
    table["rod"] = {**ROD["rod"], "bending_stiffness": [5.0, 6.0, 5.0, 6.0, 5.0, 6.0]}
    scene = Scene.from_dict(table)

    def leaves(table: object, *path: str) -> Iterator[str]:
        if isinstance(table, dict | list):
            pairs = table.items() if isinstance(table, dict) else enumerate(table)
            for key, inner in pairs:
                yield from leaves(inner, *path, str(key))
        else:
            yield ".".join(path)

    modelled = scene.model_dump(
        exclude_none=True, exclude={"name": True, "initial": True, "integrate": True}
    )
    fields = {field.key for field in fields_of(scene)}
    starts = {".".join(place) for place in starts_of(scene)}
    chosen = {"rod.links", "rod.boundary", "rod.inertia", "bodies.0.name", "bodies.1.name"}
    assert set(leaves(modelled)) - fields - starts == chosen


def test_terms_that_anchor_a_rod_can_be_added_and_taken_away() -> None:
    scene = Scene.from_dict(ROD)
    form = form_of(scene)
    held = reshape(scene, replace(form, terms=(*form.terms, "foundation", "supports")), [])
    assert held.anchors.terms == ("foundation", "supports")
    assert max(held.parameters["support_stiffness_y"]) > 0
    assert reshape(held, form, []) == scene


def test_states_begin_where_they_are_told_to() -> None:
    scene = Scene.from_toml(SCENES / "sounding_rocket.toml")
    place = ("states", "gimbal", "initial")
    assert place in starts_of(scene)
    other = reshape(scene, form_of(scene), [(place, 0.05)])
    assert (other.structure, other.initial_state()[-1]) == (scene.structure, 0.05)


def test_fin_factors_can_be_moved_whether_by_part_or_by_joint() -> None:
    scene = Scene.from_toml(SCENES / "missile.toml")
    tail = ("loads", "external_damping", "fin_factor", "tail")
    assert edit(scene, [(tail, 7.0)]).parameters["fin_factor"][-1] == 7.0
    every = [1.0] * 21
    listed = edit(scene, [(tail[:-1], every)])
    assert edit(listed, [((*tail[:-1], "3"), 9.0)]).parameters["fin_factor"][3] == 9.0


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0, 0.0, "1", None])
def test_nonsense_leaves_the_scene_as_it_was(value: object) -> None:
    scene = Scene.from_toml(SCENES / "missile.toml")
    with pytest.raises(SceneError, match=r"rod\.mass"):
        edit(scene, [(("rod", "mass"), value)])
    assert scene == Scene.from_toml(SCENES / "missile.toml")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
@pytest.mark.parametrize("boundary", ["free", "cantilever", "clamped", "pinned"])
def test_every_scene_can_be_held_in_every_way(path: Path, boundary: str) -> None:
    scene = Scene.from_toml(path)
    terms = ("follower", "gravity", "internal_damping", "external_damping", "tip_load")
    forms = [Form(5, boundary, "lumped", ()), Form(6, boundary, "uniform", terms)]
    # Massless links carry no body that has inertia.
    for form in forms[any(body.inertia for body in scene.bodies) :]:
        other = reshape(scene, form, [])
        assert form_of(other) == form
        assert other.initial_state().size == 2 * (6 - (boundary == "cantilever")) + (
            4 if boundary == "free" else 0
        ) - 2 * (form.links == 5) + len(scene.states)


def test_form_that_cannot_be_is_refused() -> None:
    scene = Scene.from_toml(SCENES / "missile.toml")
    for form, field in (
        (Form(0, "free", "uniform", ()), "rod.links"),
        (Form(1, "cantilever", "uniform", ()), "rod.links"),
        (Form(3, "glued", "uniform", ()), "rod.boundary"),
    ):
        with pytest.raises(SceneError) as refused:
            reshape(scene, form, [])
        assert refused.value.field == field
    with pytest.raises(SceneError, match=r"initial\.phi"):
        reshape(scene, form_of(scene), [(("initial", "phi"), "__import__('os')")])
