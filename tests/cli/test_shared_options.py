"""Options that commands share: other values of keys, quiet, no pictures, JSON, completion."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import rodgen as package
from rodgen.cli.app import OWN, app
from rodgen.cli.shared import read_scene
from rodgen.scene import Scene, SceneError
from tests.cli.conftest import Run

Short = Callable[..., Path]


@pytest.mark.parametrize("name", OWN)
def test_every_command_has_the_options_that_it_shares(works: Run, name: str) -> None:
    help_of = works(name, "--help").stdout
    usage = help_of.splitlines()[0]
    assert "--quiet" in help_of
    if "SCENE" in usage:
        assert "--set KEY=VALUE" in help_of
    if re.search(r"folder of the scene's +or +study's name", " ".join(help_of.split())):
        assert "--no-pictures" in help_of


def test_commands_are_listed_with_whole_sentences(works: Run) -> None:
    listed = works("--help").stdout.partition("Commands:")[2].partition("\n\n")[0]
    sentences = re.split(r"\n  (?=\w)", listed)
    assert len(sentences) > len(OWN)
    assert "..." not in listed
    assert all(one.strip().endswith(".") for one in sentences if one.strip())


VALUES: list[tuple[str, dict[str, Any]]] = [
    ("loads.follower.force=300", {"loads.follower.force": 300}),
    ("loads.follower.force=3e2*t", {"loads.follower.force": "3e2*t"}),
    ("initial.phi='0.1*s'", {"initial.phi": "0.1*s"}),
    ("initial.phi=[0, 0.1, 0.2, 0.3]", {"initial.phi": [0, 0.1, 0.2, 0.3]}),
    ("loads.gravity=", {"loads.gravity": None}),
    ("rod.boundary=pinned", {"rod.boundary": "pinned"}),
    ("rod.boundary = 'pinned'", {"rod.boundary": "pinned"}),
    (
        "loads.drag={normal = 1.0, tangential = 0.1}",
        {"loads.drag": {"normal": 1.0, "tangential": 0.1}},
    ),
]


@pytest.mark.parametrize(("text", "changes"), VALUES, ids=lambda one: str(one))
def test_values_are_those_of_a_file(short: Short, text: str, changes: dict[str, Any]) -> None:
    path = short()
    assert read_scene(path, [text]) == Scene.from_toml(path).replace(changes)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("rod.mass", "--set"),
        ("=3", "--set"),
        ("rod..mass=3", "--set"),
        ("rod.mass=-1", "rod.mass = -1"),
        ("loads.graviti=", "loads.graviti = None"),
        ("rod.wheels=4", "not a known key"),
        ("rod.mass=1\nrod.length=1", "rod.mass = '1"),
        (f"rod.mass={'[' * 5000}", "rod.mass = '[["),
        ("rod.mass=1979-05-27", "rod.mass"),
    ],
)
def test_what_cannot_be_set_is_refused(short: Short, text: str, says: str) -> None:
    with pytest.raises(SceneError, match=re.escape(says)):
        read_scene(short(), [text])


def test_a_run_in_json_without_pictures(works: Run, short: Short, tmp_path: Path) -> None:
    given = ("--set", "integrate.span=[0, 0.1]", "--set", "name=other")
    done = works("run", short(), *given, "--json", "--no-pictures", "--out", tmp_path)
    told = json.loads(done.stdout)
    run = package.load(tmp_path / "other" / "solution.nc")
    assert run.t[-1] == told["end"] == 0.1
    assert told["tip"] == run.tip[-1].tolist()
    assert told["energy_error"] == run.energy_error
    assert (told["samples"], told["steps"]) == (len(run.t), run.stats.steps)
    assert told["files"][:2] == ["solution.nc", "summary.txt"]
    assert not list((tmp_path / "other").glob("*.png"))
    assert {name.rstrip("/") for name in told["files"]} == {
        path.name for path in (tmp_path / "other").iterdir()
    }


def test_quiet_commands_print_nothing(works: Run, short: Short, tmp_path: Path) -> None:
    scene = short()
    for command in ("show", "modes"):
        out = ("--out", tmp_path) if command == "modes" else ()
        done = works(command, scene, "--quiet", *out)
        assert (done.stdout, done.stderr) == ("", "")
        assert works(command, scene, *out).stdout
    assert (tmp_path / "short" / "modes.png").is_file()


def test_show_in_json(works: Run, short: Short) -> None:
    path = short()
    told = json.loads(works("show", path, "--json").stdout)
    scene = Scene.from_toml(path)
    assert told["structure"] == scene.structure.hash
    assert told["parameters"] == scene.parameters
    assert told["breaks"] == scene.breaks()
    assert {one["piece"]: one["present"] for one in told["contents"]}["gravity"]
    assert told["method"] in works("show", path).stdout
    assert told["largest_stable_steps"]["rk4"] > 0


def test_the_module_of_a_scene_is_derived_and_checked(
    works: Run, refused: Run, short: Short, tmp_path: Path
) -> None:
    scene = ("--scene", short())
    told = json.loads(works("derive", *scene, "--json", "--out", tmp_path).stdout)
    structure = Scene.from_toml(scene[1]).structure
    assert (told["module"], told["structure"]) == (structure.stem, structure.hash)
    assert sum(one["entries"] for one in told["proven"]) > 10
    (file,) = told["files"]
    assert Path(file).name == f"{structure.stem}.py"
    checked = json.loads(works("check", file, "--json").stdout)
    assert checked["largest"] == max(one["error"] for one in checked["deviations"])
    assert checked["largest"] <= checked["allowed"]
    refused("derive", "3", *scene, says="N = '3': must be absent beside --scene")
    refused("derive", "--boundary", "free", *scene, says="--boundary = 'free': must be absent")
    refused("derive", "3", "--set", "rod.mass=1", says="given with --scene")
    refused("derive", says="N = (missing)")


@pytest.mark.parametrize(
    ("words", "completed"),
    [
        ("crit", {"critical"}),
        ("run x.toml --method rk", {"rk4", "rk23", "rk45"}),
        (
            "run x.toml --set loads.drag.",
            {f"loads.drag.{key}" for key in ("normal", "tangential", "wind")},
        ),
        ("branch x.toml --vary integrate.sp", {"integrate.span"}),
        ("new mine --from missile", {"missile", "missile_conservative"}),
        ("derive 3 --terms drag,gra", {"drag,gravity"}),
        ("run x", set()),  # the shell completes files
    ],
)
def test_shells_complete_commands_and_values(words: str, completed: set[str]) -> None:
    env = {
        "_RODGEN_COMPLETE": "complete_bash",
        "COMP_WORDS": f"rodgen {words}",
        "COMP_CWORD": str(len(words.split())),
    }
    done = CliRunner().invoke(app, prog_name="rodgen", env=env)
    assert set(done.stdout.split()) == completed
