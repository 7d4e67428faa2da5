"""Scenes from TOML: what is accepted, and what is said of the rest."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rodgen.errors import InputError, Missing
from rodgen.model.rod import BOUNDARIES
from rodgen.model.term import JOINTS, POSITIVE
from rodgen.model.terms import PARAMETERS, PLACES, TERMS
from rodgen.scene import Scene
from rodgen.scene.term_texts import MOST_LINKS
from rodgen.system import System
from tests.scene.tables import ROD, put, scene_of, table_of
from tests.told import refused

FINS = "loads.external_damping.fin_factor"
DRAG: dict[str, Any] = {"loads.external_damping.coefficient": 1.0}
HELD: dict[str, Any] = {"rod.boundary": "clamped"}
# What is set: the last of it is refused, with its value; or another field, that comes behind.
REFUSED: list[tuple[Any, ...]] = [
    *(({"rod.links": value},) for value in (0, -1, 2.5, True, MOST_LINKS + 1)),
    ({"rod.boundary": "cantilever", "rod.links": 1},),
    (HELD | {"rod.links": 0},),
    *(({"rod.mass": value},) for value in (-1.0, 0, math.nan)),
    *(({"rod.length": value},) for value in (math.inf, "5 m")),
    ({"rod.bending_stiffness": -3.0},),
    ({"rod.mass": None}, "rod.mass", Missing),
    ({"rod.colour": 1},),
    ({"rod.length": None, "rod.lenght": 1.0},),
    ({"rod.boundary": "glued"},),
    ({"rod.inertia": "none"},),
    ({"rod.boundary": "pinned", "rod.clamp_angle": 0.1},),
    ({"rod.clamp_angle": 0.1},),
    *(({"name": value},) for value in ("../x", "a/b", "", "a\n")),
    ({"colour": 1},),
    ({"version": 9},),
    ({"loads.wind": {}},),
    ({"gravity": {"g": 9.81}},),
    ({"loads.follower": {}}, "loads.follower.force", Missing),
    *(({"loads.follower.force": value},) for value in ("t + x", math.nan)),
    *(({"loads.tip.x": law},) for law in ("sin(x)", "2*min(t, 1", "t^2", "np.sin(t)", "sine(t)")),
    ({"loads.tip.x": "d/dt(tip_q)"},),
    *(({"loads.tip.y": value},) for value in ("s", "t + 1/0", math.inf)),
    ({"loads.tip.z": 1.0},),
    ({"loads.tip_load": {}},),
    ({"loads.gravity.g": "up"},),
    ({"loads.internal_damping.coefficient": -1.0},),
    (DRAG | {FINS: [1.0, 2.0]},),
    (DRAG | {f"{FINS}.wing": 1.0},),
    (DRAG | {FINS: [1, 1, 1, "a", 1, 1]}, f"{FINS}.3", "a"),
    *(({"initial.phi": value},) for value in ("__import__('os')", "log(s - 1)", [0.1])),
    *(({"initial.position": value},) for value in ([1.0], 1.0)),
    ({"rod.boundary": "cantilever", "initial.velocity": [1.0, 0.0]},),
    (HELD | {"initial.position": [1.0, 0.0]},),
    ({"rod.boundary": "pinned", "initial.velocity": [0.0, 0.0]},),
    ({"integrate.atol": 0.0},),
    ({"integrate.method": "magic"},),
    ({"integrate.method": "rk4"}, "integrate.step", None),
    *(({"integrate.span": value},) for value in ([1.0, 1.0], [0.0, -1.0])),
    ({"integrate.span": [0.0, math.inf]}, "integrate.span.1", math.inf),
    ({"integrate.rtol": 1e-20},),
    ({"integrate.output_every": 1e-9},),
    ({"integrate.method": "euler", "integrate.step": 1e-12},),
]


def test_bad_input_names_field_and_value() -> None:
    for changes, *other in REFUSED:
        table = table_of()
        for field, value in changes.items():
            put(table, field, value)
        assert refused(Scene.from_dict, table)[:2] == (tuple(other) or (field, value))


def test_what_is_meant_is_told() -> None:
    for key, value, near in (
        ("gravity", {}, "loads.gravity"),
        ("loads", {"tip_load": {}}, "tip"),
        ("loads", {"tip": {"x": "t^2"}}, "**"),
        ("loads", {"tip": {"x": "sine(t)"}}, "sin"),
        ("loads", {"tip": {"x": "np.sin(t)"}}, "sin"),
        ("loads", {"tip": {"x": "d/dt(tip_q)"}}, "omega(s)"),
        ("rod", {"boundary": "glued"}, "pinned"),
    ):
        assert near in refused(scene_of, **{key: value}).allowed
    for end in ("\r", "\n", "\r\n"):  # of lines, as Python counts them
        assert refused(scene_of, loads={"tip": {"x": f"t{end}+1"}}).numbers[:2] == [1, 2]
    place = refused(scene_of, loads={"tip": {"x": "2*min(t, 1"}})
    assert 6 in place.numbers  # the character at which a parenthesis is opened


def test_angles_at_the_start_that_look_like_degrees_are_doubted() -> None:
    """Those of links that turn more than once."""
    for phi, turns in ((90, 14.3), ("45*s", 6.4), ([0.0, 0.0, 0.0, 0.0, -7.0], 1.1)):
        (told,) = System(scene_of(initial={"phi": phi})).doubts
        assert told.text.startswith("initial.phi = ")
        assert told.figures["turns"] == pytest.approx(turns, abs=0.05)
    for phi in (0.0, 3.0, "6*s"):
        assert not System(scene_of(initial={"phi": phi, "position": [90.0, 0.0]})).doubts
    fast = {"omega": 90.0, "velocity": [90.0, 0.0]}
    assert not System(scene_of(initial=fast)).doubts


def test_initial_state_is_in_the_order_of_the_contract() -> None:
    """A rod is straight along its clamp unless told otherwise."""
    full = {"position": [1.0, 2.0], "velocity": [3.0, 4.0], "phi": "s", "omega": [5, 6, 7, 8, 9]}
    middles = [0.1, 0.3, 0.5, 0.7, 0.9]
    held, clamped = {"boundary": "cantilever"}, {"boundary": "clamped", "clamp_angle": 0.7}
    for rod, initial, due in (
        ({}, full, [1, 2, *middles, 3, 4, 5, 6, 7, 8, 9]),
        ({}, {}, [0.0] * 14),
        (held, {"phi": "s", "omega": 2}, [*middles[1:], 2, 2, 2, 2]),
        (held | {"clamp_angle": 0.7}, {}, [0.7] * 4 + [0.0] * 4),
        (clamped, {}, [0.7] * 5 + [0.0] * 5),
    ):
        state = scene_of(rod=rod, initial=initial).initial_state()
        np.testing.assert_allclose(state, due, atol=1e-15)


def test_samples_start_and_end_with_the_span() -> None:
    for every, expected in ((0.25, [0, 0.25, 0.5, 0.75, 1]), (0.4, [0, 0.4, 0.8, 1]), (7, [0, 1])):
        scene = scene_of(integrate={"span": [0, 1], "output_every": every})
        np.testing.assert_allclose(scene.integrate.sample_times, expected, atol=1e-15)
        assert scene.integrate.sample_times[-1] == 1.0


numbers = st.floats(1e-6, 1e6)
forces = st.floats(-1e6, 1e6) | st.sampled_from(["7*2", "sin(t)", "t if t < 1 else 2"])


def test_a_scene_and_a_module_allow_the_same_values(make_scene: Callable[..., Scene]) -> None:
    """A scene refuses what `parameters` of a module refuses, and takes the rest."""
    loads = tuple(name for name, term in TERMS.items() if term.is_load)
    given = make_scene(5, "clamped", loads).to_dict() | {"base": {"x": 0.0}}
    for (name, (table, *keys)), value in product(PLACES.items(), (-1.0, 0.0, 1e-9, 1.0)):
        parameter, scene = PARAMETERS[name], copy.deepcopy(given)
        inner = scene[table][keys[0]] if table == "loads" else scene[table]
        if parameter.part is None:
            inner[parameter.key] = [value] * 6 if parameter.each == JOINTS else value
        else:
            inner.setdefault(parameter.key, [0.0, 0.0])[parameter.part] = value
        for other in (one for one in PARAMETERS.values() if one.unless == parameter.key):
            inner.pop(other.key, None)  # the one stands in place of the other
        allowed = value > 0 if parameter.rule == POSITIVE else value >= 0
        if allowed or parameter.is_signed:
            # What differs along the rod is a mean over every link.
            np.testing.assert_allclose(Scene.from_dict(scene).parameters[name], value, rtol=4e-16)
        else:
            assert refused(Scene.from_dict, scene).field.startswith(".".join(PLACES[name]))


@given(
    links=st.integers(2, 30),
    boundary=st.sampled_from(list(BOUNDARIES)),
    mass=numbers,
    length=numbers,
    stiffness=st.floats(0, 1e9),
    loads=st.fixed_dictionaries(
        {},
        optional={
            "follower": st.fixed_dictionaries({"force": forces}),
            "gravity": st.just({}),
            "internal_damping": st.fixed_dictionaries({"coefficient": st.floats(0, 1e3)}),
            "external_damping": st.fixed_dictionaries({"coefficient": st.floats(0, 1e3)}),
            "tip": st.fixed_dictionaries({}, optional={"x": forces, "y": forces}),
        },
    ),
)
def test_any_sensible_scene_goes_through_and_back(
    links: int, boundary: str, mass: float, length: float, stiffness: float, loads: dict[str, Any]
) -> None:
    rod = {"links": links, "length": length, "bending_stiffness": stiffness, "mass": mass}
    scene = Scene.from_dict({"name": "any", "rod": {**rod, "boundary": boundary}, "loads": loads})
    assert {TERMS[term].table for term in scene.structure.terms} == set(loads)
    assert tuple(scene.parameters) == scene.structure.parameters
    size = {"free": links + 2, "cantilever": links - 1}.get(boundary, links)
    assert scene.initial_state().shape == (2 * size,)
    assert Scene.from_dict(scene.model_dump(exclude_none=True)) == scene


junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=6,
)
JUNK_IN = [
    *("name", *(f"rod.{key}" for key in (*ROD, "boundary", "clamp_angle"))),
    *("rod", "loads", "loads.follower", "loads.external_damping", "loads.tip", "loads.tip.x"),
    *("initial", "initial.phi", "initial.position"),
    *("integrate", "integrate.span", "integrate.method"),
]


@settings(max_examples=60)
@given(field=st.sampled_from(JUNK_IN), value=junk)
def test_junk_anywhere_is_accepted_or_refused_in_one_line(field: str, value: object) -> None:
    table: dict[str, Any] = table_of()
    put(table, field, value)
    try:
        Scene.from_dict(table)
    except InputError:
        assert refused(Scene.from_dict, table).field
