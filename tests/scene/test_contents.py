"""What a scene holds: its loads and their times, its bodies, supports and states."""

from __future__ import annotations

import math

import pytest

from rodgen.scene import Scene
from rodgen.scene.contents import contents, in_words
from tests.scene.tables import table_of


@pytest.mark.parametrize(("table", "key"), [("follower", "force"), ("tip", "x"), ("tip", "y")])
def test_force_without_t_is_a_number(table: str, key: str) -> None:
    text = Scene.from_dict(table_of(loads={table: {key: "2*150"}}))
    number = Scene.from_dict(table_of(loads={table: {key: 300.0}}))
    assert text.structure == number.structure
    assert text.parameters == number.parameters
    assert 300.0 in text.parameters.values()
    assert text.breaks() == []


def test_forces_in_t_are_part_of_the_structure_and_no_parameters() -> None:
    loads = {"tip": {"y": "abs(t - 2)", "x": 5.0}, "follower": {"force": "min(t, 3)"}}
    scene = Scene.from_dict(table_of(loads=loads))
    assert scene.structure.expressions == (
        ("follower_force", "min(t, follower_force_1)"),
        ("tip_force_y", "abs(t - tip_force_y_1)"),
    )
    assert scene.parameters["tip_force_x"] == 5.0
    assert not {"follower_force", "tip_force_y"} & set(scene.parameters)
    shown = {piece.piece: piece.reason for piece in contents(scene)}
    assert shown["tip load"] == "y is a function of t, part of the code: abs(t - 2)"
    assert shown["follower"] == "force is a function of t, part of the code: min(t, 3)"


def test_what_a_scene_holds_names_every_load_body_support_and_state() -> None:
    loads = {
        "follower": [{"force": 1.0}, {"force": "2*phi(0)", "at": 0.5}, {"force": 3.0, "at": 0.1}],
        "gravity": {},
    }
    scene = Scene.from_dict(
        table_of(
            rod={"links": 5},
            loads=loads,
            bodies=[{"name": "engine", "at": 1.0, "mass": 2.0}],
            supports=[{"at": 0.3, "stiffness": [0.0, 7.0]}, {"at": 0.9, "rotation": 4.0}],
            foundation={"stiffness": 8.0},
            states={"lag": {"rate": "-lag"}},
        )
    )
    present = {piece.piece: piece.reason for piece in contents(scene) if piece.present}
    first, *rest = (name for name in present if name.startswith("follower"))
    assert [first, *rest] == ["follower", "follower 2", "follower 3"]
    assert "s = 0.5" in present["follower 2"]
    assert "phi(0)" in present["follower 2"]
    assert "link 0" in present["follower 3"]
    assert {"gravity", "body engine", "support 0", "support 1", "state lag"} <= {*present}
    assert "7 N/m along y" in present["support 0"]
    assert "4 N m/rad" in present["support 1"]
    assert in_words(scene) == [
        "follower",
        "follower 2",
        "follower 3",
        "gravity",
        "foundation",
        "2 supports",
        "state lag",
    ]


def test_break_points_of_all_forces_are_those_of_thetable_of() -> None:
    loads = {
        "follower": {"force": "max(t - 3, 0) + abs(t - 0.1*3)"},
        # the same times but for a rounding
        "tip": {"x": "1 if t < 3 else 2", "y": "abs(10*t - 3) + abs(sin(t))"},
    }
    breaks = Scene.from_dict(table_of(loads=loads, integrate={"span": [0, 4]})).breaks()
    assert breaks == pytest.approx([0.3, 3.0, math.pi], abs=1e-13)


def test_first_pole_of_all_forces_is_that_of_thetable_of() -> None:
    loads = {"follower": {"force": "1/(t - 3)"}, "tip": {"x": "2/(t - 2)", "y": "t"}}
    at, force = Scene.from_dict(table_of(loads=loads)).course.pole() or (None, None)
    assert at == 2.0
    assert force is not None
    assert force.not_finite(2.0) == "loads.tip.x = '2/(t - 2)' is not finite at t = 2"
    assert Scene.from_dict(table_of(loads={"tip": {"y": "1/(t - 30)"}})).course.pole() is None


@pytest.mark.parametrize("boundary", ["free", "clamped", "pinned"])
def test_one_lumped_link_is_a_rod(boundary: str) -> None:
    scene = Scene.from_dict(table_of(rod={"links": 1, "inertia": "lumped", "boundary": boundary}))
    assert scene.structure.inertia == "lumped"
    assert len(scene.initial_state()) == (6 if boundary == "free" else 2)
    present = {piece.piece: piece.present for piece in contents(scene)}
    assert not present["rotary springs"]
    assert not present["rotary inertia of links"]
    assert present["root spring"] == (boundary == "clamped")
