"""Output of commands: lines, bars, tables, JSON and pictures."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from rodgen.errors import DoubtWarning
from rodgen.progress import report_stages_to, show_run, show_work
from rodgen.show.picture_settings import PictureSettings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rodgen.result import Result, ResultTable

__all__ = ["err", "out", "show_run", "show_work"]

_pictures: ContextVar[PictureSettings | None] = ContextVar("pictures", default=None)

out = Console(highlight=False, soft_wrap=True, markup=False)
err = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)


@contextmanager
def set_output(quiet: bool, as_json: bool, pictures: PictureSettings | None) -> Iterator[None]:
    """Set what is printed and drawn inside; quiet: no bars, lines and tables; as_json: standard
    output is for one JSON object, lines go to standard error; pictures: None for none."""
    token, before = _pictures.set(pictures), (out.quiet, out.stderr)
    out.quiet, out.stderr = quiet, as_json
    try:
        with report_stages_to(lambda _: None) if quiet else nullcontext():
            yield
    finally:
        _pictures.reset(token)
        out.quiet, out.stderr = before


def picture_settings() -> PictureSettings | None:
    """How pictures are written, None where none are asked for."""
    return _pictures.get()


def warn(message: str) -> None:
    """Print a warning on standard error."""
    err.print(f"rodgen: warning: {message}")


@contextmanager
def print_doubts() -> Iterator[None]:
    """Print Python's warnings of doubts on standard error, each once."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", DoubtWarning)
        otherwise, said = warnings.showwarning, set[str]()

        def show_warning(message: Warning | str, category: type[Warning], *where: Any) -> None:
            text = str(message)
            if not issubclass(category, DoubtWarning):
                otherwise(message, category, *where)
            elif text not in said:
                said.add(text)
                warn(text)

        warnings.showwarning = show_warning  # type: ignore[assignment]  # its other arguments go on
        yield


def print_json(result: Mapping[str, Any]) -> None:
    """Print a result as one JSON object."""
    print(json.dumps(result, allow_nan=False))


def print_result(title: str, found: Result, as_json: bool = False) -> None:
    """Print a result: as JSON, or its tables under a title, after its remarks. Doubts are printed
    as warnings."""
    if as_json:
        print_json(found.to_dict())
        return
    for note in found.notes:
        if note.kind == "remark":
            out.print(f"note: {note}")
    for table in found.tables():
        print_table(title, table)
        title = ""


def print_table(title: str, given: ResultTable) -> None:
    """Print a table of names and values, or of columns with numbers to the right."""
    table = Table(title=title or None, show_header=any(given.columns))
    for number, column in enumerate(given.columns):
        numbers = any(given.columns) and all(_is_number(row[number]) for row in given.rows)
        table.add_column(column, justify="right" if numbers else "left")
    for row in given.rows:
        table.add_row(*row)
    out.print(table)


def _is_number(cell: str) -> bool:
    return cell.strip("-") == "" or cell[-1].isdigit()


def write_picture(draw: Callable[[], Figure], folder: Path, name: str) -> None:
    """Draw a picture into a folder, and say so; where none are asked for, do nothing."""
    settings = picture_settings()
    if settings is None:
        return
    from rodgen.show.picture_files import save_figures

    with show_work("drawing"):
        (made,) = save_figures(((one, draw()) for one in [name]), folder, settings)
    out.print(f"Written: {made}")
