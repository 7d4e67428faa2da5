"""Options that commands share: other values of keys, quiet, no pictures, JSON, completion."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from rodgen.cli.app import make_app, own_commands
from rodgen.cli.options import parse_bounds, read_scene
from rodgen.scene import Scene
from tests.cli.conftest import Run, Write, one_object
from tests.told import refused

# Commands that draw pictures beside what they print.
DRAWING = (
    *("run", "modes", "static", "critical", "branch", "boundary", "exponents", "cycle"),
    *("precision", "study"),
)


def test_commands_have_the_options_that_they_share_and_are_listed_whole(works: Run) -> None:
    listed = works("--help").stdout.partition("Commands:")[2].partition("\n\n")[0]
    sentences = re.split(r"\n  (?=\w)", listed)
    assert all(one.strip().endswith(".") for one in sentences if one.strip())
    assert {*own_commands()} <= {one.split()[0] for one in sentences if one.strip()}
    for name in own_commands():
        help_of = works(name, "--help").stdout
        assert "--quiet" in help_of
        assert "--set KEY=VALUE" in help_of or "SCENE" not in help_of.splitlines()[0]
        for option in ("--no-pictures", "--format", "--width"):
            assert option in help_of or name not in DRAWING


VALUES: list[tuple[str, dict[str, Any]]] = [
    ("rod.length=2*deg(90)", {"rod.length": "2*deg(90)"}),
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


def test_values_are_those_of_a_file(short: Path) -> None:
    for text, changes in VALUES:
        assert read_scene(short, [text]) == Scene.from_toml(short).replace(changes), text


def test_bounds_are_numbers_or_expressions() -> None:
    for text, due in (("0,-1e3", (0.0, -1e3)), (",5", (None, 5.0)), ("deg(180),", (math.pi, None))):
        assert parse_bounds(text) == due
    for text in ("1", "1,2,3", "0,inf", "0,t", "0,deg(", "a,b"):
        assert refused(parse_bounds, text)[:2] == ("--bounds", text)


def test_what_cannot_be_set_is_refused(short: Path) -> None:
    for text, field in (
        *(("rod.mass", "--set"), ("=3", "--set"), ("rod..mass=3", "--set")),
        *(("rod.mass=-1", "rod.mass"), ("rod.mass=1\nrod.length=1", "rod.mass")),
        *((f"rod.mass={'[' * 5000}", "rod.mass"), ("rod.mass=1979-05-27", "rod.mass")),
        *(("loads.graviti=", "loads.graviti"), ("rod.wheels=4", "rod.wheels")),
    ):
        assert refused(read_scene, short, [text]).field == field, text


def test_quiet_commands_print_nothing(works: Run, short: Path, tmp_path: Path) -> None:
    for command in ("show", "modes"):
        out = ("--out", tmp_path) if command == "modes" else ()
        done = works(command, short, "--quiet", *out)
        assert (done.stdout, done.stderr) == ("", "")
        assert works(command, short, *out).stdout
    assert (tmp_path / "short" / "modes.png").is_file()


# What commands that draw are given, and the pictures that they then write, without their endings.
DRAWN: dict[tuple[str, ...], set[str]] = {
    ("modes",): {"modes"},
    ("static",): {"static"},
    ("static", "--all"): {"equilibria"},
    ("branch", "--vary", "loads.tip.x", "--bounds", "0,-1"): {"branch"},
}


@pytest.mark.parametrize("command", DRAWN)
def test_json_has_pictures_only_where_they_are_asked_for(
    works: Run, column: Write, work: Path, command: tuple[str, ...]
) -> None:
    """By --format or --width; the object is the same, and alone on standard output."""
    given = (command[0], column(), *command[1:])
    alone = one_object(works(*given, "--json"))
    for asked, ending in ((("--format", "svg"), "svg"), (("--width", "3.3in"), "png")):
        done = works(*given, "--json", *asked, "--out", work.parent / ending)
        assert one_object(done) == alone
        written = {file.name for file in (work.parent / ending / "rod").iterdir()}
        assert written == {f"{name}.{ending}" for name in DRAWN[command]}
        assert all(name in done.stderr for name in written)
    given = (*given, "--json", "--format", "svg", "--no-pictures")
    assert one_object(works(*given)) == alone


@pytest.mark.compiler
def test_a_run_in_json_has_pictures_only_where_they_are_asked_for(
    works: Run, short: Path, tmp_path: Path
) -> None:
    for asked in ((), ("--format", "svg")):
        found = json.loads(works("run", short, "--json", *asked, "--out", tmp_path).stdout)
        there = {file.name for file in (tmp_path / "short").iterdir()}
        assert {name.rstrip("/") for name in found["files"]} == there
        assert any(name.endswith(".svg") for name in there) == bool(asked)
        assert not any(name.endswith(".png") for name in there)


COMPLETED = {
    "crit": {"critical"},
    "run x.toml --method rk": {"rk4", "rk23", "rk45"},
    "run x.toml --set loads.drag.": {f"loads.drag.{k}" for k in ("normal", "tangential", "wind")},
    "branch x.toml --vary integrate.sp": {"integrate.span"},
    "new mine --like missile": {"missile", "missile_conservative"},
    "derive 3 --terms drag,gra": {"drag,gravity"},
    "run x": set(),  # the shell completes files
}


def test_shells_complete_commands_and_values() -> None:
    for words, completed in COMPLETED.items():
        env = {
            "_RODGEN_COMPLETE": "complete_bash",
            "COMP_WORDS": f"rodgen {words}",
            "COMP_CWORD": str(len(words.split())),
        }
        done = CliRunner().invoke(make_app(), prog_name="rodgen", env=env)
        assert set(done.stdout.split()) == completed
