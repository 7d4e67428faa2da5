"""By a clock that is moved by hand: how long runs are kept without a page, and how fast they go."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from live.tests.conftest import SCENE
from rodgen.errors import InputError
from rodgen_live.page.sessions import Sessions
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.run_thread import Pace


@pytest.fixture
def sessions(clock: Any) -> Iterator[Sessions]:
    made = Sessions(clock)
    yield made
    made.close_all()


def opened(sessions: Sessions) -> tuple[str, LiveRun]:
    run = sessions.get(name := sessions.open(SCENE))
    assert run is not None
    return name, run


def send(message: bytes) -> None:
    """Nobody looks at what a page is sent."""


def after(sessions: Sessions, clock: Any, seconds: float) -> None:
    clock.now += seconds
    sessions.close_idle()


def test_runs_wait_half_a_minute_for_their_first_page(sessions: Sessions, clock: Any) -> None:
    """Each by itself."""
    name, run = opened(sessions)
    after(sessions, clock, 20.0)
    other, _ = opened(sessions)
    after(sessions, clock, 9.0)
    assert sessions.get(name) is run
    after(sessions, clock, 2.0)
    assert (sessions.get(name), len(sessions)) == (None, 1)
    assert run.submit(lambda: None).cancelled()  # it does nothing any more
    assert sessions.get(other) is not None
    assert [sessions.get(wrong) for wrong in ("", "x" * 22, None, 3, ["x"])] == [None] * 5


def test_run_outlives_a_reload_and_not_its_page(sessions: Sessions, clock: Any) -> None:
    name, run = opened(sessions)
    run.page.attach(send)
    for _ in range(100):  # for as long as the page is there
        after(sessions, clock, 60.0)
    run.page.detach(send)
    after(sessions, clock, 5.0)  # a page that is reloaded is back by then
    assert sessions.get(name) is run
    run.page.attach(send)
    after(sessions, clock, 60.0)
    run.page.detach(send)
    after(sessions, clock, 10.0)
    assert sessions.get(name) is None


def test_page_that_comes_and_goes_between_two_looks(sessions: Sessions, clock: Any) -> None:
    """It was there: its run is not kept for the half minute that a first page may take."""
    name, run = opened(sessions)
    sessions.close_idle()
    run.page.attach(send)
    run.page.detach(send)
    after(sessions, clock, 0.5)
    after(sessions, clock, 9.0)
    assert sessions.get(name) is None


def test_reload_may_take_its_time(sessions: Sessions, clock: Any) -> None:
    """While a page is on its way, no run is ended, and then not the one that it is for, until it
    has come. One that does not come counts for half a minute."""
    (name, run), (other, _) = opened(sessions), opened(sessions)
    run.page.attach(send)
    sessions.close_idle()
    with sessions.arrival():
        run.page.detach(send)
        after(sessions, clock, 29.0)
        assert sessions.claim(name) is run
    after(sessions, clock, 20.0)
    assert (sessions.get(name), sessions.get(other)) == (run, None)
    run.page.attach(send)
    sessions.close_idle()
    run.page.detach(send)
    with sessions.arrival():
        after(sessions, clock, 29.0)
        assert sessions.get(name) is run
        after(sessions, clock, 2.0)
    assert sessions.claim(name) is None


def test_runs_that_are_being_made_count(sessions: Sessions) -> None:
    """Sixteen a server: fifteen are being made, one is open."""
    sessions.open(SCENE)
    with ExitStack() as making:
        for _ in range(15):
            making.enter_context(sessions.reserve())
        with pytest.raises(InputError, match="16"), sessions.reserve():
            pass
    with sessions.reserve():  # those were cancelled
        pass


def test_time_due_follows_the_clock(clock: Any) -> None:
    for speed in (0.01, 1.0, 5.0, math.inf):
        pace = Pace(speed, clock)
        pace.start(3.0)
        clock.now += 2.0
        assert pace.target() == pytest.approx(3.0 + 2.0 * speed)
    assert pace.ratio is None  # of a run that goes as fast as it can


def test_run_that_cannot_keep_up_is_not_chased(clock: Any) -> None:
    """It comes to half of what is due each time: the arrears do not grow."""
    pace, t = Pace(1.0, clock), 0.0
    pace.start(t)
    for _ in range(600):
        clock.now += 1 / 60
        t += (pace.target() - t) * 0.5 if pace.target() - t > 0.01 else 0.0
        pace.record(t)
    assert pace.target() - t < 0.11  # seconds
    for _ in range(120):  # half as fast as the clock
        clock.now += 1 / 60
        t += 0.5 / 60
        pace.record(t)
    assert pace.target() - t < 0.11
    assert pace.ratio == pytest.approx(0.5, rel=0.02)


def test_real_time_is_missed_where_steps_are_what_takes_so_long(clock: Any) -> None:
    """Not from the first moment: a run is given two seconds."""
    for reached, spent, missed in (
        (0.5, 0.5, True),  # half of what is due, all of it in steps
        (0.5, 0.01, False),  # the machine is busy with other things
        (1.0, 0.9, False),
    ):
        pace, seen = Pace(1.0, clock), []
        pace.start(0.0)
        for frame in range(1, 181):
            clock.now += 1 / 60
            pace.add_cost(spent / 60)
            pace.record(reached * frame / 60)
            seen.append(pace.is_too_slow)
        assert not any(seen[:119])
        assert seen[-1] == missed
        pace.speed = math.inf
        assert not pace.is_too_slow
