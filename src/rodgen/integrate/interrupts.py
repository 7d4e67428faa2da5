"""Ctrl-C during a run: held back until nothing is half done."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import Any, Self


class HeldBack:
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
