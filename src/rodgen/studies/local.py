"""Points computed in another process, so that one that kills it does not kill the study.

    python -m rodgen.studies.local

A worker without Dask forks that process, and does without it where there are no forks. A worker of
Dask, which may fork none, starts it as a program of its own, once a point has killed a worker: it
reads a study and requests from standard input. Both end with their parents.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING, Any, Self

from rodgen.errors import InputError, StudyError
from rodgen.progress import report_stages_to
from rodgen.studies import task
from rodgen.studies.specification import Texts
from rodgen.studies.store import StudyStore
from rodgen.studies.task import Arrays

if TYPE_CHECKING:
    from rodgen.studies.study import Study

# Other systems fork no process that has threads, as one with a dashboard or a notebook has.
FORKS = sys.platform == "linux"
PAYS = 15.0  # seconds of a study from which on starting workers, 1.5 s each, is worth it
SOON = 5.0  # seconds that the timing for this may take
TWICE = 2
DEAD = EOFError, OSError, pickle.UnpicklingError  # what asking a process raises that has ended
TIMING, UNKNOWN = "timing", 1.0  # seconds of a point that kills its process while it is timed


class LocalWorker:
    """Context manager of a local worker, whose process computes block after block. start: starts
    that process, by default a fork where there are any."""

    count = 1

    def __init__(self, start: Callable[[Study], _Fork | _Program] | None = None) -> None:
        self._start = start or (_Fork if FORKS else None)
        self._child: _Fork | _Program | None = None
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

    def compute(
        self, store: StudyStore, wanted: Iterator[task.Work], texts: Texts
    ) -> Iterator[Any]:
        """Compute blocks or points in their order; yields what `task.compute_work` returns."""
        for work in wanted:
            yield task.compute_work(store, work, self._compute)

    def _compute(self, study: Study, indices: Sequence[int]) -> Arrays:
        """Compute points; where one of them kills the process, each by itself."""
        found = self._ask(study, indices)
        if found is not None:
            return dict(found)
        return self.compute_each(study, indices)

    def compute_each(self, study: Study, indices: Sequence[int]) -> Arrays:
        """Compute points one after the other. One that kills a new process twice is recorded as
        failed."""
        return task.concatenate([self._compute_one(study, index) for index in indices])

    def _compute_one(self, study: Study, index: int) -> Arrays:
        deaths, status = 0, 0
        while deaths < TWICE:
            first = self._child is None
            found = self._ask(study, [index])
            if found is not None:
                return dict(found)
            deaths, status = deaths + first, self._status
        return task.failure_arrays(
            study, f"its process was ended {_describe_exit(status)}, twice and alone"
        )

    def _ask(self, study: Study, what: Any, patience: float | None = None) -> Any:
        """Return the answer of the process, None where it died. Raises what was raised in it, and
        _LateError where it does not answer in so many seconds."""
        if self._start is None:
            return _answer(study, what)
        if self._child is None or self._child.study is not study:
            self._end_child()
            self._child = self._start(study)
        try:
            kind, answer = self._child.ask(what, patience)
        except DEAD:
            self._status = self._child.wait()
            self._child = None
            return None
        if kind == "raised":
            raise answer
        return answer

    def _end_child(self) -> None:
        if self._child is not None:
            self._child.process.kill()
            self._child.wait()
            self._child = None


def compute_in_process(study: Study, indices: Sequence[int]) -> Arrays:
    """Compute points one after the other in a process of its own program. One that ends a new
    process twice is recorded as failed. Raises StudyError where no such process can be started."""
    with LocalWorker(_Program) as worker:
        return worker.compute_each(study, indices)


def _describe_exit(status: int) -> str:
    """Describe how a process ended: with a status, or by a signal."""
    if status >= 0:
        return f"with status {status}"
    try:
        return f"by {signal.Signals(-status).name}"
    except ValueError:
        return f"by signal {-status}"


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


class _Fork:
    """A forked process that computes points of a study on request."""

    def __init__(self, study: Study):
        self.study = study
        context = multiprocessing.get_context("fork")
        self._pipe, other = context.Pipe()
        self.process = context.Process(
            target=_serve_fork, args=(study, other, self._pipe), daemon=True
        )
        global _starting
        _starting = True
        with warnings.catch_warnings():
            # It computes, and asks for nothing that other threads of this process may hold.
            warnings.simplefilter("ignore", DeprecationWarning)
            try:
                self.process.start()
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
        self.process.join()
        self._pipe.close()
        return self.process.exitcode or 0


class _Program:
    """A process of its own program that computes points of a study on request."""

    def __init__(self, study: Study):
        import cloudpickle

        self.study = study
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        # -P: the folder in which it is started may be somebody else's; nothing is imported from it.
        command = [sys.executable, "-P", "-m", "rodgen.studies.local"]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, env=environment)
        try:
            self.ask(cloudpickle.dumps(study))
        except DEAD:
            why = f"(it ended with status {self.wait()} before its first point)"
            raise StudyError(f"no process for points that run alone {why}") from None

    def ask(self, what: Any, patience: float | None = None) -> tuple[str, Any]:
        """Return its answer, however long it takes. Raises what is in DEAD where it dies."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        pickle.dump(what, self.process.stdin)
        self.process.stdin.flush()
        answer: tuple[str, Any] = pickle.load(self.process.stdout)
        return answer

    def wait(self) -> int:
        """Wait for its end, and return its exit status: below zero, the number of a signal."""
        with suppress(OSError), self.process:  # its pipes are closed; of what was not sent
            pass
        return self.process.returncode


def _serve_fork(study: Study, pipe: Connection, other: Connection) -> None:
    other.close()
    _serve(study, pipe.recv, pipe.send)


def _serve(study: Study, receive: Callable[[], Any], send: Callable[[Any], None]) -> None:
    """Answer requests. This process ends with the one that asks, whatever it computes."""
    for name in ("SIGINT", "SIGHUP", "SIGQUIT"):  # the process that asks hears
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    requests = SimpleQueue[Any]()
    Thread(target=_read_to_end, args=(receive, requests), daemon=True).start()
    with report_stages_to(lambda _: None):
        while True:
            what = requests.get()
            try:
                answer = "made", _answer(study, what)
            except InputError as error:
                answer = "raised", error
            except Exception as error:  # of a function of the user's, or of a library under it
                answer = "raised", StudyError(f"{type(error).__name__}: {error}")
            with suppress(OSError):  # of a pipe at whose other end there is nobody any more
                send(answer)


def _read_to_end(receive: Callable[[], Any], requests: SimpleQueue[Any]) -> None:
    """Put requests into a queue, and end this process where there will be none any more."""
    with suppress(EOFError, OSError):
        while True:
            requests.put(receive())
    os._exit(1)


def _answer(study: Study, what: Any) -> Any:
    return task.time_point(study) if what == TIMING else task.compute_points(study, what)


def main() -> None:
    """Answer requests that are read from standard input, the first of them a study."""
    requests, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a function of the user's prints is no answer

    def send(answer: Any) -> None:
        pickle.dump(answer, answers)
        answers.flush()

    study = pickle.loads(pickle.load(requests))
    send(("made", None))
    _serve(study, partial(pickle.load, requests), send)


if __name__ == "__main__":
    main()
