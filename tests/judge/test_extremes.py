"""The matrix of extremes: what is right is found right, and what is wrong is found wrong."""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

import rodgen
from rodgen.integrate.methods import fixed_step
from rodgen.judge.stability import extremes, extremes_invalid, extremes_run
from rodgen.judge.stability.extremes_case import Array, Extreme, Measure
from rodgen.judge.stability.extremes_run import judge, verdict
from rodgen.judge.stability.extremes_scales import links
from rodgen.judge.stability.extremes_verdict import (
    LOST,
    RIGHT,
    UNFINISHED,
    WRONG,
    balance,
    of_adaptive,
)


@pytest.fixture(scope="module")
def swing() -> Extreme:
    """One link on a pin, of which the motion is known in closed form."""
    return next(case for case in links() if case.name == "1, a pendulum")


def _faster(model: ModuleType) -> ModuleType:
    """The module with rates that are a thousandth too large: energy balances as before."""
    parts = {name: getattr(model, name) for name in dir(model)}

    def rhs(t: float, y: Array, p: Array) -> Array:
        return np.asarray(1.001 * model.rhs(t, y, p))

    scaled = ModuleType("scaled")
    scaled.__dict__.update({**parts, "rhs": rhs})
    return scaled


def test_every_group_is_in_the_short_report_too() -> None:
    for quick in (False, True):
        names = [unit.name for unit in extremes.units([], quick)]
        assert len(set(names)) == len(names) == len(extremes.GROUPS) + 1
    for group, cases in extremes.GROUPS.items():
        assert any(case.quick for case in cases()), group


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
def test_pendulum_is_right_by_all_methods(swing: Extreme) -> None:
    rows = judge(swing)
    assert len(rows) == 12
    assert {row["outcome"] for row in rows} == {RIGHT}
    assert all(row["digits"] > 1 for row in rows)


def test_model_that_is_off_by_a_thousandth_is_wrong(swing: Extreme) -> None:
    """No energy balance can tell: it is the same motion, a thousandth faster."""
    model = rodgen.build(swing.scene, "numpy")
    truth = swing.truth(swing.scene)
    assert verdict(swing, truth, "dop853", "numpy", model).outcome == RIGHT
    said = verdict(swing, truth, "dop853", "numpy", _faster(model))
    assert said.outcome == WRONG
    assert 2 < said.digits < 4


def test_method_whose_error_does_not_shrink_is_wrong(
    swing: Extreme, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the gain of a thousandth a step, half the step makes more of it."""
    right = fixed_step.METHODS["rk4"]

    def off(rhs: object, t: float, y: Array, f: Array, h: float) -> Array:
        return np.asarray(y + 1.002 * (right(rhs, t, y, f, h) - y))  # type: ignore[arg-type]

    truth, model = swing.truth(swing.scene), rodgen.build(swing.scene, "numpy")
    assert verdict(swing, truth, "rk4", "numpy", model).outcome == RIGHT
    monkeypatch.setitem(fixed_step.METHODS, "rk4", off)
    assert verdict(swing, truth, "rk4", "numpy", model).outcome in (WRONG, LOST)


def test_run_that_says_itself_how_wrong_it_is_is_lost(swing: Extreme) -> None:
    truth = swing.truth(swing.scene)
    sol = rodgen.simulate(swing.scene, target="numpy", method="dop853")
    off = np.linspace(1.0, 1.1, len(sol.t))[:, None]
    bad = replace(sol, y=sol.y * off)
    assert balance(sol) < 1e-6 < 1e-2 < balance(bad)
    assert of_adaptive(truth, sol).outcome == RIGHT
    assert of_adaptive(truth, bad).outcome == LOST


def test_run_without_an_end_is_no_verdict(swing: Extreme) -> None:
    tables = {**swing.tables, "integrate": {**swing.tables["integrate"], "max_steps": 10}}
    case = Extreme("", "", tables, swing.truth)
    assert verdict(case, swing.truth(case.scene), "rk45", "numpy").outcome == UNFINISHED


def test_errors_are_measured_by_the_motion(swing: Extreme) -> None:
    """By hand: it swings from 1.5 over the vertical at -pi/2; 0.1 rad over the range."""
    truth = swing.truth(swing.scene)
    measure = Measure(swing.scene, truth.y)
    y = truth.y.copy()
    y[-1, 0] += 0.1
    size = np.abs(truth.y[:, 0] - 1.5).max()
    assert measure.errors(y)["angles"] == pytest.approx(0.1 / size, rel=1e-12)
    assert measure.errors(y)["rates"] == 0


def test_scenes_refuse_what_is_no_number() -> None:
    rows = list(extremes_invalid._scenes())
    assert len(rows) == 3 * len(extremes_invalid.PLACES) + 1
    assert {row["outcome"] for row in rows} == {"refused"}
    assert "rtol" in str(rows[-1]["said"])
