"""Scenes from TOML: what is accepted, and what is said of the rest."""

from __future__ import annotations

import copy
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rodgen.model.parameter import JOINTS, POSITIVE
from rodgen.model.rod import BOUNDARIES
from rodgen.model.terms import PARAMETERS, PLACES, TERMS
from rodgen.scene import Scene, SceneError
from rodgen.scene.structure import MOST_LINKS
from tests.scene.tables import ROD, table_of

SCENES = sorted((Path(__file__).parents[2] / "scenes").glob("*.toml"))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_scenes_of_the_project_are_valid(path: Path) -> None:
    scene = Scene.from_toml(path)
    assert scene.name == path.stem
    assert np.isfinite(scene.initial_state()).all()


FINS = "loads.external_damping.fin_factor"
DRAG: dict[str, Any] = {"loads.external_damping.coefficient": 1.0}
# What is set, of which the last is refused; what is allowed; where another field is to blame, that
# and its value.
REFUSED: list[tuple[dict[str, Any], str] | tuple[dict[str, Any], str, str, str]] = [
    ({"rod.links": 0}, "1 to 1000000"),
    ({"rod.links": -1}, "1 to 1000000"),
    ({"rod.links": 2.5}, "whole number"),
    ({"rod.links": True}, "whole number"),
    ({"rod.links": MOST_LINKS + 1}, "1000000"),
    ({"rod.boundary": "cantilever", "rod.links": 1}, "from 2"),
    ({"rod.boundary": "clamped", "rod.links": 0}, "from 1 to"),
    ({"rod.mass": -1.0}, "greater than 0"),
    ({"rod.mass": 0}, "greater than 0"),
    ({"rod.mass": math.nan}, "finite"),
    ({"rod.length": math.inf}, "finite"),
    ({"rod.length": "5"}, "number"),
    ({"rod.bending_stiffness": -3.0}, "at least 0"),
    ({"rod.mass": None}, "given", "rod.mass", "missing"),
    ({"rod.colour": 1}, "known: links"),
    ({"rod.length": None, "rod.lenght": 1.0}, "known: links, length"),
    ({"rod.boundary": "glued"}, "free, cantilever, clamped, pinned"),
    ({"rod.inertia": "none"}, "uniform, lumped"),
    ({"rod.boundary": "pinned", "rod.clamp_angle": 0.1}, "no clamp"),
    ({"rod.clamp_angle": 0.1}, "no clamp"),
    ({"name": "../x"}, "plain identifier"),
    ({"name": "a/b"}, "plain identifier"),
    ({"name": ""}, "plain identifier"),
    ({"name": "a\n"}, "plain identifier"),
    ({"colour": 1}, "known: name"),
    ({"loads.wind": {}}, "known: follower"),
    ({"loads.follower": {}}, "given", "loads.follower.force", "missing"),
    ({"loads.follower.force": "t + x"}, "not 'x'"),
    ({"loads.follower.force": math.nan}, "finite"),
    ({"loads.tip.x": "sin(x)"}, "not 'x'"),
    ({"loads.tip.x": "2*min(t, 1"}, "character 6"),
    ({"loads.tip.x": "t^2"}, "**, not ^"),
    ({"loads.tip.x": "np.sin(t)"}, "write sin"),
    ({"loads.tip.x": "sine(t)"}, "did you mean sin?"),
    ({"loads.tip.x": "d/dt(tip_q)"}, "omega(s)"),
    ({"gravity": {"g": 9.81}}, "did you mean loads.gravity?"),
    ({"loads.tip.y": "s"}, "an expression of numbers, t"),
    ({"loads.tip.y": "t + 1/0"}, "not '1 / 0'"),
    ({"loads.tip.y": math.inf}, "finite"),
    ({"loads.tip.z": 1.0}, "known: x, y"),
    ({"loads.tip_load": {}}, "tip, "),
    ({"loads.gravity.g": "up"}, "number"),
    ({"loads.internal_damping.coefficient": -1.0}, "at least 0"),
    (DRAG | {FINS: [1.0, 2.0]}, "6 values"),
    (DRAG | {f"{FINS}.wing": 1.0}, "nose, body, tail"),
    (DRAG | {FINS: [1, 1, 1, "a", 1, 1]}, "a number", f"{FINS}.3", "'a'"),
    ({"initial.phi": "__import__('os')"}, "an expression of", "initial.phi", "__import__"),
    ({"initial.phi": "log(s - 1)"}, "finite at every link"),
    ({"initial.phi": [0.1]}, "5 values"),
    ({"initial.position": [1.0]}, "2 numbers"),
    ({"initial.position": 1.0}, "[x, y]"),
    ({"rod.boundary": "cantilever", "initial.velocity": [1.0, 0.0]}, "joint 0"),
    ({"rod.boundary": "clamped", "initial.position": [1.0, 0.0]}, "boundary clamped is fixed"),
    ({"rod.boundary": "pinned", "initial.velocity": [0.0, 0.0]}, "boundary pinned is fixed"),
    ({"integrate.atol": 0.0}, "greater than 0"),
    ({"integrate.method": "magic"}, "dop853"),
    ({"integrate.method": "rk4"}, "fixed step", "integrate.step", "None"),
    ({"integrate.span": [1.0, 1.0]}, "start < end"),
    ({"integrate.span": [0.0, math.inf]}, "finite", "integrate.span", "inf"),
    ({"integrate.rtol": 1e-20}, "from 2.3e-14"),
    ({"integrate.output_every": 1e-9}, "samples"),
    ({"integrate.method": "euler", "integrate.step": 1e-12}, "steps"),
]


