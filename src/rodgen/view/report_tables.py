"""Rows as tables of a page: columns, and how their numbers are printed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, TypeGuard

from rodgen.judge.rows import label, setting, short
from rodgen.judge.summary import duration
from rodgen.judge.unit import Row, Value

NONE = "-"


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
    show: Callable[[Value], str]


def words(value: Value) -> str:
    """Text as it is."""
    return NONE if value is None or value == "" else str(value)


def three(value: Value) -> str:
    """Three digits."""
    return short(float(value)) if _is_number(value) else words(value)


def error(value: Value) -> str:
    """Two digits and a power of ten."""
    return short(float(value), ".1e") if _is_number(value) and value else words(value)


def count(value: Value) -> str:
    """A whole number, in groups of three digits."""
    if _is_number(value) and math.isfinite(value):
        return f"{value:,.0f}".replace(",", "\u2009")
    return words(value)


def time(value: Value) -> str:
    """Seconds, in the unit that suits them."""
    return duration(float(value)) if _is_number(value) else words(value)


def percent(value: Value) -> str:
    """A fraction in percent, with its sign."""
    return f"{value:+.2%}" if _is_number(value) else words(value)


def times(value: Value) -> str:
    """How many times as much."""
    return f"{value:.3g} x" if _is_number(value) else words(value)


def _is_number(value: Value) -> TypeGuard[float | int]:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def table(caption: str, rows: Iterable[Row], columns: Sequence[Column]) -> Shown:
    """Columns that are empty in all rows are left out."""
    several = list(rows)
    kept = [c for c in columns if any(row.get(c.key) not in (None, "") for row in several)]
    body = [[cell(column, row) for column in kept] for row in several]
    return Shown(caption, [column.title for column in kept], body)


def cell(column: Column, row: Row) -> Cell:
    """An entry as it is printed."""
    value = row.get(column.key)
    kind = "number" if _is_number(value) or (value is None and column.show is not words) else "text"
    return Cell(column.show(value), kind)


def named(rows: Iterable[Row]) -> list[Row]:
    """Rows with the name of the contestant and its setting in words."""
    return [{**row, "label": label(row), "shown": setting(row)} for row in rows]
