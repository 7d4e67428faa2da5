"""Studies from files and from Python: what they vary, and what is refused before a point is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

import rodgen
from rodgen import InputError, Study
from rodgen.studies.sampling import points_at
from rodgen.studies.task import evaluate
from tests.cli.conftest import names
from tests.studies.conftest import BECK, PENDULUM, scene
from tests.told import refused

FILE = """
name = "forces"
scene = "beck.toml"
[vary]
"loads.follower.force" = {bounds = [5, 60], count = 4}
"loads.material_damping.time" = {bounds = [1e-4, 1e-1], count = 4, scale = "log"}
[compute]
analysis = "modes"
keep = ["frequencies"]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "beck.toml").write_text(tomli_w.dumps(BECK))
    (tmp_path / "study.toml").write_text(FILE)
    return tmp_path / "study.toml"


def of(vary: Any, table: dict[str, Any] = BECK, **given: Any) -> Study:
    return Study.of(scene(table), vary, **{"analysis": "critical", **given})


def test_a_file_and_python_give_the_same_study(file: Path) -> None:
    vary = {
        "loads.follower.force": {"bounds": [5, 60], "count": 4},
        "loads.material_damping.time": {"bounds": [1e-4, 1e-1], "count": 4, "scale": "log"},
    }
    study = Study.from_toml(file)
    own = rodgen.Scene.from_toml(file.with_name("beck.toml"))
    assert study == Study.of(own, vary, analysis="modes", keep=["frequencies"])
    assert study.shape == (4, 4)
    listed = [point["loads.follower.force"] for point in points_at(study, range(0, 16, 4))]
    np.testing.assert_array_equal(listed, np.linspace(5, 60, 4))
    times = [point["loads.material_damping.time"] for point in points_at(study, range(4))]
    np.testing.assert_allclose(times, [1e-4, 1e-3, 1e-2, 1e-1], rtol=1e-15)


VARIED: list[tuple[str, Any, Callable[[rodgen.Scene], Any]]] = [
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
]


def test_any_number_of_a_scene_can_be_varied() -> None:
    more = {
        "bodies": [{"name": "payload", "at": 0.5, "mass": 2.0}],
        "supports": [{"at": 0.5, "stiffness": [0.0, 2.0]}],
        "parameters": {"P0": 3.0},
        "foundation": {"stiffness": "P0"},
    }
    for key, value, of_scene in VARIED:
        study = of({key: [value]}, {**BECK, **more})
        assert of_scene(study.scene_at(points_at(study, [0])[0])) == value, key


def test_values_and_bounds_may_be_expressions() -> None:
    """Texts that are numbers are: of other texts, which are laws, all values are texts."""
    for axis, due in (
        (["deg(60)", 1.5], [np.pi / 3, 1.5]),
        ({"bounds": ["-deg(90)", "deg(90)"], "count": 3}, [-np.pi / 2, 0.0, np.pi / 2]),
    ):
        (made,) = of({"rod.clamp_angle": axis}, BECK).axes
        np.testing.assert_allclose(made.values, due, rtol=1e-15)
    (made,) = of({"loads.follower.force": ["deg(t)", "2*t"]}, BECK).axes
    assert [*made.values] == ["deg(t)", "2*t"]


