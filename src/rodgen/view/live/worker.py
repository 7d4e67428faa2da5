"""A thread that does what it is told between the frames of what it does anyway."""

from __future__ import annotations

import threading
import time
import traceback
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, TypeVar

FRAME = 1 / 60  # seconds
IDLE = 0.25  # seconds after which a thread that has nothing to do looks up
T = TypeVar("T")


class Worker:
    """A frame is `slice`, then `show`, then work that others have handed in by `do`.

    busy: whether frames follow each other; else the thread sleeps until something comes.
    """

    def __init__(self) -> None:
        self._work: deque[tuple[Callable[[], Any], Future[Any]]] = deque()
        self._wake, self._closed = threading.Event(), False
        self._thread = threading.Thread(target=self._loop, name="rodgen-run", daemon=True)

    def start(self) -> None:
        """Begin: what is made of the worker is complete."""
        self._thread.start()

    def slice(self) -> None:
        """A frame's worth of going on."""

    def show(self) -> None:
        """What there is to see of it."""

    @property
    def busy(self) -> bool:
        """Whether another frame is due."""
        return False

    def failed(self, message: str) -> None:
        """Told in words of a defect in a frame."""

    def do(self, work: Callable[[], T]) -> Future[T]:
        """Have the thread do something between two frames."""
        future: Future[T] = Future()
        if self._closed:
            future.cancel()
            return future
        self._work.append((work, future))
        self.wake_up()
        return future

    def close(self) -> None:
        """End the thread; what waits is cancelled."""
        self._closed = True
        self.wake_up()

    def wake_up(self) -> None:
        """Look up, if it is idle: somebody has come, or something is to be done."""
        self._wake.set()

    def _loop(self) -> None:
        due = time.perf_counter()
        while not self._closed:
            self._wake.clear()
            self._do_work()
            self._guarded(self.slice)
            self._guarded(self.show)
            # By the clock, not by what a wait takes: frames are to come evenly.
            now = time.perf_counter()
            due = max(due + FRAME, now) if self.busy else now + IDLE
            if due > now and not self._work:
                self._wake.wait(due - now)
        while self._work:
            self._work.popleft()[1].cancel()

    def _do_work(self) -> None:
        while self._work:
            work, future = self._work.popleft()
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(work())
            except BaseException as error:
                future.set_exception(error)

    def _guarded(self, work: Callable[[], None]) -> None:
        """A defect is told, and does not end the thread."""
        try:
            work()
        except Exception as error:  # whatever it is: the page is to be told
            traceback.print_exc()
            self.failed(f"rodgen has failed: {error!r}")
