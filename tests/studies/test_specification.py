"""Studies from files and from Python: what they vary, and what is refused before a point is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import SceneError, Study
from rodgen.studies.points import points
from tests.studies.scenes import BECK, PENDULUM, scene

FILE = """
name = "forces"
scene = "beck.toml"
[vary]
"loads.follower.force" = {from = 5, to = 60, count = 4}
"loads.material_damping.time" = {from = 1e-4, to = 1e-1, count = 4, scale = "log"}
[compute]
what = "modes"
keep = ["frequency"]
"""
SCENE = """
name = "beck"
[rod]
links = 3
length = 5.0
bending_stiffness = 100.0
mass = 20.0
boundary = "clamped"
[loads.follower]
force = 20.0
[loads.material_damping]
time = 1e-3
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "beck.toml").write_text(SCENE)
    (tmp_path / "study.toml").write_text(FILE)
    return tmp_path / "study.toml"


def of(vary: Any, table: dict[str, Any] = BECK, **given: Any) -> Study:
    return Study.of(scene(table), vary, **{"what": "critical", **given})


def test_a_file_and_python_give_the_same_study(file: Path) -> None:
    vary = {
        "loads.follower.force": np.linspace(5, 60, 4),
        "loads.material_damping.time": {"from": 1e-4, "to": 1e-1, "count": 4, "scale": "log"},
    }
    study = Study.from_toml(file)
    made = Study.of(
        rodgen.Scene.from_toml(file.with_name("beck.toml")),
        {**vary, "loads.follower.force": {"from": 5, "to": 60, "count": 4}},
        what="modes",
        keep=["frequency"],
    )
    assert study == made
    assert study.shape == (4, 4)
    listed = [point["loads.follower.force"] for point in points(study, range(0, 16, 4))]
    np.testing.assert_array_equal(listed, vary["loads.follower.force"])
    times = [point["loads.material_damping.time"] for point in points(study, range(4))]
    np.testing.assert_allclose(times, [1e-4, 1e-3, 1e-2, 1e-1], rtol=1e-15)


def test_the_scene_may_stand_in_the_file(file: Path) -> None:
    table = SCENE.replace("[", "[scene.").replace('name = "beck"', '[scene]\nname = "beck"')
    inside = FILE.replace('scene = "beck.toml"', "") + table
    file.with_name("inside.toml").write_text(inside)
    assert Study.from_toml(file.with_name("inside.toml")) == Study.from_toml(file)


@pytest.mark.parametrize(
    ("key", "value", "of_scene"),
    [
        ("loads.follower.force", 12.0, lambda s: s.loads.follower.force),
        ("loads.follower.at", 0.5, lambda s: s.loads.follower.at),
        ("rod.clamp_angle", 0.3, lambda s: s.rod.clamp_angle),
        ("rod.links", 4, lambda s: s.rod.links),
        ("integrate.method", "rk45", lambda s: s.integrate.method),
        ("integrate.max_steps", 7, lambda s: s.integrate.max_steps),
        ("integrate.span.1", 3.0, lambda s: s.integrate.span[1]),
        ("bodies.payload.mass", 3.0, lambda s: s.bodies[0].mass),
        ("bodies.0.at", 0.7, lambda s: s.bodies[0].at),
        ("supports.0.stiffness.1", 9.0, lambda s: s.supports[0].stiffness[1]),
        ("parameters.P0", 5.0, lambda s: s.numbers["P0"]),
    ],
)
def test_any_number_of_a_scene_can_be_varied(key: str, value: Any, of_scene: Any) -> None:
    more = {
        "bodies": [{"name": "payload", "at": 0.5, "mass": 2.0}],
        "supports": [{"at": 0.5, "stiffness": [0.0, 2.0]}],
        "parameters": {"P0": 3.0},
        "foundation": {"stiffness": "P0"},
    }
    study = of({key: [value]}, {**BECK, **more})
    assert of_scene(study.scene_at(points(study, [0])[0])) == value


def test_another_number_of_links_converts_damping() -> None:
    base = {**BECK, "loads": {**BECK["loads"], "internal_damping": {"coefficient": 0.1}}}
    study = of({"rod.links": [8, 16]}, base)
    coefficients = [
        study.scene_at(point).loads.internal_damping.coefficient for point in points(study, [0, 1])
    ]
    np.testing.assert_allclose(coefficients, [0.1, 0.4], rtol=1e-14)


