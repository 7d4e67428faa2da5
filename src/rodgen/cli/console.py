"""Where commands print, and the progress bar of anything that takes more than a second."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

out = Console(highlight=False, soft_wrap=True, markup=False)
err = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)

PATIENCE = 1.0  # seconds without a bar


@contextmanager
def progress(what: str, start: float, end: float) -> Iterator[Callable[[float], None]]:
    """A callback that shows how far a run from start to end has come."""
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[at]}"),
        TimeRemainingColumn(),
        console=err,
        transient=True,
    )
    task = bar.add_task(what, total=end - start, at="")
    began, shown = perf_counter(), False

    def update(at: float) -> None:
        nonlocal shown
        if not shown and perf_counter() - began > PATIENCE:
            bar.start()
            shown = True
        if shown:
            bar.update(task, completed=at - start, at=f"t = {at:.3f} s of {end:g} s")

    try:
        yield update
    finally:
        if shown:
            bar.stop()
