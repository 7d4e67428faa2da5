"""Ctrl-C, and what a batch system or a closing terminal sends, while there is something to lose."""

from __future__ import annotations

import os
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from ctypes import PYFUNCTYPE, c_int, c_void_p, pythonapi
from functools import cache
from threading import Event, Thread, Timer, main_thread
from time import monotonic
from types import FrameType
from typing import NoReturn

from rodgen.cli.errors import INTERRUPTED
from rodgen.native.library import ENDS, end_compilers
from rodgen.progress import remove_bars

SOON = 0.01  # s
PATIENCE = 1.0  # seconds that Python has to come to a Ctrl-C
CLOSE = 0.1  # seconds between a signal and its being seen by a thread
# What ends a program as Ctrl-C does, where the system has it: a program that is killed by one of
# these leaves what it has started.
ENDING = ("SIGTERM", "SIGHUP", "SIGQUIT")


_heard = -1.0  # when it was called last, by Ctrl-C
_calls: list[object] = []  # kept, as Python may still make them
_last: list[Callable[[], str]] = []


def _hear(number: int, frame: FrameType | None) -> NoReturn:
    """Raise KeyboardInterrupt, and note when."""
    global _heard
    _heard = monotonic()
    signal.default_int_handler(number, frame)


vars(_hear)[ENDS] = True


def end_within_libraries() -> None:
    """Let Ctrl-C end the program also while a library is at work that looks for no signals, such as
    LAPACK on a large matrix: where Python does not come to it within PATIENCE, nothing is lost by
    ending at once."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _hear)
    _start_watch()


@cache
def _start_watch() -> None:
    """Start the thread that looks after signals, once in a process."""
    read, written = socket.socketpair()
    written.setblocking(False)
    signal.set_wakeup_fd(written.fileno(), warn_on_full_buffer=False)
    Thread(target=_watch, args=(read, written), daemon=True).start()
    if hasattr(os, "register_at_fork"):  # whose signals are not those of this process
        os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))


def _watch(read: socket.socket, written: socket.socket) -> None:
    """Look after every signal whether Python comes to it; written: kept open for the others."""
    ending = {signal.SIGINT, *_ending()}
    while number := read.recv(1):
        if number[0] in ending and signal.getsignal(signal.SIGINT) is _hear:
            Thread(target=_look, args=(monotonic(),), daemon=True).start()


def _look(since: float) -> None:
    """End the program unless its main thread comes to a signal soon, by whatever handler that has,
    or leaves it for later."""
    came = Event()

    def come(_: object) -> int:
        came.set()
        return 0

    # Python calls it where it comes to signals, after the handlers of these.
    call = PYFUNCTYPE(c_int, c_void_p)(come)
    _calls.append(call)
    pythonapi.Py_AddPendingCall(call, None)
    heard = came.wait(PATIENCE) or _heard >= since - CLOSE
    if heard or signal.getsignal(signal.SIGINT) is not _hear:
        return
    end_compilers()
    said = "".join(do() for do in _last)
    remove_bars()
    print(f"rodgen: interrupted{said}", file=sys.stderr, flush=True)
    os._exit(INTERRUPTED)


@contextmanager
def at_last(do: Callable[[], str]) -> Iterator[None]:
    """Call a function if the program is ended at once inside; what it returns is said as well."""
    _last.append(do)
    try:
        yield
    finally:
        _last.remove(do)


def _ending() -> list[signal.Signals]:
    return [getattr(signal, name) for name in ENDING if hasattr(signal, name)]


def end_as_by_ctrl_c() -> None:
    """Let what a batch system or a terminal sends to end a program do what Ctrl-C does, so that it
    loses and leaves no more. What is ignored from the start, as under nohup, stays so."""
    # In the background of a script, Ctrl-C is ignored from the start: the other would be, too.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        let_ctrl_c_through()
    for number in _ending():
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, lambda *_: signal.raise_signal(signal.SIGINT))


def hold_back_ctrl_c() -> None:
    """Ignore Ctrl-C: what was computed is to be written first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def let_ctrl_c_through() -> None:
    """Let Ctrl-C end what it meets again."""
    signal.signal(signal.SIGINT, _hear)


def lose_no_ctrl_c() -> None:
    """Let a Ctrl-C come again that met a callback of the interpreter, such as a finalizer, from
    which nothing can be raised: it would end nothing."""
    otherwise = sys.unraisablehook

    def look_at(what: sys.UnraisableHookArgs) -> None:
        if isinstance(what.exc_value, KeyboardInterrupt):
            again = Timer(SOON, _interrupt)
            again.daemon = True
            again.start()
        else:
            otherwise(what)

    sys.unraisablehook = look_at


def _interrupt() -> None:
    """Send Ctrl-C to the main thread: it may wait for something, and a flag would not wake it."""
    number = main_thread().ident
    if number is not None and sys.platform != "win32":
        signal.pthread_kill(number, signal.SIGINT)
    else:
        signal.raise_signal(signal.SIGINT)
