"""Local worker without Dask: a forked process, so that a point that kills it does not kill the
study; this process itself where there are no forks."""

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
from rodgen.progress import report_stages_to
from rodgen.studies import task
from rodgen.studies.isolated import TWICE, describe_exit
from rodgen.studies.store import StudyStore
from rodgen.studies.task import Arrays, BlockOutcome

if TYPE_CHECKING:
    from rodgen.studies.study import Study

Texts = dict[tuple[str, ...], str]
# Other systems fork no process that has threads, as one with a dashboard or a notebook has.
FORKS = sys.platform == "linux"
PAYS = 15.0  # seconds of a study from which on starting workers, 1.5 s each, is worth it
SOON = 5.0  # seconds that the timing for this may take
TIMING, UNKNOWN = "timing", 1.0  # seconds of a point that kills its process while it is timed


class LocalWorker:
    """Context manager of a local worker, whose forked process computes block after block."""

    count = 1

    def __init__(self) -> None:
        self._child: _Child | None = None
        self._status = 0  # of the last one that died
        self._each: float | None = None  # seconds of a point, once they are known

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: Any) -> None:
        self._end_child()

    def time_point(self, study: Study) -> tuple[float, Texts]:
        """Return the time of a point [s], and no texts."""
        return self._measure(study) if self._each is None else self._each, {}

    def is_enough(self, study: Study) -> bool:
        """Whether a study is so short that more processes are not worth their start."""
        if not FORKS:  # nothing ends a point here that takes long
            return False
        try:
            return study.count * self._measure(study, SOON) < PAYS
        except _LateError:
            return False

    def _measure(self, study: Study, patience: float | None = None) -> float:
        found = self._ask(study, TIMING, patience)
        self._each = UNKNOWN if found is None else float(found)
        return self._each

    def compute_blocks(
        self, store: StudyStore, blocks: Iterator[int], texts: Texts
    ) -> Iterator[BlockOutcome]:
        """Compute blocks in their order."""
        for block in blocks:
            indices = store.layout.indices(block)
            if store.is_done(block):
                yield BlockOutcome(block, len(indices), 0)
            else:
                yield task.write_block(store, block, self._compute(store.study, indices))

    def compute_points(
        self, store: StudyStore, pieces: Iterator[list[int]], texts: Texts
    ) -> Iterator[tuple[list[int], Arrays]]:
        """Compute points that are no blocks, without writing them."""
        for piece in pieces:
            yield piece, self._compute(store.study, piece)

    def _compute(self, study: Study, indices: Sequence[int]) -> Arrays:
        """Compute points; where one of them kills the process, each by itself."""
        found = self._ask(study, indices)
        if found is not None:
            return dict(found)
        return task.concatenate([self._compute_one(study, index) for index in indices])

    def _compute_one(self, study: Study, index: int) -> Arrays:
        """Compute one point, which is recorded as failed if it kills a new process twice."""
        deaths, status = 0, 0
        while deaths < TWICE:
            first = self._child is None
            found = self._ask(study, [index])
            if found is not None:
                return dict(found)
            deaths, status = deaths + first, self._status
        return task.failure_arrays(
            study, f"its process was ended {describe_exit(status)}, twice and alone"
        )

    def _ask(self, study: Study, what: Any, patience: float | None = None) -> Any:
        """Return the answer of the process, None where it died. Raises what was raised in it, and
        _LateError where it does not answer in so many seconds."""
        if not FORKS:
            return _answer(study, what)
        if self._child is None or self._child.study is not study:
            self._end_child()
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

    def _end_child(self) -> None:
        if self._child is not None:
            self._child.kill()
            self._child = None


_starting = False  # while a process is forked off here


def _drop_input() -> None:
    """Drop standard input in a process forked here: the lock of a thread that read it stays held
    though the thread is gone, and closing would wait for it for ever."""
    if _starting:
        sys.stdin = None


if FORKS:
    os.register_at_fork(after_in_child=_drop_input)


class _LateError(Exception):
    """No answer within the time allowed."""


class _Child:
    """A forked process that computes points of a study on request."""

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
        """Return its answer. Raises EOFError or OSError where it dies, _LateError where it does not
        answer in so many seconds."""
        self._pipe.send(what)
        if not self._pipe.poll(patience):
            raise _LateError
        answer: tuple[str, Any] = self._pipe.recv()
        return answer

    def wait(self) -> int:
        """Wait for its end, and return its exit status: below zero, the number of a signal."""
        self._process.join()
        self._pipe.close()
        return self._process.exitcode or 0

    def kill(self) -> None:
        """Kill it, whatever it computes."""
        self._process.kill()
        self.wait()


def _answer(study: Study, what: Any) -> Any:
    return task.time_point(study) if what == TIMING else task.compute_points(study, what)


def _exit_with_process(other: Any) -> None:
    """End this process when another one ends, whatever it computes."""
    other.join()
    os._exit(1)


def _serve(study: Study, pipe: Connection, other: Connection) -> None:
    """Answer requests until the pipe is closed."""
    other.close()
    for name in ("SIGINT", "SIGHUP", "SIGQUIT"):  # the process that asks hears
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    Thread(target=_exit_with_process, args=(multiprocessing.parent_process(),), daemon=True).start()
    with report_stages_to(lambda _: None):
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
