"""The time that a point of a study may take."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock, Timer, get_ident

from rodgen.errors import InputError
from rodgen.scene.plain import is_number, plain
from rodgen.system import System

MAKING = 60.0  # seconds that the first point of a structure has more, for making its module
LONGEST = 1e9  # seconds that a timer can wait
_known: set[str] = set()  # structures whose modules are there, by their hashes


class TooLong(BaseException):
    """A computation that took longer than it may. Nothing that goes on after any Exception is to go
    on after this."""


def checked_limit(seconds: object, field: str = "compute.time_limit") -> float | None:
    """A limit of time [s], or None. Raises InputError."""
    seconds = plain(seconds, field)
    if seconds is not None and not (is_number(seconds) and 0 < seconds < float("inf")):
        raise InputError(field, seconds, "a positive number of seconds")
    return None if seconds is None else float(seconds)


@contextmanager
def time_limit(seconds: float | None, *systems: System) -> Iterator[None]:
    """Raise TooLong inside where it takes longer than so many seconds, at the next line of Python;
    None for no limit. systems: of which modules may have to be made first."""
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
                ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, ctypes.py_object(TooLong))

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
        raise TooLong
