"""rodgen run into a folder that holds results already: what is replaced, and what is said."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., subprocess.CompletedProcess[str]]

SCENE = """
name = "same"
[rod]
links = 4
length = 1.0
bending_stiffness = 2.0
mass = 1.0
[loads.gravity]
[integrate]
span = [0.0, 0.1]
"""


@pytest.fixture
def run(rodgen: Run, tmp_path: Path) -> Run:
    """Run the scene, some text of it replaced by another, into one folder."""

    def run(
        old: str = "", new: str = "", *options: object, **settings: object
    ) -> subprocess.CompletedProcess[str]:
        path = tmp_path / "scene.toml"
        path.write_text(SCENE.replace(old, new) if old else SCENE, encoding="utf-8")
        return rodgen("run", path, "--target", "numpy", "--out", tmp_path, *options, **settings)

    assert run().returncode == 0
    return run


def test_run_of_another_scene_is_said_to_be_replaced(run: Run, tmp_path: Path) -> None:
    done = run("length = 1.0", "length = 2.0")
    assert done.returncode == 0, done.stderr
    (line,) = done.stderr.splitlines()
    assert str(tmp_path / "same" / "solution.nc") in line
    assert "changed: rod.length" in line
    assert "replaced" in line


@pytest.mark.parametrize("new", ["span = [0.0, 0.2]", "span = [0.0, 0.1]\nrtol = 1e-6"])
def test_same_scene_integrated_otherwise_is_replaced_silently(run: Run, new: str) -> None:
    done = run("span = [0.0, 0.1]", new)
    assert done.returncode == 0
    assert done.stderr == ""


def test_file_that_is_no_result_is_said_to_be_replaced(run: Run, tmp_path: Path) -> None:
    (tmp_path / "same" / "solution.nc").write_text("notes of mine", encoding="utf-8")
    done = run()
    assert done.returncode == 0
    assert "is no result of this version; it is replaced" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def modules(folder: Path) -> set[str]:
    return {path.name for path in folder.glob("rod_*")}


def test_module_of_an_earlier_structure_is_taken_away(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "same"
    assert modules(folder) == {"rod_free_n4_gravity.py"}
    # Neither is the earlier run's: one by its name, one by its text.
    (folder / "rod_free_n9.py").write_text("mine = 1\n", encoding="utf-8")
    assert run("links = 4", "links = 5").returncode == 0
    assert modules(folder) == {"rod_free_n5_gravity.py", "rod_free_n9.py"}
    (folder / "rod_free_n5_gravity.py").write_text("mine = 1\n", encoding="utf-8")
    assert run("links = 4", "links = 6").returncode == 0
    expected = {"rod_free_n5_gravity.py", "rod_free_n6_gravity.py", "rod_free_n9.py"}
    assert modules(folder) == expected


@pytest.mark.compiler
def test_module_of_another_target_is_taken_away(run: Run, rodgen: Run, tmp_path: Path) -> None:
    c = {f"rod_free_n4_gravity_c.{ending}" for ending in ("py", "c", "h")}
    done = rodgen("run", tmp_path / "scene.toml", "--target", "c", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert modules(tmp_path / "same") == c
    assert run().returncode == 0
    assert modules(tmp_path / "same") == {"rod_free_n4_gravity.py"}


def test_finished_run_is_refused_without_a_word_of_starting_again(run: Run) -> None:
    done = run("", "", "--resume")
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "is finished" in line


def test_summary_names_the_target(rodgen: Run, run: Run, tmp_path: Path) -> None:
    summary = tmp_path / "same" / "summary.txt"
    assert "target numpy" in summary.read_text(encoding="utf-8")
    assert "cannot be built" not in summary.read_text(encoding="utf-8")  # it was not wanted
    env = {"CC": "/nonexistent", "RODGEN_CACHE": str(tmp_path / "cache")}
    done = rodgen("run", tmp_path / "scene.toml", "--out", tmp_path, env=env)
    assert done.returncode == 0, done.stderr
    words = summary.read_text(encoding="utf-8")
    assert words in done.stdout
    assert "target numpy" in words
    assert "cannot be built: CC=/nonexistent: no such program" in words


@pytest.mark.compiler
def test_summary_names_c(rodgen: Run, run: Run, tmp_path: Path) -> None:
    done = rodgen("run", tmp_path / "scene.toml", "--out", tmp_path)
    assert "target c," in done.stdout
    assert "cannot be built" not in done.stdout
