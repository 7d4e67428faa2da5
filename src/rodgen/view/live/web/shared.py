"""What the parts of a page share: its run, how it is asked for something, and what is said."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from nicegui import Client, background_tasks, ui

from rodgen.scene import Scene, SceneError, Structure
from rodgen.view.live.edits import Path, edited
from rodgen.view.live.run import LiveRun
from rodgen.view.live.web.progress import Progress

T = TypeVar("T")
Edit = Callable[[Scene], Scene]


class Shared:
    """The run of a page.

    Scenes are changed in the run's own thread, as functions from the scene that is there: what
    comes between, from elsewhere on the page, is not lost.
    """

    run: LiveRun
    client: Client
    progress: Progress

    def __init__(self) -> None:
        self._making = asyncio.Lock()

    @property
    def scene(self) -> Scene:
        """As it is now."""
        return self.run.live.scene

    def say(self, text: str) -> None:
        """A message that goes away by itself."""
        if self.client.is_deleted:
            return
        with self.client:
            ui.notify(text, type="warning", multi_line=True, close_button="Close", timeout=8000)

    async def do(self, work: Callable[[], T]) -> T:
        """Have the run's thread do something."""
        return await asyncio.wrap_future(self.run.do(work))

    def soon(self, work: Callable[[], Any]) -> None:
        """The same, from a handler that does not wait; what is refused is said."""

        async def doing() -> None:
            try:
                await self.do(work)
            except SceneError as error:
                self.say(str(error))

        background_tasks.create(doing(), context=self.client)

    async def change(self, changes: Sequence[tuple[Path, Any]], what: str) -> None:
        """Other values in the scene, in words for the record. Raises SceneError."""
        await self.alter(
            lambda scene: edited(scene, changes), lambda scene: self.run.change(scene, what)
        )

    async def take(self, scene: Scene) -> None:
        """Another scene, from its start. Raises SceneError."""
        await self.alter(lambda _: scene, self.run.take)

    async def alter(self, edit: Edit, act: Callable[[Scene], object]) -> None:
        """Another scene, made of the one that is there: `act` is given it in the run's thread
        where its module is that of the run; else that is made first, and the scene begins from
        its start. Raises SceneError."""
        if await self._acted(edit, act) is None:
            return
        async with self._making:
            made = None
            while (wanted := await self._acted(edit, self.run.take, made)) is not None:
                await self.progress.make(wanted)
                made = wanted.structure

    async def _acted(
        self, edit: Edit, act: Callable[[Scene], object], made: Structure | None = None
    ) -> Scene | None:
        """Nothing, or the scene whose module is to be made; made: the structure of one that is
        there, beside that of the run."""

        def work() -> Scene | None:
            scene = edit(self.scene)
            if scene.structure not in (made, self.scene.structure):
                return scene
            act(scene)
            return None

        return await self.do(work)
