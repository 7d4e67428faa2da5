"""How long runs are kept without a page, by a clock that is moved by hand."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from rodgen.live.page.runs import Sessions
from rodgen.scene import Scene, SceneError
from tests.live.conftest import ROD

SCENE = Scene.from_dict(ROD)


@pytest.fixture
def sessions(clock: Any) -> Iterator[Sessions]:
    made = Sessions(clock)
    yield made
    made.close_all()


def test_run_waits_half_a_minute_for_its_first_page(sessions: Sessions, clock: Any) -> None:
    name = sessions.open(SCENE)
    run = sessions.get(name)
    assert run is not None
    clock.now += 29.0
    sessions.sweep()
    assert sessions.get(name) is run
    clock.now += 2.0
    sessions.sweep()
    assert sessions.get(name) is None
    assert run.do(lambda: None).cancelled()  # it does nothing any more


def test_run_outlives_a_reload_and_not_its_page(sessions: Sessions, clock: Any) -> None:
    def send(message: bytes) -> None:
        pass

    name = sessions.open(SCENE)
    run = sessions.get(name)
    assert run is not None
    run.page.attach(send)
    for _ in range(100):  # for as long as the page is there
        clock.now += 60.0
        sessions.sweep()
    run.page.detach(send)
    clock.now += 5.0  # a page that is reloaded is back by then
    sessions.sweep()
    assert sessions.get(name) is run
    run.page.attach(send)
    clock.now += 60.0
    sessions.sweep()
    run.page.detach(send)
    clock.now += 10.0
    sessions.sweep()
    assert sessions.get(name) is None


def test_page_that_comes_and_goes_between_two_looks(sessions: Sessions, clock: Any) -> None:
    """It was there: its run is not kept for the half minute that a first page may take."""

    def send(message: bytes) -> None:
        pass

    name = sessions.open(SCENE)
    run = sessions.get(name)
    assert run is not None
    sessions.sweep()
    run.page.attach(send)
    run.page.detach(send)
    clock.now += 0.5
    sessions.sweep()
    clock.now += 9.0
    sessions.sweep()
    assert sessions.get(name) is None


def test_reload_may_take_its_time(sessions: Sessions, clock: Any) -> None:
    """While a page is on its way, no run is ended, and then not the one that it is for, until it
    has come. One that does not come counts for half a minute."""

    def send(message: bytes) -> None:
        pass

    name, other = sessions.open(SCENE), sessions.open(SCENE)
    run = sessions.get(name)
    assert run is not None
    run.page.attach(send)
    sessions.sweep()
    with sessions.arrival():
        run.page.detach(send)
        clock.now += 29.0
        sessions.sweep()
        assert sessions.claim(name) is run
    clock.now += 20.0
    sessions.sweep()
    assert (sessions.get(name), sessions.get(other)) == (run, None)
    run.page.attach(send)
    sessions.sweep()
    run.page.detach(send)
    with sessions.arrival():
        clock.now += 29.0
        sessions.sweep()
        assert sessions.get(name) is run
        clock.now += 2.0
        sessions.sweep()
    assert sessions.claim(name) is None


def test_one_run_ends_without_the_other(sessions: Sessions, clock: Any) -> None:
    first = sessions.open(SCENE)
    clock.now += 20.0
    second = sessions.open(SCENE)
    clock.now += 20.0
    sessions.sweep()
    assert (sessions.get(first), len(sessions)) == (None, 1)
    assert sessions.get(second) is not None


def test_runs_that_are_being_made_count(sessions: Sessions) -> None:
    """Sixteen a server: fifteen are being made, one is open."""
    sessions.open(SCENE)
    with ExitStack() as making:
        for _ in range(15):
            making.enter_context(sessions.room())
        with pytest.raises(SceneError, match="at most 16"), sessions.room():
            pass
    with sessions.room():  # those were cancelled
        pass


@pytest.mark.parametrize("name", ["", "x" * 22, None, 3, ["x"]])
def test_names_of_no_run(sessions: Sessions, name: object) -> None:
    sessions.open(SCENE)
    assert sessions.get(name) is None
