"""What a scene holds: its loads and their times, its bodies, supports and states; a scene with its
own parameters is itself, and what is computed from others is said to be so."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rodgen.scene import Scene
from rodgen.scene.model_contents import describe_loads, model_parts
from tests.scene.tables import put, scene_of, table_of


def test_text_without_t_and_s_is_a_number() -> None:
    for field in ("loads.follower.force", "loads.tip.x", "loads.tip.y", "rod.bending_stiffness"):
        tables = [table_of(), table_of()]
        for table, value in zip(tables, ("2*150", 300.0), strict=True):
            put(table, field, value)
        text, number = map(Scene.from_dict, tables)
        assert text.structure == number.structure
        assert text.parameters == number.parameters
        assert 300.0 in text.parameters.values()
        assert text.breaks() == []


def test_forces_in_t_are_part_of_the_structure_and_no_parameters() -> None:
    loads = {"tip": {"y": "abs(t - 2)", "x": 5.0}, "follower": {"force": "min(t, 3)"}}
    scene = scene_of(loads=loads)
    assert scene.structure.expressions == (
        ("follower_force", "min(t, follower_force_1)"),
        ("tip_force_y", "abs(t - tip_force_y_1)"),
    )
    assert scene.parameters["tip_force_x"] == 5.0
    assert not {"follower_force", "tip_force_y"} & set(scene.parameters)


def test_what_a_scene_holds_names_every_load_body_support_and_state() -> None:
    loads = {
        "follower": [{"force": 1.0}, {"force": "2*phi(0)", "at": 0.5}, {"force": 3.0, "at": 0.1}],
        "gravity": {},
    }
    scene = scene_of(
        loads=loads,
        bodies=[{"name": "engine", "at": 1.0, "mass": 2.0}],
        supports=[{"at": 0.3, "stiffness": [0.0, 7.0]}, {"at": 0.9, "rotation": 4.0}],
        foundation={"stiffness": 8.0},
        states={"lag": {"rate": "-lag"}},
    )
    present = {piece.piece: piece.reason for piece in model_parts(scene) if piece.present}
    followers = ["follower", "follower 2", "follower 3"]
    assert [name for name in present if name.startswith("follower")] == followers
    for piece, *said in (
        ("follower 2", "s = 0.5", "phi(0)"),
        ("follower 3", "link 0"),
        ("support 0", "7 N/m"),
        ("support 1", "4 N m/rad"),
        *(("gravity",), ("body engine",), ("state lag",)),
    ):
        assert all(word in present[piece] for word in said)
    assert describe_loads(scene) == [*followers, "gravity", "foundation", "2 supports", "state lag"]


def test_what_a_scene_holds_says_how_its_base_moves() -> None:
    def reasons(boundary: str, **tables: Any) -> dict[str, str]:
        scene = scene_of(rod={"boundary": boundary}, **tables)
        return {piece.piece: piece.reason for piece in model_parts(scene)}

    moved = reasons("pinned", base={"x": "0.2*t**2", "y": "sin(3*t)"})
    assert all(text in moved["base"] for text in ("x is a function of t", "0.2 * t", "sin(3 * t)"))
    assert "[base]" in moved["translation x0, y0"]
    still = reasons("pinned")
    assert (still["base"], "fixed" in still["translation x0, y0"]) == ("no table [base]", True)
    assert "nothing holds" in reasons("free")["base"]


def test_break_points_of_all_forces_are_those_of_the_scene() -> None:
    loads = {
        "follower": {"force": "max(t - 3, 0) + abs(t - 0.1*3)"},
        # the same times but for a rounding
        "tip": {"x": "1 if t < 3 else 2", "y": "abs(10*t - 3) + abs(sin(t))"},
    }
    breaks = scene_of(loads=loads, integrate={"span": [0, 4]}).breaks()
    assert breaks == pytest.approx([0.3, 3.0, math.pi], abs=1e-13)


# Parameters of its own, and others ----------------------------------------------------------------

ROCKET: dict[str, Any] = {
    "name": "rocket",
    "parameters": {"burn": 2.0},
    "rod": {
        "links": 4,
        "length": 3.0,
        "mass_per_length": "5 + 3*(1 - min(t/burn, 1))*s",
        "bending_stiffness": "40*(1 + s)",
        "spring": "k*(d + 5*d**3)",
    },
    "bodies": [
        {"name": "tank", "at": 0.5, "mass": "9 - 2*t", "inertia": 0.5},
        {"name": "nose", "at": 0.0, "mass": 1.0},
    ],
    "supports": [{"at": 0.3, "stiffness": [1.0, 2.0]}],
    "foundation": {"stiffness": "1 + s"},
    "loads": {
        "follower": [{"force": "3*min(t/0.5, 1)", "angle": "z"}, {"force": 2.0, "at": 0.3}],
        "distributed_follower": {"force_per_length": "4*s"},
    },
    "states": {"z": {"rate": "0.3*phi(0.2) - z"}},
    "integrate": {"span": [0.0, 3.0]},
}
SCENES = sorted((Path(__file__).parents[2] / "scenes").glob("*.toml"))


def test_every_scene_of_the_project_can_begin() -> None:
    """And one that has everything."""
    for scene in (Scene.from_dict(ROCKET), *map(Scene.from_toml, SCENES)):
        assert np.isfinite(scene.initial_state()).all()
    assert SCENES


def test_numbers_of_masses_and_several_of_one_expression_are_changed() -> None:
    scene = Scene.from_dict(ROCKET)
    given = {
        "mass_per_length_1": 6.0,
        "mass_per_length_2": 2.0,
        "body_tank_mass_1": 8.0,
        "follower_force_1": 4.0,
        "follower_force_2": 0.25,
        "spring_1": 7.0,
    }
    changed = scene.replace(
        {
            "rod.mass_per_length.0": 6.0,
            "rod.mass_per_length.1": 2.0,
            "bodies.tank.mass.0": 8.0,
            "loads.follower.0.force.0": 4.0,
            "loads.follower.0.force.1": 0.25,
            "rod.spring.0": 7.0,
        }
    )
    assert changed.parameters | given == changed.parameters
    assert changed.structure == scene.structure
    assert changed.distribution.body_masses == [8.0, 1.0]
