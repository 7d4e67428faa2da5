"""Rows of a table: what was measured, what was asked for, and whether it is met."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

from rich.table import Table

from rodgen.loading import BuildError


class Report:
    """A table whose rows end in a verdict."""

    def __init__(self, title: str):
        self.table = Table(title=title)
        for column in ("what", "measured", "asked", "verdict"):
            self.table.add_column(column, justify="right" if column == "measured" else "left")

    def row(self, what: str, value: float, limit: float, shown: str, asked: str) -> None:
        """A value that is met up to a limit; the verdict carries their ratio."""
        ratio = f"{value / limit:.2g} of it"
        self.table.add_row(
            what, shown, asked, f"met, {ratio}" if value <= limit else f"NOT: {ratio}"
        )

    def time(self, what: str, seconds: float, limit: float | None = None) -> None:
        """A time that may have a limit."""
        if limit is None:
            self.note(what, duration(seconds))
        else:
            self.row(what, seconds, limit, duration(seconds), f"at most {duration(limit)}")

    def note(self, what: str, shown: str, asked: str = "", verdict: str = "") -> None:
        """A row without a verdict of its own."""
        self.table.add_row(what, shown, asked, verdict)

    def agree(self, what: str, off: float, limit: float, other: str) -> bool:
        """Whether a result differs by less than the limit; a row says so where it does not."""
        if not off < limit:
            self.note(what, "not timed", verdict=f"NOT: differs from {other} by {off:.1e}")
        return off < limit

    def module(
        self, what: str, make: Callable[..., ModuleType], *arguments: Any, **named: Any
    ) -> ModuleType | None:
        """A module, or None with a row that says why there is none."""
        try:
            return make(*arguments, **named)
        except BuildError as error:
            self.note(what, "-", verdict=f"cannot be had: {str(error).splitlines()[0]}")
            return None


def duration(seconds: float) -> str:
    """A time to three digits in a unit that suits it."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.3f} us"
