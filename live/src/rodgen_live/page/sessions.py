"""The runs of a server, one for every page."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_live.run.live_run import LiveRun

GRACE = 7.0  # seconds that a page may take to come back, as it does on a reload
FIRST = 30.0  # seconds that it may take to come at first
MOST = 16  # runs at a time


@dataclass
class Session:
    """A run, until when [s] it is kept without a page, and how many pages had come by then."""

    run: LiveRun
    until: float
    came: int = 0


class Sessions:
    """Runs of a server by their names, which cannot be guessed."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._sessions: dict[str, Session] = {}
        self._coming = 0
        self._arrivals: dict[object, float] = {}  # since when pages are on their way

    def __len__(self) -> int:
        return len(self._sessions)

    @contextmanager
    def reserve(self) -> Iterator[None]:
        """Reserve a place for a run whose module is being made. Raises InputError where there is
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
        """Begin a run, within `reserve`; returns its name. Raises InputError."""
        name = secrets.token_urlsafe(16)
        self._sessions[name] = Session(LiveRun(scene), self._clock() + FIRST)
        return name

    def get(self, name: object) -> LiveRun | None:
        """Run of that name, if it is still there."""
        session = self._sessions.get(name) if isinstance(name, str) else None
        return session.run if session else None

    @contextmanager
    def arrival(self) -> Iterator[None]:
        """Keep all runs while a page is on its way, which tells last whose it is: on a busy machine
        a reload takes its time. A page that does not come counts for half a minute."""
        page = object()
        self._arrivals[page] = self._clock()
        try:
            yield
        finally:
            del self._arrivals[page]

    def claim(self, name: object) -> LiveRun | None:
        """Run of that name, if it is still there, kept for a page that is being built."""
        run = self.get(name)
        if run is not None:
            session = self._sessions[str(name)]
            session.until, session.came = self._clock() + FIRST, run.page.came
        return run

    def close_idle(self) -> None:
        """End the runs without a page; to be called about once a second."""
        now = self._clock()
        arriving = any(now - since < FIRST for since in self._arrivals.values())
        for name, session in list(self._sessions.items()):
            page = session.run.page
            if page.came > session.came:  # and may have gone since the last look
                session.until, session.came = now + GRACE, page.came
            elif page.has_page:
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
