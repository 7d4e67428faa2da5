"""Results: rows of numbers with names, units and labels, and notes on how far to trust them."""

from __future__ import annotations

import json
import math
import numbers
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any, ClassVar, ParamSpec, Self, TypeVar

import numpy as np

from rodgen.display import Tabular
from rodgen.errors import DoubtWarning

DOUBT, REMARK, NOTES = "doubt", "remark", "notes"
DIGITS = 3, 12  # the least and the most that are printed of a value with an error
UNKNOWN = -1  # of what is neither true nor false, in a study


@dataclass(frozen=True)
class Note:
    """A sentence on a result.

    kind: "doubt" for what makes its numbers doubtful, "remark" for what else to know; text: the
    sentence; figures: the numbers that it rests on, by name, in SI units.

    Examples
    --------
    >>> import rodgen
    >>> tilted = rodgen.Scene.example("missile").replace({"loads.follower.angle": 30.0})
    >>> note = rodgen.describe(tilted).notes[0]
    >>> note.kind, round(note.figures["turns"], 1), note.to_dict()["text"] == note.text
    ('doubt', 4.8, True)
    """

    kind: str
    text: str
    figures: Mapping[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.text

    def __hash__(self) -> int:
        return hash((self.kind, self.text))

    def to_dict(self) -> dict[str, Any]:
        """Convert to plain data for JSON."""
        return {"kind": self.kind, "text": self.text, "figures": plain_data(self.figures)}


def doubt(text: str, **figures: float) -> Note:
    """Make a doubt: a note on why numbers are not to be trusted."""
    return Note(DOUBT, text, figures)


def remarks(texts: Iterable[str]) -> tuple[Note, ...]:
    """Make remarks: notes that make nothing doubtful."""
    return tuple(Note(REMARK, text) for text in texts)


@dataclass(frozen=True)
class StudyStorage:
    """How a study stores a row. usual: also where the study does not name it; dtype: of its array,
    as NumPy writes it; fill: value where nothing was found; several: how many numbers a point has,
    if several."""

    usual: bool = False
    dtype: str = "f8"
    fill: Any = math.nan
    several: int = 0


USUAL, ASKED = StudyStorage(usual=True), StudyStorage()
FLAG, WORD = StudyStorage(True, "i8", UNKNOWN), StudyStorage(True, "U12", "")


@dataclass(frozen=True)
class Row:
    """One quantity of a result.

    name: its attribute, and its key in `to_dict`; words: what it is; unit: empty if dimensionless,
    "{unit}" for that of the result; format: of a number in a table; of: function that reads it from
    a result, by default the attribute; text: function for its text where a number with its unit is
    not enough, or for several lines by name, None to leave it out of tables; along: of an array,
    what it has a value for each of, such as "mode", in whose table it is a column; kept: how a
    study stores it, None if it cannot; unknown: whole number that stands for an unknown value;
    error: attribute that is its error, which tells how many digits are printed; missing: text of
    not-a-number, if it has one.
    """

    name: str
    words: str
    unit: str = ""
    format: str = ".10g"
    of: Callable[[Any], Any] | None = None
    text: Callable[[Any], str | Mapping[str, str] | None] | None = None
    along: str = ""
    kept: StudyStorage | None = None
    unknown: int | None = None
    error: str = ""
    missing: str = ""

    def value(self, result: Any) -> Any:
        """Value of the row in a result."""
        return getattr(result, self.name) if self.of is None else self.of(result)

    def unit_in(self, result: Any) -> str:
        """Unit of the row in a result."""
        return self.unit.format(unit=getattr(result, "unit", ""))


def omit_from_tables(_: object) -> None:
    """Leave a row out of tables."""


def format_angle(angle: float) -> str:
    """Text of an angle [rad], in radians and degrees."""
    return f"{angle:.12g} rad = {math.degrees(angle):.6g} degrees"


@dataclass(frozen=True)
class ResultTable:
    """Rows of text under the names of their columns; two unnamed columns hold names and values."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @classmethod
    def of_values(cls, values: Mapping[str, str]) -> ResultTable:
        """Make a table of names and values."""
        return cls(("", ""), tuple(values.items()))

    @classmethod
    def of_rows(cls, columns: Iterable[str], rows: Iterable[Iterable[str]]) -> ResultTable:
        """Make a table with a heading."""
        return cls(tuple(columns), tuple(map(tuple, rows)))

    def __str__(self) -> str:
        lines = [self.columns, *self.rows] if any(self.columns) else [*self.rows]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        return "\n".join(
            "  ".join(cell.ljust(w) for cell, w in zip(line, widths, strict=True)).rstrip()
            for line in lines
        )


class Result(Tabular):
    """Base class of results: numbers with names, units and labels, and notes on them.

    ROWS: its quantities, in order; notes: what to know about its numbers.

    Examples
    --------
    >>> import rodgen
    >>> found = rodgen.natural_modes(rodgen.Scene.example("ziegler").replace(
    ...     {"loads.follower.force": 3.0}))
    >>> found.doubts[0].text, found.to_dict()["stable"]
    ('this state is unstable: mode 1 grows', False)
    >>> print(found.tables()[0].rows[0])
    ('stable', 'no')
    """

    ROWS: ClassVar[tuple[Row, ...]] = ()
    notes: tuple[Note, ...] = ()

    def __dir__(self) -> list[str]:
        """Names that editors complete."""
        return [name for name in super().__dir__() if name not in ("ROWS", "with_notes")]

    @property
    def doubts(self) -> tuple[Note, ...]:
        """The notes that say why its numbers are doubtful."""
        return tuple(note for note in self.notes if note.kind == DOUBT)

    def to_dict(self) -> dict[str, Any]:
        """Convert rows, by name, and notes to plain data for JSON: numbers that are not finite are
        None, complex ones [real, imaginary]."""
        made = {row.name: plain_data(row.value(self)) for row in self.ROWS}
        return made | {NOTES: [note.to_dict() for note in self.notes]}

    def with_notes(self, notes: tuple[Note, ...]) -> Self:
        """Copy with further notes.

        notes: that come after its own.
        """
        given: Any = self  # a dataclass
        made: Self = replace(given, notes=(*self.notes, *notes))
        return made

    def tables(self) -> list[ResultTable]:
        """Rows as text: a table of single values, and one for each array of them."""
        return tables(self.ROWS, self)

    def __str__(self) -> str:
        parts = [repr(self), *map(str, self.tables())]
        return "\n".join([*parts, *(f"{note.kind}: {note}" for note in self.notes)])


def plain_data(value: Any) -> Any:
    """Convert a value to what JSON can hold; a number that is not finite becomes None."""
    match value:
        case None | bool() | str():
            return value
        case np.ndarray() | np.generic():
            return plain_data(value.tolist())
        case Mapping():
            return {str(key): plain_data(one) for key, one in value.items()}
        case numbers.Integral():
            return int(value)
        case numbers.Real():
            return float(value) if math.isfinite(value) else None
        case numbers.Complex():
            return [plain_data(value.real), plain_data(value.imag)]
        case _:
            return [plain_data(one) for one in value]


def tables(rows: Iterable[Row], result: Any) -> list[ResultTable]:
    """Tables of a result: one of single values, and one for each kind of arrays, as over modes."""
    values, columns = dict[str, str](), dict[str, list[Row]]()
    for row in rows:
        if row.along:
            columns.setdefault(row.along, []).append(row)
        else:
            values |= _row_lines(row, result)
    made = [ResultTable.of_values(values)] if values else []
    return made + [_column_table(along, some, result) for along, some in columns.items()]


def _row_lines(row: Row, result: Any) -> Iterator[tuple[str, str]]:
    """Yield the name and text of a row, or of each of its values where they have names."""
    if row.text is not None:
        text = row.text(result)
        lines = text if isinstance(text, Mapping) else {} if text is None else {row.words: text}
        yield from lines.items()
        return
    value, unit = row.value(result), row.unit_in(result)
    if isinstance(value, Mapping):
        for name, one in value.items():
            yield row.words.format(name), format_value(one, row.format, unit)
    elif row.error:
        text = format_with_error(value, getattr(result, row.error))
        yield row.words, f"{text} {unit}".rstrip()
    elif row.missing and math.isnan(value):
        yield row.words, row.missing
    else:
        yield row.words, format_value(value, row.format, unit)


def format_value(value: Any, form: str, unit: str = "") -> str:
    """Text of a value with its unit."""
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    match value:
        case None:
            return "not known"
        case bool():
            return "yes" if value else "no"
        case str():
            return value
        case int():
            text = str(value)
        case numbers.Real():
            text = f"{value:{form}}"
        case numbers.Complex():
            text = f"{value.real:{form}} {value.imag:+{form}} i"
        case _:
            text = f"({', '.join(format_value(one, form) for one in value)})"
    return f"{text} {unit}" if unit else text


def format_with_error(value: float, error: float) -> str:
    """Format a value with the digits that an error leaves, twelve at most."""
    least, most = DIGITS
    if not value or not error:
        return f"{value:.{most}g}"
    known = int(np.floor(np.log10(abs(value) / error)))
    return f"{value:.{min(max(known, least), most)}g}"


def _column_table(along: str, rows: list[Row], result: Any) -> ResultTable:
    """Table with a line for each index of arrays, and a column for each row shown."""
    shown = [row for row in rows if row.text is None or row.text(result) is not None]
    numbers = "" if along in (row.words for row in shown) else along
    titles, cells = [numbers], [_to_list(row.value(result)) for row in shown]
    for row in shown:
        unit = row.unit_in(result)
        titles.append(f"{row.words} [{unit}]" if unit else row.words)
    lines = [
        (
            str(at + 1),
            *(format_value(cell, row.format) for cell, row in zip(line, shown, strict=True)),
        )
        for at, line in enumerate(zip(*cells, strict=True))
    ]
    return ResultTable.of_rows(titles, lines)


def _to_list(values: Any) -> list[Any]:
    return list(values.tolist() if isinstance(values, np.ndarray) else values)


# Warnings ---------------------------------------------------------------------------------------

# Doubts of the runs within an analysis; None outside, where runs warn of them at once.
_told: ContextVar[list[Note] | None] = ContextVar("told", default=None)
NUMBER = re.compile(r"\d+")  # that does not make one doubt another
BETWEEN = ("functools", "contextlib")  # modules through which the package calls itself
P = ParamSpec("P")
R = TypeVar("R")


def warns_of_doubts(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate an analysis to warn of each doubt about its result and about the runs within, once.
    Called within another such function, it leaves the warnings to that one."""

    @wraps(function)
    def analyse(*args: P.args, **kwargs: P.kwargs) -> R:
        if _told.get() is not None:
            return function(*args, **kwargs)
        told = list[Note]()
        try:
            with collect_doubts() as told:
                found = function(*args, **kwargs)
        except Exception:
            warn_of(told)
            raise
        whole: R = _add_doubts(found, told)
        warn_of(_doubts_of(whole))
        return whole

    return analyse


@contextmanager
def collect_doubts() -> Iterator[list[Note]]:
    """Collect the doubts of runs inside in a list, which is yielded, instead of warning of them."""
    told = list[Note]()
    token = _told.set(told)
    try:
        yield told
    finally:
        _told.reset(token)


def warn_of(notes: Iterable[Note]) -> None:
    """Warn of each doubt among notes once; within an analysis, hand them to it."""
    doubts = {note.text: note for note in notes if note.kind == DOUBT}.values()
    told = _told.get()
    if told is not None:
        told.extend(doubts)
        return
    for note in doubts:
        warnings.warn(DoubtWarning(note.text, note.figures), stacklevel=_caller_level())


def _caller_level() -> int:
    """Stack level, in the calling function, of the first caller outside the package."""
    package, level, frame = __name__.partition(".")[0], 1, sys._getframe(1)
    while frame.f_back is not None:
        name = frame.f_globals.get("__name__", "")
        if not name.startswith(f"{package}.") and name not in BETWEEN:
            break
        frame, level = frame.f_back, level + 1
    return level


def _add_doubts(found: Any, told: list[Note]) -> Any:
    """Add the doubts of the runs that led to a result or a Dataset, one of each kind."""
    kinds = {NUMBER.sub("", note.text): note for note in reversed(told)}
    if not kinds:
        return found
    if isinstance(found, Result):
        return found.with_notes(tuple(kinds.values())[::-1])
    if NOTES in getattr(found, "attrs", ()):
        notes = *notes_from(found.attrs), *tuple(kinds.values())[::-1]
        return found.assign_attrs({NOTES: notes_as_text(notes)})
    return found


def _doubts_of(found: Any) -> Iterator[Note]:
    """Yield the doubts about a result, a Dataset, or several of them."""
    if isinstance(found, list):
        for one in found:
            yield from _doubts_of(one)
    elif isinstance(found, Result):
        yield from found.doubts
    elif isinstance(known := getattr(found, "rodgen", None), Result):
        yield from known.doubts


def notes_from(attributes: Mapping[str, Any]) -> tuple[Note, ...]:
    """Read the notes among the attributes of a Dataset."""
    return tuple(Note(**one) for one in json.loads(attributes[NOTES]))


def notes_as_text(notes: Iterable[Note]) -> str:
    """Text of notes, for an attribute of a Dataset."""
    return json.dumps([note.to_dict() for note in notes])
