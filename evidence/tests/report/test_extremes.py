"""The matrix of extremes: what is right is found right, and what is wrong is found wrong."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from types import ModuleType

import numpy as np
import pytest

import rodgen
from rodgen.integrate import Solution
from rodgen.model.methods import TABLEAUX
from rodgen_evidence.report.stability import extremes, extremes_run
from rodgen_evidence.report.stability.extremes_case import Array, ExtremeCase, Measure, TrueMotion
from rodgen_evidence.report.stability.extremes_cases import follower_rod, links, spans
from rodgen_evidence.report.stability.extremes_run import (
    LOST,
    RIGHT,
    UNFINISHED,
    UNSEEN,
    WARNED,
    WRONG,
    balance,
    judge,
    judge_fixed_step,
    of_adaptive,
    verdict,
)
from rodgen_evidence.report.stability.extremes_truth import piecewise, tight


@pytest.fixture(scope="module")
def swing() -> ExtremeCase:
    """One link on a pin, of which the motion is known in closed form."""
    return next(case for case in links() if case.name == "1, a pendulum")


def _faster(model: ModuleType) -> ModuleType:
    """The module with rates that are a thousandth too large: energy balances as before."""
    parts = {name: getattr(model, name) for name in dir(model) if hasattr(model, name)}

    def rhs(t: float, y: Array, p: Array) -> Array:
        return np.asarray(1.001 * model.rhs(t, y, p))

    scaled = ModuleType("scaled")
    scaled.__dict__.update({**parts, "rhs": rhs})
    return scaled


@pytest.mark.parametrize("group", extremes.GROUPS)
def test_every_group_is_in_the_short_report_too(group: str) -> None:
    assert any(case.quick for case in extremes.GROUPS[group]())


@pytest.mark.compiler
def test_nothing_is_wrong_in_the_short_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the group that needs a single module, in the C target."""
    compiled = tuple(who for who in extremes_run.ALL if who[1] == "c")
    monkeypatch.setattr(extremes_run, "ALL", compiled)
    rows = extremes.measure("spinning", quick=True)
    assert WRONG not in {row["outcome"] for row in rows}
    right = [row for row in rows if row["outcome"] == RIGHT]
    assert len(right) > 0.7 * len(rows)


@pytest.mark.compiler
def test_pendulum_is_right_by_all_methods(swing: ExtremeCase) -> None:
    rows = judge(swing)
    assert len(rows) == 12
    assert {row["outcome"] for row in rows} == {RIGHT}
    assert all(row["digits"] >= 2 for row in rows)
    assert all(row["truth_error"] == 0 and 0 < row["allowed"] <= 0.01 + 1e-9 for row in rows)


def test_model_that_is_off_by_a_thousandth_is_wrong(swing: ExtremeCase) -> None:
    """No energy balance can tell: it is the same motion, a thousandth faster."""
    model = rodgen.build(swing.scene, "numpy")
    truth = swing.truth(swing.scene)
    assert verdict(swing, truth, "dop853", "numpy", model).outcome == RIGHT
    said = verdict(swing, truth, "dop853", "numpy", _faster(model))
    assert said.outcome == WRONG
    assert 2 < said.digits < 4


