"""A worker process beside the server for long computations, so that runs keep their frames.

    python -m rodgen_live.run.worker_main

It reads requests, a line of JSON each, and writes answers likewise.
"""

from __future__ import annotations

import atexit
import itertools
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
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


Told = Callable[[Answer], object]


@dataclass(frozen=True)
class PendingRequest:
    """A computation that the worker process has been asked for."""

    aside: WorkerProcess
    number: int

    def cancel(self) -> None:
        """Cancel the computation: no more answers are told."""
        self.aside.cancel(self.number)


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

    Requests may come from any thread; answers are told in one of its own.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._told: dict[int, Told] = {}
        self._process: subprocess.Popen[bytes] | None = None

    def submit(self, what: str, scene: Scene, told: Told, **more: Any) -> PendingRequest:
        """Request a computation of a scene, by its name in `worker_main.WORKS`."""
        table = scene.to_dict()
        with self._lock:
            number = next(self._numbers)
            self._told[number] = told
            self._send({"number": number, "what": what, "scene": table, "more": more})
        return PendingRequest(self, number)

    def cancel(self, number: int) -> None:
        """Cancel a request."""
        with self._lock:
            if self._told.pop(number, None) is not None:
                self._send({"number": number})

    def close(self) -> None:
        """End the process."""
        with self._lock:
            process, self._process = self._process, None
            self._told.clear()
        if process is not None:
            end_process(process)

    def _send(self, request: Mapping[str, Any]) -> None:
        if self._process is None:
            self._process = self._start()
        assert self._process.stdin is not None
        with suppress(OSError):  # it has died, which its listener will see
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()

    def _start(self) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "rodgen_live.run.worker_main"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, **ALONE},
            start_new_session=True,  # Ctrl-C is for the server, which ends it
        )
        threading.Thread(
            target=self._listen, args=(process,), name="rodgen-aside", daemon=True
        ).start()
        return process

    def _listen(self, process: subprocess.Popen[bytes]) -> None:
        """Tell the answers of a process until it ends, then refuse the requests that are left."""
        with process:
            assert process.stdout is not None
            for line in process.stdout:
                found = json.loads(line)
                self._deliver(found.pop("number"), Answer(**found))
        with self._lock:
            if self._process is not process:
                return
            self._process, lost = None, list(self._told)
        for number in lost:
            self._deliver(
                number, Answer(refused="the process that computes it has ended", last=True)
            )

    def _deliver(self, number: int, answer: Answer) -> None:
        with self._lock:
            told = self._told.pop(number, None) if answer.last else self._told.get(number)
        if told is not None:
            told(answer)


ASIDE = WorkerProcess()  # of this process
atexit.register(ASIDE.close)
