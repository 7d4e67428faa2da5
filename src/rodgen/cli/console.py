"""Where commands print, and the progress bar of anything that takes more than a second."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from threading import Timer
from time import perf_counter

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

out = Console(highlight=False, soft_wrap=True, markup=False)
err = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)

PATIENCE = 1.0  # seconds without a bar


def print_notes(notes: Iterable[str]) -> None:
    """Sentences that belong to a result, each a line."""
    for note in notes:
        out.print(f"note: {note}")


@contextmanager
def progress(what: str, start: float, end: float) -> Iterator[Callable[[float], None]]:
    """A callback that shows how far a run from start to end has come, how fast it goes against
    real time, and what time is left."""
    first: tuple[float, float] | None = None  # a run that is resumed does not begin at the start

    def speed(at: float) -> str:
        nonlocal first
        now = perf_counter()
        first = first or (at, now)
        return f"{(at - first[0]) / (now - first[1]):.3g} s/s" if now > first[1] else ""

    with _bar(what, end - start, TimeRemainingColumn()) as show:
        yield lambda at: show(at - start, f"t = {at:.3f} s of {end:g} s, {speed(at)}")


@contextmanager
def working(what: str, steps: int | None = None) -> Iterator[Callable[[str], None]]:
    """A callback that names what was done last, of so many steps if their number is known."""
    done = 0

    def step(last: str) -> None:
        nonlocal done
        done += 1
        show(done, last)

    with _bar(what, steps, TimeElapsedColumn()) as show:
        yield step


@contextmanager
def _bar(
    what: str, total: float | None, clock: ProgressColumn
) -> Iterator[Callable[[float, str], None]]:
    """A bar that appears after a second; it then moves on a thread of its own."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[at]}"),
        clock,
    )
    bar = Progress(*columns, console=err, transient=True, disable=not err.is_terminal)
    task = bar.add_task(what, total=total, at="")
    timer = Timer(PATIENCE, bar.start)
    timer.daemon = True
    timer.start()
    try:
        yield lambda completed, at: bar.update(task, completed=completed, at=at)
    finally:
        timer.cancel()
        timer.join()
        if bar.live.is_started:
            bar.stop()
