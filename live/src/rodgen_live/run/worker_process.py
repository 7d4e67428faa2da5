"""A worker process beside the server for long computations, so that runs keep their frames.

    python -m rodgen_live.run.worker_main

It reads requests, a line of JSON each, and answers each with a line.
"""

from __future__ import annotations

import atexit
import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NamedTuple

from rodgen.scene import Scene

ENDING = 2.0  # seconds that it is given to end
# One thread a computation: others would take the processors of runs and browsers.
ALONE = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}


class Answer(NamedTuple):
    """One of the answers to a request: its value, or why it is refused; last: whether no other
    follows."""

    value: Any = None
    refused: str = ""
    last: bool = False


LOST = Answer(refused="the process that computes it has ended", last=True)
Told = Callable[[Answer], object]


class PendingRequest:
    """A computation that the worker process has been asked for; process: the one that has begun
    it."""

    is_cancelled = False
    process: subprocess.Popen[bytes] | None = None

    def __init__(self, content: dict[str, Any], told: Told):
        self.content, self.told = content, told

    def cancel(self) -> None:
        """Cancel the computation: no more answers are told."""
        self.is_cancelled = True


def end_process(process: subprocess.Popen[bytes]) -> None:
    """End a process, by force if it takes its time."""
    process.terminate()
    try:
        process.wait(ENDING)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class WorkerProcess:
    """The worker process, started with the first request, and again where it has died.

    Requests may come from any thread; a part of each is asked for in turn, in a thread of its own,
    which tells the answers.
    """

    def __init__(self) -> None:
        self._requests = queue.SimpleQueue[PendingRequest]()
        self._process: subprocess.Popen[bytes] | None = None
        self._is_closed = False
        self._thread = threading.Thread(target=self._serve, name="rodgen-aside", daemon=True)
        self._starts = threading.Lock()

    def submit(self, what: str, scene: Scene, told: Told, **more: Any) -> PendingRequest:
        """Request a computation of a scene, by its name in `worker_main.WORKS`."""
        content = {"what": what, "scene": scene.to_dict(), "more": more}
        request = PendingRequest(content, told)
        self._requests.put(request)
        with self._starts:
            if self._thread.ident is None:
                self._thread.start()
        return request

    def close(self) -> None:
        """End the process."""
        self._is_closed = True
        if self._process is not None:
            with self._process:
                end_process(self._process)

    def _serve(self) -> None:
        while not self._is_closed:
            request = self._requests.get()
            answer = None if request.is_cancelled else self._ask(request)
            if answer is None or request.is_cancelled or self._is_closed:
                continue
            request.told(answer)
            if not answer.last:
                self._requests.put(request)

    def _ask(self, request: PendingRequest) -> Answer:
        """Ask for the first part of a computation, or for the next one."""
        if self._process is None or self._process.poll() is not None:
            self._process = _start_process()
        sent = {"number": id(request)} | ({} if request.process else request.content)
        if request.process not in (None, self._process):
            return LOST
        process = request.process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        with suppress(OSError):  # it may have died, and then has no answer
            process.stdin.write(json.dumps(sent).encode() + b"\n")
            process.stdin.flush()
        if line := process.stdout.readline():
            return Answer(**json.loads(line))
        with process:
            return LOST


def _start_process() -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "rodgen_live.run.worker_main"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, **ALONE},
        start_new_session=True,  # Ctrl-C is for the server, which ends it
    )


ASIDE = WorkerProcess()  # of this process
atexit.register(ASIDE.close)
