"""rodgen scenes and rodgen new: what comes with the package, copied to be changed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from subprocess import CompletedProcess

from rodgen.scene import Scene
from rodgen.scene.examples import studies
from rodgen.studies.specification import Study

FORGETTING = studies()["studies/forgetting"]

Run = Callable[..., CompletedProcess[str]]


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
    works("new", "mine", "--from", "ziegler", "--out", folder)
    file = folder / "mine.toml"
    assert Scene.from_toml(file) == Scene.example("ziegler").replace({"name": "mine"})
    assert file.read_text(encoding="utf-8").startswith("# Ziegler's double pendulum")
    kept = file.read_bytes()
    refused("new", "mine", "--out", folder, says="is there already")
    refused("new", "other", "--from", "rocket", "--out", folder, says="one of beck_after_flutter")
    refused("new", "../other", "--out", folder, says="a plain identifier")
    assert file.read_bytes() == kept
    assert [path.name for path in folder.iterdir()] == ["mine.toml"]


def test_a_study_is_copied_with_its_scene(works: Run, refused: Run, tmp_path: Path) -> None:
    works("new", "angles", "--from", "studies/forgetting", "--out", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"angles.toml", "falling_chain.toml"}
    copy, own = Study.from_toml(tmp_path / "angles.toml"), Study.from_toml(FORGETTING)
    assert copy.name == "angles"
    assert copy.digest == own.digest
    refused("new", "more", "--from", "studies/forgetting", "--out", tmp_path, says="falling_chain")
    refused("new", "falling_chain", "--from", "studies/forgetting", says="another")
    refused("new", "more", "--from", "forgetting", "--out", tmp_path, says="studies/forgetting")
    assert not (tmp_path / "more.toml").exists()
