"""A run that is kept beside another: its rod, its curves, and differences from it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from rodgen.live.run.live_run import LiveRun
from rodgen.live.run.scenes import edit
from rodgen.scene import Scene
from tests.live.conftest import ROD
from tests.live.test_run import Page
from tests.live.view import expect

View = Any  # see conftest.py
SCENE = Scene.from_dict(ROD)
TAIL = {"kind": "time", "y": ["phi_4"]}
LESS = {"kind": "difference", "y": ["phi_4"]}


@pytest.fixture
def run() -> Iterator[LiveRun]:
    made = LiveRun(SCENE)
    made.do(lambda: made.keep_runs(True)).result()
    to(made, 0.3)
    yield made
    made.close()


def to(run: LiveRun, t: float) -> None:
    """Samples every 0.01 s up to a time, without a clock."""
    run.do(lambda: run._took(run.live.advance(t, 10.0))).result()


def heavier(run: LiveRun) -> None:
    run.change(edit(run.live.scene, [(("rod", "mass"), 4.0)]), "rod.mass = 4")


def gets(run: LiveRun) -> Page:
    page = Page(run)
    page.gets(1)
    return page


def test_rod_that_is_kept_is_shown_at_the_same_time(run: LiveRun) -> None:
    before = run.store
    run.do(run.restart).result()
    to(run, 0.125)
    header = gets(run).headers[-1]
    sample = before.near(0.12)
    expected = run.model.joints(sample.y[0], sample.p) - np.array(header["origin"])
    assert header["ghost"].reshape(-1, 2) == pytest.approx(expected, abs=1e-6)  # single precision
    to(run, 0.4)
    assert gets(run).headers[-1]["ghost"].size == 0  # it has not come that far


def test_between_two_samples_the_rod_that_is_kept_is_between_them(run: LiveRun) -> None:
    ghost = run.do(lambda: (run.restart(), run.ghost)[1]).result()
    assert ghost is not None
    first, last = (ghost.joints(t) for t in (0.1, 0.11))
    assert ghost.joints(0.1025) == pytest.approx(0.75 * first + 0.25 * last)
    assert ghost.joints(0.1075) == pytest.approx(0.25 * first + 0.75 * last)
    assert ghost.joints(0.3001).size == ghost.joints(-0.1).size == 0


def test_curves_that_are_kept_are_those_of_the_run_before(run: LiveRun) -> None:
    run.do(lambda: run.add_plot(TAIL)).result()
    run.do(run.restart).result()
    (name,) = run.plots
    rows = gets(run).headers[-1][f"ghost:{name}"].reshape(-1, 2)
    assert rows[:, 0] == pytest.approx(np.arange(31) / 100)
    assert rows[-1, 1] != rows[0, 1]
    run.do(lambda: run.keep_runs(False)).result()
    header = gets(run).headers[-1]
    assert (header[f"ghost:{name}"].size, "ghost" in header) == (0, False)


@pytest.mark.parametrize(
    "choice",
    [
        {"kind": "phase", "y": ["omega_4"], "x": "phi_4"},
        {"kind": "poincare", "y": ["tip_y"], "x": "tip_x", "when": "t", "every": 0.02},
        {"kind": "spectrum", "y": ["phi_4"], "window": 0.2},
        {"kind": "profile", "y": ["bending_moment"]},
        {"kind": "time", "y": ["phi_4 - phi_0"]},
    ],
    ids=lambda choice: choice["kind"],
)
def test_plots_of_all_kinds_show_both(run: LiveRun, choice: dict[str, Any]) -> None:
    """What they showed of the run before; along the rod at the same time."""
    run.do(lambda: run.add_plot(choice)).result()
    (name,) = run.plots
    before = gets(run).rows[name][-1]
    assert before.size
    run.do(run.restart).result()
    to(run, 0.3)
    assert np.array_equal(gets(run).headers[-1][f"ghost:{name}"], before)


def test_energies_of_both_count_from_where_the_runs_part(run: LiveRun) -> None:
    """Another run begins in a state of the one before, and has its energies there."""
    run.do(lambda: run.add_plot({"kind": "time", "y": ["gravity_energy", "total_energy"]})).result()
    run.do(lambda: run.look_at(0.2)).result()
    run.do(run.branch).result()
    (name,) = run.plots
    page = gets(run)
    kept = page.headers[-1][f"ghost:{name}"].reshape(-1, 3)
    (there,) = kept[np.isclose(kept[:, 0], 0.2)]
    assert there == pytest.approx(page.rows[name][-1][:3])
    assert np.abs(kept[0, 1]) > 1e-3  # it has moved until then


def test_kind_of_a_rod_of_more_links_is_compared_where_both_have_it(run: LiveRun) -> None:
    """On the page that has been there before; the tail with the tail."""
    run.do(lambda: run.add_plot({"kind": "time", "y": ["phi"]})).result()
    page = gets(run)
    tail = page.rows["p1"][-1].reshape(-1, 6)[:, -1]
    run.do(lambda: run.take(edit(SCENE, [(("rod", "links"), 3)]))).result()
    (name,) = run.plots
    page.gets(2)
    kept = page.headers[1][f"ghost:{name}"].reshape(-1, 1 + 3)
    assert kept[:, -1] == pytest.approx(tail)


def test_plots_lose_what_a_rod_does_not_have_and_get_it_back(run: LiveRun) -> None:
    for names in (["phi_0", "phi_3"], ["omega_3"], ["omega_4"]):
        run.do(lambda names=names: run.add_plot({"kind": "time", "y": names})).result()

    def shown(links: int) -> list[tuple[str, ...]]:
        run.do(lambda: run.take(edit(SCENE, [(("rod", "links"), links)]))).result()
        return [plot.names for plot in run.plots.values()]

    assert sorted(shown(3)) == [("omega_2",), ("phi_0",)]
    assert run.unplotted == ("φ₃", "ω₃")
    assert sorted(shown(5)) == [("omega_3",), ("omega_4",), ("phi_0", "phi_3")]
    assert run.unplotted == ()


def test_two_runs_that_are_alike_differ_by_nothing(run: LiveRun) -> None:
    run.do(lambda: run.add_plot(LESS)).result()
    run.do(run.restart).result()
    page = gets(run)
    to(run, 0.354)
    page.acknowledge()
    page.gets(2)
    (name,) = run.plots
    t, difference = page.column(name, 2, 0), page.column(name, 2, 1)
    assert t[-1] == pytest.approx(0.35)
    assert difference[t < 0.301] == pytest.approx(0.0, abs=1e-14)  # the rounding of a cubic
    assert np.isnan(difference[t > 0.301]).all()  # there is nothing to compare with


def test_branch_begins_in_the_state_that_was_looked_at(run: LiveRun) -> None:
    """With another mass: the difference begins at zero, and the energies still balance."""
    run.do(lambda: run.add_plot(LESS)).result()
    run.do(lambda: run.look_at(0.2)).result()
    run.do(run.branch).result()
    assert run.store.span == (0.2, 0.2)
    run.do(lambda: heavier(run)).result()
    to(run, 0.3)
    (name,) = run.plots
    page = gets(run)
    difference = page.column(name, 2, 1)
    assert difference[0] == pytest.approx(0.0, abs=1e-12)
    assert np.abs(difference[-1]) > 1e-4
    balance = run.catalogue.columns(["energy_balance"], run.shown)[0, 0]
    assert balance == pytest.approx(0.0, abs=1e-6)  # rtol 1e-8 of some 30 J
    assert run.marks.every[0].what == "begun from a state of the run before"


def test_difference_is_that_of_two_runs_of_their_own(run: LiveRun) -> None:
    """The second route: the catalogue's values of both runs, at the same samples."""
    run.do(lambda: run.add_plot(LESS)).result()
    first = run.do(run.solution).result()
    run.do(run.restart).result()
    run.do(lambda: heavier(run)).result()
    to(run, 0.3)
    second = run.do(run.solution).result()
    (name,) = run.plots
    difference = gets(run).column(name, 2, 1)
    tails = [solution.values("phi")[:, -1] for solution in (first, second)]
    assert difference[1:] == pytest.approx((tails[1] - tails[0])[1:], abs=1e-12)


