"""What commands print: lines, bars, tables, JSON, and the pictures that they write."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from rodgen.progress import running as progress
from rodgen.progress import telling, working

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rodgen.show.result_tables import ResultTable

__all__ = ["err", "out", "progress", "working"]

_pictures: ContextVar[bool] = ContextVar("pictures", default=True)

out = Console(highlight=False, soft_wrap=True, markup=False)
err = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)


@contextmanager
def printing(quiet: bool, pictures: bool) -> Iterator[None]:
    """What is printed and drawn inside: where it is to be quiet, no bars, lines and tables."""
    token, before, out.quiet = _pictures.set(pictures), out.quiet, quiet
    try:
        with telling(lambda _: None) if quiet else nullcontext():
            yield
    finally:
        _pictures.reset(token)
        out.quiet = before


def drawn() -> bool:
    """Whether pictures are asked for."""
    return _pictures.get()


def finite(option: str, value: float | None) -> float | None:
    """The value of an option; raises InputError for one that is not finite."""
    from rodgen.errors import InputError

    if value is not None and not math.isfinite(value):
        raise InputError(option, value, "a finite number")
    return value


def finite_or_none(value: float) -> float | None:
    """A number as JSON has it: None for one that is not finite."""
    return value if math.isfinite(value) else None


def warn(message: str) -> None:
    """A line on standard error; what is computed goes on."""
    err.print(f"rodgen: warning: {message}")


def print_notes(notes: Iterable[str]) -> None:
    """Sentences that belong to a result, each a line."""
    for note in notes:
        out.print(f"note: {note}")


def print_json(result: Mapping[str, Any]) -> None:
    """A result as one JSON object."""
    print(json.dumps(result, allow_nan=False))


def print_values(title: str, rows: Mapping[str, str]) -> None:
    """A table of names and values."""
    table = Table(title=title, show_header=False)
    for row in rows.items():
        table.add_row(*row)
    out.print(table)


def print_table(title: str, given: ResultTable) -> None:
    """A table of numbers, to the right of their columns."""
    table = Table(title=title)
    for column in given.columns:
        table.add_column(column, justify="right")
    for row in given.rows:
        table.add_row(*row)
    out.print(table)


def write_picture(draw: Callable[[], Figure], folder: Path, name: str) -> None:
    """Draw a picture into a folder, and say so; where none are asked for, do nothing."""
    if not drawn():
        return
    from rodgen.show.pictures import save_figures

    with working("drawing"):
        (made,) = save_figures([(name, draw())], folder)
    out.print(f"Written: {made}")
