"""Events of a scene: which quantities there are, and what is said of those that are not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rodgen.loading import build
from rodgen.model.rod import BOUNDARIES
from rodgen.scene import Scene, SceneError
from tests.scene.tables import table_of

DERIVED = (
    *("tip_x", "tip_y", "centre_of_gravity_x", "centre_of_gravity_y"),
    *("kinetic_energy", "spring_energy", "gravity_energy", "total_energy"),
    *("inertia_x", "inertia_y", "product_xy"),
)


def _scene(*events: Any, boundary: str = "free", links: int = 3) -> Scene:
    rod = {"links": links, "boundary": boundary}
    return Scene.from_dict(table_of(rod=rod, events=[*events]))


def _event(**changes: Any) -> dict[str, Any]:
    return {"quantity": "phi_1", "value": 1.5, **changes}


def test_events_from_toml(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(
        """
        name = "test"
        [rod]
        links = 50
        length = 1.0
        bending_stiffness = 1.0
        mass = 1.0
        [[events]]
        name = "tail turns"
        quantity = "phi_49"
        value = 1.5
        direction = "rising"
        action = "stop"
        [[events]]
        quantity = "tip_x"
        value = -2
        """
    )
    first, second = Scene.from_toml(path).events
    assert first.name == "tail turns"
    assert (first.direction, first.action) == ("rising", "stop")
    assert (second.direction, second.action) == ("either", "record")
    assert (second.name, second.value) == ("tip_x = -2.0", -2.0)


def test_a_scene_without_events_has_none() -> None:
    assert _scene().events == []


def test_events_survive_other_settings() -> None:
    scene = _scene(_event(), _event(name="again"))
    assert scene.with_integrate(rtol=1e-6).events == scene.events


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_names_are_those_of_the_module(boundary: str) -> None:
    """From the scene alone: every name of STATE, every derived quantity, and no others."""
    names = [f"{name}{i}" for name in ("x", "y", "vx", "vy") for i in range(2)]
    names += [f"{name}_{i}" for name in ("phi", "omega") for i in range(5)]
    names += [f"joint_{i}_{axis}" for i in range(6) for axis in "xyz"]
    names += [*DERIVED, "phi", "phi_{}", "joint_1", "tip", "energy_balance", "principal_angle"]

    def allowed(name: str) -> bool:
        try:
            _scene(_event(quantity=name), boundary=boundary)
        except SceneError:
            return False
        return True

    model = build(_scene(boundary=boundary), "numpy")
    # Joints that do not move cross nothing: joint 0 where it is held, joint 1 of a held link.
    first = {"free": 0, "cantilever": 2, "clamped": 1, "pinned": 1}[boundary]
    joints = [f"joint_{i}_{axis}" for i in range(first, 4) for axis in "xy"]
    assert {*filter(allowed, names)} == {*model.STATE, *DERIVED, *joints}


REFUSED: list[tuple[Any, str, str, str]] = [
    (_event(quantity="phi_3"), "events[0].quantity", "'phi_3'", "phi_0 to phi_2"),
    (_event(quantity="phi_01"), "events[0].quantity", "'phi_01'", "phi_0 to phi_2"),
    (_event(quantity="phi_-1"), "events[0].quantity", "'phi_-1'", "phi_0 to phi_2"),
    (_event(quantity="phi_{}"), "events[0].quantity", "'phi_{}'", "phi_0 to phi_2"),
    (_event(quantity="phi_\u0661"), "events[0].quantity", "phi_", "phi_0 to phi_2"),
    (_event(quantity="phi_" + "9" * 5000), "events[0].quantity", "phi_999", "phi_0 to phi_2"),
    (_event(quantity="joint_4_x"), "events[0].quantity", "'joint_4_x'", "joint_0_x to joint_3_x"),
    (_event(quantity="tip"), "events[0].quantity", "'tip'", "one of x0, y0, phi_0"),
    (_event(quantity=""), "events[0].quantity", "''", "product_xy"),
    (_event(quantity=3), "events[0].quantity", "3", "text"),
    ({"value": 1.0}, "events[0].quantity", "(missing)", "given"),
    ({"quantity": "x0"}, "events[0].value", "(missing)", "given"),
    (_event(value="1"), "events[0].value", "'1'", "a number"),
    (_event(value=float("nan")), "events[0].value", "nan", "finite"),
    (_event(value=float("inf")), "events[0].value", "inf", "finite"),
    (_event(value=1e61), "events[0].value", "1e+61", "at most 1e+60"),
    (_event(direction="up"), "events[0].direction", "'up'", "one of rising, falling, either"),
    (_event(direction=1), "events[0].direction", "1", "text"),
    (_event(action="halt"), "events[0].action", "'halt'", "one of record, stop"),
    (_event(name=""), "events[0].name", "''", "1 to 64 printable characters"),
    (_event(name=" "), "events[0].name", "' '", "1 to 64 printable characters"),
    (_event(name="a\nb"), "events[0].name", "nb'", "1 to 64 printable characters"),
    (_event(name="a" * 65), "events[0].name", "'aaa", "1 to 64 printable characters"),
    (_event(name=7), "events[0].name", "7", "text"),
    (_event(colour=1), "events[0].colour", "1", "known: quantity, value, direction, action, name"),
    ("phi_1", "events[0]", "'phi_1'", "a table"),
]


@pytest.mark.parametrize(("event", "field", "value", "allowed"), REFUSED)
def test_what_is_wrong_is_named(event: Any, field: str, value: str, allowed: str) -> None:
    with pytest.raises(SceneError) as caught:
        _scene(event)
    assert caught.value.field == field
    message = str(caught.value)
    assert message.startswith(f"{field} = ")
    assert value in message
    assert allowed in message
    assert len(message.splitlines()) == 1


def test_the_place_in_the_array_is_named() -> None:
    with pytest.raises(SceneError, match=r"^events\[1\]\.action = 'halt': must be one of"):
        _scene(_event(), _event(action="halt"))


def test_one_table_is_no_array() -> None:
    rod = {"links": 3, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}
    with pytest.raises(SceneError, match=r"events = .*: must be an array of tables, \[\[events\]"):
        Scene.from_dict({"name": "test", "rod": rod, "events": _event()})


@pytest.mark.parametrize(
    "pair",
    [
        (_event(name="a"), _event(name="a", value=2.0)),
        (_event(direction="rising"), _event(direction="falling")),  # both "phi_1 = 1.5"
        (_event(name="phi_1 = 1.5", value=7.0), _event()),
    ],
)
def test_names_are_unique(pair: tuple[dict[str, Any], dict[str, Any]]) -> None:
    with pytest.raises(SceneError, match=r"events\[2\]\.name = .*: must be unlike that of events"):
        _scene(pair[0], _event(name="between"), pair[1])
    _scene(*({**event, "name": str(i)} for i, event in enumerate(pair)))


def test_held_links_have_no_state() -> None:
    with pytest.raises(SceneError, match="one of phi_1 to phi_2, omega_1 to omega_2, joint_2_x"):
        _scene(_event(quantity="phi_0"), boundary="cantilever")


def test_a_single_link_is_no_range() -> None:
    with pytest.raises(SceneError, match="one of phi_0, omega_0, joint_1_x, joint_1_y, centre"):
        _scene(_event(), boundary="pinned", links=1)


def test_names_of_a_million_links_are_not_listed() -> None:
    with pytest.raises(SceneError, match="phi_0 to phi_999999"):
        _scene(_event(quantity="phi_1000000"), links=10**6)
