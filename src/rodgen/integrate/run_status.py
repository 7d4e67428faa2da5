"""Statuses of runs, and the message of a run that an event has ended."""

from __future__ import annotations

from rodgen.integrate.stepper import ChatterError, StepError

FINISHED, FAILED, INTERRUPTED = "finished", StepError.status, "interrupted"
CHATTERS = ChatterError.status
TOO_LONG = "too long"  # of a point of a study
ENDED = (FINISHED, FAILED, CHATTERS)  # and cannot be gone on with
NO_RESULT = (FAILED, CHATTERS, TOO_LONG)


def event_message(t: float, name: str) -> str:
    """Message of a run that an event has ended at a time [s]."""
    return f"ended at t = {t:.12g} s by the event {name!r}"
