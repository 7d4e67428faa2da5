"""What a page asks of its run, while the run is busy and while a module is being made."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Coroutine, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("nicegui", reason="the extra view is not installed")

from nicegui import Client, background_tasks, core, ui
from starlette.requests import Request

from rodgen.integrate.pull import Pull
from rodgen.live.page.module_process import Modules
from rodgen.live.page.page import Page
from rodgen.live.page.runs import PageRun, Sessions
from rodgen.live.run import live_run, pulling
from rodgen.live.run.live_run import LiveRun
from rodgen.live.run.scenes import Folder, edit
from rodgen.loading import build
from rodgen.scene import Scene, SceneError
from tests.live.conftest import ROD, finished
from tests.live.view import PATIENT

SCENE = Scene.from_dict(ROD)
MASS, GRAVITY, LINKS = ("rod", "mass"), ("loads", "gravity", "g"), ("rod", "links")


class Making:
    """Stands for what makes modules: what happens meanwhile is up to a test."""

    def __init__(self) -> None:
        self.made: list[int] = []  # links
        self.meanwhile: Callable[[], Coroutine[Any, Any, None]] | None = None

    async def make(self, scene: Scene) -> None:
        self.made.append(scene.rod.links)
        if self.meanwhile is not None:
            await self.meanwhile()


@pytest.fixture
def making() -> Making:
    return Making()


@pytest.fixture
def page(making: Making, monkeypatch: pytest.MonkeyPatch) -> Iterator[PageRun]:
    """By NumPy: what a test makes another structure of is not compiled."""
    monkeypatch.setattr(live_run, "build_fastest", lambda scene: build(scene, "numpy"))
    # Without a page: nothing of it is asked for.
    nowhere: Any = None
    run = LiveRun(SCENE)
    yield PageRun(run, making.make, nowhere, nowhere, {})
    run.close()


def test_edits_close_together_are_both_kept(page: PageRun) -> None:
    """The second is asked for before the run has got to the first."""
    free = threading.Event()

    async def both() -> None:
        busy = page.run.do(free.wait)
        edits = asyncio.gather(
            page.change([(MASS, 25.0)], "mass = 25"), page.change([(GRAVITY, 1.5)], "g = 1.5")
        )
        await asyncio.sleep(0.05)
        free.set()
        await edits
        assert busy.result()

    finished(both())
    assert (page.scene.rod.mass, page.scene.loads.value("gravity")) == (25.0, 1.5)


def test_changes_while_a_module_is_made_are_kept(page: PageRun, making: Making) -> None:
    async def meanwhile() -> None:
        await page.change([(GRAVITY, 1.5)], "g = 1.5")
        assert page.scene.rod.links == 5  # the old one goes on

    making.meanwhile = meanwhile
    finished(page.change([(LINKS, 3)], ""))
    assert making.made == [3]
    assert (page.scene.rod.links, page.scene.loads.value("gravity")) == (3, 1.5)


def test_structures_asked_for_together_come_one_after_the_other(
    page: PageRun, making: Making
) -> None:
    """Each is made of the scene that is there by then."""

    async def meanwhile() -> None:
        await asyncio.sleep(0.01)

    async def both() -> None:
        await asyncio.gather(
            page.change([(LINKS, 3)], ""),
            page.change([(("loads", "tip"), {"x": 0.0, "y": -1.0})], ""),
        )

    making.meanwhile = meanwhile
    finished(both())
    assert making.made == [3, 3]
    assert page.scene.structure.terms == (*SCENE.structure.terms, "tip_load")


def test_scene_of_the_same_structure_needs_no_making(page: PageRun, making: Making) -> None:
    finished(page.take(edit(SCENE, [(MASS, 7.0)])))
    assert (making.made, page.scene.rod.mass, page.run.taken) == ([], 7.0, 2)


def test_refusals_come_to_who_asked(page: PageRun) -> None:
    with pytest.raises(SceneError, match=r"rod\.mass"):
        finished(page.change([(MASS, -1.0)], "mass = -1"))
    assert page.scene.rod.mass == 3.0


def test_page_that_is_asked_for_and_never_shown() -> None:
    """Such as for the preview of a link: a minute later it is given up, and nothing is begun."""
    sessions = Sessions()

    async def asked() -> None:
        core.loop = asyncio.get_running_loop()
        request = Request({"type": "http", "headers": [], "method": "GET", "path": "/"})
        client = Client(ui.page("/nobody"), request=request)

        async def show() -> None:
            with client:
                await Page(sessions, Modules(), Folder(Path()), SCENE, moves=False).show("")

        showing = asyncio.create_task(show())
        await asyncio.sleep(0.01)
        assert not showing.done()
        client.delete()
        await asyncio.wait_for(showing, PATIENT)
        await background_tasks.teardown()

    finished(asked())
    core.loop = None
    assert len(sessions) == 0


def test_changes_are_undone_and_redone(page: PageRun) -> None:
    """Those of one value that follow each other, as a slider makes them, are one."""

    async def changes() -> None:
        for mass in (4.0, 5.0, 6.0):
            await page.change([(MASS, mass)], f"rod.mass = {mass}")
        await page.change([(GRAVITY, 1.5)], "loads.gravity.g = 1.5")

    def values() -> tuple[float, float | None]:
        return page.scene.rod.mass, page.scene.loads.value("gravity")

    finished(changes())
    seen = [values()]
    for forth in (False, False, False, True, True, True):
        finished(page.undo(forth))
        seen.append(values())
    there = [(6.0, 1.5), (6.0, 9.81), (3.0, 9.81), (3.0, 9.81), (6.0, 9.81), (6.0, 1.5), (6.0, 1.5)]
    assert seen == there
    assert page.run.undo.file == SCENE
    finished(page.undo())
    finished(page.change([(MASS, 7.0)], "rod.mass = 7"))
    finished(page.undo(forth=True))  # there is nothing to redo after another change
    assert values() == (7.0, 9.81)


def test_kick_and_pull_are_undone(page: PageRun, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run goes back to the sample before, and on as one that nobody has touched; changes of
    before and after are undone as ever."""
    monkeypatch.setattr(pulling, "build_fastest", lambda scene: build(scene, "numpy"))
    run = page.run

    def goes_to(t: float) -> None:
        run.do(lambda: run._took(run.live.advance(t, 60.0))).result()

    goes_to(0.1)
    finished(page.change([(MASS, 4.0)], "rod.mass = 4"))
    goes_to(0.2)
    before = run.shown
    run.do(lambda: run.kick(2, 0.5, (3.0, 1.0))).result()
    goes_to(0.3)
    finished(page.allow_pulls())
    run.do(lambda: run.pull(Pull(3, 0.25, (1.3, 0.4), 60.0, 1.5))).result()
    goes_to(0.4)
    finished(page.change([(GRAVITY, 1.5)], "loads.gravity.g = 1.5"))
    finished(page.undo())
    assert run.shown.t[-1] > 0.3
    assert page.scene.loads.value("gravity") == 9.81
    for ends, marks in ((0.3, 2), (0.2, 1)):
        finished(page.undo())
        assert run.store.span == (0.0, pytest.approx(ends, abs=0.01))  # a sample
        assert (run.live.pulling, len(run.marks.every)) == (None, marks)
    np.testing.assert_array_equal(run.shown.y, before.y)
    assert run.live.given == pytest.approx(before.given, abs=1e-12)
    goes_to(0.4)
    alone = LiveRun(SCENE)
    alone.do(lambda: alone._took(alone.live.advance(0.1, 60.0))).result()
    alone.do(lambda: alone.change(edit(SCENE, [(MASS, 4.0)]))).result()
    alone.do(lambda: alone._took(alone.live.advance(0.4, 60.0))).result()
    # Its method began anew at 0.2 s, at rtol 1e-8.
    np.testing.assert_allclose(run.shown.y, alone.shown.y, rtol=1e-6, atol=1e-6)
    alone.close()
    assert run.undo.next(forth=True) is not None  # the change of gravity, but no kick
    finished(page.undo())
    assert page.scene.rod.mass == 3.0
    run.do(lambda: run.kick(2, 0.5, (3.0, 1.0))).result()
    run.do(run.restart).result()
    assert run.undo.next(forth=False) is None  # of another run


def test_scene_and_structure_are_undone(page: PageRun, making: Making) -> None:
    """The scene of another file, and what differs from a file, come back, too."""
    other = edit(SCENE, [(MASS, 7.0)])
    finished(page.take(other))
    assert page.run.undo.file == other
    finished(page.change([(LINKS, 3)], ""))
    finished(page.undo())
    assert (page.scene, page.run.undo.file) == (other, other)
    finished(page.undo())
    assert (page.scene, page.run.undo.file) == (SCENE, SCENE)
    finished(page.undo(forth=True))
    assert (page.scene.rod.mass, making.made) == (7.0, [3, 5])


def test_refused_changes_are_not_undone(page: PageRun) -> None:
    with pytest.raises(SceneError):
        finished(page.change([(MASS, -1.0)], "rod.mass = -1"))
    assert page.run.undo.next(forth=False) is None
