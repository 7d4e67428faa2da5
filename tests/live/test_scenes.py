"""Scenes as the page takes and gives them: texts, addresses, files of a folder, edited ones."""

from __future__ import annotations

import base64
import zlib
from pathlib import Path

import pytest

pytest.importorskip("tomli_w", reason="the extra view is not installed")

from rodgen.scene import Scene, SceneError
from rodgen.view.live.edits import edited, movable, scale_of
from rodgen.view.live.restructured import Form, form_of, restructured
from rodgen.view.live.scenes import (
    LARGEST,
    Folder,
    from_toml_text,
    packed,
    to_toml,
    unpacked,
)

SCENES = Path(__file__).parents[2] / "scenes"
FILES = sorted(SCENES.glob("*.toml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_scene_survives_text_and_address(path: Path) -> None:
    scene = Scene.from_toml(path)
    assert from_toml_text(to_toml(scene).encode()) == scene
    text = packed(scene)
    assert set(text) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_")
    assert unpacked(text) == scene


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
        unpacked(text)


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
    """What is moved arrives in the scene, under its name in the module, and stays in its module."""
    scene = Scene.from_toml(path)
    reached = {name: value for name, value in scene.parameters.items() if name != "fin_factor"}
    moved = dict(reached)
    for field in movable(scene):
        if field.value is None or "fin_factor" in field.path:
            continue
        low, high = field.reach(scale_of(field))
        assert low <= field.value <= high
        other = edited(scene, [(field.path, field.value + 0.25)])
        assert other.structure == scene.structure
        for name, value in other.parameters.items():
            if name != "fin_factor" and value != reached[name]:
                assert value == pytest.approx(reached[name] + 0.25)
                del moved[name]
    assert moved == {}


def test_fin_factors_can_be_moved_whether_by_part_or_by_joint() -> None:
    scene = Scene.from_toml(SCENES / "missile.toml")
    tail = ("loads", "external_damping", "fin_factor", "tail")
    assert edited(scene, [(tail, 7.0)]).parameters["fin_factor"][-1] == 7.0
    every = [1.0] * 21
    listed = edited(scene, [(tail[:-1], every)])
    assert edited(listed, [((*tail[:-1], "3"), 9.0)]).parameters["fin_factor"][3] == 9.0


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0, 0.0, "1", None])
def test_nonsense_leaves_the_scene_as_it_was(value: object) -> None:
    scene = Scene.from_toml(SCENES / "missile.toml")
    with pytest.raises(SceneError, match=r"rod\.mass"):
        edited(scene, [(("rod", "mass"), value)])
    assert scene == Scene.from_toml(SCENES / "missile.toml")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
@pytest.mark.parametrize("boundary", ["free", "cantilever", "clamped", "pinned"])
def test_every_scene_can_be_held_in_every_way(path: Path, boundary: str) -> None:
    scene = Scene.from_toml(path)
    terms = ("follower", "gravity", "internal_damping", "external_damping", "tip_load")
    for form in (Form(5, boundary, "lumped", ()), Form(6, boundary, "uniform", terms)):
        other = restructured(scene, form, {})
        assert form_of(other) == form
        assert other.initial_state().size == 2 * (6 - (boundary == "cantilever")) + (
            4 if boundary == "free" else 0
        ) - 2 * (form.links == 5)


def test_form_that_cannot_be_is_refused() -> None:
    scene = Scene.from_toml(SCENES / "missile.toml")
    for form, field in (
        (Form(0, "free", "uniform", ()), "rod.links"),
        (Form(1, "cantilever", "uniform", ()), "rod.links"),
        (Form(3, "glued", "uniform", ()), "rod.boundary"),
    ):
        with pytest.raises(SceneError) as refused:
            restructured(scene, form, {})
        assert refused.value.field == field
    with pytest.raises(SceneError, match=r"initial\.phi"):
        restructured(scene, form_of(scene), {"phi": "__import__('os')"})
