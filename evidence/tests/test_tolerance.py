"""Errors over tolerances are small on two scenes, and a run that is falsified is reported."""

from __future__ import annotations

import copy
import io
from functools import lru_cache
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

import rodgen
from rodgen_evidence.tolerance.equal_error import costs
from rodgen_evidence.tolerance.error_tables import show_errors
from rodgen_evidence.tolerance.measure.random_rods import random_tables
from rodgen_evidence.tolerance.measure.scene_record import AUTO, measure_scene
from rodgen_evidence.tolerance.over_tolerance import over_tolerance
from rodgen_evidence.tolerance.records import FILE, records
from rodgen_evidence.tolerance.rule_tables import show_costs

CALM = 10, 17  # two links with damping and gravity, and three with gravity
FEW = 1e-4, 1e-6

Record = dict[str, Any]


@lru_cache
def known(seed: int) -> Record:
    return {"seed": seed, "seconds": 0.0} | measure_scene(seed, FEW)


def shown(lines: list[Record]) -> tuple[tuple[int, int], str]:
    text = io.StringIO()
    console = Console(file=text, width=240)
    wrong = show_errors(lines, console)
    show_costs(lines, console)
    return wrong, text.getvalue()


@pytest.mark.parametrize("seed", CALM)
def test_errors_are_a_few_tolerances(seed: int) -> None:
    found = list(over_tolerance(known(seed)))
    assert {over.rtol for over in found} == {*FEW}
    assert {"angles", "rates", "positions"} <= {over.kind for over in found}
    assert all(0 <= over.end <= over.samples < over.allowed for over in found)


def test_auto_is_the_method_that_it_takes() -> None:
    """Its row is that of the method, since its run is the same to the last bit."""
    scene = rodgen.Scene.from_dict(random_tables(CALM[0]))
    for rtol in FEW:
        rows = [row for row in known(CALM[0])["runs"] if row["rtol"] == rtol]
        auto = next(row for row in rows if row["method"] == AUTO)
        given = {"rtol": rtol, "atol": 0.01 * rtol, "progress": False}
        one, other = (rodgen.simulate(scene, method=m, **given) for m in (AUTO, auto["chosen"]))
        assert (one.y == other.y).all()


def test_a_falsified_run_is_reported() -> None:
    lines = [known(seed) for seed in CALM]
    assert shown(lines)[0] == (0, 0)
    false = copy.deepcopy(lines)
    rows = [row for row in false[1]["runs"] if (row["method"], row["rtol"]) == (AUTO, 1e-6)]
    largest = false[1]["reference"]["size"]["rates"]
    allowed = next(over_tolerance(false[1])).allowed
    rows[0]["errors"] = rows[0]["errors"] | {"rates": [1.1 * allowed * 1e-6 * largest, 0.0]}
    wrong, text = shown(false)
    assert wrong == (1, 0)
    assert f"{CALM[1]}: rates off by" in text
    rows[0]["warned"] = "it was said"
    assert shown(false)[0] == (0, 0)


def test_a_dear_choice_is_reported() -> None:
    """A method that takes ten times as long for the same errors."""
    line = copy.deepcopy(known(CALM[0]))
    for row in line["runs"]:
        if row["method"] in ("auto", "dop853"):
            row["seconds"] *= 10
    found = [cost for cost in costs(line) if cost.method == AUTO]
    assert found
    assert min(cost.times for cost in found) > 3
    assert f"{CALM[0]}: rtol" in shown([line])[1]


def test_what_is_finished_is_not_done_again(tmp_path: Path) -> None:
    asked: list[int] = []

    def measure(seed: int) -> Record:
        asked.append(seed)
        return {"reference": None, "runs": []}

    assert len(list(records(range(2), tmp_path, measure))) == 2
    with (tmp_path / FILE).open("a") as file:
        file.write('{"seed": 2, "sou')  # of a run that was killed
    assert len(list(records(range(3), tmp_path, measure))) == 3
    assert len(list(records(range(3), tmp_path, measure))) == 3
    assert asked == [0, 1, 2]
