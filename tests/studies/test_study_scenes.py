"""The studies beside the scenes: each can be read, and a few of its points be computed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rodgen.studies.block import evaluate
from rodgen.studies.points import points
from rodgen.studies.specification import Study

FOLDER = Path(__file__).parents[2] / "scenes" / "studies"
QUICK = "flutter_map", "mesh"  # for which nothing is compiled


@pytest.mark.compiler
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(path.stem, marks=() if path.stem in QUICK else pytest.mark.nightly)
        for path in sorted(FOLDER.glob("*.toml"))
    ],
)
def test_points_of_a_study(name: str) -> None:
    study = Study.from_toml(FOLDER / f"{name}.toml")
    assert study.name == name
    some = [0, study.count // 2, study.count - 1]
    found = evaluate(study, points(study, some), some).arrays
    assert found["status"].tolist() == ["finished"] * 3
    for kept in study.keep:
        assert isinstance(kept, str)
        values = found[kept]
        assert values.dtype.kind != "f" or np.isfinite(values).all()
