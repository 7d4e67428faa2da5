"""The runs of a server, one for every page; those that nobody looks at any more are ended."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from rodgen.scene import Scene, SceneError
from rodgen.view.live.run import LiveRun

GRACE = 7.0  # seconds that a page may take to come back, as it does on a reload
FIRST = 30.0  # seconds that it may take to come at first
MOST = 16  # runs at a time


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

    def __len__(self) -> int:
        return len(self._sessions)

    @contextmanager
    def room(self) -> Iterator[None]:
        """Keeps a place for a run whose module is being made. Raises SceneError where there is
        none."""
        if len(self) + self._coming >= MOST:
            raise SceneError("runs", len(self) + 1, f"at most {MOST} on one server; close a tab")
        self._coming += 1
        try:
            yield
        finally:
            self._coming -= 1

    def open(self, scene: Scene) -> str:
        """A new run, within `room`. Raises SceneError."""
        name = secrets.token_urlsafe(16)
        self._sessions[name] = Session(LiveRun(scene), self._clock() + FIRST)
        return name

    def get(self, name: object) -> LiveRun | None:
        """The run of that name, if it is still there."""
        session = self._sessions.get(name) if isinstance(name, str) else None
        return session.run if session else None

    def sweep(self) -> None:
        """End the runs without a page; to be called about once a second."""
        now = self._clock()
        for name, session in list(self._sessions.items()):
            page = session.run.page
            if page.watched or page.came > session.came:  # or it came and went since the last look
                session.until, session.came = now + GRACE, page.came
            elif now > session.until:
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
