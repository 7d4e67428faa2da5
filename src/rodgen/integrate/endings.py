"""How a run ends: its status, the exceptions that carry what there is of it."""

from __future__ import annotations

from typing import Any

from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import ChatterError, StepError

FINISHED, FAILED, INTERRUPTED = "finished", StepError.status, "interrupted"
CHATTERS = ChatterError.status
TOO_LONG = "too long"  # of a point of a study
ENDED = (FINISHED, FAILED, CHATTERS)  # and cannot be gone on with
NO_RESULT = (FAILED, CHATTERS, TOO_LONG)


def ended_by(t: float, name: str) -> str:
    """What there is to say of a run that an event has ended at a time [s]."""
    return f"ended at t = {t:.12g} s by the event {name!r}"


class RunError(ArithmeticError):
    """A run could not be finished.

    solution: all samples so far.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("missile")
    >>> rodgen.simulate(scene, max_steps=10, progress=False)  # doctest: +IGNORE_EXCEPTION_DETAIL
    Traceback (most recent call last):
    rodgen.integrate.endings.RunError: stopped at t = 0.0119 s: the budget is used up
    """

    def __init__(self, message: str, solution: Solution):
        super().__init__(message)
        self.solution = solution

    @property
    def status(self) -> str:
        """That of the solution."""
        return self.solution.status

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.solution)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run.

    solution: all samples so far.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("missile")
    >>> try:
    ...     sol = rodgen.simulate(scene, progress=False)
    ... except rodgen.Interrupted as stopped:
    ...     sol = stopped.solution
    """

    def __init__(self, solution: Solution):
        super().__init__(solution.message)
        self.solution = solution

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.solution,)


class StepWarning(UserWarning):
    """A fixed step is beyond the stability limit of its method.

    Examples
    --------
    >>> import rodgen, warnings
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("error", rodgen.StepWarning)  # such a step is refused
    ...     sol = rodgen.simulate(rodgen.Scene.example("missile"), progress=False)
    """
