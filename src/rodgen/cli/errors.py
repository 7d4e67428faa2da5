"""What a command says when it cannot go on, and the exit status that goes with it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from rodgen.scene import SceneError

DISPROVEN, BAD_INPUT, FAILED_RUN, INTERRUPTED = 1, 2, 3, 130


def fail(message: str, status: int) -> None:
    """Print one line to standard error and end with a status."""
    print(f"rodgen: {message}", file=sys.stderr)
    sys.exit(status)


@contextmanager
def reported() -> Iterator[None]:
    """Bad input ends in one line and status 2, without a traceback."""
    try:
        yield
    except SceneError as error:
        fail(str(error), BAD_INPUT)
    except MemoryError:
        fail("not enough memory for this many links and samples", BAD_INPUT)
    except KeyboardInterrupt:
        fail("interrupted", INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(1)
