"""How a run ends: its status, the exceptions that carry what there is of it, and Ctrl-C."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import Any, Self

from rodgen.integrate.solution import Solution

FINISHED, FAILED, INTERRUPTED = "finished", "failed", "interrupted"


class RunError(ArithmeticError):
    """A run that could not be finished. solution: all samples up to there."""

    def __init__(self, message: str, solution: Solution):
        super().__init__(message)
        self.solution = solution

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.solution)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run. solution: all samples up to there."""

    def __init__(self, solution: Solution):
        super().__init__(solution.message)
        self.solution = solution

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.solution,)


class StepWarning(UserWarning):
    """A fixed step is beyond the stability limit of its method."""


class DeferredInterrupt:
    """Within it, Ctrl-C only leaves a note, which `look` turns into KeyboardInterrupt.

    Where Python would raise it at once, a step might be taken and its samples not. One that nobody
    looked for is raised at the end. In threads, and where the program has a handler of its own,
    nothing is changed.
    """

    def __init__(self) -> None:
        self._noted = False
        self._before: Any = None

    def __enter__(self) -> Self:
        main = threading.current_thread() is threading.main_thread()
        if main and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            self._before = signal.signal(signal.SIGINT, self._note)
        return self

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._noted = True

    def look(self) -> None:
        """Raise KeyboardInterrupt if there was one."""
        if self._noted:
            self._noted = False
            raise KeyboardInterrupt

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)
        if kind is None:
            self.look()
