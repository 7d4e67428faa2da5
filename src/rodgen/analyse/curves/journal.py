"""The journal of a command that follows curves: every step is in a file as soon as it is taken, so
that the same command, after it was killed, goes on with the next one.

What follows a curve is deterministic but for its steps, which cost the time: a command that goes on
does all again as it did, and takes the steps that it has taken already from the journal.
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

from rodgen.analyse.curves.curve import Point, Problem, Special
from rodgen.arrays import Array
from rodgen.loading.cache import PACKAGES, source_hash
from rodgen.result import Note

SAME = 1e-6  # by which the start of a curve may differ from that of the journal
# What steps follow from, to the bit.
SOURCES = (*PACKAGES, "rodgen.integrate", "rodgen.analyse")


@dataclass(frozen=True)
class Step:
    """A step along a curve: the point at its end, the special points and notes on the way, the
    length of the next step, and how many special points wait for the change of stability that they
    explain."""

    point: Point
    special: list[Special]
    notes: list[Note]
    h: float
    before: int


def beside(file: Path) -> Path:
    """The journal of the file of a curve: branch.nc has branch.nc.steps."""
    return file.with_name(f"{file.name}.steps")


def identity(command: Mapping[str, Any]) -> dict[str, Any]:
    """A command with all that its steps follow from, as JSON has it."""
    sources = {"rodgen": version("rodgen"), "sources": source_hash(*SOURCES)[:32]}
    made: dict[str, Any] = json.loads(json.dumps(dict(command) | sources))
    return made


class Journal:
    """The steps of a command in a file, curve after curve, each in a line with its checksum. A
    line that a kill has cut off counts for nothing, and is overwritten."""

    def __init__(self, path: Path, command: Mapping[str, Any]):
        """command: what the curves follow from, see `identity`."""
        self.path, self.command = path, command
        self._end = 0  # of the lines that count
        self._ahead: list[Line] = []  # to be taken up, last first

    @classmethod
    def read(cls, path: Path) -> Self | None:
        """The journal in a file; None where there is none."""
        lines = [*_lines(path)]
        if not lines:
            return None
        first, *ahead = lines
        made = cls(path, first.content)
        made._end, made._ahead = first.end, ahead[::-1]
        return made

    @property
    def steps(self) -> int:
        """How many steps are still to be taken up."""
        return sum("point" in line.content for line in self._ahead)

    def begin(self, problem: Problem, start: Point) -> None:
        """Begin the next curve; where another one was begun in its place, forget that and all that
        came after it."""
        if self._ahead:
            known = self._ahead[-1].content.get("start")
            if known is not None and _alike(problem, _point_of(known), start):
                self._taken()
                return
            self._ahead = []
        self._write({"start": _point_in_words(start)})

    def next(self) -> Step | None:
        """The next step of this curve that was taken already, if any."""
        if not self._ahead or "point" not in self._ahead[-1].content:
            return None
        line = self._taken()
        special = [
            Special(**{**one, "u": _array(one["u"]), "ways": _array(one["ways"])})
            for one in line["special"]
        ]
        notes = [Note(**one) for one in line["notes"]]
        return Step(_point_of(line["point"]), special, notes, line["h"], line["before"])

    def add(self, step: Step) -> None:
        """Keep a step."""
        self._ahead = []  # of a curve that ended here before
        special = [
            one._asdict() | {"u": _text(one.u), "ways": _text(one.ways)} for one in step.special
        ]
        notes = [one.to_dict() for one in step.notes]
        told = {"special": special, "notes": notes, "h": step.h, "before": step.before}
        self._write({"point": _point_in_words(step.point), **told})

    def discard(self) -> None:
        """Take the file away: all is done."""
        self.path.unlink(missing_ok=True)
        self._ahead, self._end = [], 0

    def _taken(self) -> Any:
        """What the next line says, which counts from now on."""
        line = self._ahead.pop()
        self._end = line.end
        return line.content

    def _write(self, content: Mapping[str, Any]) -> None:
        """Write a line after those that count, in place of all others."""
        if not self._end:  # only now, as there is something to lose
            self.path.write_bytes(_line(json.dumps(self.command).encode()))
            self._end = self.path.stat().st_size
        with suppress(FileNotFoundError), self.path.open("r+b") as file:  # taken away: no loss yet
            file.truncate(self._end)
            file.seek(self._end)
            file.write(_line(json.dumps(content).encode()))
            self._end = file.tell()


_journal: ContextVar[Journal | None] = ContextVar("journal", default=None)


@contextmanager
def written(journal: Journal | None) -> Iterator[None]:
    """Have all curves that are followed inside kept in a journal, and gone on with from there."""
    token = _journal.set(journal)
    try:
        yield
    finally:
        _journal.reset(token)


def current() -> Journal | None:
    """The journal of what is going on, if it has one."""
    return _journal.get()


class Line(NamedTuple):
    """What a line of a journal says, and where in the file it ends."""

    content: Any
    end: int


def _line(text: bytes) -> bytes:
    """A text as it stands in the file, with its checksum."""
    return b"%08x %s\n" % (crc32(text), text)


def _lines(path: Path) -> Iterator[Line]:
    """The lines of a journal that are whole, up to the first that is not."""
    if not path.exists():
        return
    end = 0
    for line in path.read_bytes().splitlines(keepends=True):
        text = line[9:-1]
        if line != _line(text):
            return
        end += len(line)
        yield Line(json.loads(text), end)


def _alike(problem: Problem, a: Point, b: Point) -> bool:
    """Whether two curves that begin in these points are one."""
    if len(a.u) != len(b.u):
        return False
    apart = max(problem.length(a.u - b.u), problem.length(a.tangent - b.tangent))
    return apart < SAME


def _text(array: Array | None) -> list[Any] | None:
    """An array of doubles, to the bit."""
    if array is None:
        return None
    made = np.ascontiguousarray(array, dtype="<f8")
    return [list(made.shape), b64encode(made.tobytes()).decode()]


def _array(text: list[Any] | None) -> Any:
    if text is None:
        return None
    shape, content = text
    return np.frombuffer(b64decode(content), dtype="<f8").astype(float).reshape(shape)


def _point_in_words(point: Point) -> dict[str, Any]:
    made = point._asdict() | {"u": _text(point.u), "tangent": _text(point.tangent)}
    made["unstable"] = None if point.unstable is None else int(point.unstable)
    made["sign"] = int(point.sign)
    return made | {"measures": {name: float(value) for name, value in point.measures.items()}}


def _point_of(words: dict[str, Any]) -> Point:
    return Point(**{**words, "u": _array(words["u"]), "tangent": _array(words["tangent"])})
