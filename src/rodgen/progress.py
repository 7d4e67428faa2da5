"""What is told of work that takes long: its stages, and a bar where somebody looks on."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock, Timer, current_thread, main_thread
from time import perf_counter
from typing import Self

DERIVING, EMITTING, COMPILING = "deriving the equations", "emitting the module", "compiling"
INTEGRATING = "integrating"

PATIENCE = 1.0  # seconds without a bar

Stage = Callable[[str], None]  # is told by name what is begun

_shown = Lock()  # one bar at a time: within another, there is none


class Moment(float):
    """A time of a run [s]; stage: what is being done there, one of those above."""

    stage: str

    def __new__(cls, t: float, stage: str = INTEGRATING) -> Self:
        moment = super().__new__(cls, t)
        moment.stage = stage
        return moment


def watched() -> bool:
    """Whether somebody sees a bar: in a terminal or a notebook, not behind a pool or a server."""
    terminal = sys.stderr is not None and sys.stderr.isatty()
    alone = multiprocessing.parent_process() is None and current_thread() is main_thread()
    return (terminal or "ipykernel" in sys.modules) and alone


@contextmanager
def running(what: str, start: float, end: float) -> Iterator[Callable[[float], None]]:
    """A callback that shows how far a run from start to end has come, how fast it goes against
    real time, and what time is left; of a Moment before, what is being done."""
    first: tuple[float, float] | None = None  # a run that is resumed does not begin at the start

    def speed(at: float) -> str:
        nonlocal first
        now = perf_counter()
        first = first or (at, now)
        return f"{(at - first[0]) / (now - first[1]):.3g} s/s" if now > first[1] else ""

    def shown(at: float) -> str:
        stage = getattr(at, "stage", INTEGRATING)
        return f"t = {at:.3f} s of {end:g} s, {speed(at)}" if stage == INTEGRATING else stage

    with _bar(what, end - start, remaining=True) as show:
        yield lambda at: show(at - start, shown(at))


@contextmanager
def working(what: str, steps: int | None = None) -> Iterator[Stage]:
    """A callback that names what is done, of so many steps if their number is known."""
    done = 0

    def step(last: str) -> None:
        nonlocal done
        done += 1
        show(done, last)

    with _bar(what, steps) as show:
        yield step


@contextmanager
def _bar(
    what: str, total: float | None, remaining: bool = False
) -> Iterator[Callable[[float, str], None]]:
    """A bar that appears after a second; it then moves on a thread of its own."""
    if not watched() or not _shown.acquire(blocking=False):
        yield lambda completed, at: None
        return
    try:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        # A notebook has a line that can be written over, like a terminal.
        console = Console(stderr=True, force_terminal=True, force_jupyter=False, highlight=False)
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[at]}", markup=False),
            TimeRemainingColumn() if remaining else TimeElapsedColumn(),
        )
        bar = Progress(*columns, console=console, transient=True)
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
    finally:
        _shown.release()
