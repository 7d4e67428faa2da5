"""Scenes with sensors and states of their own: what is taken, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen.scene import Scene, SceneError
from rodgen.scene.overrides import with_parameters, with_state

GIMBAL = {"rate": "(-2*phi(0.3) - 0.5*omega(0.3) - gimbal)/lag", "initial": 0.25}
TABLE: dict[str, Any] = {
    "name": "steered",
    "parameters": {"lag": 0.05},
    "rod": {"links": 4, "length": 2.0, "mass": 3.0, "bending_stiffness": 30.0},
    "loads": {"follower": {"force": 40.0, "angle": "max(-0.1, min(0.1, gimbal))"}},
    "states": {"gimbal": GIMBAL, "turned": {"rate": "phi(1)"}},
}


def _with(**tables: Any) -> Scene:
    return Scene.from_dict(TABLE | tables)


def test_states_stand_behind_those_of_the_rod() -> None:
    scene = _with()
    assert scene.initial_state().tolist()[-2:] == [0.25, 0.0]
    assert len(scene.initial_state()) == 2 * 6 + 2
    moved = with_state(scene, np.arange(14.0))
    assert [state.initial for state in moved.states.values()] == [12.0, 13.0]
    assert moved.structure == scene.structure
    assert Scene.from_dict(scene.model_dump(exclude_none=True)) == scene


def test_numbers_of_laws_are_parameters() -> None:
    scene = _with()
    angle, rate = (tuple(f"{of}_{at}" for at in (1, 2)) for of in ("follower_angle", "gimbal_rate"))
    assert tuple(scene.structure.numbers) == (*angle, *rate, "lag")
    changed = with_parameters(scene, {"gimbal_rate_2": 0.75, "lag": 0.1})
    assert changed.structure == scene.structure
    assert changed.parameters["gimbal_rate_2"] == 0.75
    assert changed.parameters["lag"] == 0.1


def test_where_a_sensor_is_belongs_to_the_structure() -> None:
    other = GIMBAL | {"rate": GIMBAL["rate"].replace("0.3", "0.4")}  # type: ignore[attr-defined]
    assert _with(states={"gimbal": other}).structure.hash != _with().structure.hash
    one, two = (_with(states={"a": {"rate": text}}, loads={}) for text in ("x(1)", "x( 1.0 )"))
    assert one.structure == two.structure


def test_events_watch_states() -> None:
    assert _with(events=[{"quantity": "gimbal", "value": 0.1}]).events[0].quantity == "gimbal"
    with pytest.raises(SceneError):
        _with(events=[{"quantity": "rudder", "value": 0.1}])


@pytest.mark.parametrize(
    ("tables", "field"),
    [
        ({"states": {"a": {"rate": "phi(1.5)"}}}, "states.a.rate"),
        ({"states": {"a": {"rate": "phi(-0.1)"}}}, "states.a.rate"),
        ({"states": {"a": {"rate": "phi(a)"}}}, "states.a.rate"),
        ({"states": {"a": {"rate": "phi()"}}}, "states.a.rate"),
        ({"states": {"a": {"rate": "phi"}}}, "states.a.rate"),
        ({"states": {"a": {"rate": "b"}}}, "states.a.rate"),
        ({"states": {"a": {"rate": "interp(t, [a, 1], [0, 1])"}}}, "states.a.rate"),
        ({"states": {"a": {"rate": 1.0, "start": 0.0}}}, "states.a.start"),
        ({"states": {"a": {"initial": 0.0}}}, "states.a.rate"),
        ({"states": {"a": {"rate": 1.0, "initial": "0"}}}, "states.a.initial"),
        ({"states": {"t": {"rate": 1.0}}}, "states.t"),
        ({"states": {"follower": {"rate": 1.0}}}, "states.follower"),
        ({"states": {"tip": {"rate": 1.0}}}, "states.tip"),
        ({"states": {"follower_force": {"rate": 1.0}}}, "states.follower_force"),
        ({"states": {"phi_0": {"rate": 1.0}}}, "states.phi_0"),
        ({"states": {"tip_x": {"rate": 1.0}}}, "states.tip_x"),
        ({"states": {"joint_2_x": {"rate": 1.0}}}, "states.joint_2_x"),
        ({"states": {"LAG": {"rate": 1.0}}}, "states.LAG"),
        ({"states": {"a": {"rate": 1.0}, "A": {"rate": 1.0}}}, "states.A"),
        ({"states": {"a": {"rate": 1.0}, "a_rate_1": {"rate": 1.0}}}, "states.a_rate_1"),
        (
            {"parameters": {"gimbal_rate_2": 1.0}, "states": {"gimbal": {"rate": 1.0}}},
            "parameters.gimbal_rate_2",
        ),
        ({"states": {"1st": {"rate": 1.0}}}, "states.1st"),
        ({"loads": {"gravity": {"g": "9.81*phi(0)"}}}, "loads.gravity.g"),
        ({"initial": {"phi": "phi(0.3)"}}, "initial.phi"),
        ({"initial": {"phi": "gimbal"}}, "initial.phi"),
    ],
)
def test_refused(tables: dict[str, Any], field: str) -> None:
    table = TABLE | {"loads": {}, "states": {}} | tables
    with pytest.raises(SceneError) as refused:
        Scene.from_dict(table)
    assert refused.value.field == field


@pytest.mark.parametrize("key", ["bending_stiffness", "mass_per_length"])
def test_neither_stiffness_nor_mass_follows_the_motion(key: str) -> None:
    rod = {k: v for k, v in TABLE["rod"].items() if k not in (key, "mass")}
    rod |= {key: "3*(1 + phi(0.5))"} | ({"mass": 3.0} if key != "mass_per_length" else {})
    with pytest.raises(SceneError) as refused:
        _with(rod=rod)
    assert refused.value.field == f"rod.{key}"
