"""Looking back at samples of a run, at what is marked, and at a run that is kept beside another."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from live.tests.conftest import SCENE, SHORT
from live.tests.runs import Page, does, gets, to
from live.tests.view import until
from rodgen.scene import Scene
from rodgen_live.page.server import act_on_answer
from rodgen_live.run.change_history import MOST_MARKS, ChangeMark, ChangeMarks
from rodgen_live.run.live_run import LiveRun


@pytest.fixture
def run(run: LiveRun) -> LiveRun:
    """Paused after samples at 0, 0.01, ..., 0.3 s, with a profile of the rates."""
    run.submit(lambda: run.add_plot({"kind": "profile", "y": ["omega"]})).result()
    to(run, 0.3)
    return run


def looks(run: LiveRun, page: Page, text: str) -> dict[str, Any]:
    """What the page gets of what the run shows after it has said something."""
    before = len(page.headers)
    assert act_on_answer(run, text)
    past = run.submit(lambda: None if run.past is None else float(run.past.t[-1])).result()
    line = {"past": past, "to": run.store.span[1]}

    def shown() -> list[dict[str, Any]]:
        page.acknowledge()
        return [one for one in page.headers[before:] if line.items() <= one["line"].items()]

    return until(shown, lambda found: len(found) > 0, "it is not shown")[0]


def test_rod_profile_and_values_are_those_of_the_sample(run: LiveRun) -> None:
    page = gets(run)
    line = {"from": 0.0, "to": 0.3, "count": 31, "past": None, "keeps": False, "marks": []}
    assert page.headers[-1]["line"] == line
    header = looks(run, page, '{"look": 0.1234}')
    sample = run.store.nearest(0.12)
    assert (header["t"], header["line"]["past"]) == (0.12, 0.12)
    joints = run.model.joints(sample.y[0], sample.p)
    # Single precision.
    assert header["joints"].reshape(-1, 2) == pytest.approx(joints - joints[0], abs=1e-6)
    (plot,) = run.plots
    half = sample.y.shape[1] // 2
    assert page.rows[plot][-1].reshape(-1, 2)[:, 1] == pytest.approx(sample.y[0, half + 2 :])
    assert float(header["texts"]["kinetic_energy"]) == pytest.approx(  # five digits are shown
        float(run.catalogue.columns(["kinetic_energy"], sample)[0, 0]), rel=1e-4
    )


def test_places_that_are_asked_for_are_shown_while_the_run_goes_on(run: LiveRun) -> None:
    """Steps end at the first sample and in the present."""
    page = gets(run)
    for said, past in (
        ('{"step": -1}', 0.29),
        ('{"step": -100}', 0.0),
        ('{"step": 29}', 0.29),
        ('{"step": 1}', None),
        ('{"look": 0.2}', 0.2),
    ):
        assert looks(run, page, said)["line"]["past"] == pytest.approx(past)
    to(run, 0.5)
    header = looks(run, page, '{"step": 0}')
    assert (header["t"], header["line"]["to"]) == (pytest.approx(0.2), 0.5)
    assert looks(run, page, '{"look": null}')["t"] == 0.5


def test_what_moves_the_rod_is_seen_in_the_present(run: LiveRun) -> None:
    """A kick, a change, a step or a start shows what it does, wherever the page looked."""
    page = gets(run)
    heavier = run.live.system.at({"rod.mass": 4.0})
    for act in (
        lambda: run.kick(4, 1.0, (0.0, 0.1)),
        lambda: run.change(heavier, "rod.mass = 4"),
        run.one_step,
        run.restart,
    ):
        looks(run, page, '{"step": -1}')
        run.submit(act).result()
        assert run.past is None
        to(run, run.live.t + 0.1)


def test_marks_of_a_slider_are_one_and_bounded() -> None:
    marks = ChangeMarks()
    for t, what in ((1.0, "mass = 2"), (1.5, "mass = 3"), (2.0, "kick (0, 1) N s upon link 0")):
        marks.note(t, what)
    assert marks.every == (
        ChangeMark(1.5, "mass = 3"),
        ChangeMark(2.0, "kick (0, 1) N s upon link 0"),
    )
    for k in range(2 * MOST_MARKS):
        marks.note(3.0 + k, f"kick {k}")
    assert len(marks.every) == MOST_MARKS
    assert (marks.every[0].t, marks.every[-1].what) == (1.5, f"kick {2 * MOST_MARKS - 1}")


NONE = (
    *("", "3", "[]", "{}", '{"ack": 1, "step": 1}', '{"go": 1}', '{"ack": 1.5}', '{"keep": 1}'),
    *('{"branch": true}', '{"look": NaN}', '{"look": true}', '{"look": "1"}', '{"step": null}'),
    *('{"step": 1.5}', '{"ack": ' + "1" * 500 + "}", "[" * 100_000),
)


def test_other_answers_are_none(run: LiveRun) -> None:
    assert [text for text in NONE if act_on_answer(run, text)] == []


@pytest.fixture
def kept(other: LiveRun) -> LiveRun:
    """One that is kept, with samples at 0, 0.01, ..., 0.3 s."""
    does(other, lambda: other.keep_runs(True))
    to(other, 0.3)
    return other


def plotted(kept: LiveRun, **choice: Any) -> str:
    """The name of a plot that is added."""
    kept.submit(lambda: kept.add_plot(choice)).result()
    return list(kept.plots)[-1]


def heavier(kept: LiveRun) -> None:
    heavy = kept.live.system.at({"rod.mass": 4.0})
    kept.submit(lambda: kept.change(heavy, "rod.mass = 4")).result()


def test_rod_that_is_kept_is_shown_at_the_same_time(kept: LiveRun) -> None:
    before = kept.store
    kept.submit(kept.restart).result()
    to(kept, 0.125)
    header = gets(kept).headers[-1]
    sample = before.nearest(0.12)
    expected = kept.model.joints(sample.y[0], sample.p) - np.array(header["origin"])
    assert header["ghost"].reshape(-1, 2) == pytest.approx(expected, abs=1e-6)  # single precision
    ghost = kept.ghost
    assert ghost is not None
    first, last = (ghost.joints(t) for t in (0.1, 0.11))
    assert ghost.joints(0.1025) == pytest.approx(0.75 * first + 0.25 * last)
    assert ghost.joints(0.3001).size == ghost.joints(-0.1).size == 0
    to(kept, 0.4)
    header = gets(kept).headers[-1]
    assert header["ghost"].size == 0  # it has not come that far, and the picture says so
    assert header["kept"] == pytest.approx(ghost.store.span)
    kept.submit(kept.restart).result()
    last_one = kept.ghost
    kept.submit(kept.restart).result()
    assert kept.ghost is last_one  # a run that did not move is not


@pytest.mark.parametrize(
    "choice",
    [
        {"kind": "time", "y": ["phi_4 - phi_0"]},
        {"kind": "phase", "y": ["omega_4"], "x": "phi_4"},
        {"kind": "poincare", "y": ["tip_y"], "x": "tip_x", "when": "t", "every": 0.02},
        {"kind": "spectrum", "y": ["phi_4"], "window": 0.2},
        {"kind": "profile", "y": ["bending_moment"]},
    ],
    ids=lambda choice: choice["kind"],
)
def test_plots_of_all_kinds_show_both(kept: LiveRun, choice: dict[str, Any]) -> None:
    """What they showed of the run before; along the rod at the same time."""
    name = plotted(kept, **choice)
    before = gets(kept).rows[name][-1]
    assert before.size
    kept.submit(kept.restart).result()
    to(kept, 0.3)
    assert np.array_equal(gets(kept).headers[-1][f"ghost:{name}"], before)
    kept.submit(lambda: kept.keep_runs(False)).result()
    header = gets(kept).headers[-1]
    assert (header[f"ghost:{name}"].size, "ghost" in header) == (0, False)


def test_another_rod_is_compared_where_both_have_a_quantity(kept: LiveRun) -> None:
    """On the page that has been there before; the tail with the tail. Plots lose what it does not
    have, and get it back."""
    for y in (["tip_x"], ["phi"], ["phi_0", "phi_3"], ["omega_3"], ["omega_4"]):
        plotted(kept, kind="time", y=y)
    page = gets(kept)
    tail = page.rows["p2"][-1].reshape(-1, 6)[:, -1]
    kept.submit(lambda: kept.switch_to(Scene.from_dict(SHORT))).result()
    shown = {plot.names: name for name, plot in kept.plots.items()}
    assert kept.unplotted == ("φ₃", "ω₃")
    assert {("tip_x",), ("omega_2",), ("phi_0",)} < shown.keys()
    header = page.gets(2)
    assert header["ghost"].size == 2 * 6  # joints of five links
    assert header[f"ghost:{shown['tip_x',]}"].size == 2 * 31
    curves = header[f"ghost:{shown['phi_0', 'phi_1', 'phi_2']}"].reshape(-1, 4)
    assert curves[:, -1] == pytest.approx(tail)
    kept.submit(lambda: kept.switch_to(SCENE)).result()
    again = {plot.names for plot in kept.plots.values()}
    assert {("omega_3",), ("omega_4",), ("phi_0", "phi_3")} < again
    assert kept.unplotted == ()


def test_branch_begins_in_the_state_that_was_looked_at(kept: LiveRun) -> None:
    """With another mass: the difference begins at zero and is that of two runs, by the values of
    both at the same samples; and the energies still balance."""
    name = plotted(kept, kind="difference", y=["phi_4"])
    first = does(kept, kept.solution)
    does(kept, lambda: kept.look_at(0.2), kept.branch)
    assert kept.store.span == (0.2, 0.2)
    heavier(kept)
    to(kept, 0.3)
    second = does(kept, kept.solution)
    difference = gets(kept).table(name, 2)[:, 1]
    assert difference[0] == pytest.approx(0.0, abs=1e-12)
    assert np.abs(difference[-1]) > 1e-4
    tails = (first.values("phi")[20:30, -1], second.values("phi")[:, -1])  # from 0.2 s on
    assert difference == pytest.approx(tails[1] - tails[0], abs=1e-12)
    balance = kept.catalogue.columns(["energy_balance"], kept.shown)[0, 0]
    assert balance == pytest.approx(0.0, abs=1e-6)  # rtol 1e-8 of some 30 J
    assert kept.marks.every[0].t == 0.2
