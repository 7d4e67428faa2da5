"""Tables of stops, walls and friction: what they may be, and what follows from them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen.scene.structure import Structure
from tests.told import refused

STOP = {"at": 1.0, "direction": 0.0, "stiffness": 10.0}
JOINT_STOP = {"at": 0.5, "direction": 1, "gap": 0.1, "stiffness": 10.0}
WALL = {"normal": "pi/2", "stiffness": 10.0}


def scene(boundary: str = "clamped", **tables: Any) -> Scene:
    rod = {"links": 4, "length": 2.0, "bending_stiffness": 3.0, "mass": 1.0, "boundary": boundary}
    return Scene.from_dict({"name": "touching", "rod": rod} | tables)


@pytest.mark.parametrize(
    ("tables", "field"),
    [
        ({"stops": [STOP | {"exponent": 0.9}]}, "stops[0].exponent"),
        ({"stops": [STOP, STOP | {"stiffness": 0.0}]}, "stops[1].stiffness"),
        ({"stops": [STOP | {"damping": -1.0}]}, "stops[0].damping"),
        ({"stops": [STOP | {"at": 1.5}]}, "stops[0].at"),
        ({"stops": [STOP | {"force": 1.0}]}, "stops[0].force"),
        ({"stops": [STOP | {"at": 0.0}]}, "stops[0].at"),
        ({"stops": STOP}, "stops"),
        ({"stops": [STOP] * 101}, "stops"),
        ({"joint_stops": [JOINT_STOP | {"at": 0.4}]}, "joint_stops[0].at"),
        ({"joint_stops": [JOINT_STOP | {"at": 1.0}]}, "joint_stops[0].at"),
        ({"joint_stops": [JOINT_STOP | {"direction": 0}]}, "joint_stops[0].direction"),
        ({"walls": [WALL | {"friction": 0.3}]}, "walls[0].friction_speed"),
        ({"walls": [WALL | {"friction_speed": 0.1}]}, "walls[0].friction_speed"),
        ({"walls": [WALL | {"point": [1.0]}]}, "walls[0].point"),
        ({"loads": {"joint_friction": {"rate": 0.0}}}, "loads.joint_friction.rate"),
        ({"loads": {"tip": {"x": "stop(1)"}}, "stops": [STOP]}, "loads.tip.x"),
        ({"loads": {"tip": {"x": "joint_stop(0)"}}}, "loads.tip.x"),
        ({"states": {"push_stop": {"rate": 1.0}}}, "states.push_stop"),
        ({"loads": {"tip": {"x": "stop(0.5)"}}, "stops": [STOP]}, "loads.tip.x"),
        (
            {"stops": [STOP], "events": [{"quantity": "push_wall", "value": 1.0}]},
            "events[0].quantity",
        ),
    ],
)
def test_what_no_module_can_have_is_refused(tables: dict[str, Any], field: str) -> None:
    told = refused(scene, **tables)
    assert told.field == field
    assert told.allowed


def test_both_frictions_of_joints_and_taken_names_are_refused() -> None:
    both = {"moment_per_joint": 1.0, "moment_per_length": 1.0, "rate": 0.1}
    for wrong in (both, {"rate": 0.1}):
        told = refused(scene, loads={"joint_friction": wrong})
        assert told.field == "loads.joint_friction.moment_per_joint"
    event = {"quantity": "tip_x", "value": 1.0, "name": "stop touches"}
    assert refused(scene, stops=[STOP], events=[event]).field == "events[0].name"
    # Without a stop the name is free.
    assert scene(events=[event]).events[0].name == "stop touches"


def test_a_stop_on_a_held_link_is_refused() -> None:
    told = refused(scene, boundary="cantilever", stops=[STOP | {"at": 0.1}])
    assert told.field == "stops[0].at"
    assert refused(scene, boundary="pinned", joint_stops=[JOINT_STOP | {"at": 0.0}]).field
    assert scene(joint_stops=[JOINT_STOP | {"at": 0.0}]).structure.contacts


def test_files_and_structures_keep_them() -> None:
    given = scene(
        stops=[STOP | {"to": [2.0, "1/3"], "exponent": 1.5}, STOP | {"at": 0.6}],
        joint_stops=[JOINT_STOP],
        walls=[WALL | {"friction": 0.2, "friction_speed": "1e-3", "edge": 0.0}],
    )
    again = Scene.from_dict(given.to_dict())
    assert again == given
    assert again.structure.terms == (
        *("stop+exponent".replace("+", "@"), "stop@2+2/5", "joint_stop@2", "wall@edge+friction"),
    )
    for text in ("stop@6", "stop@1+3/2", "stop@1+damping+exponent", "stop@spring", "wall@2"):
        with pytest.raises(InputError):
            Structure(4, "clamped", terms=(text,))
    with pytest.raises(InputError):
        Structure(4, "pinned", terms=("joint_stop@0",))


def test_places_of_stops_follow_the_rod_where_none_is_given() -> None:
    system = rodgen.System(scene(stops=[STOP | {"at": 0.5}]))
    assert system.parameter("stop_x") == pytest.approx(1.0)
    assert system.at({"rod.length": 3.0}).parameter("stop_x") == pytest.approx(1.5)
    fixed = rodgen.System(scene(stops=[STOP | {"to": [0.3, 0.0]}]))
    moved = fixed.at({"rod.length": 3.0, "stops.0.gap": 0.7, "stops.0.to.1": 0.1})
    found = {name: moved.parameter(f"stop_{name}") for name in ("x", "y", "gap")}
    assert found == {"x": 0.3, "y": 0.1, "gap": 0.7}
    # The same by way of another scene.
    other = rodgen.System(fixed.scene.replace({"rod.length": 3.0, "stops.0.gap": 0.7}))
    assert other.parameter("stop_gap") == 0.7


def test_obstacles_have_what_pushes_to_their_right() -> None:
    made = scene(
        stops=[STOP | {"to": [2.0, 0.0], "gap": 0.5}], walls=[WALL | {"edge": 1.0}]
    ).obstacles
    line, table = made
    # A stop to the right of the tail, drawn upwards.
    np.testing.assert_allclose(line[:, 0], 2.5)
    assert line[1, 1] > line[0, 1]
    # The top of a table from the left to its edge, and down its side.
    np.testing.assert_allclose(table[1:, 0], 1.0, atol=1e-12)
    assert table[0, 0] < -10.0 < 0.0 < -table[2, 1]


def test_studies_count_touches_and_keep_pushes() -> None:
    flying = scene(
        boundary="free",
        walls=[{"normal": "-pi/2", "point": [0.0, 0.1], "stiffness": 1e4}],
        initial={"velocity": [0.0, 1.0]},
        integrate={"span": [0.0, 0.3], "method": "dop853"},
    )
    keep = ["count('wall touches')", "count('wall leaves at joint 2')", "max(push_wall)"]
    data = rodgen.study(flying, {"initial.velocity.1": [0.1, 1.0]}, keep=keep)
    assert data["count('wall touches')"].values.tolist() == [0, 5]
    assert data["count('wall leaves at joint 2')"].values.tolist() == [0, 1]
    least, most = data["max(push_wall)"].values
    # v sqrt(m k L) of a rod that stays straight.
    assert least == 0.0
    assert most == pytest.approx(np.sqrt(1.0 * 1e4 * 2.0), rel=0.05)
    assert data["max(push_wall)"].attrs["units"] == "N"
