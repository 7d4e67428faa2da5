"""Faults that the tests must find: a text of the sources, what takes its place, and the tests that
are concerned, a line each in faults.txt.

A text stands once in the room it is looked for in, whatever its file is called there. `python -m
tests.mutation.seed` sows them one at a time.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple


class Fault(NamedTuple):
    room: str  # of the sources: a folder below the package
    right: str
    wrong: str
    tests: str  # files and folders below tests/, in words


def _parse(row: str) -> Fault:
    room, _, rest = row.partition(": ")
    texts, _, tests = rest.replace("\\n", "\n").rpartition(" @ ")
    right, _, wrong = texts.partition(" => ")
    return Fault(room, right, wrong, tests)


ROWS = Path(__file__).with_name("faults.txt").read_text(encoding="utf-8").splitlines()
FAULTS = tuple(_parse(row) for row in ROWS if row and not row.startswith("#"))
