"""Ctrl-C, and what a batch system or a closing terminal sends, while there is something to lose."""

from __future__ import annotations

import signal
import sys
from threading import Timer, main_thread

SOON = 0.01  # s
# What ends a program as Ctrl-C does, where the system has it: a program that is killed by one of
# these leaves what it has started.
ENDING = ("SIGTERM", "SIGHUP", "SIGQUIT")


def end_as_by_ctrl_c() -> None:
    """Let what a batch system or a terminal sends to end a program do what Ctrl-C does, so that it
    loses and leaves no more. What is ignored from the start, as under nohup, stays so."""
    # In the background of a script, Ctrl-C is ignored from the start: the other would be, too.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        let_ctrl_c_through()
    for number in (getattr(signal, name) for name in ENDING if hasattr(signal, name)):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, lambda *_: signal.raise_signal(signal.SIGINT))


def hold_back_ctrl_c() -> None:
    """Ignore Ctrl-C: what was computed is to be written first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def let_ctrl_c_through() -> None:
    """Let Ctrl-C end what it meets again."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


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
