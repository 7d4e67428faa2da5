"""Error messages of commands, and their exit statuses."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

# 130 and 141 are what a shell reports for SIGINT and SIGPIPE.
DISPROVEN, BAD_INPUT, FAILED_RUN, INTERRUPTED, NO_READER = 1, 2, 3, 130, 141


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
