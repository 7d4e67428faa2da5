"""Events of a scene: which quantities there are, and what is said of those that are not."""

from __future__ import annotations

import math
from typing import Any

from rodgen.errors import InputError, Missing
from rodgen.loading import build
from rodgen.model.rod import BOUNDARIES
from rodgen.scene import Scene
from tests.scene.tables import scene_of
from tests.told import refused

DERIVED = (
    *("tip_x", "tip_y", "centre_of_gravity_x", "centre_of_gravity_y"),
    *("kinetic_energy", "spring_energy", "gravity_energy", "total_energy"),
    *("inertia_x", "inertia_y", "product_xy"),
)


def _scene(*events: Any, boundary: str = "free", links: int = 3) -> Scene:
    return scene_of(rod={"links": links, "boundary": boundary}, events=[*events])


def _event(**changes: Any) -> dict[str, Any]:
    return {"quantity": "phi_1", "value": 1.5, **changes}


def test_events_have_names_directions_and_actions() -> None:
    named = _event(name="turns", direction="rising", action="stop")
    scene = _scene(named, {"quantity": "tip_x", "value": -2})
    first, second = scene.events
    assert first.name == "turns"
    assert (first.direction, first.action) == ("rising", "stop")
    assert (second.direction, second.action) == ("either", "record")
    assert (second.name, second.value) == ("tip_x = -2.0", -2.0)
    assert scene.with_integrate(rtol=1e-6).events == scene.events
    assert _scene().events == []


def test_names_are_those_of_the_module() -> None:
    """From the scene alone: every name of STATE, every derived quantity, and no others."""
    names = [f"{name}{i}" for name in ("x", "y", "vx", "vy") for i in range(2)]
    names += [f"{name}_{i}" for name in ("phi", "omega") for i in range(5)]
    names += [f"joint_{i}_{axis}" for i in range(6) for axis in "xyz"]
    names += [*DERIVED, "phi", "phi_{}", "joint_1", "tip", "energy_balance", "principal_angle"]

    def allowed(name: str, boundary: str) -> bool:
        try:
            _scene(_event(quantity=name), boundary=boundary, links=2)
        except InputError:
            return False
        return True

    # Joints that do not move cross nothing: joint 0 where it is held, joint 1 of a held link.
    first = {"free": 0, "cantilever": 2, "clamped": 1, "pinned": 1}
    for boundary in BOUNDARIES:
        model = build(_scene(boundary=boundary, links=2), "numpy")
        joints = [f"joint_{i}_{axis}" for i in range(first[boundary], 3) for axis in "xy"]
        found = {name for name in names if allowed(name, boundary)}
        assert found == {*model.STATE, *DERIVED, *joints}


WRONG: list[tuple[str, Any]] = [
    *(("quantity", f"phi_{i}") for i in ("3", "01", "-1", "{}", "\u0661", "9" * 5000)),
    *(("quantity", value) for value in ("joint_4_x", "tip", "", 3)),
    *(("value", value) for value in ("1 rad", math.nan, math.inf, 1e61)),
    *(("direction", value) for value in ("up", 1)),
    *(("action", value) for value in ("halt", None)),
    *(("name", value) for value in ("", " ", "a\nb", "a" * 65, 7)),
    ("colour", 1),
]


def test_what_is_wrong_is_named() -> None:
    for key, value in WRONG:
        told = refused(_scene, _event(name="other"), _event(**{key: value}))
        assert told[:2] == (f"events[1].{key}", value)
    assert refused(_scene, {"value": 1.0})[:2] == ("events[0].quantity", Missing)
    assert refused(_scene, {"quantity": "x0"})[:2] == ("events[0].value", Missing)
    assert refused(_scene, "phi_1")[:2] == ("events[0]", "phi_1")
    assert refused(scene_of, events=_event())[:2] == ("events", _event())
    assert _scene(_event(value=1e60, name="a" * 64))


def test_names_are_unique() -> None:
    for pair in (
        (_event(name="a"), _event(name="a", value=2.0)),
        (_event(direction="rising"), _event(direction="falling")),  # both "phi_1 = 1.5"
        (_event(name="phi_1 = 1.5", value=7.0), _event()),
    ):
        told = refused(_scene, pair[0], _event(name="between"), pair[1])
        assert told[:2] == ("events[2].name", pair[0].get("name", "phi_1 = 1.5"))
        _scene(*({**event, "name": str(i)} for i, event in enumerate(pair)))


def test_the_quantities_that_there_are_are_named() -> None:
    """By their ranges: not those of a link that is held, and not a million of them."""
    for quantity, boundary, links, first, last in (
        ("phi_3", "free", 3, "phi_0", "phi_2"),
        ("joint_4_x", "free", 3, "joint_0_x", "joint_3_x"),
        ("phi_0", "cantilever", 3, "phi_1", "phi_2"),
        ("phi_1", "pinned", 1, "phi_0", "omega_0"),
        ("phi_1000000", "free", 10**6, "phi_0", "phi_999999"),
    ):
        told = refused(_scene, _event(quantity=quantity), boundary=boundary, links=links)
        assert first in told.allowed
        assert last in told.allowed
        assert len(told.allowed) < 1000
    assert "phi_0 " not in refused(_scene, _event(quantity="phi_0"), boundary="cantilever").allowed
