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

from rodgen.emit.targets import check_output
from rodgen.model.parameter import JOINTS, POSITIVE
from rodgen.model.rod import BOUNDARIES, INERTIAS, STEADY, UNEVEN
from rodgen.model.terms import PARAMETERS, PLACES, TERMS, THESIS_TERMS
from rodgen.scene import Scene, SceneError
from rodgen.scene.contents import contents, in_words
from rodgen.scene.structure import MOST_LINKS, Structure, parse_terms

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
    table = _scene()
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
        ("follower_force", "min(t, follower_force_1)"),
        ("tip_force_y", "abs(t - tip_force_y_1)"),
    )
    assert scene.parameters["tip_force_x"] == 5.0
    assert not {"follower_force", "tip_force_y"} & set(scene.parameters)
    shown = {piece.piece: piece.reason for piece in contents(scene)}
    assert shown["tip load"] == "y is a function of t, part of the code: abs(t - 2)"
    assert shown["follower"] == "force is a function of t, part of the code: min(t, 3)"


def test_what_a_scene_holds_names_every_load_body_support_and_state() -> None:
    loads = {
        "follower": [{"force": 1.0}, {"force": "2*phi(0)", "at": 0.5}, {"force": 3.0, "at": 0.1}],
        "gravity": {},
    }
    scene = Scene.from_dict(
        _scene(
            rod={"links": 5},
            loads=loads,
            bodies=[{"name": "engine", "at": 1.0, "mass": 2.0}],
            supports=[{"at": 0.3, "stiffness": [0.0, 7.0]}, {"at": 0.9, "rotation": 4.0}],
            foundation={"stiffness": 8.0},
            states={"lag": {"rate": "-lag"}},
        )
    )
    present = {piece.piece: piece.reason for piece in contents(scene) if piece.present}
    first, *rest = (name for name in present if name.startswith("follower"))
    assert [first, *rest] == ["follower", "follower 2", "follower 3"]
    assert "s = 0.5" in present["follower 2"]
    assert "phi(0)" in present["follower 2"]
    assert "link 0" in present["follower 3"]
    assert {"gravity", "body engine", "support 1", "support 2", "state lag"} <= {*present}
    assert "7 N/m along y" in present["support 1"]
    assert "4 N m/rad" in present["support 2"]
    assert in_words(scene) == [
        "follower",
        "follower 2",
        "follower 3",
        "gravity",
        "foundation",
        "2 supports",
        "state lag",
    ]


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
    at, force = Scene.from_dict(_scene(loads=loads)).course.pole() or (None, None)
    assert at == 2.0
    assert force is not None
    assert force.not_finite(2.0) == "loads.tip.x = '2/(t - 2)' is not finite at t = 2"
    assert Scene.from_dict(_scene(loads={"tip": {"y": "1/(t - 30)"}})).course.pole() is None


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


DIFFERING = {one.name for way in UNEVEN.values() for one in way.parameters} | {
    one.name for one in STEADY.values()
}
numbers = st.floats(1e-6, 1e6)
forces = st.floats(-1e6, 1e6) | st.sampled_from(["7*2", "sin(t)", "t if t < 1 else 2"])
terms = st.lists(st.sampled_from([t for t in TERMS if TERMS[t].loads]), unique=True)


def test_every_parameter_has_its_place_in_p_and_in_a_scene() -> None:
    everything = Structure(3, "clamped", terms=tuple(TERMS))
    assert (
        everything.parameters
        == tuple(name for name in PARAMETERS if name not in DIFFERING)
        == (
            *("mass", "length", "bending_stiffness", "follower_force", "follower_angle", "gravity"),
            *("internal_damping", "external_damping", "clamp_angle", "tip_force_x", "tip_force_y"),
            *("material_damping_time", "foundation_angle", "support_angle"),
            *("drag_normal", "drag_tangential", "wind_x", "wind_y"),
            *("fin_factor", "distributed_follower", "foundation_stiffness", "foundation_damping"),
            *(one.name for one in TERMS["supports"].parameters if one.several),
        )
    )  # modules, files and programs in C rely on the order
    computed = ("foundation_", "support_")
    assert set(PLACES) == {name for name in everything.parameters if not name.startswith(computed)}
    assert len(set(PLACES.values())) == len(PLACES)
    for name, term in TERMS.items():
        assert name == term.name
        assert term.table == name.removesuffix("_load")


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
        scene = _scene(rod={"boundary": "clamped"}, loads=copy.deepcopy(loads))
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


def test_all_terms_are_those_of_the_thesis() -> None:
    assert parse_terms("all") == THESIS_TERMS == Structure(3).terms
    assert "tip_load" not in THESIS_TERMS
    assert parse_terms("tip_load, follower") == ("follower", "tip_load")
    assert parse_terms("tip_load") == ("tip_load",)
    with pytest.raises(SceneError, match="gravity, internal_damping, external_damping, tip_load, "):
        parse_terms("tip")


@given(
    links=st.integers(-3, 40),
    boundary=st.sampled_from(list(BOUNDARIES)),
    inertia=st.sampled_from(list(INERTIAS)),
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
    table: dict[str, Any] = _scene()
    inner = table
    for key in place[:-1]:
        inner = inner.setdefault(key, {})
    inner[place[-1]] = value
    try:
        Scene.from_dict(table)
    except SceneError as error:
        assert len(str(error).splitlines()) == 1  # noqa: PT017 (acceptance is fine too)
