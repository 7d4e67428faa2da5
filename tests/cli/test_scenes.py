"""rodgen scenes and rodgen new: what comes with the package, copied to be changed."""

from __future__ import annotations

import json
from pathlib import Path

from rodgen.scene import Scene
from rodgen.scene.examples import studies
from rodgen.studies.study import Study
from tests.cli.conftest import Run

FORGETTING = studies()["studies/forgetting"]


def test_scenes_are_listed(works: Run) -> None:
    shown = works("scenes").stdout
    told = json.loads(works("scenes", "--json").stdout)
    assert len(told["scenes"]) > 10
    for name, one in told["scenes"].items():
        assert name in shown
        assert Scene.from_toml(one["file"]) == Scene.example(name)
    assert told["studies"].keys() >= {"studies/flutter_map", "studies/falling_chain"}
    assert Path(told["studies"]["studies/flutter_map"]["file"]).is_file()


def test_a_copy_is_written_once(works: Run, refused: Run, tmp_path: Path) -> None:
    folder = tmp_path / "new"
    works("new", "mine", "--like", "ziegler", "--out", folder)
    file = folder / "mine.toml"
    assert Scene.from_toml(file) == Scene.example("ziegler").replace({"name": "mine"})
    kept = file.read_text(encoding="utf-8")
    assert kept.startswith("# ")  # with its comments
    refused("new", "mine", "--out", folder)
    assert file.read_text(encoding="utf-8") == kept
    assert [path.name for path in folder.iterdir()] == ["mine.toml"]


def test_a_study_is_copied_with_its_scene(works: Run, refused: Run, tmp_path: Path) -> None:
    """Which it does not write over; nor has a study the name of its scene."""
    works("new", "angles", "--like", "studies/forgetting", "--out", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"angles.toml", "falling_chain.toml"}
    copy, own = Study.from_toml(tmp_path / "angles.toml"), Study.from_toml(FORGETTING)
    assert copy.name == "angles"
    assert copy.digest == own.digest
    for name in ("more", "falling_chain"):
        done = refused("new", name, "--like", "studies/forgetting", "--out", tmp_path)
        assert "falling_chain" in done.stderr
    assert not (tmp_path / "more.toml").exists()
