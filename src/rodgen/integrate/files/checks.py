"""Checksums (CRC-32) by which a result file tells that it is as it was written.

One is of all that is written once: header, scene, labels. It is in the text of the run, which has
one of itself; each sample and each event has its own. Those begin from the first and the number of
the sample, so that what belongs to another file, or to another place, is not taken for it.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.files.header import Header

CHECKSUM = "checksum"  # last in a record
EVENT = "event_number", "event_time", "event_y", "event_checksum"
RUN = "run"  # the variable with the text
NUMRECS = 4  # where the number of records lies in a file, in four bytes
SEAL = b'{"checksum": "', 8  # how a sealed text begins, and digits that follow


def of_fixed(header: Header, read: Callable[[int, int], bytes]) -> int:
    """Of all before the records that does not change; read: bytes from here, so many."""
    changing = [header.variables[name] for name in (RUN, *EVENT) if name in header.variables]
    left_out = [(NUMRECS, NUMRECS + 4), *((v.begin, v.begin + v.size) for v in changing)]
    found = at = 0
    for begin, end in [*sorted(left_out), (header.start, header.start)]:
        found = zlib.crc32(read(at, begin - at), found)
        at = end
    return found


def of_records(records: NDArray[Any], first: int, fixed: int) -> NDArray[np.int32]:
    """Of records (K,), without the checksum at the end of each; first: the number of the first."""
    content, size = memoryview(records.tobytes()), records.dtype.itemsize
    found = [
        zlib.crc32(content[at : at + size - 4], fixed + first + k & 0xFFFFFFFF)
        for k, at in enumerate(range(0, len(content), size))
    ]
    return np.array(found, np.uint32).view(np.int32)


def of_event(at: int, number: int, t: Any, y: Any, fixed: int) -> np.int32:
    """Of the event in this place of the file."""
    content = b"".join(np.asarray(v, ">f8").tobytes() for v in (number, t, y))
    return np.uint32(zlib.crc32(content, fixed + at & 0xFFFFFFFF)).view(np.int32)


def unused(number: NDArray[Any], t: NDArray[Any], y: NDArray[Any], found: NDArray[Any]) -> bool:
    """Whether places for events are as they are left where there is none."""
    nothing = np.array(np.nan, ">f8").view(">i8")
    numbers = (number == -1).all() and not found.any()
    return bool(numbers and all((v.view(">i8") == nothing).all() for v in (t, y)))


def sealed(text: bytes) -> bytes:
    """A text of JSON that begins as SEAL does, with its own checksum."""
    head, digits = SEAL
    assert text.startswith(head)
    rest = text[len(head) + digits :]
    return head + b"%08x" % zlib.crc32(rest) + rest


def unharmed(text: bytes) -> bool:
    """Whether a text is as `sealed` made it."""
    return text.startswith(SEAL[0]) and text == sealed(text)
