"""One worker without Dask: a process that is forked off this one, so that a point that kills its
process does not kill the study; where there are no forks, this process itself."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from threading import Thread
from typing import TYPE_CHECKING, Any, Self

from rodgen.errors import InputError, StudyError
from rodgen.progress import telling
from rodgen.studies import task
from rodgen.studies.alone import TWICE, by
from rodgen.studies.store import Store
from rodgen.studies.task import Arrays, Done

if TYPE_CHECKING:
    from rodgen.studies.study import Study

Texts = dict[tuple[str, ...], str]
# Other systems fork no process that has threads, as one with a dashboard or a notebook has.
FORKS = sys.platform == "linux"
PAYS = 15.0  # seconds of a study from which on starting workers, 1.5 s each, is worth it
SOON = 5.0  # seconds after which nobody waits to know that
TIMING, UNKNOWN = "timing", 1.0  # seconds of a point that kills its process while it is timed


class Here:
    """One block after the other. A context manager: at its end the process that was forked ends."""

    count = 1

    def __init__(self) -> None:
        self._child: _Child | None = None
        self._status = 0  # of the last one that died
        self._each: float | None = None  # seconds of a point, once they are known

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: Any) -> None:
        self._end()

    def timed(self, study: Study) -> tuple[float, Texts]:
        """Time that a point takes [s], and no texts."""
        return self._time(study) if self._each is None else self._each, {}

    def is_enough(self, study: Study) -> bool:
        """Whether a study is so short that more processes are not worth their start."""
        if not FORKS:  # nothing ends a point here that takes long
            return False
        try:
            return study.count * self._time(study, SOON) < PAYS
        except _LateError:
            return False

    def _time(self, study: Study, patience: float | None = None) -> float:
        found = self._asked(study, TIMING, patience)
        self._each = UNKNOWN if found is None else float(found)
        return self._each

    def compute(self, store: Store, blocks: Iterator[int], texts: Texts) -> Iterator[Done]:
        """Compute blocks in their order."""
        for block in blocks:
            indices = store.layout.indices(block)
            if store.is_done(block):
                yield Done(block, len(indices), 0)
            else:
                yield task.keep(store, block, self._computed(store.study, indices))

    def pieces(
        self, store: Store, pieces: Iterator[list[int]], texts: Texts
    ) -> Iterator[tuple[list[int], Arrays]]:
        """Compute points that are no blocks."""
        for piece in pieces:
            yield piece, self._computed(store.study, piece)

    def _computed(self, study: Study, indices: Sequence[int]) -> Arrays:
        """What comes out of points: where one of them kills the process, each by itself."""
        found = self._asked(study, indices)
        if found is not None:
            return dict(found)
        return task.joined([self._alone(study, index) for index in indices])

    def _alone(self, study: Study, index: int) -> Arrays:
        """What comes out of a point; failed if it ends the process twice, where it is the first."""
        deaths, status = 0, 0
        while deaths < TWICE:
            first = self._child is None
            found = self._asked(study, [index])
            if found is not None:
                return dict(found)
            deaths, status = deaths + first, self._status
        return task.failed(study, f"its process was ended {by(status)}, twice and alone")

    def _asked(self, study: Study, what: Any, patience: float | None = None) -> Any:
        """What the process answers; None where it died of it. Raises what was raised in it, and
        _LateError where it does not answer in so many seconds."""
        if not FORKS:
            return _answer(study, what)
        if self._child is None or self._child.study is not study:
            self._end()
            self._child = _Child(study)
        try:
            kind, answer = self._child.ask(what, patience)
        except (EOFError, OSError):
            self._status = self._child.wait()
            self._child = None
            return None
        if kind == "raised":
            raise answer
        return answer

    def _end(self) -> None:
        if self._child is not None:
            self._child.end()
            self._child = None


_starting = False  # while a process is forked off here


def _leave_input() -> None:
    """Close no standard input in a process forked here: of a thread that reads it, gone in that
    process, the lock stays held, and closing would wait for it for ever."""
    if _starting:
        sys.stdin = None


if FORKS:
    os.register_at_fork(after_in_child=_leave_input)


class _LateError(Exception):
    """There is no answer yet."""


class _Child:
    """A process that answers what it is asked of a study."""

    def __init__(self, study: Study):
        self.study = study
        context = multiprocessing.get_context("fork")
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=_serve, args=(study, other, self._pipe), daemon=True)
        global _starting
        _starting = True
        with warnings.catch_warnings():
            # It computes, and asks for nothing that other threads of this process may hold.
            warnings.simplefilter("ignore", DeprecationWarning)
            try:
                self._process.start()
            finally:
                _starting = False
        other.close()

    def ask(self, what: Any, patience: float | None = None) -> tuple[str, Any]:
        """Its answer. Raises EOFError or OSError where it dies, _LateError where it does not answer
        in so many seconds."""
        self._pipe.send(what)
        if not self._pipe.poll(patience):
            raise _LateError
        answer: tuple[str, Any] = self._pipe.recv()
        return answer

    def wait(self) -> int:
        """Wait for its end: its exit status, below zero the number of a signal."""
        self._process.join()
        self._pipe.close()
        return self._process.exitcode or 0

    def end(self) -> None:
        """End it, whatever it does."""
        self._process.kill()
        self.wait()


def _answer(study: Study, what: Any) -> Any:
    return task.timed(study) if what == TIMING else task.computed(study, what)


def _end_with(other: Any) -> None:
    """End when another process does, whatever is being computed: nobody asks for it any more."""
    other.join()
    os._exit(1)


def _serve(study: Study, pipe: Connection, other: Connection) -> None:
    """Answer until nobody asks any more."""
    other.close()
    for name in ("SIGINT", "SIGHUP", "SIGQUIT"):  # the process that asks hears
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    Thread(target=_end_with, args=(multiprocessing.parent_process(),), daemon=True).start()
    with telling(lambda _: None):
        while True:
            with suppress(OSError):  # of a pipe at whose other end there is nobody any more
                try:
                    what = pipe.recv()
                except EOFError:
                    return
                try:
                    answer = "made", _answer(study, what)
                except InputError as error:
                    answer = "raised", error
                except Exception as error:  # of a function of the user's, or of a library under it
                    answer = "raised", StudyError(f"{type(error).__name__}: {error}")
                pipe.send(answer)
                continue
            return
