"""Points computed one by one in a process of their own, after their worker was killed.

    python -m rodgen.studies.isolated

The process reads a study and numbers of points from standard input, and writes the results of each
point as soon as it is done, so that its parent knows at which point it died. It ends with its
parent.
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
from rodgen.studies.task import Arrays, compute_points, concatenate, failure_arrays

if TYPE_CHECKING:
    from rodgen.studies.study import Study

TWICE = 2
READY = "ready"


def compute_in_process(study: Study, indices: Sequence[int]) -> Arrays:
    """Compute points one after the other in another process. A point that ends that process twice,
    as the first that it computes, is recorded as failed. Raises StudyError where no such process
    can be started."""
    found: list[Arrays] = []
    deaths = 0
    while len(found) < len(indices):
        came, status = _compute_until_death(study, indices[len(found) :])
        found += came
        deaths = 0 if came else deaths + 1
        if deaths == TWICE:
            found.append(
                failure_arrays(
                    study, f"its process was ended {describe_exit(status)}, twice and alone"
                )
            )
            deaths = 0
    return concatenate(found)


def describe_exit(status: int) -> str:
    """Describe how a process ended: with a status, or by a signal."""
    if status >= 0:
        return f"with status {status}"
    try:
        return f"by {signal.Signals(-status).name}"
    except ValueError:
        return f"by signal {-status}"


def _compute_until_death(study: Study, indices: Sequence[int]) -> tuple[list[Arrays], int]:
    """Compute points until the process dies or all are done. Returns the results of those that were
    computed, and the exit status."""
    import cloudpickle

    found: list[Arrays] = []
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    # -P: the folder in which it is started may be somebody else's; nothing is imported from there.
    command = [sys.executable, "-P", "-m", "rodgen.studies.isolated"]
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
    Thread(target=_exit_at_end_of, args=(sys.stdin.buffer,), daemon=True).start()
    _send(READY, answers)
    for index in indices:
        _send(compute_points(study, [index]), answers)


def _send(what: object, to: IO[bytes]) -> None:
    pickle.dump(what, to)
    to.flush()


def _exit_at_end_of(pipe: IO[bytes]) -> None:
    """End this process when the other end of the pipe is closed."""
    while pipe.read(1):
        pass
    os._exit(1)


if __name__ == "__main__":
    main()
