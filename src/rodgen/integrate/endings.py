"""How a run ends: its status, and what is said of it."""

from __future__ import annotations

from rodgen.integrate.stepper import ChatterError, StepError

FINISHED, FAILED, INTERRUPTED = "finished", StepError.status, "interrupted"
CHATTERS = ChatterError.status
TOO_LONG = "too long"  # of a point of a study
ENDED = (FINISHED, FAILED, CHATTERS)  # and cannot be gone on with
NO_RESULT = (FAILED, CHATTERS, TOO_LONG)


def ended_by(t: float, name: str) -> str:
    """What there is to say of a run that an event has ended at a time [s]."""
    return f"ended at t = {t:.12g} s by the event {name!r}"
