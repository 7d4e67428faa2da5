"""The runs of a server, one for every page, and a run as the panels of its page use it."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import (
    Awaitable,
    Callable,
    Coroutine,
    Iterator,
    Mapping,
    MutableMapping,
)
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol, TypeVar

from nicegui import Client, app, background_tasks, ui
from nicegui.element import Element

from rodgen.errors import InputError
from rodgen.live.run.live_run import LiveRun
from rodgen.scene import Scene, Structure
from rodgen.system import System

GRACE = 7.0  # seconds that a page may take to come back, as it does on a reload
FIRST = 30.0  # seconds that it may take to come at first
MOST = 16  # runs at a time
VIEW = "view"  # chosen by the tab of a browser, which keeps it over a reload

T = TypeVar("T")
Edit = Callable[[System], System]
Make = Callable[[Scene], Awaitable[None]]


@dataclass
class Session:
    """A run; until when [s] it is kept without a page; how many pages had come by then."""

    run: LiveRun
    until: float
    came: int = 0


class Sessions:
    """Runs by their names, which cannot be guessed."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._sessions: dict[str, Session] = {}
        self._coming = 0
        self._arrivals: dict[object, float] = {}  # since when pages are on their way

    def __len__(self) -> int:
        return len(self._sessions)

    @contextmanager
    def room(self) -> Iterator[None]:
        """Keep a place for a run whose module is being made. Raises InputError where there is
        none."""
        if len(self) + self._coming >= MOST:
            raise InputError(
                "runs", len(self) + self._coming + 1, f"at most {MOST} on one server; close a tab"
            )
        self._coming += 1
        try:
            yield
        finally:
            self._coming -= 1

    def open(self, scene: Scene) -> str:
        """Begin a run, within `room`; returns its name. Raises InputError."""
        name = secrets.token_urlsafe(16)
        self._sessions[name] = Session(LiveRun(scene), self._clock() + FIRST)
        return name

    def get(self, name: object) -> LiveRun | None:
        """The run of that name, if it is still there."""
        session = self._sessions.get(name) if isinstance(name, str) else None
        return session.run if session else None

    @contextmanager
    def arrival(self) -> Iterator[None]:
        """Keep all runs while a page is on its way, which tells last whose it is: on a busy machine
        a reload takes its time. One that does not come counts for half a minute."""
        page = object()
        self._arrivals[page] = self._clock()
        try:
            yield
        finally:
            del self._arrivals[page]

    def claim(self, name: object) -> LiveRun | None:
        """The run of that name, if it is still there, kept for a page that is being built."""
        run = self.get(name)
        if run is not None:
            session = self._sessions[str(name)]
            session.until, session.came = self._clock() + FIRST, run.page.came
        return run

    def sweep(self) -> None:
        """End the runs without a page; to be called about once a second."""
        now = self._clock()
        arriving = any(now - since < FIRST for since in self._arrivals.values())
        for name, session in list(self._sessions.items()):
            page = session.run.page
            if page.came > session.came:  # and may have gone since the last look
                session.until, session.came = now + GRACE, page.came
            elif page.watched:
                session.until = max(session.until, now + GRACE)
            elif now > session.until and not arriving:
                self.close(name)

    def close(self, name: str) -> None:
        """End a run."""
        session = self._sessions.pop(name, None)
        if session:
            session.run.close()

    def close_all(self) -> None:
        """End all runs."""
        for name in list(self._sessions):
            self.close(name)


class Panel(Protocol):
    """A part of the page."""

    def refresh(self) -> None:
        """Show the run as it is now."""


def notify(client: Client, text: str) -> None:
    """Show a message on a page that goes away by itself."""
    if client.is_deleted:
        return
    with client:
        ui.notify(text, type="warning", multi_line=True, close_button="Close", timeout=8000)


