"""A scene with its own parameters is itself, and what is computed from others is said to be so."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rodgen.scene import Scene, SceneError
from rodgen.scene.overrides import with_parameters

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
SCENES = sorted(Path("scenes").glob("*.toml"), key=str)


@pytest.mark.parametrize("path", [*SCENES, None], ids=lambda path: path.stem if path else "rocket")
def test_a_scene_with_its_own_parameters_is_itself(path: Path | None) -> None:
    scene = Scene.from_toml(path) if path else Scene.from_dict(ROCKET)
    own = scene.parameters
    assert with_parameters(scene, own) == scene
    assert with_parameters(scene, {name: np.array(value) for name, value in own.items()}) == scene


@pytest.mark.parametrize(
    "name",
    [
        "mass",
        "joint_stiffness",
        "steady_mass",
        "body_tank_along",
        "foundation_angle",
        "foundation_stiffness",
        "support_x",
    ],
)
def test_another_value_of_what_is_computed_is_refused(name: str) -> None:
    scene = Scene.from_dict(ROCKET)
    value = np.asarray(scene.parameters[name]) + 1.0
    with pytest.raises(SceneError) as refused:
        with_parameters(scene, {name: value.tolist()})
    assert refused.value.field == name


def test_what_follows_from_a_change_may_be_given_as_it_was() -> None:
    scene = Scene.from_dict(ROCKET)
    changed = with_parameters(scene, scene.parameters | {"length": 4.0})
    assert changed.rod.length == 4.0
    assert changed.parameters["joint_stiffness"] != scene.parameters["joint_stiffness"]


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
    changed = with_parameters(scene, given)
    assert changed.parameters | given == changed.parameters
    assert changed.structure == scene.structure
    assert changed.distribution.body_mass == [8.0, 1.0]
