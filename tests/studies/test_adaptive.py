"""Maps that are refined where classes differ: every pair of neighbours on the border is there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import InputError
from rodgen.studies import adaptive
from rodgen.studies.engine import run_study
from rodgen.studies.sampling import points_at
from rodgen.studies.store import read_store
from rodgen.studies.study import Study
from rodgen.studies.task import evaluate
from tests.studies.conftest import BECK, scene

FORCE, TIME = "loads.follower.force", "loads.material_damping.time"
Array = np.ndarray
Values = Callable[[Array], dict[str, Array]]  # of the points that are asked for


def stability(rows: int, columns: int, **more: Any) -> Study:
    vary = {
        FORCE: {"bounds": [20.0, 90.0], "count": rows},
        TIME: {"bounds": [1e-3, 1.0], "count": columns, "scale": "log"},
    }
    return Study.of(scene(BECK), vary, analysis="modes", keep=["stable", "largest_growth"], **more)


def refined(study: Study, of: Values, *how: Any) -> tuple[Array, list[list[int]]]:
    """Which points are computed, and in which rounds."""
    asked, known = list[list[int]](), np.zeros(study.count, dtype=bool)
    steps = adaptive.refinement_rounds(study, *how)
    values = None
    while True:
        try:
            now = next(steps) if values is None else steps.send(values)
        except StopIteration:
            return known.reshape(study.shape), asked
        assert not known[now].any()
        assert len({*now}) == len(now)
        known[now] = True
        asked.append(now)
        values = of(np.array(now))


def given(**whole: Array) -> Values:
    """The values of the points that are asked for, of all that there are."""
    usual = {"stable": np.ones(10_000, dtype=int), "status": np.full(40_000, "finished")}
    return lambda flat: {name: of.flat[flat] for name, of in (usual | whole).items()}


SHAPES: dict[str, Callable[[Array, Array], Array]] = {
    "a line": lambda x, y: y > 0.3 + 0.4 * x,
    "a disc": lambda x, y: (x - 0.5) ** 2 + (y - 0.4) ** 2 < 0.09,
    "waves": lambda x, y: y > 0.5 + 0.3 * np.sin(9 * x),
    "a corner": lambda x, y: (x > 0.97) & (y > 0.98),
    "nothing": lambda x, y: x > 2,
}


@pytest.mark.parametrize("size", [(200, 200), (90, 31)])
def test_the_whole_border_is_found(size: tuple[int, int]) -> None:
    study = stability(*size)
    x, y = np.meshgrid(*(np.linspace(0, 1, count) for count in size), indexing="ij")
    for name, shape in SHAPES.items():
        whole = shape(x, y).astype(int)
        known, asked = refined(study, given(stable=whole))
        for axis in (0, 1):
            classes, there = np.moveaxis(whole, axis, 0), np.moveaxis(known, axis, 0)
            assert (there[1:] & there[:-1])[classes[1:] != classes[:-1]].all(), name
        if size == (200, 200):
            assert known.mean() < 0.1, name
        assert len(asked) == 1 or name != "nothing"


def test_a_wider_border_takes_fewer_points_and_a_failed_point_is_a_class() -> None:
    study = stability(100, 100)
    status = np.repeat(np.where(np.arange(100) > 40, "failed", "finished"), 100)
    fine, _ = refined(study, given(status=status))
    coarse, _ = refined(study, given(status=status), 0.05)
    assert fine[40:42].all(axis=0).any()
    assert coarse.sum() < fine.sum()


def test_real_numbers_have_a_level() -> None:
    values = np.linspace(-1.0, 3.0, 3600)
    for by, level in (("largest_growth", 1.0), ("largest_growth > 0", 0.0)):
        known, _ = refined(stability(60, 60), given(largest_growth=values), None, by)
        row = int(np.searchsorted(values, level)) // 60
        assert known[row - 1 : row + 1].any(axis=0).all()


def test_the_border_of_stability_is_the_critical_force() -> None:
    """By the modes of each point, and by eigenvalues that cross the axis."""
    study = stability(71, 3)

    def of(flat: Array) -> dict[str, Array]:
        return evaluate(study, points_at(study, flat.tolist()))

    known, _ = refined(study, of)
    forces, times = (np.array(axis.values) for axis in study.axes)
    for column, time in enumerate(times):
        critical = rodgen.critical_load(study.scene_at({TIME: float(time), FORCE: 20.0})).value
        row = int(np.searchsorted(forces, critical))
        assert known[row - 1 : row + 1, column].all()
        assert of(np.array([(row - 1) * 3 + column, row * 3 + column]))["stable"].tolist() == [1, 0]


def test_what_cannot_be_refined() -> None:
    two = {FORCE: [1.0, 2.0], TIME: [1.0, 2.0]}
    for vary, how in (
        ({FORCE: [1.0, 2.0]}, ()),
        ({FORCE: [1.0, 2.0], TIME: [1.0]}, ()),
        *((two, how) for how in ((2.0,), (None, "force"), (None, "largest_growth > 1-1"))),
    ):
        study = Study.of(scene(BECK), vary, analysis="modes", keep=["stable", "largest_growth"])
        with pytest.raises(InputError):
            next(adaptive.refinement_rounds(study, *how))


@pytest.mark.slow
def test_several_workers_refine_into_one_store(tmp_path: Path) -> None:
    """As one does: they open the store of a study that says how its points are chosen."""
    study = stability(25, 25)
    for count in (1, 2):
        path = tmp_path / f"{count}.zarr"
        run_study(study, path, workers=count, adaptive=0.04, by="stable")
    one, two = (read_store(tmp_path / f"{count}.zarr") for count in (1, 2))
    computed = one["status"].values != ""
    assert 0 < computed.sum() < computed.size
    np.testing.assert_array_equal(two["status"].values != "", computed)
    np.testing.assert_array_equal(two["stable"], one["stable"])
