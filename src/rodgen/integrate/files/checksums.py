"""Checksums (CRC-32) of a result file, and the text in it on how its run goes.

One checksum is of all that is written once: header, scene, labels. It is in the text of the run,
which has one of itself; each sample and each event has its own. These begin from the first one and
the number of the sample, so that a sample of another file, or of another place, is not taken for
it.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError
from rodgen.integrate.files.netcdf import NUMRECS, PAGE, Header
from rodgen.integrate.stepper import Stats
from rodgen.result import REMARK, Note

CHECKSUM = "checksum"  # last in a record
EVENT = "event_number", "event_time", "event_y", "event_checksum"
RUN = "run"  # the variable with the text
SEAL = b'{"checksum": "', 8  # how a sealed text begins, and digits that follow
RUNNING = "running"  # status in a file whose run has not ended
NO_STATS = Stats()


def checksum_of_header(header: Header, read: Callable[[int, int], bytes]) -> int:
    """Checksum of what does not change before the records; read: bytes from here, so many."""
    changing = [header.variables[name] for name in (RUN, *EVENT) if name in header.variables]
    left_out = [(NUMRECS, NUMRECS + 4), *((v.begin, v.begin + v.size) for v in changing)]
    found = at = 0
    for begin, end in [*sorted(left_out), (header.start, header.start)]:
        found = zlib.crc32(read(at, begin - at), found)
        at = end
    return found


def checksums_of_records(records: NDArray[Any], first: int, fixed: int) -> NDArray[np.int32]:
    """Checksums of records (K,), which end in room for them; first: the number of the first."""
    content, size = memoryview(records.tobytes()), records.dtype.itemsize
    found = [
        zlib.crc32(content[at : at + size - 4], fixed + first + k & 0xFFFFFFFF)
        for k, at in enumerate(range(0, len(content), size))
    ]
    return np.array(found, np.uint32).view(np.int32)


def checksum_of_event(at: int, number: int, t: Any, y: Any, fixed: int) -> np.int32:
    """Checksum of the event in this place of the file."""
    content = b"".join(np.asarray(v, ">f8").tobytes() for v in (number, t, y))
    return np.uint32(zlib.crc32(content, fixed + at & 0xFFFFFFFF)).view(np.int32)


def is_empty(number: NDArray[Any], t: NDArray[Any], y: NDArray[Any], found: NDArray[Any]) -> bool:
    """Whether places for events are empty, as a new file has them."""
    nothing = np.array(np.nan, ">f8").view(">i8")
    numbers = (number == -1).all() and not found.any()
    return bool(numbers and all((v.view(">i8") == nothing).all() for v in (t, y)))


def seal(text: bytes) -> bytes:
    """Put the checksum of a text of JSON that begins as SEAL does into it."""
    head, digits = SEAL
    assert text.startswith(head)
    rest = text[len(head) + digits :]
    return head + b"%08x" % zlib.crc32(rest) + rest


def is_intact(text: bytes) -> bool:
    """Whether a text has the checksum that `seal` gave it."""
    return text.startswith(SEAL[0]) and text == seal(text)


LEFT_OUT = "a file has no room for the other notes of the run"


class RunState(NamedTuple):
    """State of a run as its file tells it. lost: events for which the file had no room; samples,
    events: how many of them count; fixed: checksum of what in the file does not change."""

    status: str = RUNNING
    message: str = ""
    stats: Stats | None = None
    lost: int = 0
    samples: int = 0
    events: int = 0
    fixed: int = 0
    notes: tuple[Note, ...] = ()

    def text(self) -> bytes:
        """Encode it as PAGE bytes of JSON with a checksum; where they are too few, notes are left
        out, the last first, and a message is cut."""
        run = {"checksum": "0" * SEAL[1], **self._asdict()}
        run["stats"] = self.stats and asdict(self.stats)
        run["notes"] = notes = [note.to_dict() for note in self.notes]
        message = self.message
        while len(text := json.dumps({**run, "message": message}).encode()) > PAGE:
            if len(notes) > 1:
                notes[-2:] = [Note(REMARK, LEFT_OUT).to_dict()]
                continue
            if not message:
                raise ValueError(f"{len(text)} bytes of status and stats, more than {PAGE}")
            # In JSON a character needs 12 bytes at most.
            message = message[: -max(1, (len(text) - PAGE) // 12)]
        return seal(text.ljust(PAGE))

    @classmethod
    def of(cls, text: bytes, path: Path) -> RunState:
        """Decode what `text` made; raises InputError for other text, in the file at path."""
        if not is_intact(text):
            raise InputError("file", str(path), "as it was written (damaged: how the run went)")
        run = json.loads(text)
        run["stats"] = run["stats"] and Stats(**run["stats"])
        run["notes"] = tuple(Note(**one) for one in run["notes"])
        return cls(**{name: run[name] for name in cls._fields})
