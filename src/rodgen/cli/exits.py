"""How commands end: exit statuses, lines on errors, Ctrl-C, and the signals of batch systems and
closing terminals."""

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

from rodgen.native.library import ENDS, end_compilers
from rodgen.progress import remove_bars

# 130 and 141 are what a shell reports for SIGINT and SIGPIPE.
DISPROVEN, BAD_INPUT, FAILED_RUN, INTERRUPTED, NO_READER = 1, 2, 3, 130, 141

SOON = 0.01  # s
PATIENCE = 1.0  # seconds that Python has to come to a Ctrl-C
CLOSE = 0.1  # seconds between a signal and its being seen by a thread
# Signals that end a program as Ctrl-C does, where the system has them: one that is killed by one of
# these leaves what it has started.
ENDING = ("SIGTERM", "SIGHUP", "SIGQUIT")

_heard = -1.0  # when it was called last, by Ctrl-C
_calls: list[object] = []  # kept, as Python may still make them
_last: list[Callable[[], str]] = []


def fail(message: str, status: int) -> NoReturn:
    """Print one line to standard error and end with a status."""
    print(f"rodgen: {message}", file=sys.stderr)
    sys.exit(status)


@contextmanager
def report_errors() -> Iterator[None]:
    """End with one line and an exit status, without a traceback, on bad input and on Ctrl-C."""
    try:
        yield
    except KeyboardInterrupt:
        fail("interrupted", INTERRUPTED)
    except BrokenPipeError:
        # Nobody reads the output any more: nor shall Python try to flush it at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(NO_READER)
    except MemoryError:
        fail("not enough memory for this many links and samples", BAD_INPUT)
    except Exception as error:  # nothing is silenced: what is not explained is raised again
        _exit_with_reason(error)
        raise


def _exit_with_reason(error: Exception) -> None:
    """End with one line for an error that the user can mend."""
    from rodgen.errors import AnalysisError, InputError, StudyError
    from rodgen.loading import BuildError

    if isinstance(error, AnalysisError | StudyError):
        fail(str(error), FAILED_RUN)
    if isinstance(error, InputError):
        notes = "".join(f" ({note})" for note in getattr(error, "__notes__", ()))
        fail(f"{error}{notes}", BAD_INPUT)
    if isinstance(error, BuildError):
        fail(str(error), BAD_INPUT)
    if isinstance(error, OSError) and error.strerror:
        what = f" {error.filename!r}" if error.filename else ""
        fail(f"cannot read or write{what}: {error.strerror}", BAD_INPUT)
    # Typer's own errors, by what they have in common: it does not export their base class.
    if hasattr(error, "format_message"):
        fail(" ".join(error.format_message().split()), BAD_INPUT)
    if type(error).__name__ == "Abort":
        fail("interrupted", INTERRUPTED)


def _handle_interrupt(number: int, frame: FrameType | None) -> NoReturn:
    """Raise KeyboardInterrupt, and note the time."""
    global _heard
    _heard = monotonic()
    signal.default_int_handler(number, frame)


vars(_handle_interrupt)[ENDS] = True


def end_within_libraries() -> None:
    """Let Ctrl-C end the program also while a library is at work that checks no signals, such as
    LAPACK on a large matrix: at once, where Python does not handle it within PATIENCE."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _handle_interrupt)
    _start_watch()


@cache
def _start_watch() -> None:
    """Start the thread that watches signals, once in a process."""
    read, written = socket.socketpair()
    written.setblocking(False)
    signal.set_wakeup_fd(written.fileno(), warn_on_full_buffer=False)
    Thread(target=_watch, args=(read, written), daemon=True).start()
    if hasattr(os, "register_at_fork"):  # whose signals are not those of this process
        os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))


def _watch(read: socket.socket, written: socket.socket) -> None:
    """Check, at every signal, that Python handles it soon; written: kept open for the others."""
    ending = {signal.SIGINT, *_ending_signals()}
    while number := read.recv(1):
        if number[0] in ending and signal.getsignal(signal.SIGINT) is _handle_interrupt:
            Thread(target=_end_if_stuck, args=(monotonic(),), daemon=True).start()


def _end_if_stuck(since: float) -> None:
    """End the program unless its main thread handles a signal soon, by whatever handler, or holds
    it back."""
    came = Event()

    def handle(_: object) -> int:
        came.set()
        return 0

    # Python calls it where it handles signals, after their handlers.
    call = PYFUNCTYPE(c_int, c_void_p)(handle)
    _calls.append(call)
    pythonapi.Py_AddPendingCall(call, None)
    heard = came.wait(PATIENCE) or _heard >= since - CLOSE
    if heard or signal.getsignal(signal.SIGINT) is not _handle_interrupt:
        return
    end_compilers()
    said = "".join(do() for do in _last)
    remove_bars()
    print(f"rodgen: interrupted{said}", file=sys.stderr, flush=True)
    os._exit(INTERRUPTED)


@contextmanager
def call_at_end(do: Callable[[], str]) -> Iterator[None]:
    """Call a function if the program has to end at once inside; the text it returns is printed."""
    _last.append(do)
    try:
        yield
    finally:
        _last.remove(do)


def _ending_signals() -> list[signal.Signals]:
    return [getattr(signal, name) for name in ENDING if hasattr(signal, name)]


def treat_signals_as_ctrl_c() -> None:
    """Handle the signals by which batch systems and terminals end a program as Ctrl-C, so that it
    loses and leaves no more. A signal that is ignored from the start, as under nohup, stays so."""
    # In the background of a script, Ctrl-C is ignored from the start: the other would be, too.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        restore_ctrl_c()
    for number in _ending_signals():
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, lambda *_: signal.raise_signal(signal.SIGINT))


def ignore_ctrl_c() -> None:
    """Ignore Ctrl-C: what was computed is to be written first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def restore_ctrl_c() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again."""
    signal.signal(signal.SIGINT, _handle_interrupt)


def resend_lost_ctrl_c() -> None:
    """Send a Ctrl-C again that was raised in a callback of the interpreter, such as a finalizer,
    where it ends nothing."""
    otherwise = sys.unraisablehook

    def handle_unraisable(what: sys.UnraisableHookArgs) -> None:
        if isinstance(what.exc_value, KeyboardInterrupt):
            again = Timer(SOON, _interrupt)
            again.daemon = True
            again.start()
        else:
            otherwise(what)

    sys.unraisablehook = handle_unraisable


def _interrupt() -> None:
    """Send Ctrl-C to the main thread: it may wait for something, and a flag would not wake it."""
    number = main_thread().ident
    if number is not None and sys.platform != "win32":
        signal.pthread_kill(number, signal.SIGINT)
    else:
        signal.raise_signal(signal.SIGINT)