LINE = {"bounds": [1, 2], "count": 2}
# By field: what is given of the axes of a study; of the mass alone; and beside a varied mass.
NOT_VARIED: dict[str, list[Any]] = {
    "vary": [
        *({}, {"loads.gravity.g": [1.0]}, {"rod": [1.0]}, {"integrate.span": [1.0]}),
        *({"name": ["a"]}, {"bodies.0.mass": [1.0]}, {"__class__": [1.0]}),
    ],
    "vary.loads.follower.forse": [{"loads.follower.forse": [1.0]}],
    "vary.rod.links": [{"rod.links": [2.5]}, {"rod.links": {"bounds": [2, 5], "count": 3}}],
    "vary.integrate.method": [{"integrate.method": ["none"]}],
}
NO_MASSES: dict[str, list[Any]] = {
    "": [1.0, ["heavy"], [-1.0, -2.0]],
    ".values": [[], [1.0, "a"], [1.0, 1.0]],
    ".values[0]": [[True], [float("nan")]],
    ".count": [{"bounds": [1, 2]}, {"values": [1.0], "count": 2}],
    ".bounds": [
        *({"count": 2}, {**LINE, "bounds": [1]}, {**LINE, "bounds": [1, 1]}),
        {**LINE, "bounds": [0, 2], "scale": "log"},
    ],
    ".bounds.0": [{**LINE, "bounds": ["t", 2]}],
    ".step": [{**LINE, "step": 2}],
    ".scale": [{**LINE, "scale": "square"}],
}
NOT_COMPUTED: dict[str, list[dict[str, Any]]] = {
    "compute.analysis": [{"analysis": "walk"}],
    "compute.keep[0]": [{"keep": [3]}],
    "sample.method": [{"sample": {"method": "dice", "count": 3}}],
    "sample.count": [
        {"sample": {"method": "sobol", **count}} for count in ({}, {"count": 0}, {"count": 2**40})
    ],
    "name": [{"name": "../up"}],
}


def test_what_cannot_be_varied_or_computed_is_refused() -> None:
    refusals: list[tuple[str, Any, dict[str, Any]]] = [
        *((field, vary, {}) for field, each in NOT_VARIED.items() for vary in each),
        *(
            (f"vary.rod.mass{field}", {"rod.mass": mass}, {})
            for field, each in NO_MASSES.items()
            for mass in each
        ),
    ]
    for field, each in NOT_COMPUTED.items():
        for given in each:
            line = {"bounds": [1, 2]} if "sample" in given else LINE
            refusals.append((field, {"rod.mass": line}, given))
    for field, vary, given in refusals:
        assert refused(of, vary, **given).field == field, (vary, given)


def test_files_that_are_none_are_refused(file: Path, rodgen: Any, tmp_path: Path) -> None:
    """In a line with the field that is wrong, as by the command."""
    for text, field in (
        (FILE.replace("[vary]", "[varied]"), "varied"),
        (FILE.replace("keep =", "kept ="), "compute.kept"),
        (FILE.replace('scene = "beck.toml"', "scene = 3"), "scene = 3"),
        (FILE.replace("beck.toml", "other.toml"), "scene"),
        ("name = ", "study"),
    ):
        file.write_text(text)
        done = rodgen("study", file, "--out", tmp_path / "out")
        assert done.returncode == 2
        assert names(done.stderr.strip(), field), done.stderr
        assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_more_points_than_anybody_wants_are_asked_for_twice(tmp_path: Path) -> None:
    axis = {"bounds": [1, 2], "count": 10**4 + 1}
    vary = {"rod.mass": axis, "rod.length": axis}
    with pytest.raises(InputError, match="--yes"):
        rodgen.study(scene(BECK), vary, analysis="critical", out=tmp_path / "a.zarr", workers=1)
    assert not list(tmp_path.iterdir())


def test_digests_tell_functions_apart() -> None:
    def one(solution: Any) -> float:
        return 1.0

    def other(solution: Any) -> float:
        return 2.0

    def study(function: Any) -> Study:
        return of({"rod.mass": [1.0, 2.0]}, PENDULUM, analysis="run", keep=[function])

    assert study(one) == study(one)
    assert study(one) != study(other)


# Studies beside the scenes ------------------------------------------------------------------------

FOLDER = Path(__file__).parents[2] / "scenes" / "studies"
QUICK = "flutter_map", "mesh"  # for which nothing is compiled


@pytest.mark.compiler
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(path.stem, marks=() if path.stem in QUICK else pytest.mark.nightly)
        for path in sorted(FOLDER.glob("*.toml"))
    ],
)
def test_points_of_a_study(name: str) -> None:
    study = Study.from_toml(FOLDER / f"{name}.toml")
    assert study.name == name
    some = [0, study.count // 2, study.count - 1]
    found = evaluate(study, points_at(study, some))
    assert found["status"].tolist() == ["finished"] * 3
    for kept in study.keep:
        assert isinstance(kept, str)
        values = found[kept]
        assert values.dtype.kind != "f" or np.isfinite(values).all()
