"""What commands print: lines, bars, tables, JSON, and the pictures that they write."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from rodgen.progress import running as progress
from rodgen.progress import working

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["err", "out", "progress", "working"]

out = Console(highlight=False, soft_wrap=True, markup=False)
err = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)


def finite(option: str, value: float | None) -> float | None:
    """The value of an option; raises SceneError for one that is not finite."""
    from rodgen.scene import SceneError

    if value is not None and not math.isfinite(value):
        raise SceneError(option, value, "a finite number")
    return value


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


def write_picture(draw: Callable[[], Figure], folder: Path, name: str) -> None:
    """Draw a picture into a folder, and say so."""
    from rodgen.show.pictures import save_figures

    with working("drawing"):
        (made,) = save_figures([(name, draw())], folder)
    out.print(f"Written: {made}")