def test_run_that_did_not_move_is_not_kept(run: LiveRun) -> None:
    run.do(run.restart).result()
    ghost = run.ghost
    run.do(run.restart).result()
    assert run.ghost is ghost


def test_another_rod_is_compared_where_it_has_the_same_quantities(run: LiveRun) -> None:
    run.do(lambda: run.add_plot({"kind": "time", "y": ["tip_x"]})).result()
    run.do(lambda: run.take(edit(SCENE, [(("rod", "links"), 3)]))).result()
    to(run, 0.1)
    header = gets(run).headers[-1]
    (name,) = run.plots
    assert header["ghost"].size == 2 * 6  # five links
    assert header[f"ghost:{name}"].size == 2 * 31


@pytest.mark.nightly
def test_runs_are_kept_and_branched_in_the_page(view: View) -> None:
    keep = view.button("Keep each run")
    keep.click()
    expect(keep).to_have_attribute("aria-pressed", "true")
    view.pause_after(0.3)
    kept = "rodgenLive.plots[Object.keys(rodgenLive.plots)[0]].kept"
    assert view.page.evaluate(kept) == 0
    view.button("Reset to").click()
    view.sees(kept, lambda rows: rows > 10, "no curves are kept")
    view.pause_after(0.3)
    view.page.get_by_role("slider", name="Time that is shown").press("PageDown")
    view.sees("rodgenLive.past !== null", True, "the past is not shown")
    t = view.live("t")
    view.button("Another run").click()
    view.sees("rodgenLive.past", None, "the new run is not shown")
    assert view.live("t") == t
    keep.click()
    view.sees(kept, 0, "curves are still kept")


@pytest.mark.nightly
def test_the_kept_run_stands_beside_in_one_scale(view: View) -> None:
    """Where there is no room at the side, both rods become smaller, lest the other be outside."""
    view.button("Keep each run").click()
    view.pause_after(0.3)
    view.button("Reset to").click()
    view.page.set_viewport_size({"width": 420, "height": 900})
    most = 420 / (2.0 + 1.2 * 2.0)  # pixels per metre of rods of 2 m, 1.2 lengths apart
    view.button("What is shown").click()
    beside = view.page.get_by_role("switch", name="run that is kept")
    for shown in (True, False):
        beside.click()
        view.sees("rodgenLive.scale", lambda found, s=shown: (0 < found < most) is s, "not fitted")