class PageRun:
    """A run and the page that shows it; when something has changed, all panels are refreshed.

    make: has the module of a scene made; root: the element that dialogs are built in; tab: what the
    tab of the browser remembers over a reload.

    A system is changed in the run's own thread, by a function from the system that is there: what
    comes between, from elsewhere on the page, is not lost.
    """

    def __init__(
        self,
        run: LiveRun,
        make: Make,
        client: Client,
        root: Element,
        tab: MutableMapping[str, Any],
    ):
        self.run, self.client, self.root, self.tab = run, client, root, tab
        self.panels: tuple[Panel, ...] = ()
        self._make, self._making = make, asyncio.Lock()

    @property
    def scene(self) -> Scene:
        """The scene as it is now."""
        return self.run.live.scene

    def refresh(self) -> None:
        """Show all panels anew, as something has changed."""
        if self.client.is_deleted:
            return
        with self.client:
            try:
                for panel in self.panels:
                    panel.refresh()
            except Exception as error:  # a defect: the page says so, and stays
                app.handle_exception(error)

    def say(self, text: str) -> None:
        """Show a message that goes away by itself."""
        notify(self.client, text)

    async def do(self, work: Callable[[], T]) -> T:
        """Have the run's thread do something."""
        return await asyncio.wrap_future(self.run.do(work))

    def soon(self, work: Callable[[], Any]) -> None:
        """Have the run's thread do something and do not wait for it; what is refused is said."""
        self.begin(self.do(work))

    def begin(self, doing: Coroutine[Any, Any, object]) -> None:
        """Do something and do not wait for it; what is refused is said."""

        async def told() -> None:
            try:
                await doing
            except InputError as error:
                self.say(str(error))

        background_tasks.create(told(), context=self.client)

    async def change(self, changes: Mapping[str, Any], what: str) -> None:
        """Change values of keys of the scene; what: in words, for the record. Raises InputError."""
        await self.alter(
            lambda system: system.at(changes),
            lambda system: self.run.change(system, what),
            lambda before: self.run.undo.note(before, what),
        )

    async def take(self, scene: Scene) -> None:
        """Run another scene, from its start. Raises InputError."""
        await self.alter(
            lambda _: System(scene),
            self.run.take,
            lambda before: self.run.undo.take(before, scene),
        )

    async def undo(self, forth: bool = False) -> None:
        """Go back to the system before the last change, or before the last kick or pull; or forth
        again. Raises InputError."""
        run, undo = self.run, self.run.undo
        if (kept := undo.next(forth)) is None:
            return
        said = "redo" if forth else "undo"

        def act(system: System) -> None:
            if kept.mark is not None:
                run.back_to(kept.mark)
            elif kept.anew:
                run.take(system)
            else:
                run.change(system, said)

        await self.alter(lambda _: kept.system, act, lambda before: undo.go(before, forth))

    async def alter(
        self, edit: Edit, act: Callable[[System], object], note: Callable[[System], object]
    ) -> None:
        """Another system, made of the one that is there: `act` is given it in the run's thread
        where its module is that of the run; else that is made first, and the system begins from
        its start. `note` is given the system before, once it has gone well. Raises InputError."""
        if await self._acted(edit, act, note) is None:
            return
        async with self._making:
            made = None
            while (wanted := await self._acted(edit, self.run.take, note, made)) is not None:
                await self._make(wanted.scene)
                made = wanted.structure

    async def allow_pulls(self) -> None:
        """Have the module by which the rod can be pulled, and let the run go on by it. Raises
        InputError."""
        if await self.do(self.run.allow_pulls) is None:
            return
        async with self._making:
            made = None
            while (wanted := await self.do(partial(self.run.allow_pulls, made))) is not None:
                await self._make(wanted.scene)
                made = wanted.structure

    async def _acted(
        self,
        edit: Edit,
        act: Callable[[System], object],
        note: Callable[[System], object],
        made: Structure | None = None,
    ) -> System | None:
        """Nothing, or the system whose module is to be made; made: the structure of one that is
        there, beside that of the run."""

        def work() -> System | None:
            before = self.run.live.system
            system = edit(before)
            if system.structure not in (made, before.structure):
                return system
            act(system)
            note(before)
            self.run.told()
            return None

        return await self.do(work)
