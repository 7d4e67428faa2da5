"""Messages that nobody can read, from pages that are broken or strangers that try: counted, in
place of a traceback for each."""

from __future__ import annotations

import logging
import traceback
from pathlib import Path

from rodgen.live.page import guard

# Who logs what comes in: of connections, of what they carry, and of tasks that it starts.
LOGGERS = ("uvicorn.error", "engineio.server", "socketio.server", "nicegui", "asyncio")
UNREADABLE = ("Invalid HTTP request received.", "Unsupported upgrade request.")
OF_PAGES = "handle_log_message"  # logs whatever a page asks for
OWN = Path(guard.__file__).parents[2]
PASSED = guard.__file__  # through which every request comes

Place = tuple[type[BaseException], str, int | None]


class Misunderstood(logging.Filter):
    """Leaves out of a log, and counts, messages that the libraries around the page cannot read. An
    error within rodgen is told in full, but once for each place."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0
        self._told: set[Place] = set()

    def attach(self) -> None:
        """See everything that is logged of messages."""
        for name in LOGGERS:
            logging.getLogger(name).addFilter(self)

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a record is told."""
        if self._is_told(record):
            return True
        self.count += 1
        return False

    def _is_told(self, record: logging.LogRecord) -> bool:
        if not record.exc_info or record.exc_info[1] is None:
            return record.msg not in UNREADABLE and record.funcName != OF_PAGES
        place = _place(record.exc_info[1])
        if place is None or place in self._told:
            return False
        self._told.add(place)
        return True


def _place(error: BaseException) -> Place | None:
    """Where within rodgen an error was raised, or what rodgen called that raised it."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [one for one in frames if OWN in Path(one.filename).parents and one.filename != PASSED]
    return (type(error), own[-1].filename, own[-1].lineno) if own else None
