"""Every piece of Python on the pages is run, those of a page one after the other."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import pytest
from sybil import Sybil
from sybil.parsers.myst import PythonCodeBlockParser, SkipParser

ROOT = Path(__file__).parents[1]

pytest_collect_file = Sybil(
    parsers=[PythonCodeBlockParser(), SkipParser()],
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
