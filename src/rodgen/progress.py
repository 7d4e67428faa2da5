"""Progress of long work: its stages, reported to a callback or shown in a bar."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from html import escape
from math import isfinite
from threading import Timer, current_thread, main_thread
from time import perf_counter
from typing import Any, Self

DERIVING, EMITTING, COMPILING = "deriving the equations", "emitting the module", "compiling"

PATIENCE = 1.0  # seconds without a bar
TOLD = 0.1  # seconds between two messages to a notebook
FIRST, OFTEN = 10.0, 300.0  # seconds before the first line of progress; between two, at most

Tell = Callable[[str], None]  # is told by name what is begun

_told: ContextVar[Tell | None] = ContextVar("told", default=None)


def report_stage(stage: str) -> None:
    """Report the stage that begins to the current callback, if there is one."""
    told = _told.get()
    if told is not None:
        told(stage)


@contextmanager
def report_stages_to(told: Tell) -> Iterator[None]:
    """Report all stages inside to this callback, and show no bars."""
    token = _told.set(told)
    try:
        yield
    finally:
        _told.reset(token)


@contextmanager
def show_work(what: str, steps: int | None = None) -> Iterator[Tell]:
    """Show a bar of work; yields a callback that names the step just done. steps: how many there
    are, if known. Within the bar of other work it reports the stage there."""
    done = 0
    if not _can_show_bar():
        yield report_stage
        return

    def step(last: str) -> None:
        nonlocal done
        done += 1
        bar.show(done, last)

    with _Bar(what, steps) as bar, report_stages_to(lambda stage: bar.show(done, stage)):
        yield step


@contextmanager
def show_run(what: str, start: float, end: float) -> Iterator[Callable[[float], None]]:
    """Show a bar of a run from start to end; yields a callback that takes the time reached. The bar
    shows the speed against real time and the time left; within other work, the time alone."""
    first: tuple[float, float] | None = None  # a run that is resumed does not begin at the start

    def speed_text(at: float) -> str:
        nonlocal first
        now = perf_counter()
        first = first or (at, now)
        return f", {(at - first[0]) / (now - first[1]):.3g} s/s" if at > first[0] else ""

    def step(at: float) -> None:
        bar.show(at - start, f"t = {at:.3f} s of {end:g} s{speed_text(at)}")

    if not _can_show_bar():
        yield lambda at: report_stage(f"t = {at:.3f} s of {end:g} s")
        return
    with (
        _Bar(what, end - start, remaining=True) as bar,
        report_stages_to(lambda stage: bar.show(0, stage)),
    ):
        yield step


@contextmanager
def show_count(
    what: str, total: int, before: int = 0, said: Tell | None = None
) -> Iterator[Callable[[int, int], None]]:
    """Show how many points are computed; yields a callback that takes the numbers of new points and
    of failed ones among them. Count, rate and time left go to a bar, or without one, now and then,
    as lines to ``said``. total: of all points; before: how many there were at first."""
    begun, done, failed, next_one = perf_counter(), 0, 0, FIRST

    def add(count: int, bad: int) -> tuple[str, float]:
        """Add to the counts; returns the line that reports them, and the points per second."""
        nonlocal done, failed
        done, failed = done + count, failed + bad
        rate = done / max(perf_counter() - begun, 1e-9)
        lost = f", {failed} failed" if failed else ""
        return f"{before + done} of {total} points, {rate:.3g} 1/s{lost}", rate

    def step(count: int, bad: int) -> None:
        bar.show(before + done + count, add(count, bad)[0])

    def print_line(count: int, bad: int) -> None:
        nonlocal next_one
        (text, rate), passed = add(count, bad), perf_counter() - begun
        if said is not None and rate and passed >= next_one:
            next_one = passed + min(passed, OFTEN)
            said(f"{what}: {text}, {format_duration((total - before - done) / rate)} left")

    if not _can_show_bar():
        yield (lambda *_: None) if said is None or _told.get() is not None else print_line
        return
    with (
        _Bar(what, total, remaining=True) as bar,
        report_stages_to(lambda stage: bar.show(before, stage)),
    ):
        yield step


def announce(what: str, said: Tell) -> None:
    """Say what will be done, if neither a bar nor a callback will."""
    if not _can_show_bar() and _told.get() is None:
        said(what)


def format_duration(seconds: float) -> str:
    """Text of a duration [s] in a suitable unit, from ns to days."""
    if not isfinite(seconds):
        return "-"
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if abs(seconds) >= 2 * size:
            return f"{seconds / size:.3g} {unit}"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if abs(seconds) >= size or size == 1e-9:
            return f"{seconds / size:.3g} {unit}"
    raise AssertionError


def _can_show_bar() -> bool:
    """Whether a bar would be seen: in a terminal or a notebook, on the main thread of the first
    process, and where no callback takes its place."""
    terminal = sys.stderr is not None and sys.stderr.isatty()
    alone = multiprocessing.parent_process() is None and current_thread() is main_thread()
    return (terminal or _is_notebook()) and alone and _told.get() is None


def _is_notebook() -> bool:
    """Whether the process is the kernel of a notebook."""
    return "ipykernel" in sys.modules


class _Bar:
    """Progress bar that appears after a second, and then moves on a thread of its own."""

    def __init__(self, what: str, total: float | None, remaining: bool = False):
        self._what, self._total = what, total
        self._far: dict[str, Any] = {"completed": 0.0, "at": ""}
        self._remaining = remaining
        self._drawn: TerminalBar | NotebookBar | None = None
        self._timer = Timer(PATIENCE, self._appear)
        self._timer.daemon = True

    def __enter__(self) -> Self:
        _bars.append(self)
        self._timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        _bars.remove(self)

    def stop(self) -> None:
        """Remove the bar."""
        self._timer.cancel()
        self._timer.join()
        if self._drawn is not None:
            self._drawn.stop()

    def show(self, completed: float, at: str) -> None:
        """Set how much is completed, and the text beside the bar."""
        self._far = {"completed": completed, "at": at}
        if self._drawn is not None:
            self._drawn.update(**self._far)

    def _appear(self) -> None:
        kind = NotebookBar if _is_notebook() else TerminalBar
        self._drawn = kind(self._what, self._total, self._remaining)
        self._drawn.update(**self._far)  # what was shown meanwhile


_bars: list[_Bar] = []


def remove_bars() -> None:
    """Remove all visible bars, before the program ends at once."""
    for bar in _bars:
        bar.stop()


class TerminalBar:
    """A bar in a line of standard error."""

    def __init__(self, what: str, total: float | None, remaining: bool):
        from rich import progress as rich  # only where something takes long
        from rich.console import Console

        console = Console(stderr=True, force_terminal=True, highlight=False)
        columns = (
            rich.TextColumn("{task.description}", markup=False),
            rich.BarColumn(),
            rich.TextColumn("{task.fields[at]}", markup=False),
            rich.TimeRemainingColumn() if remaining else rich.TimeElapsedColumn(),
        )
        self._bar = rich.Progress(*columns, console=console, transient=True)
        self._task = self._bar.add_task(what, total=total, at="")
        self._bar.start()

    def update(self, completed: float, at: str) -> None:
        """Set how much is completed, and the text beside the bar."""
        self._bar.update(self._task, completed=completed, at=at)

    def stop(self) -> None:
        """Remove the bar."""
        self._bar.stop()


class NotebookBar:
    """HTML progress bar below a cell, and a line of text where there is no browser."""

    def __init__(self, what: str, total: float | None, remaining: bool):
        from IPython.display import display

        self._what, self._total, self._remaining = what, total, remaining
        self._begun = self._told = perf_counter()
        self._first: float | None = None
        self._place: Any = display(self._display_data(0.0, ""), raw=True, display_id=True)

    def update(self, completed: float, at: str) -> None:
        """Set how much is completed, and the text; sent ten times a second at most."""
        now = perf_counter()
        if self._first is None:  # a run that is resumed does not begin at the start
            self._first = completed
        if now - self._told >= TOLD:
            self._told = now
            self._place.update(self._display_data(completed, at), raw=True)

    def stop(self) -> None:
        """Remove the bar."""
        self._place.update({"text/plain": "", "text/html": ""}, raw=True)

    def _display_data(self, completed: float, at: str) -> dict[str, str]:
        words = ", ".join(filter(None, (self._what, at, self._time_left(completed))))
        value = "" if self._total is None else f' max="{self._total}" value="{completed}"'
        html = f"<progress{value}></progress> {escape(words)}"
        return {"text/plain": words, "text/html": html}

    def _time_left(self, completed: float) -> str:
        """Text of the time left; empty where it is not known."""
        done = completed - (self._first or 0.0)
        if not (self._remaining and self._total and done > 0):
            return ""
        left = (perf_counter() - self._begun) * (self._total - completed) / done
        return f"{left:.0f} s left"
