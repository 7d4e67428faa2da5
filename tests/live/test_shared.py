"""What a page asks of its run, while the run is busy and while a module is being made."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

import pytest

pytest.importorskip("nicegui", reason="the extra view is not installed")

from nicegui import Client, background_tasks, core, ui
from starlette.requests import Request

from rodgen.scene import Scene, SceneError
from rodgen.view.live.edits import edited
from rodgen.view.live.run import LiveRun
from rodgen.view.live.scenes import Folder
from rodgen.view.live.web.page import Page
from rodgen.view.live.web.sessions import Sessions
from rodgen.view.live.web.shared import Shared

SCENE = Scene.from_dict(
    {
        "name": "two",
        "rod": {"links": 2, "length": 2.0, "bending_stiffness": 5.0, "mass": 3.0},
        "loads": {"gravity": {"g": 9.81}},
        "integrate": {"span": [0.0, 5.0]},
    }
)
MASS, GRAVITY, LINKS = ("rod", "mass"), ("loads", "gravity", "g"), ("rod", "links")

T = TypeVar("T")


def finished(work: Coroutine[Any, Any, T]) -> T:
    """What comes of it, in a thread of its own: a browser may have the loop of this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, work).result()


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
def shared() -> Iterator[Shared]:
    made = Shared()
    # Making stands for Progress, without a page.
    made.run, made.progress = LiveRun(SCENE), Making()  # type: ignore[assignment]
    yield made
    made.run.close()


def test_edits_close_together_are_both_kept(shared: Shared) -> None:
    """The second is asked for before the run has got to the first."""
    free = threading.Event()

    async def both() -> None:
        busy = shared.run.do(free.wait)
        edits = asyncio.gather(
            shared.change([(MASS, 25.0)], "mass = 25"), shared.change([(GRAVITY, 1.5)], "g = 1.5")
        )
        await asyncio.sleep(0.05)
        free.set()
        await edits
        assert busy.result()

    finished(both())
    assert (shared.scene.rod.mass, shared.scene.loads.value("gravity")) == (25.0, 1.5)


def test_changes_while_a_module_is_made_are_kept(shared: Shared) -> None:
    making: Any = shared.progress

    async def meanwhile() -> None:
        await shared.change([(GRAVITY, 1.5)], "g = 1.5")
        assert shared.scene.rod.links == 2  # the old one goes on

    making.meanwhile = meanwhile
    finished(shared.change([(LINKS, 3)], ""))
    assert making.made == [3]
    assert (shared.scene.rod.links, shared.scene.loads.value("gravity")) == (3, 1.5)


def test_structures_asked_for_together_come_one_after_the_other(shared: Shared) -> None:
    """Each is made of the scene that is there by then."""
    making: Any = shared.progress

    async def meanwhile() -> None:
        await asyncio.sleep(0.01)

    async def both() -> None:
        await asyncio.gather(
            shared.change([(LINKS, 3)], ""),
            shared.change([(("loads", "tip"), {"x": 0.0, "y": -1.0})], ""),
        )

    making.meanwhile = meanwhile
    finished(both())
    assert making.made == [3, 3]
    assert shared.scene.structure.terms == ("gravity", "tip_load")


def test_scene_of_the_same_structure_needs_no_making(shared: Shared) -> None:
    making: Any = shared.progress
    finished(shared.take(edited(SCENE, [(MASS, 7.0)])))
    assert (making.made, shared.scene.rod.mass, shared.run.taken) == ([], 7.0, 2)


def test_refusals_come_to_who_asked(shared: Shared) -> None:
    with pytest.raises(SceneError, match=r"rod\.mass"):
        finished(shared.change([(MASS, -1.0)], "mass = -1"))
    assert shared.scene.rod.mass == 3.0


def test_page_that_is_asked_for_and_never_shown() -> None:
    """Such as for the preview of a link: a minute later it is given up, and nothing is begun."""
    sessions = Sessions()

    async def asked() -> None:
        core.loop = asyncio.get_running_loop()
        request = Request({"type": "http", "headers": [], "method": "GET", "path": "/"})
        client = Client(ui.page("/nobody"), request=request)

        async def show() -> None:
            with client:
                await Page(sessions, Folder(Path()), SCENE).show("")

        showing = asyncio.create_task(show())
        await asyncio.sleep(0.01)
        assert not showing.done()
        client.delete()
        await asyncio.wait_for(showing, 5.0)
        await background_tasks.teardown()

    finished(asked())
    core.loop = None
    assert len(sessions) == 0
