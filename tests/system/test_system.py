"""A system with other numbers is that of the scene with these numbers, to the bit."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen.scene.examples import examples, find_example
from rodgen.system import System
from tests.scene.tables import scene_of
from tests.told import refused

# A scene with everything that has numbers.
ROD = {"links": 4, "length": 2.0, "mass": 3.0, "bending_stiffness": 30.0}
TAPERED = {"links": 4, "length": 2.0, "bending_stiffness": "30*(2 - s)", "mass": None}
WHOLE: dict[str, Any] = {
    "rod": {**ROD, "boundary": "clamped", "clamp_angle": 0.1, "spring": "k*(d + c*d**3)"},
    "parameters": {"P0": 30.0, "c": 0.5, "lag": 0.2, "k0": 2.0},
    "loads": {
        "follower": [
            {"force": "P0*min(t/0.5, 1)", "angle": "max(-0.1, min(0.1, gimbal))"},
            {"force": 2.0, "at": 0.3},
        ],
        "tip": {"x": 1.0, "y": "-2*sin(3*t)"},
        "gravity": {},
        "internal_damping": {"coefficient": 0.01},
        "external_damping": {"coefficient": 0.5, "fin_factor": {"tail": 3.0}},
        "distributed_follower": {"force_per_length": 0.7},
        "drag": {"normal": 0.2, "wind": ["5*sin(t)", 0.0]},
    },
    "supports": [
        {"at": 0.3, "stiffness": [1.0, 2.0], "damping": [0.1, 0.0]},
        {"at": 0.8, "rotation": 3.0},
    ],
    "foundation": {"stiffness": 4.0, "damping": 0.1},
    "states": {"gimbal": {"rate": "(-2*phi(0.3) - gimbal)/lag", "initial": 0.05}},
    "initial": {"phi": 0.1, "omega": [0.1, 0.2, 0.3, 0.4]},
    "integrate": {"span": [0.0, 1.0]},
}


def numbers(table: Any, *keys: str) -> Iterator[tuple[str, float]]:
    """Keys of all numbers in tables and lists, with these."""
    if isinstance(table, dict | list):
        inner = table.items() if isinstance(table, dict) else enumerate(table)
        for key, value in inner:
            yield from numbers(value, *keys, str(key))
    elif isinstance(table, float):
        yield ".".join(keys), table


def scenes() -> Iterator[Scene]:
    yield scene_of(**WHOLE)
    yield scene_of(rod={**ROD, "mass": 3.0}, initial={"position": [1.0, 2.0], "phi": [0.1] * 4})
    tank = {"name": "tank", "at": 0.6, "mass": "8*exp(-t/2)", "inertia": 0.3}
    yield scene_of(
        rod={**TAPERED, "boundary": "pinned", "mass_per_length": "3*exp(-t)"},
        bodies=[tank, {"name": "nose", "at": 0.0, "mass": 1.0}],
        loads={"follower": {"force": "3*t"}, "internal_damping": {"coefficient": 0.01}},
    )
    yield from (Scene.from_toml(find_example(name)) for name in examples())


def _refusal(scene: Scene, changes: dict[str, float], t: float | None) -> InputError | None:
    """Why a scene is refused at a time, if it is."""
    try:
        System(scene.replace(changes)).at(t=t)
    except InputError as error:
        return error
    return None


@pytest.mark.parametrize("t", [None, 0.25])
def test_every_number_of_a_scene_is_what_the_scene_makes_of_it(t: float | None) -> None:
    """Two routes: a slot of p or of the state at the start, and another scene."""
    slots = 0
    for scene in scenes():
        system = System(scene)
        steady = system if t is None else system.at(t=scene.integrate.span[0] + t)
        for key, value in numbers(scene.to_dict()):
            other = 0.875 * value if value else 0.25
            told = _refusal(scene, {key: other}, steady.t)
            if told is not None:
                assert refused(steady.at, {key: other})[:2] == (told.field, told.value), key
                continue
            written = System(scene.replace({key: other}))
            written = written if t is None else written.at(t=steady.t)
            made = steady.at({key: other})
            assert made.structure == written.structure, key
            np.testing.assert_array_equal(made.p, written.p, err_msg=key)
            np.testing.assert_array_equal(made.y0, written.y0, err_msg=key)
            assert made.scene == written.scene, key
            assert made.settings == written.settings, key
            assert made.time_laws == written.time_laws, key
            slots += steady.parameter_map.slot(key) is not None
    assert slots > 60  # of some 200 numbers


def test_a_slot_takes_what_the_scene_takes() -> None:
    scene = scene_of(**WHOLE)
    system = System(scene)
    for key, _ in numbers(scene.to_dict()):
        slot = system.parameter_map.slot(key)
        for value in (0.0, -1.0, np.inf, 1e70, True, "x") if slot is not None else ():
            try:
                scene.replace({key: value})
            except InputError:
                assert not slot.accepts(value), (key, value)
            else:
                assert slot.accepts(value) or isinstance(value, str), (key, value)


def test_changes_add_up_whatever_their_order() -> None:
    system = System(scene_of(**WHOLE))
    changes = {
        "loads.follower.1.force": 5.0,
        "supports.0.stiffness.1": 7.0,
        "foundation.stiffness": 1.0,
        "parameters.P0": 20.0,
        "initial.omega.2": 0.7,
        "rod.length": 2.5,
        "loads.tip.y.0": 4.0,
        "integrate.rtol": 1e-6,
    }
    at_once = system.at(changes)
    one, other = system, system
    for key, value in changes.items():
        one = one.at({key: value})
    for key, value in reversed(changes.items()):
        other = other.at({key: value})
    for made in (one, other):
        np.testing.assert_array_equal(made.p, at_once.p)
        np.testing.assert_array_equal(made.y0, at_once.y0)
        assert made.scene == at_once.scene
        assert made.settings.rtol == 1e-6
    assert system.scene == scene_of(**WHOLE)  # is what it was


def test_the_last_change_of_a_state_at_the_start_counts() -> None:
    system = System(scene_of(**WHOLE))
    y = np.arange(9.0) / 10
    one = system.at({"initial.omega.2": 0.7}).at(y0=y)
    np.testing.assert_array_equal(one.y0, y)
    assert one.scene.initial_state().tolist() == y.tolist()
    two = one.at({"initial.omega.2": 0.7})
    assert two.y0.tolist() == [*y[:6], 0.7, *y[7:]] == two.scene.initial_state().tolist()


def test_another_number_of_links_converts_the_damping_that_there_is() -> None:
    system = System(scene_of(rod=ROD, loads={"internal_damping": {"coefficient": 0.01}}))
    doubled = system.at({"loads.internal_damping.coefficient": 0.02}).at({"rod.links": 8})
    assert doubled.scene.loads.value("internal_damping") == pytest.approx(0.08)


def test_loads_at_a_time_are_numbers() -> None:
    system = System(scene_of(**WHOLE)).at({"parameters.P0": 20.0}, t=0.25)
    assert system.parameter("follower_force") == 10.0
    assert system.source.loads.follower[0].force == "P0*min(t/0.5, 1)"
    assert system.at({"parameters.P0": 40.0}).parameter("follower_force") == 20.0
    assert refused(system.at, t=2.0)[:2] == ("t", 2.0)


def test_what_is_no_state_or_key_is_refused() -> None:
    system = System(scene_of(rod=ROD))
    for y0 in ([1.0, 2.0], np.full(12, np.nan), "text", np.ones(12, bool), 3.0, 1j):
        assert refused(system.at, y0=y0).field == "y0"
    assert refused(system.at, {"rod.mas": 1.0}).field == "rod.mas"
    assert refused(system.at, {"rod.mass": -1.0})[:2] == ("rod.mass", -1.0)
    for asked, name in ((System, "scene"), (System.of, "system")):
        with pytest.raises(TypeError, match=name):
            asked("missile.toml")  # type: ignore[operator]  # of no kind that they take


def test_rows_are_those_of_every_system() -> None:
    system = System(scene_of(rod={**ROD, "boundary": "pinned"}, loads={"follower": {"force": 1.0}}))
    given = {"loads.follower.force": [1.0, 2.0, 3.0], "initial.phi": 0.5}
    assert refused(system.batch_arrays, given).field == "p"  # it stands in no table
    system = system.at({"initial.phi": 0.0})
    p, y0 = system.batch_arrays(given)
    for row, force in enumerate(given["loads.follower.force"]):
        alone = system.at({"loads.follower.force": force, "initial.phi": 0.5})
        np.testing.assert_array_equal(p[row], alone.p)
        np.testing.assert_array_equal(y0[row], alone.y0)
    assert refused(system.batch_arrays, {"rod.links": [3, 4]})[:2] == ("p", "rod.links")
    assert refused(system.batch_arrays, {"rod.mass": [1.0, -1.0]})[:2] == ("rod.mass", -1.0)
    assert (
        refused(system.batch_arrays, {"rod.mass": [1.0, 2.0], "rod.length": [1.0] * 3}).field == "p"
    )


def test_a_system_goes_through_pickle() -> None:
    system = System(scene_of(**WHOLE)).at({"parameters.P0": 20.0}, t=0.25)
    again = pickle.loads(pickle.dumps(system))
    np.testing.assert_array_equal(again.p, system.p)
    assert again.scene == system.scene
    assert again.at({"loads.tip.x": 3.0}).parameter("tip_force_x") == 3.0


def test_analyses_take_systems_and_scenes() -> None:
    scene = Scene.example("ziegler")
    system = System(scene).at({"loads.follower.force": 2.5})
    written = scene.replace({"loads.follower.force": 2.5})
    np.testing.assert_array_equal(
        rodgen.natural_modes(system).frequencies, rodgen.natural_modes(written).frequencies
    )
    assert rodgen.static_equilibrium(system).scene == written
    one, other = (
        rodgen.simulate(given, target="numpy", span=(0, 0.1)) for given in (system, written)
    )
    np.testing.assert_array_equal(one.y, other.y)
    assert one.scene == other.scene


def test_a_system_stands_where_a_scene_does() -> None:
    """In the making of a module, and in the limit of many links."""
    system = System(scene_of(rod=ROD))
    assert rodgen.build(system, "numpy") is rodgen.build(system.scene, "numpy")
    systems = [System(scene_of(rod={**ROD, "links": n})) for n in (2, 4, 8)]
    assert rodgen.richardson(systems, [1 + 1 / n**2 for n in (2, 4, 8)]).value == pytest.approx(1.0)
    with pytest.raises(TypeError, match="System"):
        rodgen.build(3.0)  # type: ignore[arg-type]  # of no kind that it takes
