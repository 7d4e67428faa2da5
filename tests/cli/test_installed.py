"""Commands that other packages add, and what is said where packages are not installed."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from typer.testing import CliRunner

from rodgen.cli import app as module
from rodgen.cli.exits import BAD_INPUT
from tests.cli.conftest import ROOT, python

Commands = Callable[..., tuple[int, str, str]]


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch) -> Commands:
    """Exit status and output of a command line with these entry points alone."""

    def run(installed: dict[str, str], *arguments: str) -> tuple[int, str, str]:
        entries = [EntryPoint(name, value, module.GROUP) for name, value in installed.items()]
        monkeypatch.setattr(module, "entry_points", lambda group: entries)
        done = CliRunner().invoke(module.make_app(), list(arguments))
        return done.exit_code, done.stdout, done.stderr

    return run


def test_commands_of_other_packages(commands: Commands) -> None:
    """None takes the place of one that is there, and one that cannot be loaded spares the rest."""
    scene = str(ROOT / "scenes" / "becks_column.toml")
    status, out, _ = commands({"shown": "rodgen.cli.show_command:show"}, "shown", scene)
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
    present = dict.fromkeys(module.ELSEWHERE, "rodgen.cli.show_command:show")
    assert "Not installed" not in commands(present, "--help")[1]
    help_of = commands({}, "--help")[1]
    assert all(name in help_of.partition("Not installed")[2] for name in module.ELSEWHERE)
    for name, how in module.ELSEWHERE.items():
        status, _, err = commands({}, name, "--quick", "scene.toml")
        assert status == BAD_INPUT
        assert name in err
        assert how in " ".join(err.split())


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
EXTRAS = "imageio_ffmpeg,cffi,sksundae"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "extra"),
    [("animate SCENE --out film.mp4", ".[film]"), ("run SCENE --target c", "cffi")],
)
def test_what_to_install_is_said(
    short: Path, work: Path, monkeypatch: pytest.MonkeyPatch, command: str, extra: str
) -> None:
    monkeypatch.setenv("PATH", str(work))  # which may have an ffmpeg
    done = python(BLOCKED, EXTRAS, *command.replace("SCENE", str(short)).split())
    assert done.returncode == 2
    assert done.stderr.startswith("rodgen: ")
    assert re.search(rf'pip install "?{re.escape(extra)}', done.stderr)
