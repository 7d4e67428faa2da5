"""Tables of a page: columns, cells, and how their numbers are printed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import NamedTuple

from rodgen.analyse.precision.contestant import Measurement, Value
from rodgen.analyse.precision.rows import format_short
from rodgen.progress import format_duration

NONE = "-"
Show = Callable[[Value], str]


class Cell(NamedTuple):
    """kind: text or number, by which it is aligned; mark: a class of the page's style."""

    text: str
    kind: str = "text"
    mark: str = ""
    title: str = ""  # more about it, for a pointer


class Shown(NamedTuple):
    """A table of a page; caption: what it has."""

    caption: str
    head: list[str]
    body: list[list[Cell]]


class Column(NamedTuple):
    """key: an entry of the rows; show: how it is printed."""

    key: str
    title: str
    show: Show


def words(value: Value) -> str:
    """Text as it is."""
    return NONE if value is None or value == "" else str(value)


def numeric(shown: Callable[[float], str], value: Value) -> str:
    """A number in some way, and what is none as it is."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return shown(value)
    return words(value)


def as_in(spec: str) -> Show:
    """Return the function that prints numbers by a format."""
    return partial(numeric, f"{{:{spec}}}".format)


three = partial(numeric, format_short)
error = partial(numeric, lambda value: format_short(value, ".1e") if value else words(value))
count = partial(numeric, lambda value: f"{value:,.0f}".replace(",", "\u2009"))
time = partial(numeric, format_duration)  # in the unit that suits it
percent = as_in("+.2%")  # of a fraction
times = partial(numeric, "{:.3g} x".format)


def table(caption: str, rows: Iterable[Measurement], columns: Sequence[Column]) -> Shown:
    """Columns that are empty in all rows are left out."""
    several = list(rows)
    kept = [c for c in columns if any(row.get(c.key) not in (None, "") for row in several)]
    body = [[cell(column, row) for column in kept] for row in several]
    return Shown(caption, [column.title for column in kept], body)


def cell(column: Column, row: Measurement) -> Cell:
    """An entry as it is printed."""
    value = row.get(column.key)
    text = isinstance(value, (str, bool, list)) or (value is None and column.show is words)
    return Cell(column.show(value), "text" if text else "number")
