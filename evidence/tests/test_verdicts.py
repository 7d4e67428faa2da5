"""Verdicts are right on a few scenes, and one that is wrong is reported."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen_evidence.verdicts import branch_check, compare, critical_check, wind
from rodgen_evidence.verdicts.along_load import AlongLoad
from rodgen_evidence.verdicts.campaign import FILE, campaign, show
from rodgen_evidence.verdicts.chain_loads import rates
from rodgen_evidence.verdicts.compare import judge, summary
from rodgen_evidence.verdicts.digits import FLOAT
from rodgen_evidence.verdicts.judgement import CONTRADICTED, NONE, REFUSED, RIGHT, Judgement
from rodgen_evidence.verdicts.link_chain import LinkChain
from rodgen_evidence.verdicts.product_answers import Answers, Refusal
from rodgen_evidence.verdicts.random_scenes import sketch

CALM = 3  # a rod that does not turn back in its wind
LOADS = 5
STRAIGHT, BENT = 4, 13  # two links, with feedback and with springs
WRONG = {CONTRADICTED, REFUSED}


# Beside the loads of random scenes.
MORE = {
    "moment": [{"moment": 3.0, "at": 0.4}, {"moment": "2*phi(0.5) - omega(1)"}],
    "distributed_follower": {"force_per_length": 4.0, "angle": -1.2},
    "viscous_drag": {"normal": 0.8, "tangential": 0.3, "wind": [0.5, -0.2]},
    "gravity": {"acceleration": [1.5, "-2*phi(0.3)"]},
}


@pytest.mark.parametrize(("seed", "more"), [(0, {}), (16, {}), (48, {}), (64, {}), (0, MORE)])
def test_the_chain_moves_as_rodgen_says(seed: int, more: dict[str, Any]) -> None:
    """Two programs that share nothing but the text of a scene: 1e-12 of the largest rate."""
    one = sketch(seed)
    table = one.at(one.unit)
    table |= {"loads": table["loads"] | more}
    scene = rodgen.Scene.from_dict(table)
    model = rodgen.build(scene, "numpy")
    y = np.random.default_rng(seed).normal(size=len(scene.initial_state()))
    expected = model.rhs(0.0, y, model.parameters(**scene.parameters))
    found = rates(LinkChain(table, FLOAT), y.tolist())
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


class Asked(Answers):
    """Answers that are computed once."""

    __hash__, __eq__ = object.__hash__, object.__eq__
    critical = lru_cache(Answers.critical)
    static = lru_cache(Answers.static)
    modes = lru_cache(Answers.modes)
    branch = lru_cache(Answers.branch)


@lru_cache
def known(seed: int) -> tuple[AlongLoad, Asked]:
    return AlongLoad(sketch(seed), LOADS), Asked(sketch(seed))


@pytest.mark.parametrize("seed", [STRAIGHT, BENT])
def test_verdicts_are_right(seed: int) -> None:
    found = judge(*known(seed))
    assert not [one for one in found if one.kind in WRONG]
    assert {*summary(found)} == {"critical", "static", "modes", "branch"}
    assert sum(one.kind == RIGHT for one in found) > 2 * LOADS


FALSE = "late", "kind", "none", "stable", "y", "growth", "counts", "hopf"


@pytest.mark.parametrize("false", FALSE)
def test_a_false_answer_is_reported(false: str) -> None:
    reference, answers = known(BENT)
    size, found = float(reference.grid[1]), list[Judgement]()
    if false in ("late", "kind", "none"):
        right = answers.critical()
        late = replace(right, value=1.05 * right.value)
        other = replace(right, kind="divergence", frequency=0.0)
        answer = {"late": late, "kind": other, "none": Refusal("none")}[false]
        found = critical_check.critical(reference, answer)
    elif false in ("stable", "y"):
        right = answers.static(size)
        y, stable = right.y + 1e-3 * (false == "y"), right.stable != (false == "stable")
        found = compare.static(reference, size, SimpleNamespace(y=y, stable=stable))
    elif false == "growth":
        right = answers.modes(size)
        found = compare.modes(reference, size, replace(right, growth=right.growth + 1e-2))
    else:
        answer = answers.branch().copy()
        answer["unstable"] = answer["unstable"] + (false == "counts")
        answer["special_value"] = (1 + 0.01 * (false == "hopf")) * answer["special_value"]
        found = branch_check.branch(reference, answer, 1.0)
    assert WRONG & {one.kind for one in found}


def test_what_is_finished_is_not_done_again(tmp_path: Path) -> None:
    asked: list[int] = []

    def judge(seed: int) -> list[Judgement]:
        asked.append(seed)
        return [Judgement("static", CONTRADICTED if seed == 2 else NONE, 1.5, "why")]

    assert show(list(campaign(range(3), tmp_path, judge))) == 1
    with (tmp_path / FILE).open("a") as file:
        file.write('{"seed": 3, "sou')  # of a run that was killed
    assert len(list(campaign(range(4), tmp_path, judge))) == 4
    assert len(list(campaign(range(4), tmp_path, judge))) == 4
    assert asked == [0, 1, 2, 3]


def test_a_rest_in_a_wind() -> None:
    """One that is found, and what would be said of others."""
    assert wind.judge_rest(CALM, step=0.1).kind == RIGHT
    size = LinkChain(wind.windy(CALM), FLOAT).size
    away = SimpleNamespace(y=np.ones(2 * size))
    assert wind.judge_rest(CALM, away, step=0.1).kind == CONTRADICTED
    assert wind.judge_rest(CALM, Refusal("none"), step=0.1).kind == REFUSED
