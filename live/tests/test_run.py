"""A live run without a page: what it does when told, and what it sends to whom."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from live.tests.conftest import SCENE
from live.tests.runs import Page, does, gets, to
from live.tests.view import until
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_live.open_run import FOR_LOOKING
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.page_state import AHEAD, TRAIL
from rodgen_live.run.run_record import PAUSED, RUNNING, STOPPED
from rodgen_live.run.run_thread import Pace


def past(run: LiveRun, t: float) -> None:
    """Wait until the run has come so far [s]."""
    until(lambda: float(run.shown.t[-1]), lambda now: now > t, "time does not pass")


def test_run_goes_round_until_somebody_changes_it(run: LiveRun) -> None:
    """It begins again where the span of its scene is over, goes on beyond that once kicked, and
    round again after a reset, unless the loop was switched off; it stands once it is paused."""
    assert run.status == PAUSED
    does(run, lambda: run.switch_to(SCENE.replace({"integrate.span": [0.0, 0.05]})), run.resume)
    until(lambda: run.begun, lambda count: count > 3, "it does not begin again")
    assert run.status == RUNNING
    does(run, lambda: run.kick(0, 0.5, (0.1, 0.0)))
    begun = run.begun
    past(run, 0.2)
    assert (run.begun, run.goes_round) == (begun, False)
    does(run, run.restart)
    assert not run.repeats
    assert does(run, run.solution).t[-1] < 0.05  # what there is
    until(lambda: run.begun, lambda count: count > begun + 3, "it does not begin again")
    first, *_, last = does(run, run.solution).t  # of a whole round, and a frame at most
    assert (first, last) == (0.0, pytest.approx(0.05, abs=0.02))
    does(run, lambda: run.loop(False), run.restart)
    past(run, 0.2)
    does(run, run.pause)
    t = run.shown.t[-1]
    does(run, lambda: None)
    assert (run.status, run.shown.t[-1]) == (PAUSED, t)


def test_blow_up_stops_and_a_change_mends(run: LiveRun) -> None:
    """But a state beyond use is lost: it takes a reset."""
    told: list[str] = []
    run.told = lambda: told.append(run.status)
    does(run, lambda: run.stop("a defect"))
    assert (run.status, run.is_unusable, told) == (STOPPED, False, [STOPPED])
    wild = SCENE.replace({"integrate.method": "euler", "integrate.step": 0.2})
    does(run, lambda: run.set_speed(np.inf), lambda: run.change(wild), run.resume)
    until(lambda: run.status, STOPPED, "it goes on")
    assert (run.is_unusable, told[-1]) == (True, STOPPED)
    does(run, lambda: run.change(SCENE), lambda: run.kick(0, 0.5, (1.0, 0.0)))
    assert run.status == STOPPED
    does(run, run.restart)
    assert not run.is_unusable
    does(run, lambda: run.change(SCENE), run.resume)
    past(run, 0.2)
    assert run.status == RUNNING


STEPS: dict[str, tuple[float, Callable[[complex], float]]] = {
    "euler": (0.05, lambda root: -root.real / abs(root) ** 2),
    "semi_implicit_euler": (0.0, lambda root: 1 / abs(root)),
    "rk4": (0.0, lambda root: 2**0.5 / abs(root)),
}


def test_number_that_is_moved_makes_no_scene(run: LiveRun, monkeypatch: pytest.MonkeyPatch) -> None:
    """Until one is shown; it takes effect and is on the record as any other change."""
    does(run, run.one_step)
    with monkeypatch.context() as patch:
        patch.setattr(Scene, "from_dict", None)
        does(run, lambda: run.change(run.live.system.at({"rod.mass": 4.0}), "rod.mass = 4"))
    at = run.model.PARAMETERS.index("mass")
    assert (run.live.p[at], run.shown.p[at]) == (4.0, 4.0)
    assert [mark.what for mark in run.marks.every] == ["rod.mass = 4"]
    assert run.live.scene == SCENE.replace({"rod.mass": 4.0})


def test_step_for_a_method_is_half_its_limit(run: LiveRun) -> None:
    """Textbook limits (Hairer, Norsett, Wanner 1993, II and IV.2), by the fastest root of the
    module's own Jacobian, with a damping. There is none for a method that blows a rod up that is
    not damped."""
    with pytest.raises(InputError, match="euler"):
        does(run, lambda: run.live.step_for("euler"))
    for method, (damping, half) in STEPS.items():
        damped = SCENE.replace({"loads.internal_damping.coefficient": damping})
        does(run, partial(run.change, damped))
        roots = np.linalg.eigvals(run.model.jac(0.0, damped.initial_state(), run.live.p))
        fastest = roots[np.argmax(np.abs(roots))]
        step = run.submit(partial(run.live.step_for, method)).result()
        assert step == pytest.approx(half(fastest), rel=6e-3), method  # three digits


class Missed(Pace):
    """Says that real time is missed."""

    is_too_slow = True


def test_tolerance_for_looking_is_taken_where_real_time_is_missed(run: LiveRun) -> None:
    """And said, in the record as well; once it was taken back, it is not taken again by itself
    before the scene has another tolerance. The scene itself keeps its own, and a loop goes on."""

    def used() -> tuple[object, ...]:
        settings = run.live.settings
        return settings.method, settings.rtol, settings.atol

    does(run, run.resume, lambda: run.roughen(True))
    assert used() == ("gauss", 1e-5, 1e-8)
    does(run, lambda: run.roughen(False))
    run.strict, run.pace = False, Missed()
    does(run, run.resume)
    until(lambda: run.live.rough, len(FOR_LOOKING), "it is not taken")
    does(run, lambda: None)  # the frame is over
    assert run.goes_round
    assert used() == ("radau", 1e-3, 1e-6)
    assert run.run_status().settings == run.live.settings
    assert run.live.scene == SCENE
    past(run, 0.1)
    assert "radau at rtol 0.001" in run.submit(run.solution).result().message
    does(run, lambda: run.roughen(False))
    past(run, float(run.shown.t[-1]) + 0.1)
    assert not run.live.rough
    assert run.live.settings == SCENE.integrate
    does(run, lambda: run.change(SCENE.replace({"integrate.rtol": 1e-7})))
    until(lambda: run.live.rough, len(FOR_LOOKING), "it is not taken")
    does(run, run.pause, lambda: run.change(SCENE))
    assert run.live.settings == SCENE.integrate


def test_slow_page_gets_fewer_messages_and_all_rows(run: LiveRun) -> None:
    """A sample a message, were it as fast as the run; whoever comes later gets everything."""
    page, answers = Page(run), 0
    does(run, lambda: run.add_plot({"kind": "time", "y": ["phi_0"], "window": 100.0}))
    for k in range(1, 41):
        to(run, 0.01 * k)
        does(run, run.show)
        if k % 10 == 0:
            assert len(page.headers) <= AHEAD * (answers + 1)
            page.acknowledge()
            answers += 1

    def last() -> float:
        page.acknowledge()
        return float(page.table("p1", 2)[-1, 0])

    until(last, pytest.approx(0.4), "the last rows do not come")
    assert page.table("p1", 2)[:, 0] == pytest.approx(np.arange(41) / 100)  # no sample is missing
    does(run, lambda: run.page.detach(page.take))
    seen = len(page.headers)
    to(run, 0.5)
    second = gets(run)
    assert len(page.headers) == seen
    assert {"texts", "t", "origin", "joints"} <= set(second.headers[0])
    assert second.table("p1", 2)[:, 0] == pytest.approx(np.arange(51) / 100)


def test_page_is_told_of_every_change_of_the_plots(run: LiveRun) -> None:
    """After it: the page may have read the plots before."""
    told: list[list[str]] = []
    for name in ("first", "second"):
        does(run, lambda name=name: run.add_plot({"kind": "time", "y": ["phi"], "title": name}))
    run.told = lambda: told.append([plot.spec.title for plot in run.plots.values()])
    first, second = run.plots
    does(run, lambda: run.arrange_plots([second, first]))
    assert told == [["second", "first"]]
    does(run, lambda: run.remove_plot(second))
    assert told[1:] == [["first"]]


def test_rows_of_plots_that_are_gone_are_not_kept(run: LiveRun) -> None:
    """Nobody looks: what waits is bounded, also over other scenes."""
    for k in range(3):
        for _ in range(4):
            does(run, lambda: run.add_plot({"kind": "time", "y": ["phi"]}))
        to(run, 10.0 * (k + 1))
        does(run, lambda: run.switch_to(SCENE))
        assert set(run.page._rows) <= {TRAIL, *run.plots}
    waiting = sum(part.size for parts in run.page._rows.values() for part in parts)
    assert waiting < len(run.plots) * 2**18 + 2**16