@pytest.mark.parametrize("row", REFUSED, ids=str)
def test_bad_input_names_field_value_and_what_is_allowed(row: tuple[Any, ...]) -> None:
    changes, allowed, *other = row
    table = table_of()
    for field, value in changes.items():
        *path, key = field.split(".")
        inner = table
        for name in path:
            inner = inner.setdefault(name, {})
        inner[key] = value
        if value is None:
            del inner[key]
    field, shown = other or (field, repr(value).strip("[]"))
    with pytest.raises(SceneError) as error:
        Scene.from_dict(table)
    message = str(error.value)
    for part in (field, shown, allowed):
        assert part in message
    assert "\n" not in message


def test_files_that_are_no_scenes_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # a long path is shown shortened
    broken, binary = Path("broken.toml"), Path("binary.toml")
    broken.write_text("name = \n", encoding="utf-8")
    huge, deep = Path("huge.toml"), Path("deep.toml")
    huge.write_text("name = " + "9" * 5000, encoding="utf-8")
    deep.write_text("name = " + "[" * 5000, encoding="utf-8")
    for path, reason in ((huge, "valid TOML"), (deep, "50 deep")):
        with pytest.raises(SceneError, match=reason):
            Scene.from_toml(path)
    binary.write_bytes(b"\xff\xfe\x00")
    for path, reason in ((broken, "line 1"), (binary, "UTF-8"), (Path("no.toml"), "No such")):
        with pytest.raises(SceneError, match=reason) as error:
            Scene.from_toml(path)
        assert path.name in str(error.value)


def test_initial_state_is_in_the_order_of_the_contract() -> None:
    initial = {"position": [1.0, 2.0], "velocity": [3.0, 4.0], "phi": "s", "omega": [5, 6, 7, 8, 9]}
    state = Scene.from_dict(table_of(initial=initial)).initial_state()
    middles = [0.1, 0.3, 0.5, 0.7, 0.9]
    np.testing.assert_allclose(state, [1, 2, *middles, 3, 4, 5, 6, 7, 8, 9], atol=1e-15)
    held = table_of(rod={"boundary": "cantilever"}, initial={"phi": "s", "omega": 2})
    np.testing.assert_allclose(
        Scene.from_dict(held).initial_state(), [*middles[1:], 2, 2, 2, 2], atol=1e-15
    )


