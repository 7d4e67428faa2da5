"""Scenes with sensors and states of their own: what is taken, and what is refused."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np

from rodgen.errors import Missing
from rodgen.scene import Scene
from rodgen.system import System
from tests.scene.tables import put
from tests.told import refused

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
    moved = System(scene).at(y0=np.arange(14.0)).scene
    assert [state.initial for state in moved.states.values()] == [12.0, 13.0]
    assert moved.structure == scene.structure
    assert Scene.from_dict(scene.model_dump(exclude_none=True)) == scene


def test_numbers_of_laws_are_parameters() -> None:
    scene = _with()
    angle, rate = (tuple(f"{of}_{at}" for at in (1, 2)) for of in ("follower_angle", "gimbal_rate"))
    assert tuple(scene.structure.numbers) == (*angle, *rate, "lag")
    changed = scene.replace({"states.gimbal.rate.1": 0.75, "parameters.lag": 0.1})
    assert changed.structure == scene.structure
    assert changed.parameters["gimbal_rate_2"] == 0.75
    assert changed.parameters["lag"] == 0.1


def test_where_a_sensor_is_belongs_to_the_structure() -> None:
    other = GIMBAL | {"rate": GIMBAL["rate"].replace("0.3", "0.4")}
    assert _with(states={"gimbal": other}).structure.hash != _with().structure.hash
    one, two = (_with(states={"a": {"rate": text}}, loads={}) for text in ("x(1)", "x( 1.0 )"))
    assert one.structure == two.structure


def test_events_watch_states() -> None:
    assert _with(events=[{"quantity": "gimbal", "value": 0.1}]).events[0].quantity == "gimbal"
    told = refused(_with, events=[{"quantity": "rudder", "value": 0.1}])
    assert told[:2] == ("events[0].quantity", "rudder")


def test_a_rate_that_cannot_be_is_refused() -> None:
    wrong = "phi(1.5)", "phi(-0.1)", "phi(a)", "phi()", "phi", "b", "interp(t, [a, 1], [0, 1])"
    for rate in wrong:
        assert refused(_with, loads={}, states={"a": {"rate": rate}})[:2] == ("states.a.rate", rate)
    for table, key, value in (
        ({"rate": 1.0, "start": 0.0}, "start", 0.0),
        ({"initial": 0.0}, "rate", Missing),
        ({"rate": 1.0, "initial": "t"}, "initial", "t"),
    ):
        assert refused(_with, loads={}, states={"a": table})[:2] == (f"states.a.{key}", value)


def test_names_of_other_things_are_no_names_of_states() -> None:
    """Of the time, loads, parameters, events and, by their letters' size, of other numbers."""
    for name in (
        *("t", "follower", "tip", "follower_force", "phi_0", "tip_x", "joint_2_x", "LAG", "1st"),
        *("A", "a_rate_1"),
    ):
        states = {"a": {"rate": 1.0}, name: {"rate": 1.0}}
        assert refused(_with, loads={}, states=states)[:2] == (f"states.{name}", name)
    told = refused(_with, parameters={"gimbal_rate_2": 1.0}, states={"gimbal": {"rate": 1.0}})
    assert told[:2] == ("parameters.gimbal_rate_2", "gimbal_rate_2")


def test_what_cannot_follow_the_motion_is_refused() -> None:
    for field, law in (
        ("loads.drag.normal", "9.81*phi(0)"),
        ("initial.phi", "phi(0.3)"),
        ("initial.phi", "gimbal"),
        ("rod.bending_stiffness", "3*(1 + phi(0.5))"),
        ("rod.mass_per_length", "3*(1 + phi(0.5))"),
    ):
        table = deepcopy(TABLE)
        put(table, field, law)
        if field == "rod.mass_per_length":
            put(table, "rod.mass", None)
        assert refused(Scene.from_dict, table)[:2] == (field, law)
