"""Times that one looks at while working on rodgen, each beside a yardstick of the same run."""

from __future__ import annotations

import os
import platform
from importlib.metadata import version

from rich.console import Console
from rich.table import Table

from rodgen.progress import format_duration


class Times:
    """A table of times, each beside another; the ratio is what to quote, as machines drift."""

    def __init__(self, title: str):
        self.title, self.rows = title, list[tuple[str, float, str, float]]()

    def add(self, what: str, seconds: float, other: str, its: float) -> None:
        """A time [s] beside another."""
        self.rows.append((what, seconds, other, its))

    def show(self) -> None:
        """Print the table, and with what it was made."""
        table = Table(title=self.title)
        for column in ("what", "time", "beside", "its time", "ratio"):
            table.add_column(column, justify="left" if column in ("what", "beside") else "right")
        for what, seconds, other, its in self.rows:
            shown = f"{seconds / its:.3g}"
            table.add_row(what, format_duration(seconds), other, format_duration(its), shown)
        console = Console()
        console.print(table)
        versions = ", ".join(f"{p} {version(p)}" for p in ("rodgen", "sympy", "numpy", "scipy"))
        load = f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
        console.print(f"Python {platform.python_version()}, {versions}; {load}", highlight=False)
