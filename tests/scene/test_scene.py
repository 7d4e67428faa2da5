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
from rodgen.scene.contents import contents
from rodgen.scene.structure import (
    BOUNDARIES,
    BOUNDARY_PARAMETERS,
    INERTIAS,
    MOST_LINKS,
    PARAMETERS,
    ROD_PARAMETERS,
    TERM_PARAMETERS,
    TERMS,
    THESIS_TERMS,
    TIMED,
    Structure,
    check_output,
    parse_terms,
)
from rodgen.scene.tables import PLACES, TABLES

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
    (
        {"rod": {"boundary": "glued"}},
        "rod.boundary",
        "'glued'",
        "free, cantilever, clamped, pinned",
    ),
    ({"rod": {"inertia": "none"}}, "rod.inertia", "'none'", "uniform, lumped"),
    ({"rod": {"boundary": "pinned", "clamp_angle": 0.1}}, "rod.clamp_angle", "0.1", "no clamp"),
    ({"rod": {"boundary": "clamped", "links": 0}}, "rod.links", "0", "from 1 to"),
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
    ({"loads": {"tip": {"x": "sin(x)"}}}, "loads.tip.x", "sin", "not 'x'"),
    ({"loads": {"tip": {"x": 1.0, "y": "s"}}}, "loads.tip.y", "'s'", "an expression of numbers, t"),
    ({"loads": {"tip": {"y": "t + 1/0"}}}, "loads.tip.y", "1/0", "not '1 / 0'"),
    ({"loads": {"tip": {"y": math.inf}}}, "loads.tip.y", "inf", "finite"),
    ({"loads": {"tip": {"z": 1.0}}}, "loads.tip.z", "1.0", "known: x, y"),
    ({"loads": {"tip_load": {}}}, "loads.tip_load", "{}", "tip)"),
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
    (
        {"rod": {"boundary": "clamped"}, "initial": {"position": [1.0, 0.0]}},
        "initial.position",
        "1.0, 0.0",
        "joint 0 of boundary clamped is fixed",
    ),
    (
        {"rod": {"boundary": "pinned"}, "initial": {"velocity": [0.0, 0.0]}},
        "initial.velocity",
        "0.0, 0.0",
        "joint 0 of boundary pinned is fixed",
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
    held = _scene(rod={"boundary": "clamped", "clamp_angle": 0.7})
    np.testing.assert_array_equal(Scene.from_dict(held).initial_state(), [0.7] * 5 + [0.0] * 5)
    np.testing.assert_array_equal(Scene.from_dict(_scene()).initial_state(), np.zeros(14))


@pytest.mark.parametrize(("table", "key"), [("follower", "force"), ("tip", "x"), ("tip", "y")])
def test_force_without_t_is_a_number(table: str, key: str) -> None:
    text = Scene.from_dict(_scene(loads={table: {key: "2*150"}}))
    number = Scene.from_dict(_scene(loads={table: {key: 300.0}}))
    assert text.structure == number.structure
    assert text.parameters == number.parameters
    assert 300.0 in text.parameters.values()
    assert text.breaks() == []


def test_forces_in_t_are_part_of_the_structure_and_no_parameters() -> None:
    loads = {"tip": {"y": "abs(t - 2)", "x": 5.0}, "follower": {"force": "min(t, 3)"}}
    scene = Scene.from_dict(_scene(loads=loads))
    assert scene.structure.expressions == (
        ("follower_force", "min(t, 3)"),
        ("tip_force_y", "abs(t - 2)"),
    )
    assert scene.parameters["tip_force_x"] == 5.0
    assert not {"follower_force", "tip_force_y"} & set(scene.parameters)
    shown = {piece.piece: piece.reason for piece in contents(scene)}
    assert shown["tip load"] == "y is a function of t, part of the code: abs(t - 2)"
    assert shown["follower"] == "force is a function of t, part of the code: min(t, 3)"


def test_break_points_of_all_forces_are_those_of_the_scene() -> None:
    loads = {
        "follower": {"force": "max(t - 3, 0) + abs(t - 0.1*3)"},
        # the same times but for a rounding
        "tip": {"x": "1 if t < 3 else 2", "y": "abs(10*t - 3) + abs(sin(t))"},
    }
    breaks = Scene.from_dict(_scene(loads=loads, integrate={"span": [0, 4]})).breaks()
    assert breaks == pytest.approx([0.3, 3.0, math.pi], abs=1e-13)


def test_first_pole_of_all_forces_is_that_of_the_scene() -> None:
    loads = {"follower": {"force": "1/(t - 3)"}, "tip": {"x": "2/(t - 2)", "y": "t"}}
    at, force = Scene.from_dict(_scene(loads=loads)).pole() or (None, None)
    assert at == 2.0
    assert force is not None
    assert force.not_finite(2.0) == "loads.tip.x = '2/(t - 2)' is not finite at t = 2"
    assert Scene.from_dict(_scene(loads={"tip": {"y": "1/(t - 30)"}})).pole() is None


def test_beam_is_that_of_the_test_set() -> None:
    """Fx = -phi, Fy = phi with phi = 1.5 sin(t)^2 until pi; at rest along x."""
    path = Path(__file__).parents[2] / "scenes" / "ivp_beam.toml"
    scene = Scene.from_toml(path)
    stem = f"rod_clamped_n40_tip_load_lumped_{scene.structure.hash[:6]}"
    assert scene.structure.stem == stem
    assert scene.breaks() == pytest.approx([math.pi], abs=1e-15)
    assert scene.pole() is None
    np.testing.assert_array_equal(scene.initial_state(), np.zeros(80))
    phi = 1.5 * np.sin([0.0, 1.0, 2.0, 3.0]) ** 2
    for name, sign in (("tip_force_x", -1), ("tip_force_y", 1)):
        force = scene.timed[name]([0.0, 1.0, 2.0, 3.0, 3.2, 5.0])
        np.testing.assert_allclose(force, [*(sign * phi), 0.0, 0.0], rtol=1e-15)


@pytest.mark.parametrize("boundary", ["free", "clamped", "pinned"])
def test_one_lumped_link_is_a_rod(boundary: str) -> None:
    scene = Scene.from_dict(_scene(rod={"links": 1, "inertia": "lumped", "boundary": boundary}))
    assert scene.structure.inertia == "lumped"
    assert len(scene.initial_state()) == (6 if boundary == "free" else 2)
    present = {piece.piece: piece.present for piece in contents(scene)}
    assert not present["rotary springs"]
    assert not present["rotary inertia of links"]
    assert present["root spring"] == (boundary == "clamped")


@pytest.mark.parametrize(
    ("every", "expected"), [(0.25, [0, 0.25, 0.5, 0.75, 1]), (0.4, [0, 0.4, 0.8, 1]), (7, [0, 1])]
)
def test_samples_start_and_end_with_the_span(every: float, expected: list[float]) -> None:
    scene = Scene.from_dict(_scene(integrate={"span": [0, 1], "output_every": every}))
    np.testing.assert_allclose(scene.integrate.samples, expected, atol=1e-15)
    assert scene.integrate.samples[-1] == 1.0


numbers = st.floats(1e-6, 1e6)
forces = st.floats(-1e6, 1e6) | st.sampled_from(["7*2", "sin(t)", "t if t < 1 else 2"])
terms = st.lists(st.sampled_from(TERMS), unique=True)


def test_every_parameter_has_its_place_in_p_and_in_a_scene() -> None:
    loads = [name for names in TERM_PARAMETERS.values() for name in names]
    held = {name for names in BOUNDARY_PARAMETERS.values() for name in names}
    assert set(PARAMETERS) == {*ROD_PARAMETERS, *loads, *held}
    assert len(PARAMETERS) == len(set(PARAMETERS))
    assert list(PLACES) == loads
    assert set(TIMED) <= set(loads)
    assert {term: term.removesuffix("_load") for term in TERMS} == TABLES
    everything = Structure(3, "clamped", terms=TERMS)
    assert everything.parameters == PARAMETERS


def test_order_of_expressions_does_not_matter() -> None:
    pairs = (("tip_force_x", "t"), ("follower_force", "2 * t"))
    one, two = (Structure(3, terms=TERMS, expressions=e) for e in (pairs, pairs[::-1]))
    assert one == two
    assert one.hash == two.hash
    for name, terms in (("gravity", TERMS), ("tip_force_x", THESIS_TERMS), ("follower_force", ())):
        with pytest.raises(SceneError, match=f"expressions = '{name}': must be"):
            Structure(3, terms=terms, expressions=((name, "t"),))


NAMES = [
    (("numpy", "chain"), ""),
    (("numpy", "dense"), "_dense"),
    (("c", "chain"), "_c"),
]


@pytest.mark.parametrize(("output", "ending"), NAMES)
def test_names_of_modules(output: tuple[str, str], ending: str) -> None:
    structures = {
        Structure(20): "rod_free_n20",
        Structure(5, "pinned", terms=()): "rod_pinned_n5_conservative",
        Structure(5, "clamped", "lumped", ("tip_load",)): "rod_clamped_n5_tip_load_lumped",
        Structure(5, inertia="lumped"): "rod_free_n5_lumped",
        Structure(2, terms=TERMS): f"rod_free_n2_{'_'.join(TERMS)}",
    }
    for structure, stem in structures.items():
        assert structure.stem == structure.module_stem() == stem
        assert structure.module_stem(*output) == stem + ending


@pytest.mark.parametrize(("output", "ending"), NAMES)
def test_modules_that_differ_in_an_expression_differ_in_name(
    output: tuple[str, str], ending: str
) -> None:
    stems = set()
    for text in ("sin(t)", "cos(t)"):
        structure = Structure(5, expressions=(("follower_force", text),))
        stem = structure.module_stem(*output)
        assert stem == f"rod_free_n5{ending}_{structure.hash[:6]}"
        assert stem.isidentifier()
        stems.add(stem)
    assert len(stems) == 2


def test_what_cannot_be_written_is_refused() -> None:
    for target, form, message in (
        ("fortran", "chain", "target = 'fortran': must be one of numpy, c"),
        ("numpy", "sparse", "form = 'sparse': must be one of chain, dense"),
        ("c", "dense", "form = 'dense': must be chain for target c"),
    ):
        with pytest.raises(SceneError, match=message):
            check_output(target, form)
        with pytest.raises(SceneError, match=message):
            Structure(3).module_stem(target, form)


def test_all_terms_are_those_of_the_thesis() -> None:
    assert parse_terms("all") == THESIS_TERMS == Structure(3).terms
    assert "tip_load" not in THESIS_TERMS
    assert parse_terms("tip_load, follower") == ("follower", "tip_load")
    assert parse_terms("tip_load") == ("tip_load",)
    with pytest.raises(SceneError, match="gravity, internal_damping, external_damping, tip_load"):
        parse_terms("tip")


@given(
    links=st.integers(-3, 40),
    boundary=st.sampled_from(list(BOUNDARIES)),
    inertia=st.sampled_from(INERTIAS),
    names=terms,
)
def test_structures_are_checked_and_have_a_name_of_their_own(
    links: int, boundary: str, inertia: str, names: list[str]
) -> None:
    if links < BOUNDARIES[boundary].least_links:
        with pytest.raises(SceneError, match="links"):
            Structure(links, boundary, inertia, tuple(names))
        return
    structure = Structure(links, boundary, inertia, tuple(names))
    assert structure.stem.isidentifier()
    assert structure.stem.startswith(f"rod_{boundary}_n{links}")
    assert structure.stem.endswith("_lumped") == (inertia == "lumped")
    assert structure == Structure(links, boundary, inertia, tuple(reversed(names)))
    assert structure.hash == Structure(links, boundary, inertia, structure.terms).hash
    if names:
        assert structure.terms == parse_terms(",".join(names))
    if names and set(names) != set(THESIS_TERMS):
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
    assert {TABLES[term] for term in scene.structure.terms} == set(loads)
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


@settings(max_examples=300)
@given(place=st.sampled_from(JUNK_IN), value=junk)
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
