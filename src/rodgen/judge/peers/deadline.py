"""Calls of others that never come back to Python are stopped by a signal."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

import numpy as np

from rodgen.judge.precision.contestant import Deadline, TooSlowError

WHY = "stopped, as it took too long"


@contextmanager
def stopped() -> Iterator[None]:
    """Raise TooSlowError at the deadline, from calls that ask Python for signals now and then."""
    alarms = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    if not alarms or not np.isfinite(Deadline.at):
        yield
        return
    before = signal.signal(signal.SIGALRM, _over)
    signal.setitimer(signal.ITIMER_REAL, max(1e-3, Deadline.at - time.perf_counter()))
    try:
        yield
    except BaseException as error:
        if time.perf_counter() >= Deadline.at:  # as whatever the call made of it
            raise TooSlowError(WHY) from error
        raise
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _over(*_: Any) -> NoReturn:
    raise TooSlowError(WHY)
