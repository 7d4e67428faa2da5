"""Log filter for unreadable messages, from broken pages or from strangers: counted, in place of a
traceback for each."""

from __future__ import annotations

import logging
import traceback
from pathlib import Path

from rodgen import errors
from rodgen_live.page import access

# Who logs what comes in: of connections, of what they carry, and of tasks that it starts.
LOGGERS = ("uvicorn.error", "engineio.server", "socketio.server", "nicegui", "asyncio")
UNREADABLE = ("Invalid HTTP request received.", "Unsupported upgrade request.")
OF_PAGES = "handle_log_message"  # logs whatever a page asks for
OWN = {Path(errors.__file__).parent, Path(access.__file__).parents[1]}  # rodgen, rodgen_live
PASSED = access.__file__  # through which every request comes

Place = tuple[type[BaseException], str, int | None]


class UnreadableFilter(logging.Filter):
    """Log filter that leaves out, and counts, messages that the libraries around the page cannot
    read. An error within rodgen is logged in full, but once for each place."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0
        self._told: set[Place] = set()

    def attach(self) -> None:
        """Add the filter to all loggers of messages."""
        for name in LOGGERS:
            logging.getLogger(name).addFilter(self)

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a record is logged; one that is not is counted."""
        error = record.exc_info[1] if record.exc_info else None
        if error is None:
            worth = record.msg not in UNREADABLE and record.funcName != OF_PAGES
        elif worth := (place := _error_place(error)) is not None and place not in self._told:
            self._told.add(place)
        self.count += not worth
        return worth


def _error_place(error: BaseException) -> Place | None:
    """Place within rodgen where an error was raised, or where rodgen called what raised it."""
    frames = traceback.extract_tb(error.__traceback__)
    names = (one for one in frames if one.filename != PASSED)
    own = [one for one in names if not OWN.isdisjoint(Path(one.filename).parents)]
    return (type(error), own[-1].filename, own[-1].lineno) if own else None
