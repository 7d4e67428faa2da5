"""A live run without a page: what it does when told, and what it sends to whom."""

from __future__ import annotations

import json
import struct
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.live import FOR_LOOKING
from rodgen.live.run.live_run import BEYOND, PAUSED, RUNNING, STOPPED, LiveRun
from rodgen.live.run.page_state import AHEAD
from rodgen.live.run.scenes import edit
from rodgen.live.run.worker import Pace
from rodgen.scene import Scene, SceneError
from tests.live.conftest import ROD, varied
from tests.live.view import until


@pytest.fixture
def scene() -> Scene:
    return Scene.from_dict(ROD)


@pytest.fixture
def run(scene: Scene) -> Iterator[LiveRun]:
    made = LiveRun(scene)
    yield made
    made.close()


def past(run: LiveRun, t: float) -> None:
    """Wait until the run has come so far [s]."""
    until(lambda: float(run.shown.t[-1]), lambda now: now > t, "time does not pass")


class Page:
    """What a page sees."""

    def __init__(self, run: LiveRun):
        self.run, self.headers, self.rows = run, [], {}
        self.headers: list[dict[str, Any]]
        self.rows: dict[str, list[Any]]
        run.page.attach(self.take)
        run.wake_up()

    def take(self, message: bytes) -> None:
        (length,) = struct.unpack_from("<I", message)
        header, at = json.loads(message[4 : 4 + length]), 4 + length
        for name, kind, count in header["arrays"]:
            array = np.frombuffer(message, f"<{kind}", count, at)
            at += -(-array.nbytes // 8) * 8
            if name.startswith("plot!"):
                self.rows[name[5:]] = [array]
            elif name.startswith("plot:"):
                self.rows.setdefault(name[5:], []).append(array)
            header[name] = array
        self.headers.append(header)

    def gets(self, count: int) -> None:
        """Wait for so many messages or more."""
        until(lambda: len(self.headers), lambda got: got >= count, "no message")

    def acknowledge(self) -> None:
        self.run.page.acknowledge(self.headers[-1]["frame"])

    def column(self, plot: str, width: int, column: int) -> np.ndarray:
        rows = np.concatenate(self.rows[plot]).reshape(-1, width)
        return np.asarray(rows[:, column])


def test_run_goes_by_the_clock_and_pauses(run: LiveRun) -> None:
    assert run.status == PAUSED
    start = time.monotonic()
    run.do(run.go).result()
    past(run, 0.5)
    assert time.monotonic() - start > 0.45  # real time, not faster
    run.do(run.pause).result()
    assert run.status == PAUSED
    t = run.shown.t[-1]
    time.sleep(0.2)
    assert run.shown.t[-1] == t


def test_run_goes_round_until_somebody_changes_it(scene: Scene) -> None:
    """It begins again where the span of its scene is over, and goes on beyond that once paused."""
    run = LiveRun(edit(scene, [(("integrate", "span"), [0.0, 0.05])]))
    try:
        run.do(run.go_round).result()
        until(lambda: run.begun, lambda count: count > 3, "it does not begin again")
        assert run.status == RUNNING
        run.do(lambda: run.kick(0, 0.5, (0.1, 0.0))).result()
        begun = run.begun
        past(run, 0.2)
        assert run.begun == begun
    finally:
        run.close()


def test_samples_are_those_of_simulate(run: LiveRun, scene: Scene) -> None:
    run.do(lambda: run.set_speed(np.inf)).result()
    run.do(run.go).result()
    past(run, 1.0)
    run.do(run.pause).result()
    sol = run.do(run.solution).result()
    again = rodgen.simulate(scene)
    count = min(len(sol.t), len(again.t))
    assert count > 100
    assert np.array_equal(sol.y[:count], again.y[:count])
    assert sol.energy_error < 1e-6  # of rtol 1e-8, and energies of some joules


def test_nonsense_leaves_the_run_as_it_was(run: LiveRun) -> None:
    for work in (
        lambda: run.kick(99, 0.5, (1.0, 0.0)),
        lambda: run.kick(0, 0.5, (float("nan"), 0.0)),
        lambda: run.add_plot({"kind": "time", "y": ["nothing"]}),
        lambda: run.change(Scene.from_dict(varied(links=6))),
    ):
        with pytest.raises((SceneError, ValueError)):
            run.do(work).result()
    run.do(run.go).result()
    past(run, 0.05)
    assert run.status == RUNNING


def test_kick_of_a_run_at_rest_is_seen_at_once(run: LiveRun) -> None:
    """A free rod gets the velocity J/M, whatever the link."""
    page = Page(run)
    page.gets(1)
    run.do(lambda: run.kick(2, 0.3, (0.6, -0.9))).result()
    chunk = run.shown
    h = 1e-7
    model, y, p = run.model, chunk.y[-1], chunk.p
    half = len(y) // 2
    ahead = np.concatenate((y[:half] + h * y[half:], y[half:]))
    velocity = (model.centre_of_gravity(ahead, p) - model.centre_of_gravity(y, p)) / h
    assert velocity == pytest.approx([0.2, -0.3], abs=1e-6)  # a difference over 1e-7 s
    page.acknowledge()
    page.gets(2)


def test_blow_up_stops_and_a_change_mends(run: LiveRun, scene: Scene) -> None:
    """But a state beyond use is lost: it takes a reset."""
    told: list[str] = []
    run.told = lambda: told.append(run.status)
    run.do(lambda: run.failed("a defect")).result()
    assert (run.status, run.lost, told) == (STOPPED, False, [STOPPED])
    method = [(("integrate", "method"), "euler"), (("integrate", "step"), 0.2)]
    run.do(lambda: run.set_speed(np.inf)).result()
    run.do(lambda: run.change(edit(scene, method))).result()
    run.do(run.go).result()
    until(lambda: run.status, STOPPED, "it goes on")
    assert "stopped at t =" in run.message
    assert (run.lost, told[-1]) == (True, STOPPED)
    run.do(lambda: run.change(scene)).result()
    run.do(lambda: run.kick(0, 0.5, (1.0, 0.0))).result()
    assert run.status == STOPPED
    run.do(run.restart).result()
    assert not run.lost
    run.do(lambda: run.change(scene)).result()
    run.do(run.go).result()
    past(run, 0.2)
    assert run.status == RUNNING


def test_state_that_a_method_has_made_is_lost_before_it_is_large(
    run: LiveRun, scene: Scene
) -> None:
    """Between two samples a motion grows from ten times what it began with beyond all numbers; the
    energy of the last sample came from nowhere."""
    table = scene.model_dump(exclude_none=True)
    table["integrate"] |= {"method": "euler", "step": 0.01, "output_every": 0.1}
    run.do(lambda: run.set_speed(np.inf)).result()
    run.do(lambda: run.change(Scene.from_dict(table))).result()
    run.do(run.go).result()
    until(lambda: run.status, STOPPED, "it goes on")
    assert np.abs(run.shown.y[-1]).max() < BEYOND
    assert run.lost
    run.do(lambda: run.change(scene)).result()
    assert run.status == STOPPED


@pytest.mark.parametrize(
    ("method", "damping", "half"),
    [
        ("euler", 0.05, lambda root: -root.real / abs(root) ** 2),
        ("semi_implicit_euler", 0.0, lambda root: 1 / abs(root)),
        ("rk4", 0.0, lambda root: 2**0.5 / abs(root)),
    ],
)
def test_step_for_a_method_is_half_its_limit(
    run: LiveRun, scene: Scene, method: str, damping: float, half: Callable[[complex], float]
) -> None:
    """Textbook limits (Hairer, Norsett, Wanner 1993, II and IV.2), by the fastest root of the
    module's own Jacobian."""
    damped = edit(scene, [(("loads", "internal_damping", "coefficient"), damping)])
    run.do(lambda: run.change(damped)).result()
    roots = np.linalg.eigvals(run.model.jac(0.0, damped.initial_state(), run.live.p))
    fastest = roots[np.argmax(np.abs(roots))]
    step = run.do(lambda: run.live.step_for(method)).result()
    assert step == pytest.approx(half(fastest), rel=6e-3)  # three digits


def test_method_without_a_stable_step_is_refused(run: LiveRun) -> None:
    """Nothing damps the rod but what is next to nothing."""
    with pytest.raises(SceneError, match="with every step of euler this rod swings ever wider"):
        run.do(lambda: run.live.step_for("euler")).result()


def test_plots_of_all_energies_follow_what_there_is(run: LiveRun, scene: Scene) -> None:
    """Springs that become a chain, in the place of the plot that there was."""
    for y in (["energy"], ["phi_0"]):
        run.do(lambda y=y: run.add_plot({"kind": "time", "y": y})).result()
    chain = edit(scene, [(("rod", "bending_stiffness"), 0.0)])
    before = "p1"
    for values in (chain, scene):
        run.do(lambda values=values: run.change(values)).result()
        energies, other = run.plots
        assert (energies == before, other) == (False, "p2")  # rows of another width
        assert ("spring_energy" in run.plots[energies].names) == (values is scene)
        before = energies


class Missed(Pace):
    """Says that real time is missed."""

    missed = True


def test_tolerance_for_looking_is_taken_where_real_time_is_missed(
    run: LiveRun, scene: Scene
) -> None:
    """And said, in the record as well; once it was taken back, it is not taken again by itself
    before the scene has another tolerance. The scene itself keeps its own, and a loop goes on."""
    run.do(run.go_round).result()
    run.do(lambda: run.roughen(True)).result()
    first = run.live.settings
    assert (first.method, first.rtol, first.atol) == ("gauss", 1e-5, 1e-8)
    run.do(lambda: run.roughen(False)).result()
    run.strict, run.pace = False, Missed()
    run.do(run.go_round).result()
    until(lambda: run.live.rough, len(FOR_LOOKING), "it is not taken")
    run.do(lambda: None).result()  # the frame is over
    assert run.goes_round
    used = run.live.settings
    assert (used.method, used.rtol, used.atol) == ("radau", 1e-3, 1e-6)
    assert run.present().settings == used
    assert run.live.scene == scene
    past(run, 0.1)
    assert "radau at rtol 0.001 for looking at t = " in run.do(run.solution).result().message
    run.do(lambda: run.roughen(False)).result()
    past(run, float(run.shown.t[-1]) + 0.1)
    assert not run.live.rough
    assert run.live.settings == scene.integrate
    other = edit(scene, [(("integrate", "rtol"), 1e-7)])
    run.do(lambda: run.change(other)).result()
    until(lambda: run.live.rough, len(FOR_LOOKING), "it is not taken")
    run.do(run.pause).result()
    run.do(lambda: run.change(scene)).result()
    assert run.live.settings == scene.integrate


def test_slow_page_gets_fewer_messages_and_all_rows(run: LiveRun) -> None:
    page = Page(run)
    run.do(lambda: run.add_plot({"kind": "time", "y": ["phi_0"]})).result()
    run.do(run.go).result()
    past(run, 0.5)
    assert len(page.headers) <= AHEAD  # nothing is acknowledged
    answers = 0
    while run.shown.t[-1] < 1.5:
        page.acknowledge()
        answers += 1
        time.sleep(0.4)
        assert len(page.headers) <= AHEAD * (answers + 1)
    run.do(run.pause).result()

    def missing() -> float:
        """Seconds from the last row to what is shown, which may be between two samples."""
        page.acknowledge()
        return float(run.shown.t[-1] - page.column("p1", 2, 0)[-1])

    until(missing, lambda t: t < 0.01 - 1e-9, "the last rows do not come")
    assert np.allclose(np.diff(page.column("p1", 2, 0)), 0.01, atol=1e-9)  # no sample is missing


def test_page_that_comes_back_gets_everything(run: LiveRun) -> None:
    first = Page(run)
    run.do(lambda: run.add_plot({"kind": "time", "y": ["phi_0"], "window": 100.0})).result()
    run.do(run.go).result()
    while run.shown.t[-1] < 0.5:
        first.acknowledge() if first.headers else None
        time.sleep(0.01)
    run.do(lambda: run.page.detach(first.take)).result()  # between two frames
    seen = len(first.headers)
    past(run, 0.8)
    assert len(first.headers) == seen
    second = Page(run)
    second.gets(1)
    assert {"texts", "t", "origin", "joints"} <= set(second.headers[0])
    assert second.column("p1", 2, 0)[0] == 0.0
    assert len(second.column("p1", 2, 0)) > 75


def test_critical_force_comes_while_the_run_is_paused(run: LiveRun, scene: Scene) -> None:
    page = Page(run)
    wanted = rodgen.critical_force(scene).force

    def shown() -> float:
        if page.headers:
            page.acknowledge()
        texts = [header.get("texts", {}) for header in page.headers]
        found = [new["critical_force"] for new in texts if "critical_force" in new]
        try:
            return float(found[-1].replace("\u2007", ""))
        except (IndexError, ValueError):  # "computing"
            return 0.0

    until(shown, pytest.approx(wanted, rel=1e-4), "another force")  # five digits are shown
    assert run.status == PAUSED


def test_rows_of_plots_that_are_gone_are_not_kept(run: LiveRun, scene: Scene) -> None:
    """Nobody looks: what waits is bounded, also over other scenes."""
    for _ in range(3):
        for _ in range(4):
            run.do(lambda: run.add_plot({"kind": "time", "y": ["phi"]})).result()
        run.do(lambda: run.set_speed(np.inf)).result()
        run.do(run.go).result()
        t = run.shown.t[-1]
        past(run, t + 20.0)
        run.do(lambda: run.take(scene)).result()
        assert set(run.page._rows) <= set(run.plots)
    waiting = sum(part.size for parts in run.page._rows.values() for part in parts)
    assert waiting < len(run.plots) * 2**18 + 2**16


def test_other_structure_keeps_the_plots_that_still_mean_something(run: LiveRun) -> None:
    page = Page(run)
    for choice in (
        {"kind": "time", "y": ["phi_4", "phi_0"]},  # of the tail, of the nose
        {"kind": "time", "y": ["gravity_energy"]},
        {"kind": "phase", "y": "vy0", "x": "y0"},  # which a pinned rod does not have
    ):
        run.do(lambda choice=choice: run.add_plot(choice)).result()
    other = Scene.from_dict(varied(links=6, boundary="pinned"))
    run.do(lambda: run.take(other)).result()
    assert [plot.names for plot in run.plots.values()] == [("phi_5", "phi_0"), ("gravity_energy",)]
    run.do(run.go).result()
    past(run, 0.1)
    assert run.status == RUNNING
    assert page.headers