def test_rod_is_straight_along_its_clamp_unless_told_otherwise() -> None:
    held = table_of(rod={"boundary": "cantilever", "clamp_angle": 0.7})
    np.testing.assert_array_equal(Scene.from_dict(held).initial_state(), [0.7] * 4 + [0.0] * 4)
    held = table_of(rod={"boundary": "clamped", "clamp_angle": 0.7})
    np.testing.assert_array_equal(Scene.from_dict(held).initial_state(), [0.7] * 5 + [0.0] * 5)
    np.testing.assert_array_equal(Scene.from_dict(table_of()).initial_state(), np.zeros(14))


@pytest.mark.parametrize(
    ("every", "expected"), [(0.25, [0, 0.25, 0.5, 0.75, 1]), (0.4, [0, 0.4, 0.8, 1]), (7, [0, 1])]
)
def test_samples_start_and_end_with_the_span(every: float, expected: list[float]) -> None:
    scene = Scene.from_dict(table_of(integrate={"span": [0, 1], "output_every": every}))
    np.testing.assert_allclose(scene.integrate.samples, expected, atol=1e-15)
    assert scene.integrate.samples[-1] == 1.0


numbers = st.floats(1e-6, 1e6)
forces = st.floats(-1e6, 1e6) | st.sampled_from(["7*2", "sin(t)", "t if t < 1 else 2"])


@pytest.mark.parametrize("name", PLACES)
def test_a_scene_and_a_module_allow_the_same_values(name: str) -> None:
    """A scene refuses what `parameters` of a module refuses, and takes the rest."""
    parameter, (table, *keys) = PARAMETERS[name], PLACES[name]
    loads = {
        term.table: {
            one.key: [0.0, 0.0] if one.part is not None else one.beginning
            for one in term.parameters
            if one.each != JOINTS
        }
        for term in TERMS.values()
        if term.loads
    }
    for value in (-1.0, 0.0, 1e-9, 1.0):
        scene = table_of(rod={"boundary": "clamped"}, loads=copy.deepcopy(loads))
        inner = scene[table] if table == "rod" else scene[table][keys[0]]
        if parameter.part is None:
            inner[parameter.key] = [value] * 6 if parameter.each == JOINTS else value
        else:
            inner[parameter.key][parameter.part] = value
        allowed = value > 0 if parameter.rule == POSITIVE else value >= 0
        if allowed or parameter.signed:
            # What differs along the rod is a mean over every link.
            np.testing.assert_allclose(Scene.from_dict(scene).parameters[name], value, rtol=4e-16)
        else:
            with pytest.raises(SceneError, match=re.escape(".".join(PLACES[name]))):
                Scene.from_dict(scene)


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
    ("name",),
    ("rod",),
    *(("rod", key) for key in (*ROD, "boundary", "clamp_angle")),
    ("loads",),
    ("loads", "follower"),
    ("loads", "external_damping"),
    ("loads", "tip"),
    ("loads", "tip", "x"),
    ("initial",),
    ("initial", "phi"),
    ("initial", "position"),
    ("integrate",),
    ("integrate", "span"),
    ("integrate", "method"),
]


@settings(max_examples=150)
@given(place=st.sampled_from(JUNK_IN), value=junk)
def test_junk_anywhere_is_accepted_or_refused_in_one_line(
    place: tuple[str, ...], value: object
) -> None:
    table: dict[str, Any] = table_of()
    inner = table
    for key in place[:-1]:
        inner = inner.setdefault(key, {})
    inner[place[-1]] = value
    try:
        Scene.from_dict(table)
    except SceneError as error:
        assert len(str(error).splitlines()) == 1  # noqa: PT017 (acceptance is fine too)
