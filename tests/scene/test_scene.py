"""Scenes from TOML: what is accepted, and what is said of the rest."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rodgen.scene import Scene, SceneError
from rodgen.scene.structure import (
    BOUNDARIES,
    MOST_LINKS,
    TERMS,
    Structure,
    parse_terms,
)

SCENES = sorted((Path(__file__).parents[2] / "scenes").glob("*.toml"))
ROD = {"links": 5, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}


def _scene(**tables: Any) -> dict[str, Any]:
    rod = {**ROD, **tables.pop("rod", {})}
    rod = {key: value for key, value in rod.items() if value is not None}
    return {"name": "test", "rod": rod, **tables}


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_scenes_of_the_project_are_valid(path: Path) -> None:
    scene = Scene.from_toml(path)
    assert scene.name == path.stem
    assert np.isfinite(scene.initial_state()).all()


REFUSED = [
    ({"rod": {"links": 0}}, "rod.links", "0", "1 to 1000000"),
    ({"rod": {"links": -1}}, "rod.links", "-1", "1 to 1000000"),
    ({"rod": {"links": 2.5}}, "rod.links", "2.5", "whole number"),
    ({"rod": {"links": True}}, "rod.links", "True", "whole number"),
    ({"rod": {"links": MOST_LINKS + 1}}, "rod.links", "1000001", "1000000"),
    ({"rod": {"links": 1, "boundary": "cantilever"}}, "rod.links", "1", "from 2"),
    ({"rod": {"mass": -1.0}}, "rod.mass", "-1.0", "greater than 0"),
    ({"rod": {"mass": 0}}, "rod.mass", "0", "greater than 0"),
    ({"rod": {"mass": math.nan}}, "rod.mass", "nan", "finite"),
    ({"rod": {"length": math.inf}}, "rod.length", "inf", "finite"),
    ({"rod": {"length": "5"}}, "rod.length", "'5'", "number"),
    ({"rod": {"bending_stiffness": -3.0}}, "rod.bending_stiffness", "-3.0", "at least 0"),
    ({"rod": {"mass": None}}, "rod.mass", "missing", "given"),
    ({"rod": {"colour": 1}}, "rod.colour", "1", "known: links"),
    ({"rod": {"boundary": "glued"}}, "rod.boundary", "'glued'", "free, cantilever"),
    ({"rod": {"inertia": "none"}}, "rod.inertia", "'none'", "uniform"),
    ({"rod": {"clamp_angle": 0.1}}, "rod.clamp_angle", "0.1", "no clamp"),
    ({"name": "../x"}, "name", "'../x'", "plain identifier"),
    ({"name": "a/b"}, "name", "'a/b'", "plain identifier"),
    ({"name": ""}, "name", "''", "plain identifier"),
    ({"name": "a\n"}, "name", r"'a\\n'", "plain identifier"),
    ({"colour": 1}, "colour", "1", "known: name"),
    ({"rod": {"lenght": 1.0, "length": None}}, "rod.lenght", "1.0", "known: links, length"),
    ({"loads": {"wind": {}}}, "loads.wind", "{}", "known: follower"),
    ({"loads": {"follower": {}}}, "loads.follower.force", "missing", "given"),
    ({"loads": {"follower": {"force": "t + x"}}}, "loads.follower.force", "'t [+] x'", "not 'x'"),
    ({"loads": {"follower": {"force": math.nan}}}, "loads.follower.force", "nan", "finite"),
    ({"loads": {"gravity": {"g": "up"}}}, "loads.gravity.g", "'up'", "number"),
    ({"loads": {"internal_damping": {"coefficient": -1.0}}}, "coefficient", "-1.0", "at least 0"),
    (
        {"loads": {"external_damping": {"coefficient": 1.0, "fin_factor": [1.0, 2.0]}}},
        "loads.external_damping.fin_factor",
        "1.0, 2.0",
        "6 values",
    ),
    (
        {"loads": {"external_damping": {"coefficient": 1.0, "fin_factor": {"wing": 1.0}}}},
        "loads.external_damping.fin_factor.wing",
        "1.0",
        "nose, body, tail",
    ),
    (
        {"loads": {"external_damping": {"coefficient": 1.0, "fin_factor": [1, 1, 1, "a", 1, 1]}}},
        "loads.external_damping.fin_factor.3",
        "'a'",
        "a number",
    ),
    ({"integrate": {"atol": 0.0}}, "integrate.atol", "0.0", "greater than 0"),
    ({"initial": {"phi": "__import__('os')"}}, "initial.phi", "__import__", "an expression of"),
    ({"initial": {"phi": "log(s - 1)"}}, "initial.phi", "log", "finite at every link"),
    ({"initial": {"phi": [0.1]}}, "initial.phi", r"\[0.1\]", "5 values"),
    ({"initial": {"position": [1.0]}}, "initial.position", r"\[1.0\]", "2 numbers"),
    (
        {"rod": {"boundary": "cantilever"}, "initial": {"velocity": [1.0, 0.0]}},
        "initial.velocity",
        "1.0, 0.0",
        "joint 0",
    ),
    ({"integrate": {"method": "magic"}}, "integrate.method", "'magic'", "dop853"),
    ({"integrate": {"method": "rk4"}}, "integrate.step", "None", "fixed step"),
    ({"integrate": {"span": [1.0, 1.0]}}, "integrate.span", "1.0, 1.0", "start < end"),
    ({"integrate": {"span": [0.0, math.inf]}}, "integrate.span", "inf", "finite"),
    ({"integrate": {"rtol": 1e-20}}, "integrate.rtol", "1e-20", "from 2.3e-14"),
    ({"integrate": {"output_every": 1e-9}}, "integrate.output_every", "1e-09", "samples"),
    ({"integrate": {"method": "euler", "step": 1e-12}}, "integrate.step", "1e-12", "steps"),
]


@pytest.mark.parametrize(("change", "field", "value", "allowed"), REFUSED)
def test_bad_input_names_field_value_and_what_is_allowed(
    change: dict[str, Any], field: str, value: str, allowed: str
) -> None:
    with pytest.raises(SceneError, match=value) as error:
        Scene.from_dict(_scene(**change))
    message = str(error.value)
    assert field in message
    assert allowed in message
    assert "\n" not in message


def test_files_that_are_no_scenes_are_refused(tmp_path: Path) -> None:
    broken, binary = tmp_path / "broken.toml", tmp_path / "binary.toml"
    broken.write_text("name = \n", encoding="utf-8")
    huge, deep = tmp_path / "huge.toml", tmp_path / "deep.toml"
    huge.write_text("name = " + "9" * 5000, encoding="utf-8")
    deep.write_text("name = " + "[" * 5000, encoding="utf-8")
    for path in (huge, deep):
        with pytest.raises(SceneError, match="valid TOML"):
            Scene.from_toml(path)
    binary.write_bytes(b"\xff\xfe\x00")
    for path, reason in ((broken, "line 1"), (binary, "UTF-8"), (tmp_path / "no.toml", "No such")):
        with pytest.raises(SceneError, match=reason) as error:
            Scene.from_toml(path)
        assert path.name in str(error.value)


def test_initial_state_is_in_the_order_of_the_contract() -> None:
    initial = {"position": [1.0, 2.0], "velocity": [3.0, 4.0], "phi": "s", "omega": [5, 6, 7, 8, 9]}
    state = Scene.from_dict(_scene(initial=initial)).initial_state()
    middles = [0.1, 0.3, 0.5, 0.7, 0.9]
    np.testing.assert_allclose(state, [1, 2, *middles, 3, 4, 5, 6, 7, 8, 9], atol=1e-15)
    held = _scene(rod={"boundary": "cantilever"}, initial={"phi": "s", "omega": 2})
    np.testing.assert_allclose(
        Scene.from_dict(held).initial_state(), [*middles[1:], 2, 2, 2, 2], atol=1e-15
    )


def test_rod_is_straight_along_its_clamp_unless_told_otherwise() -> None:
    held = _scene(rod={"boundary": "cantilever", "clamp_angle": 0.7})
    np.testing.assert_array_equal(Scene.from_dict(held).initial_state(), [0.7] * 4 + [0.0] * 4)
    np.testing.assert_array_equal(Scene.from_dict(_scene()).initial_state(), np.zeros(14))


def test_force_without_t_is_a_number() -> None:
    text = Scene.from_dict(_scene(loads={"follower": {"force": "2*150"}}))
    number = Scene.from_dict(_scene(loads={"follower": {"force": 300.0}}))
    assert text.structure == number.structure
    assert text.parameters == number.parameters
    assert text.breaks() == []


@pytest.mark.parametrize(
    ("every", "expected"), [(0.25, [0, 0.25, 0.5, 0.75, 1]), (0.4, [0, 0.4, 0.8, 1]), (7, [0, 1])]
)
def test_samples_start_and_end_with_the_span(every: float, expected: list[float]) -> None:
    scene = Scene.from_dict(_scene(integrate={"span": [0, 1], "output_every": every}))
    np.testing.assert_allclose(scene.integrate.samples, expected, atol=1e-15)
    assert scene.integrate.samples[-1] == 1.0


numbers = st.floats(1e-6, 1e6)
terms = st.lists(st.sampled_from(TERMS), unique=True)


@given(links=st.integers(-3, 40), boundary=st.sampled_from(list(BOUNDARIES)), names=terms)
def test_structures_are_checked_and_have_a_name_of_their_own(
    links: int, boundary: str, names: list[str]
) -> None:
    if links < BOUNDARIES[boundary].least_links:
        with pytest.raises(SceneError, match="links"):
            Structure(links, boundary, terms=tuple(names))
        return
    structure = Structure(links, boundary, terms=tuple(names))
    assert structure.stem.isidentifier()
    assert structure.stem.startswith(f"rod_{boundary}_n{links}")
    assert structure == Structure(links, boundary, terms=tuple(reversed(names)))
    assert structure.hash == Structure(links, boundary, terms=structure.terms).hash
    if names and set(names) != set(TERMS):
        assert structure.terms == parse_terms(",".join(names))
        assert all(name in structure.stem for name in names)


@given(
    links=st.integers(2, 30),
    boundary=st.sampled_from(list(BOUNDARIES)),
    mass=numbers,
    length=numbers,
    stiffness=st.floats(0, 1e9),
    loads=st.fixed_dictionaries(
        {},
        optional={
            "follower": st.fixed_dictionaries({"force": st.floats(-1e6, 1e6)}),
            "gravity": st.just({}),
            "internal_damping": st.fixed_dictionaries({"coefficient": st.floats(0, 1e3)}),
            "external_damping": st.fixed_dictionaries({"coefficient": st.floats(0, 1e3)}),
        },
    ),
)
def test_any_sensible_scene_goes_through_and_back(
    links: int, boundary: str, mass: float, length: float, stiffness: float, loads: dict[str, Any]
) -> None:
    rod = {"links": links, "length": length, "bending_stiffness": stiffness, "mass": mass}
    scene = Scene.from_dict({"name": "any", "rod": {**rod, "boundary": boundary}, "loads": loads})
    assert set(scene.structure.terms) == set(loads)
    assert tuple(scene.parameters) == scene.structure.parameters
    size = links + 2 if boundary == "free" else links - 1
    assert scene.initial_state().shape == (2 * size,)
    assert Scene.from_dict(scene.model_dump(exclude_none=True)) == scene


junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=6,
)
PLACES = [
    ("name",),
    ("rod",),
    *(("rod", key) for key in (*ROD, "boundary", "clamp_angle")),
    ("loads",),
    ("loads", "follower"),
    ("loads", "external_damping"),
    ("initial",),
    ("initial", "phi"),
    ("initial", "position"),
    ("integrate",),
    ("integrate", "span"),
    ("integrate", "method"),
]


@settings(max_examples=300)
@given(place=st.sampled_from(PLACES), value=junk)
def test_junk_anywhere_is_accepted_or_refused_in_one_line(
    place: tuple[str, ...], value: object
) -> None:
    table: dict[str, Any] = _scene()
    inner = table
    for key in place[:-1]:
        inner = inner.setdefault(key, {})
    inner[place[-1]] = value
    try:
        Scene.from_dict(table)
    except SceneError as error:
        assert len(str(error).splitlines()) == 1  # noqa: PT017 (acceptance is fine too)
