"""Where commands print, and the bars that they show."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console

from rodgen.progress import running as progress
from rodgen.progress import working

__all__ = ["err", "out", "progress", "working"]

out = Console(highlight=False, soft_wrap=True, markup=False)
err = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)


def print_notes(notes: Iterable[str]) -> None:
    """Sentences that belong to a result, each a line."""
    for note in notes:
        out.print(f"note: {note}")