def test_method_whose_error_does_not_shrink_is_wrong(
    swing: ExtremeCase, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the gain of a thousandth a step, half the step makes more of it."""
    weights = tuple(Fraction(1002, 1000) * b for b in TABLEAUX["rk4"].b)
    truth, model = swing.truth(swing.scene), rodgen.build(swing.scene, "numpy")
    assert verdict(swing, truth, "rk4", "numpy", model).outcome == RIGHT
    monkeypatch.setitem(TABLEAUX, "rk4", replace(TABLEAUX["rk4"], b=weights))
    assert verdict(swing, truth, "rk4", "numpy", model).outcome in (WRONG, LOST)


def test_run_that_says_itself_how_wrong_it_is_is_lost(swing: ExtremeCase) -> None:
    truth = swing.truth(swing.scene)
    sol = rodgen.simulate(swing.scene, target="numpy", method="dop853")
    off = np.linspace(1.0, 1.1, len(sol.t))[:, None]
    bad = replace(sol, y=sol.y * off)
    assert balance(sol) < 1e-6 < 1e-2 < balance(bad)
    assert of_adaptive(truth, sol).outcome == RIGHT
    assert of_adaptive(truth, bad).outcome == LOST


def _moved(solution: Solution, truth: TrueMotion, by: float) -> Solution:
    """States that are off by a share of the motion at the end, energy left as it was."""
    y = truth.y.copy()
    y[-1, 0] += by * np.abs(truth.y[:, 0] - truth.y[0, 0]).max()
    return replace(solution, y=y)


def test_fixed_step_is_judged_at_its_own_step(
    swing: ExtremeCase, monkeypatch: pytest.MonkeyPatch
) -> None:
    """79 % off is not right, however well half the step does."""
    monkeypatch.setattr(extremes_run, "balance", lambda _: 0.0)
    truth = swing.truth(swing.scene)
    sol = rodgen.simulate(swing.scene, target="numpy", method="rk4", step=1e-2)
    for coarse, fine, outcome in (
        (0.79, 0.2, UNSEEN),
        (0.02, 0.01, UNSEEN),
        (0.79, 0.79, UNSEEN),
        (0.2, 0.2, WRONG),
        (0.005, 0.005, WRONG),
        (0.005, 0.001, RIGHT),
        (0.0, 0.0, RIGHT),
    ):
        said = judge_fixed_step(truth, _moved(sol, truth, coarse), _moved(sol, truth, fine))
        assert said.outcome == outcome, (coarse, fine)
    far, near = _moved(sol, truth, 0.79), _moved(sol, truth, 0.2)
    assert judge_fixed_step(truth, far, near, warned=True).outcome == WARNED
    # A balance of a hundredth says nothing of an error of four fifths.
    for share, outcome in ((0.5, LOST), (0.1, LOST), (0.01, UNSEEN), (0.0, UNSEEN)):
        monkeypatch.setattr(extremes_run, "balance", lambda _, share=share: share)
        assert judge_fixed_step(truth, far, near).outcome == outcome, share


@pytest.mark.parametrize("condition", [1.0, 1e9])
def test_adaptive_error_of_a_tenth_is_not_right(swing: ExtremeCase, condition: float) -> None:
    """At a relative tolerance of 1e-4, whatever the condition of the motion."""
    truth = replace(swing.truth(swing.scene), condition=condition)
    sol = rodgen.simulate(swing.scene, target="numpy", method="dop853", rtol=1e-4, atol=1e-6)
    assert of_adaptive(truth, sol).outcome == RIGHT
    said = of_adaptive(truth, _moved(sol, truth, 0.1))
    assert said.outcome in (WRONG, LOST)
    assert said.allowed is not None
    assert said.allowed < 0.04


def test_gauss_is_allowed_a_tolerance_a_step(swing: ExtremeCase) -> None:
    """A velocity that a step of h leaves off by tol/h is off by tol T/h after the time T."""
    truth = swing.truth(swing.scene)
    for method, tolerances, right in (
        ("gauss", 300, True),
        ("gauss", 2000, False),
        ("dop853", 300, False),
    ):
        sol = rodgen.simulate(swing.scene, target="numpy", method=method, rtol=1e-8, atol=1e-10)
        off = tolerances * Measure(sol.scene, truth.y).allowances()["angles"]
        moved = replace(_moved(sol, truth, off), stats=replace(sol.stats, nsteps=1000))
        assert (of_adaptive(truth, moved).outcome == RIGHT) is right, (method, tolerances)


def test_run_without_an_end_is_no_verdict(swing: ExtremeCase) -> None:
    tables = {**swing.tables, "integrate": {**swing.tables["integrate"], "max_steps": 10}}
    case = ExtremeCase("", tables, swing.truth)
    assert verdict(case, swing.truth(case.scene), "rk45", "numpy").outcome == UNFINISHED


def test_errors_are_measured_by_the_motion(swing: ExtremeCase) -> None:
    """By hand: it swings from 1.5 over the vertical at -pi/2; 0.1 rad over the range."""
    truth = swing.truth(swing.scene)
    measure = Measure(swing.scene, truth.y)
    y = truth.y.copy()
    y[-1, 0] += 0.1
    size = np.abs(truth.y[:, 0] - 1.5).max()
    assert measure.errors(y)["angles"] == pytest.approx(0.1 / size, rel=1e-12)
    assert measure.errors(y)["rates"] == 0


def test_scenes_refuse_what_is_no_number() -> None:
    rows = list(extremes._scenes())
    assert len(rows) == 3 * len(extremes.PLACES) + 1
    assert {row["outcome"] for row in rows} == {"refused"}
    assert "rtol" in str(rows[-1]["said"])


@pytest.mark.nightly
def test_reference_of_a_switched_load_knows_its_jumps_itself(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On at 0, off at 1 ms, and so on: without the scene's own break points."""
    tables = follower_rod("3 if sin(2*pi*500*t) > 0 else 0", 0.01)
    case = ExtremeCase("", tables, piecewise([k * 1e-3 for k in range(1, 10)]))
    measure = Measure(case.scene, tight(case.scene).y)
    monkeypatch.setattr(rodgen.Scene, "breaks", lambda _: [])
    known = case.truth(case.scene)
    assert known.error < 1e-13
    assert max(measure.errors(known.y).values()) < 1e-13


@pytest.mark.nightly
def test_late_spans_move_as_that_from_zero_on() -> None:
    """Seconds since 1970: a double has 2e-7 s of them."""
    late = {case.name: case for case in spans() if "1.7e+09" in case.name}
    assert len(late) == 3
    case = late["2 s, from 1.7e+09 s on"]
    assert tuple(case.scene.integrate.span) == (1.7e9, 1.7e9 + 2)
    zero = {**case.tables, "integrate": {"span": [0.0, 2.0]}}
    sol = rodgen.simulate(ExtremeCase("", zero, tight).scene, target="numpy", rtol=1e-9)
    assert of_adaptive(case.truth(case.scene), sol).outcome == RIGHT
    jumping = late["2 s, from 1.7e+09 s on, a force that jumps"].scene
    assert jumping.breaks() == [1.7e9 + 1]
