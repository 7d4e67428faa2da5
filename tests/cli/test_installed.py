"""Commands that other packages add, and what is said where packages are not installed."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from typer.testing import CliRunner

import rodgen as package
from rodgen.cli import app as module
from rodgen.cli.errors import BAD_INPUT
from tests.cli.conftest import ROOT, Write

Commands = Callable[..., tuple[int, str, str]]


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch) -> Commands:
    """Exit status and output of a command line with these entry points alone."""

    def run(installed: dict[str, str], *arguments: str) -> tuple[int, str, str]:
        entries = [EntryPoint(name, value, module.GROUP) for name, value in installed.items()]
        monkeypatch.setattr(module, "entry_points", lambda group: entries)
        done = CliRunner().invoke(module.commands(), list(arguments))
        return done.exit_code, done.stdout, done.stderr

    return run


def test_commands_of_other_packages(commands: Commands) -> None:
    """None takes the place of one that is there, and one that cannot be loaded spares the rest."""
    scene = str(ROOT / "scenes" / "becks_column.toml")
    status, out, _ = commands({"shown": "rodgen.cli.show:show"}, "shown", scene)
    assert status == 0
    assert "becks_column" in out
    assert "SCENE" in commands({"run": "no_such_package:run"}, "run", "--help")[1]
    broken = {"report": "no_such_package:report"}
    assert commands(broken, "--help")[0] == 0
    status, _, err = commands(broken, "report", "--quick")
    assert status == BAD_INPUT
    assert "no_such_package" in err


def test_what_is_not_installed_says_how_to_get_it(commands: Commands) -> None:
    """In the help, where a command is missing, and when it is called."""
    present = dict.fromkeys(module.EVIDENCE, "rodgen.cli.show:show")
    assert "make " not in commands(present, "--help")[1]
    help_of = commands({}, "--help")[1]
    for name in module.EVIDENCE:
        status, _, err = commands({}, name, "--quick", "scene.toml")
        assert status == BAD_INPUT
        assert f"make {name}" in err
        assert f"make {name}" in " ".join(help_of.split())


# An import of one of the packages in the first argument fails as if it were not there.
BLOCKED = """
import importlib.abc, sys
blocked = sys.argv.pop(1).split(",")
class Absent(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in blocked:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Absent())
from rodgen.cli import main
main()
"""
VIEW = ("nicegui", "uvicorn", "fastapi", "starlette")
EXTRAS = ",".join((*VIEW, "imageio_ffmpeg", "cffi", "sksundae"))
VIEWED = ("view", ROOT / "scenes" / "missile.toml", "--no-open", "--port", 0)


def without(packages: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", BLOCKED, packages, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("missing", "arguments", "extra"),
    [
        (EXTRAS, VIEWED, ".[view]"),
        (EXTRAS, ("run", "SCENE", "--target", "c"), "cffi"),
        pytest.param(
            *(EXTRAS, ("run", "SCENE", "--method", "cvode"), ".[cvode]"), marks=pytest.mark.nightly
        ),
        *(pytest.param(name, VIEWED, ".[view]", marks=pytest.mark.nightly) for name in VIEW),
    ],
)
def test_what_to_install_is_said(
    short: Write, tmp_path: Path, missing: str, arguments: tuple[object, ...], extra: str
) -> None:
    given = [short() if word == "SCENE" else word for word in arguments]
    out = ("--out", tmp_path) if "run" in arguments else ()
    done = without(missing, *given, *out)
    assert done.returncode == 2
    assert done.stderr.startswith("rodgen: ")
    assert re.search(rf'pip install "?{re.escape(extra)}', done.stderr)


@pytest.mark.nightly  # runs by NumPy and films are tested where all is installed
def test_run_and_film_without_extras(short: Write, tmp_path: Path) -> None:
    """A run by NumPy names what is missing; a film can still be a GIF."""
    done = without(EXTRAS, "run", short(), "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    result, film = tmp_path / "short" / "solution.nc", tmp_path / "film.gif"
    assert package.load(result).stats.target == "numpy"
    assert "cffi" in done.stdout
    size = ("--width", 480, "--height", 320, "--speed", 0.2)
    done = without(EXTRAS, "animate", result, "--out", film, *size)
    assert done.returncode == 0, done.stderr
    assert film.is_file()