@pytest.mark.parametrize(
    ("vary", "field", "words"),
    [
        ({}, "vary", "at least one key"),
        ({"loads.follower.forse": [1.0]}, "vary.loads.follower.forse", "known: force"),
        ({"loads.gravity.g": [1.0]}, "vary", "loads has follower, material_damping"),
        ({"rod": [1.0]}, "vary", "one value, such as rod.links"),
        ({"integrate.span": [1.0]}, "vary", "one value, such as integrate.span.0"),
        ({"name": ["a"]}, "vary", "one value"),
        ({"bodies.0.mass": [1.0]}, "vary", "bodies has none"),
        ({"__class__": [1.0]}, "vary", "a key of the scene"),
        ({"rod.mass": 1.0}, "vary.rod.mass", "a table"),
        ({"rod.mass": []}, "vary.rod.mass.values", "1 to"),
        ({"rod.mass": [True]}, "vary.rod.mass.values[0]", "finite number"),
        ({"rod.mass": [1.0, "a"]}, "vary.rod.mass.values", "all numbers or all text"),
        ({"rod.mass": [1.0, 1.0]}, "vary.rod.mass.values", "all different"),
        ({"rod.mass": [float("nan")]}, "vary.rod.mass.values[0]", "finite number"),
        ({"rod.mass": ["heavy"]}, "vary.rod.mass", "a number"),
        ({"rod.mass": [-1.0, -2.0]}, "vary.rod.mass", "greater than 0"),
        ({"rod.links": [2.5]}, "vary.rod.links", "whole numbers"),
        ({"rod.links": {"from": 2, "to": 5, "count": 3}}, "vary.rod.links", "whole numbers"),
        ({"integrate.method": ["none"]}, "vary.integrate.method", "one of auto"),
        ({"rod.mass": {"from": 1, "to": 2}}, "vary.rod.mass.count", "whole number"),
        ({"rod.mass": {"to": 2, "count": 2}}, "vary.rod.mass.from", "a number"),
        ({"rod.mass": {"from": 1, "to": 1, "count": 2}}, "vary.rod.mass.to", "other than 1"),
        ({"rod.mass": {"from": "1", "to": 2, "count": 2}}, "vary.rod.mass.from", "a number"),
        ({"rod.mass": {"from": 1, "to": 2, "step": 2}}, "vary.rod.mass.step", "known: from"),
        (
            {"rod.mass": {"from": 0, "to": 2, "count": 2, "scale": "log"}},
            "vary.rod.mass.from",
            "above zero",
        ),
        (
            {"rod.mass": {"from": 1, "to": 2, "count": 2, "scale": "square"}},
            "vary.rod.mass.scale",
            "one of linear, log",
        ),
        ({"rod.mass": {"values": [1.0], "count": 2}}, "vary.rod.mass.count", "absent beside"),
    ],
)
def test_what_cannot_be_varied_is_refused(vary: Any, field: str, words: str) -> None:
    with pytest.raises(SceneError) as refused:
        of(vary)
    assert refused.value.field == field
    assert words in refused.value.allowed


@pytest.mark.parametrize(
    ("given", "field", "words"),
    [
        ({"what": "walk"}, "compute.what", "one of run, critical, modes, static"),
        ({"keep": [3]}, "compute.keep[0]", "a function"),
        ({"sample": {"method": "dice", "count": 3}}, "sample.method", "one of sobol"),
        ({"sample": {"method": "sobol"}}, "sample.count", "given"),
        ({"sample": {"method": "sobol", "count": 0}}, "sample.count", "greater than 0"),
        ({"sample": {"method": "sobol", "count": 2**40}}, "sample.count", "at most"),
        ({"name": "../up"}, "name", "a plain identifier"),
    ],
)
def test_what_cannot_be_computed_is_refused(given: Any, field: str, words: str) -> None:
    with pytest.raises(SceneError) as refused:
        of(
            {"rod.mass": {"from": 1, "to": 2, **({} if "sample" in given else {"count": 2})}},
            **given,
        )
    assert refused.value.field == field
    assert words in refused.value.allowed


def test_a_point_that_is_refused_leaves_the_study() -> None:
    study = of({"rod.mass": [-1.0, 20.0]})
    with pytest.raises(SceneError, match=r"rod\.mass"):
        study.scene_at(points(study, [0])[0])
    assert study.scene_at(points(study, [1])[0]).rod.mass == 20.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (FILE.replace("[vary]", "[varied]"), "varied ="),
        (FILE.replace("keep =", "kept ="), "compute.kept ="),
        (FILE.replace('scene = "beck.toml"', "scene = 3"), "scene = 3"),
        (FILE.replace("beck.toml", "other.toml"), "a file that can be read"),
        ("name = ", "valid TOML"),
    ],
)
def test_files_that_are_none_are_refused(
    file: Path, text: str, words: str, rodgen: Any, tmp_path: Path
) -> None:
    file.write_text(text)
    done = rodgen("study", file, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert words in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_more_points_than_anybody_wants_are_asked_for_twice(tmp_path: Path) -> None:
    axis = {"from": 1, "to": 2, "count": 10**4 + 1}
    vary = {"rod.mass": axis, "rod.length": axis}
    with pytest.raises(SceneError, match="--yes"):
        rodgen.study(scene(BECK), vary, what="critical", out=tmp_path / "a.zarr", workers=1)
    assert not list(tmp_path.iterdir())


def test_digests_tell_functions_apart() -> None:
    def one(solution: Any) -> float:
        return 1.0

    def other(solution: Any) -> float:
        return 2.0

    def study(function: Any) -> Study:
        return of({"rod.mass": [1.0, 2.0]}, PENDULUM, what="run", keep=[function])

    assert study(one) == study(one)
    assert study(one) != study(other)
