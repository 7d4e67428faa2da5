"""Every piece of Python on the pages is run, those of a page one after the other, and every scene
is saved under its name, as a reader does."""

from __future__ import annotations

import tomllib
from pathlib import Path

import matplotlib
import pytest
from sybil import Example, Sybil
from sybil.parsers.myst import CodeBlockParser, PythonCodeBlockParser, SkipParser

ROOT = Path(__file__).parents[1]


def _save(example: Example) -> None:
    """Save a scene or a study; parts of one are only read."""
    read = tomllib.loads(example.parsed)
    if "name" in read:
        Path(f"{read['name']}.toml").write_text(example.parsed, encoding="utf-8")


pytest_collect_file = Sybil(
    parsers=[PythonCodeBlockParser(), CodeBlockParser("toml", _save), SkipParser()],
    patterns=["*.md"],
    excludes=["extending.md", "clusters.md"],  # recipes with a test; clusters
    fixtures=["folder"],
).pytest()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory):
    """A folder of its own beside the scenes, as a reader has it."""
    made = tmp_path_factory.mktemp("page")
    (made / "scenes").symlink_to(ROOT / "scenes")
    matplotlib.use("agg")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made)
        yield made
