"""The thread of a run, and its pace by the clock."""

from __future__ import annotations

import asyncio
import math
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from typing import Any, ParamSpec, TypeVar

FRAME = 1 / 60  # seconds
IDLE = 0.25  # seconds after which a thread that has nothing to do looks up
T = TypeVar("T")
P = ParamSpec("P")


def from_threads(work: Callable[P, object]) -> Callable[P, None]:
    """Make a function for other threads that has the work done in the event loop that runs here,
    and nothing once that has ended, as a server does."""
    loop = asyncio.get_running_loop()

    def call(*given: P.args, **named: P.kwargs) -> None:
        with suppress(RuntimeError):
            loop.call_soon_threadsafe(partial(work, *given, **named))

    return call


class RunThread:
    """A thread that works in frames: the work handed in by `submit`, then `do_frame` and `show`.

    is_busy: whether frames follow each other; else the thread sleeps until something comes; stop:
    told of a defect in a frame, in words.
    """

    def __init__(self) -> None:
        self._work: deque[tuple[Callable[[], Any], Future[Any]]] = deque()
        self._wake, self._closed = threading.Event(), False
        self._faults: dict[str, str] = {}  # of works, until they go well again
        self._thread = threading.Thread(target=self._loop, name="rodgen-run", daemon=True)

    def start(self) -> None:
        """Start the thread, once the subclass is set up."""
        self._thread.start()

    @property
    def is_busy(self) -> bool:
        return False

    def do_frame(self) -> None: ...

    def show(self) -> None: ...

    def stop(self, message: str) -> None: ...

    def submit(self, work: Callable[[], T]) -> Future[T]:
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
        """Wake the thread if it is idle: somebody has come, or something is to be done."""
        self._wake.set()

    def _loop(self) -> None:
        due = time.perf_counter()
        while not self._closed:
            self._wake.clear()
            self._do_work()
            self._run_safely(self.do_frame)
            self._run_safely(self.show)
            # By the clock, not by what a wait takes: frames are to come evenly.
            now = time.perf_counter()
            due = max(due + FRAME, now) if self.is_busy else now + IDLE
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

    def _run_safely(self, work: Callable[[], None]) -> None:
        """Do work; its defects are reported and do not end the thread."""
        try:
            work()
            self._faults.pop(work.__name__, None)
        except Exception as error:  # whatever it is: the page is to be told, though not every frame
            if self._faults.get(work.__name__) == repr(error):
                return
            self._faults[work.__name__] = repr(error)
            traceback.print_exc()
            self.stop(f"rodgen has failed: {error!r}")


LAG = 0.1  # seconds behind the clock from which a run that cannot keep up is let off
OVER = 1.0  # seconds over which the ratio to real time is measured
SHORT = 0.9  # of the speed that is asked for, below which it is missed
HEAVY = 0.1  # of a processor, from which on steps are what keeps a run from its speed


class Pace:
    """Pace of a run: where it should be by now, and how fast it has been of late.

    speed: simulated seconds per second; infinite: as fast as it goes.
    """

    def __init__(self, speed: float = 1.0, clock: Callable[[], float] = time.perf_counter):
        self._clock = clock
        self.speed = speed
        self._passed: deque[tuple[float, float, float]] = deque()  # by the clock, t, spent
        self._spent = 0.0
        self.start(0.0)

    def start(self, t: float) -> None:
        """Start counting now, at t [s] of the run."""
        self._since = self._clock()
        self._anchor = t, self._since
        self._passed.clear()

    def target(self) -> float:
        """Time that the run should have reached by now [s]."""
        t, since = self._anchor
        return t + self.speed * (self._clock() - since) if math.isfinite(self.speed) else math.inf

    def add_cost(self, seconds: float) -> None:
        """Add the processor time that steps have taken [s]."""
        self._spent += seconds

    def record(self, t: float) -> None:
        """Note that the run has come to t [s]."""
        now = self._clock()
        if math.isfinite(self.speed) and self.target() - t > LAG * self.speed:
            self._anchor = t, now
        self._passed.append((now, t, self._spent))
        while now - self._passed[0][0] > OVER and len(self._passed) > 2:
            self._passed.popleft()

    @property
    def ratio(self) -> float | None:
        """Simulated seconds per second of late; None where it is not known yet."""
        if len(self._passed) < 2:
            return None
        (before, first, _), (now, last, _) = self._passed[0], self._passed[-1]
        return (last - first) / (now - before) if now > before else None

    @property
    def is_too_slow(self) -> bool:
        """Whether steps keep the run from its speed: it has fallen short for a while, and to keep
        up they would need a good part of a processor. Else the machine is busy with others."""
        ratio, late = self.ratio, self._clock() - self._since > 2 * OVER
        if ratio is None or not late or not ratio < SHORT * self.speed < math.inf:
            return False
        (_, first, before), (_, last, spent) = self._passed[0], self._passed[-1]
        return (spent - before) * self.speed > HEAVY * (last - first)
