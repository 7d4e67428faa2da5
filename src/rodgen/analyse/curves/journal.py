"""Journal of a command that follows curves: every step is written to a file as soon as it is taken,
so that the same command, after it was killed, can go on with the next step.

A command that goes on repeats all that it did before, which is deterministic, but reads the steps
already taken, which cost most of the time, from the journal.
"""

from __future__ import annotations

import json
from base64 import b64decode, b64encode
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple, Self
from zlib import crc32

import numpy as np

from rodgen.analyse.curves.curve import ContinuationProblem, CurvePoint, SpecialPoint
from rodgen.arrays import Array
from rodgen.loading.cache import PACKAGES, source_hash
from rodgen.result import Note

SAME = 1e-6  # by which the start of a curve may differ from that of the journal
# What steps follow from, to the bit.
SOURCES = (*PACKAGES, "rodgen.integrate", "rodgen.analyse")


@dataclass(frozen=True)
class Step:
    """A step along a curve: the point at its end, the special points and notes on the way, the
    length h of the next step, and how many changes of stability are explained but not seen yet
    (before)."""

    point: CurvePoint
    special: list[SpecialPoint]
    notes: list[Note]
    h: float
    before: int


def journal_path(file: Path) -> Path:
    """Path of the journal of a curve's file: branch.nc.steps for branch.nc."""
    return file.with_name(f"{file.name}.steps")


def identity(command: Mapping[str, Any]) -> dict[str, Any]:
    """A command with the versions of all that its steps depend on, as plain JSON data."""
    sources = {"rodgen": version("rodgen"), "sources": source_hash(*SOURCES)[:32]}
    made: dict[str, Any] = json.loads(json.dumps(dict(command) | sources))
    return made


class Journal:
    """File with the steps of a command, curve after curve, each in a line with its checksum. A line
    that a kill has cut off is ignored and overwritten."""

    def __init__(self, path: Path, command: Mapping[str, Any]):
        """command: what the steps depend on, see `identity`."""
        self.path, self.command = path, command
        self._end = 0  # of the lines that count
        self._ahead: list[JournalLine] = []  # to be taken up, last first

    @classmethod
    def read(cls, path: Path) -> Self | None:
        """Read the journal in a file; None where there is none."""
        lines = [*_read_lines(path)]
        if not lines:
            return None
        first, *ahead = lines
        made = cls(path, first.content)
        made._end, made._ahead = first.end, ahead[::-1]
        return made

    @property
    def n_unread(self) -> int:
        """Number of recorded steps that are not read yet."""
        return sum("point" in line.content for line in self._ahead)

    def begin(self, problem: ContinuationProblem, start: CurvePoint) -> None:
        """Begin the next curve. If the journal has another curve here, that and all after it is
        dropped."""
        if self._ahead:
            known = self._ahead[-1].content.get("start")
            if known is not None and _is_same_start(problem, _decode_point(known), start):
                self._take()
                return
            self._ahead = []
        self._write({"start": _encode_point(start)})

    def next_step(self) -> Step | None:
        """Read the next recorded step of this curve; None if there is none."""
        if not self._ahead or "point" not in self._ahead[-1].content:
            return None
        line = self._take()
        special = [
            SpecialPoint(
                **{**one, "u": _decode_array(one["u"]), "ways": _decode_array(one["ways"])}
            )
            for one in line["special"]
        ]
        notes = [Note(**one) for one in line["notes"]]
        return Step(_decode_point(line["point"]), special, notes, line["h"], line["before"])

    def add(self, step: Step) -> None:
        """Write a step."""
        self._ahead = []  # of a curve that ended here before
        special = [
            one._asdict() | {"u": _encode_array(one.u), "ways": _encode_array(one.ways)}
            for one in step.special
        ]
        notes = [one.to_dict() for one in step.notes]
        told = {"special": special, "notes": notes, "h": step.h, "before": step.before}
        self._write({"point": _encode_point(step.point), **told})

    def discard(self) -> None:
        """Delete the file, once all is done."""
        self.path.unlink(missing_ok=True)
        self._ahead, self._end = [], 0

    def _take(self) -> Any:
        """Read the next line, which is kept in the file from now on."""
        line = self._ahead.pop()
        self._end = line.end
        return line.content

    def _write(self, content: Mapping[str, Any]) -> None:
        """Write a line after those that are kept, and cut off all others."""
        if not self._end:  # only now, as there is something to lose
            self.path.write_bytes(_encode_line(json.dumps(self.command).encode()))
            self._end = self.path.stat().st_size
        with suppress(FileNotFoundError), self.path.open("r+b") as file:  # taken away: no loss yet
            file.truncate(self._end)
            file.seek(self._end)
            file.write(_encode_line(json.dumps(content).encode()))
            self._end = file.tell()


_journal: ContextVar[Journal | None] = ContextVar("journal", default=None)


@contextmanager
def use_journal(journal: Journal | None) -> Iterator[None]:
    """Record all curves that are followed inside in a journal, and resume them from it."""
    token = _journal.set(journal)
    try:
        yield
    finally:
        _journal.reset(token)


def current_journal() -> Journal | None:
    """The journal in use, if any."""
    return _journal.get()


class JournalLine(NamedTuple):
    """Content of a line of a journal, and the place in the file where the line ends."""

    content: Any
    end: int


def _encode_line(text: bytes) -> bytes:
    """A text as a line of the file, with its checksum."""
    return b"%08x %s\n" % (crc32(text), text)


def _read_lines(path: Path) -> Iterator[JournalLine]:
    """Read the lines of a journal up to the first that is damaged."""
    if not path.exists():
        return
    end = 0
    for line in path.read_bytes().splitlines(keepends=True):
        text = line[9:-1]
        if line != _encode_line(text):
            return
        end += len(line)
        yield JournalLine(json.loads(text), end)


def _is_same_start(problem: ContinuationProblem, a: CurvePoint, b: CurvePoint) -> bool:
    """Whether two points are the same start of a curve."""
    if len(a.u) != len(b.u):
        return False
    apart = max(problem.length(a.u - b.u), problem.length(a.tangent - b.tangent))
    return apart < SAME


def _encode_array(array: Array | None) -> list[Any] | None:
    """Encode an array of doubles without loss: its shape, and its bytes in base64."""
    if array is None:
        return None
    made = np.ascontiguousarray(array, dtype="<f8")
    return [list(made.shape), b64encode(made.tobytes()).decode()]


def _decode_array(text: list[Any] | None) -> Any:
    if text is None:
        return None
    shape, content = text
    return np.frombuffer(b64decode(content), dtype="<f8").astype(float).reshape(shape)


def _encode_point(point: CurvePoint) -> dict[str, Any]:
    made = point._asdict() | {"u": _encode_array(point.u), "tangent": _encode_array(point.tangent)}
    made["unstable"] = None if point.unstable is None else int(point.unstable)
    made["sign"] = int(point.sign)
    return made


def _decode_point(words: dict[str, Any]) -> CurvePoint:
    return CurvePoint(
        **{**words, "u": _decode_array(words["u"]), "tangent": _decode_array(words["tangent"])}
    )
