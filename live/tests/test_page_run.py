"""What a page asks of its run, while the run is busy and while a module is being made."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Coroutine, Iterator
from typing import Any

import numpy as np
import pytest

from live.tests.conftest import SCENE, SCENES, finished
from live.tests.runs import does, to
from rodgen.errors import InputError
from rodgen.loading import build
from rodgen.scene import Scene
from rodgen_live.page.page_run import PageRun
from rodgen_live.pull import Pull
from rodgen_live.run import live_run, pulling
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.scene_text import SceneFolder

MASS, GRAVITY, LINKS = "rod.mass", "loads.gravity.g", "rod.links"


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
    for place in (live_run, pulling):
        monkeypatch.setattr(place, "build_fastest", lambda scene: build(scene, "numpy"))
    # Without a page: nothing of it is asked for.
    nowhere: Any = None
    run = LiveRun(SCENE)
    yield PageRun(run, making.make, nowhere, nowhere, {}, SceneFolder(SCENES))
    run.close()


def values(page: PageRun) -> tuple[float, float | None]:
    return page.scene.rod.mass, page.scene.loads.value("gravity")


def test_edits_close_together_are_both_kept(page: PageRun) -> None:
    """The second is asked for before the run has got to the first."""
    free = threading.Event()

    async def both() -> None:
        busy = page.run.submit(free.wait)
        edits = asyncio.gather(
            page.change({MASS: 25.0}, "mass = 25"), page.change({GRAVITY: 1.5}, "g = 1.5")
        )
        await asyncio.sleep(0.05)
        free.set()
        await edits
        assert busy.result()

    finished(both())
    assert values(page) == (25.0, 1.5)


def test_changes_while_a_module_is_made_are_kept(page: PageRun, making: Making) -> None:
    """One of a value, and one of the structure, which is made of the scene that is there then."""
    tip = {"loads.tip": {"x": 0.0, "y": -1.0}}

    async def meanwhile() -> None:
        making.meanwhile = None
        await page.change({GRAVITY: 1.5}, "g = 1.5")
        assert page.scene.rod.links == 5  # the old one goes on

    async def both() -> None:
        await asyncio.gather(page.change({LINKS: 3}, ""), page.change(tip, ""))

    making.meanwhile = meanwhile
    finished(both())
    assert making.made == [3, 3]
    assert (page.scene.rod.links, *values(page)) == (3, 3.0, 1.5)
    assert page.scene.structure.terms == (*SCENE.structure.terms, "tip_load")


def test_changes_are_undone_and_redone(page: PageRun) -> None:
    """Those of one value that follow each other, as a slider makes them, are one. A refusal comes
    to who asked, and is nothing to undo."""

    async def changes() -> None:
        for mass in (4.0, 5.0, 6.0):
            await page.change({MASS: mass}, f"rod.mass = {mass}")
        await page.change({GRAVITY: 1.5}, "loads.gravity.g = 1.5")
        with pytest.raises(InputError, match=r"rod\.mass"):
            await page.change({MASS: -1.0}, "mass = -1")

    finished(changes())
    seen = [values(page)]
    for forth in (False, False, False, True, True, True):
        finished(page.undo(forth))
        seen.append(values(page))
    there = [(6.0, 1.5), (6.0, 9.81), (3.0, 9.81), (3.0, 9.81), (6.0, 9.81), (6.0, 1.5), (6.0, 1.5)]
    assert seen == there
    assert page.run.undo.file == SCENE
    finished(page.undo())
    finished(page.change({MASS: 7.0}, "rod.mass = 7"))
    finished(page.undo(forth=True))  # there is nothing to redo after another change
    assert values(page) == (7.0, 9.81)


def test_kick_and_pull_are_undone(page: PageRun, other: LiveRun) -> None:
    """The run goes back to the sample before, and on as one that nobody has touched; changes of
    before and after are undone as ever."""
    run = page.run
    to(run, 0.1)
    finished(page.change({MASS: 4.0}, "rod.mass = 4"))
    to(run, 0.2)
    before = run.shown
    run.submit(lambda: run.kick(2, 0.5, (3.0, 1.0))).result()
    to(run, 0.3)
    finished(page.allow_pulls())
    run.submit(lambda: run.pull(Pull(3, 0.25, (1.3, 0.4), 60.0, 1.5))).result()
    to(run, 0.4)
    finished(page.change({GRAVITY: 1.5}, "loads.gravity.g = 1.5"))
    finished(page.undo())
    assert run.shown.t[-1] > 0.3
    assert page.scene.loads.value("gravity") == 9.81
    for ends, marks in ((0.3, 2), (0.2, 1)):
        finished(page.undo())
        assert run.store.span == (0.0, pytest.approx(ends, abs=0.01))  # a sample
        assert (run.live.pulling, len(run.marks.every)) == (None, marks)
    np.testing.assert_array_equal(run.shown.y, before.y)
    assert run.live.given == pytest.approx(before.given, abs=1e-12)
    to(run, 0.4)
    to(other, 0.1)
    does(other, lambda: other.change(SCENE.replace({MASS: 4.0})))
    to(other, 0.4)
    # Its method began anew at 0.2 s, at rtol 1e-8.
    np.testing.assert_allclose(run.shown.y, other.shown.y, rtol=1e-6, atol=1e-6)
    assert run.undo.next_state(forth=True) is not None  # the change of gravity, but no kick
    finished(page.undo())
    assert page.scene.rod.mass == 3.0
    does(run, lambda: run.kick(2, 0.5, (3.0, 1.0)), run.restart)
    assert run.undo.next_state(forth=False) is None  # of another run


def test_kicks_that_are_alike_are_undone_one_by_one(page: PageRun) -> None:
    run = page.run
    for t in (0.1, 0.2):
        to(run, t)
        run.submit(lambda: run.kick(2, 0.5, (3.0, 1.0))).result()
    to(run, 0.3)
    for ends, marks in ((0.2, 1), (0.1, 0)):
        finished(page.undo())
        assert run.store.span == (0.0, pytest.approx(ends, abs=0.01))  # a sample
        assert len(run.marks.every) == marks


def test_text_of_a_run_is_that_of_its_file_with_its_changes(page: PageRun) -> None:
    """Its comments stay, also over an undo; of a scene without a text it is as `to_toml` has it."""
    assert page.text == SCENE.to_toml()
    text = f"# A comment.\n{SCENE.to_toml()}"

    async def edits() -> None:
        await page.run_text(text.replace("mass = 3.0", "mass = 4.0 # kg"))
        await page.change({MASS: 5.0}, "rod.mass = 5")

    finished(edits())
    assert page.text == text.replace("mass = 3.0", "mass = 5.0 # kg")
    finished(page.undo())
    assert page.text == text.replace("mass = 3.0", "mass = 4.0 # kg")
