"""rodgen report: a scene of a user's, what is refused, and going on with what was stopped."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rodgen.cli import main
from rodgen_evidence.report import sections
from rodgen_evidence.report.cases import cases
from rodgen_evidence.report.sections import SECTIONS, required_sections

SCENE = """
name = "{name}"
[rod]
links = 2
length = 1.0
bending_stiffness = 5.0
mass = 1.0
boundary = "clamped"
[initial]
phi = "0.3*s"
[integrate]
span = [0.0, 0.5]
"""


class Done(NamedTuple):
    status: int
    out: str
    err: str


Call = Callable[..., Done]


@pytest.fixture
def call(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Call:
    """Run the command in this process, in a folder that has the scene swing.toml."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "swing.toml").write_text(SCENE.format(name="swing"), encoding="utf-8")

    def run(*arguments: object) -> Done:
        monkeypatch.setattr(sys, "argv", ["rodgen", "report", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            main()
        return Done(int(end.value.code or 0), *capsys.readouterr())

    return run


@pytest.mark.compiler
def test_a_scene_of_a_user(call: Call, tmp_path: Path) -> None:
    done = call("swing.toml", "--quick", "--only", "growth", "--out", "page")
    assert done.status == 0, done.err
    assert "written: page/index.html" in done.out
    report = json.loads((tmp_path / "page/report.json").read_text(encoding="utf-8"))
    (reference,) = report["sections"]["references"][0]["rows"]
    assert reference["scene"] == "swing"
    # Two families at tolerances of 1e-10 or less agree, whose errors of some steps add up.
    assert 0 <= reference["check_phi"] == reference["estimate_phi"] < 1e-7
    errors = {row["setting"]: row for row in report["sections"]["growth"][0]["rows"]}
    # dop853's own tolerance bounds its error, which grows with the square of so short a time.
    assert 0 < max(errors[1e-10]["error"]) < 1e-8
    assert max(errors[1e-6]["error"]) < 1e-4
    page = (tmp_path / "page/index.html").read_text(encoding="utf-8")
    assert "swing" in page
    measured = {file: file.stat().st_mtime_ns for file in tmp_path.glob("page/measured/*.json")}
    assert len(measured) == 2
    assert (
        call("swing.toml", "--quick", "--only", "growth", "--out", "page", "--resume").status == 0
    )
    assert {file: file.stat().st_mtime_ns for file in measured} == measured


@pytest.mark.nightly
@pytest.mark.compiler
def test_a_scene_that_blows_up(call: Call, tmp_path: Path) -> None:
    """It has no reference, which is said; its page is written all the same."""
    loads = '[loads.tip]\ny = "exp(2000*t)"\n'
    text = SCENE.format(name="blows").replace("[initial]", f"{loads}[initial]")
    (tmp_path / "blows.toml").write_text(text, encoding="utf-8")
    done = call("blows.toml", "--quick", "--only", "growth", "--out", "page")
    assert done.status == 3
    assert "without a reference nothing can be judged: blows" in done.err
    page = (tmp_path / "page/index.html").read_text(encoding="utf-8")
    assert "blows" in page
    assert "no reference" in page


def test_what_is_refused(call: Call, tmp_path: Path) -> None:
    (tmp_path / "again.toml").write_text(SCENE.format(name="swing"), encoding="utf-8")
    (tmp_path / "file").write_text("", encoding="utf-8")
    for arguments, words in (
        (["missing.toml"], "missing.toml"),
        (["swing.toml", "again.toml"], "another name for every scene"),
        (["swing.toml", "--only", "speed"], "one of references, precision"),
        (["swing.toml", "--out", "file/below"], "a folder to write into"),
        (["swing.toml", "--steps"], "--steps"),
    ):
        done = call(*arguments)
        assert done.status == 2, arguments
        assert words in done.err
        assert len(done.err.splitlines()) == 1
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize("command", ["report", "thesis", "audit"])
def test_folder_that_cannot_be_made_is_refused(rodgen: Callable[..., Any], command: str) -> None:
    """Before anything is computed, by every command of this package."""
    done = rodgen(command, "--out", "/dev/null/folder")
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert line.startswith("rodgen: --out = '/dev/null")


def test_sections_bring_what_they_are_made_from() -> None:
    assert required_sections(["equal_error"]) == ["references", "precision", "equal_error"]
    assert required_sections(["install"]) == ["install"]
    assert required_sections(SECTIONS) == list(SECTIONS)
    depths = {name: sections._depth(name) for name in SECTIONS}
    assert depths["references"] < depths["precision"] < depths["equal_error"]
    assert depths["references"] < depths["growth"]


@pytest.mark.parametrize("quick", [False, True])
def test_units_have_names_of_files_and_can_be_called(quick: bool, tmp_path: Path) -> None:
    planned = [
        unit
        for name in SECTIONS
        for unit in sections._units(name, cases(quick), tmp_path, quick, {})
    ]
    assert {unit.section for unit in planned} == {*SECTIONS}
    names = [unit.name for unit in planned]
    assert len(set(names)) == len(names)
    assert all(name.replace("-", "").replace("_", "").isalnum() for name in names)
    for unit in planned:
        module, _, function = unit.function.partition(":")
        assert callable(getattr(import_module(module), function))
        assert json.dumps(unit.arguments)
