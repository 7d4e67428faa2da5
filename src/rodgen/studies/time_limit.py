"""Time limit of the points of a study."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock, Timer, get_ident

from rodgen.errors import InputError
from rodgen.scene.plain_tables import is_number, to_plain
from rodgen.system import System

MAKING = 60.0  # seconds that the first point of a structure has more, for making its module
LONGEST = 1e9  # seconds that a timer can wait
_known: set[str] = set()  # structures whose modules are there, by their hashes


class TimeLimitExceeded(BaseException):
    """Raised in a computation that exceeds its time limit; no Exception, so that what catches every
    Exception lets it pass."""


def check_limit(seconds: object, field: str = "compute.time_limit") -> float | None:
    """Check a time limit [s], or None. Raises InputError."""
    seconds = to_plain(seconds, field)
    if seconds is not None and not (is_number(seconds) and 0 < seconds < float("inf")):
        raise InputError(field, seconds, "a positive number of seconds")
    return None if seconds is None else float(seconds)


@contextmanager
def time_limit(seconds: float | None, *systems: System) -> Iterator[None]:
    """Raise TimeLimitExceeded inside the block, at its next line of Python, after so many seconds;
    None for no limit. systems: whose modules may have to be built first, in extra time."""
    if seconds is None:
        yield
        return
    new = {system.structure.hash for system in systems} - _known
    thread, lock = ctypes.c_ulong(get_ident()), Lock()
    fired = over = False

    def stop() -> None:
        nonlocal fired
        with lock:
            if not over:
                fired = True
                ctypes.pythonapi.PyThreadState_SetAsyncExc(
                    thread, ctypes.py_object(TimeLimitExceeded)
                )

    timer = Timer(min(seconds + MAKING * bool(new), LONGEST), stop)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        _known.update(new)  # Whether or not it was enough: it is given once.
        with lock:
            over = True
        timer.cancel()
        if fired:  # it may be about to come yet
            ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, None)
    if fired:
        raise TimeLimitExceeded
