"""Points in a process of their own, each by itself: for those whose workers were killed.

    python -m rodgen.studies.alone

It reads a study and numbers of points from standard input, and writes what came out of each as
soon as it is there, so that whoever waits knows at which point it died. It ends with whoever
started it.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Sequence
from threading import Thread
from typing import IO, TYPE_CHECKING

from rodgen.errors import StudyError
from rodgen.studies.task import Arrays, computed, failed, joined

if TYPE_CHECKING:
    from rodgen.studies.study import Study

TWICE = 2
READY = "ready"


def apart(study: Study, indices: Sequence[int]) -> Arrays:
    """What comes out of points, computed one after the other in another process. A point that ends
    that process twice, where it is the first of it, is recorded as failed. Raises StudyError where
    there can be no such process."""
    found: list[Arrays] = []
    deaths = 0
    while len(found) < len(indices):
        came, status = _until_death(study, indices[len(found) :])
        found += came
        deaths = 0 if came else deaths + 1
        if deaths == TWICE:
            found.append(failed(study, f"its process was ended {by(status)}, twice and alone"))
            deaths = 0
    return joined(found)


def by(status: int) -> str:
    """What ended a process."""
    if status >= 0:
        return f"with status {status}"
    try:
        return f"by {signal.Signals(-status).name}"
    except ValueError:
        return f"by signal {-status}"


def _until_death(study: Study, indices: Sequence[int]) -> tuple[list[Arrays], int]:
    """What came out of the first of these points, until the process of all died or was done, and
    its exit status."""
    import cloudpickle

    found: list[Arrays] = []
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    # -P: the folder in which it is started may be somebody else's; nothing is imported from there.
    command = [sys.executable, "-P", "-m", "rodgen.studies.alone"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, env=environment) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            ready = False
            try:
                cloudpickle.dump((study, list(indices)), process.stdin)
                process.stdin.flush()
                ready = pickle.load(process.stdout) == READY
                found += (pickle.load(process.stdout) for _ in indices)
            except (EOFError, OSError, pickle.UnpicklingError):
                status = process.wait()
                if not ready:
                    why = f"(it ended with status {status} before its first point)"
                    raise StudyError(f"no process for points that run alone {why}") from None
                return found, status
            return found, 0
        finally:
            process.kill()


def main() -> None:
    """Compute the points that are read from standard input."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a function of the user's prints is no answer
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    study, indices = pickle.load(sys.stdin.buffer)
    Thread(target=_end_with, args=(sys.stdin.buffer,), daemon=True).start()
    _send(READY, answers)
    for index in indices:
        _send(computed(study, [index]), answers)


def _send(what: object, to: IO[bytes]) -> None:
    pickle.dump(what, to)
    to.flush()


def _end_with(pipe: IO[bytes]) -> None:
    """End when nobody holds the other end of the pipe any more."""
    while pipe.read(1):
        pass
    os._exit(1)


if __name__ == "__main__":
    main()
