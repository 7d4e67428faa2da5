"""What is told of work that takes long: its stages, to a callback or in a bar."""

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
from typing import Any, Protocol, Self

DERIVING, EMITTING, COMPILING = "deriving the equations", "emitting the module", "compiling"

PATIENCE = 1.0  # seconds without a bar
TOLD = 0.1  # seconds between two messages to a notebook
FIRST, OFTEN = 10.0, 300.0  # seconds before the first line of progress; between two, at most

Tell = Callable[[str], None]  # is told by name what is begun

_told: ContextVar[Tell | None] = ContextVar("told", default=None)


def tell(stage: str) -> None:
    """Name what is begun to whoever is told of it."""
    told = _told.get()
    if told is not None:
        told(stage)


@contextmanager
def telling(told: Tell) -> Iterator[None]:
    """All that is told inside is told to this callback, and no bars are shown."""
    token = _told.set(told)
    try:
        yield
    finally:
        _told.reset(token)


@contextmanager
def working(what: str, steps: int | None = None) -> Iterator[Tell]:
    """A callback that names what was done last, of so many steps if their number is known; in a
    bar, or within the bar of other work."""
    done = 0
    if not _shows():
        yield tell
        return

    def step(last: str) -> None:
        nonlocal done
        done += 1
        bar.show(done, last)

    with _Bar(what, steps) as bar, telling(lambda stage: bar.show(done, stage)):
        yield step


@contextmanager
def running(what: str, start: float, end: float) -> Iterator[Callable[[float], None]]:
    """A callback that shows how far a run from start to end has come, how fast it goes against
    real time, and what time is left; within the bar of other work, it names the time alone."""
    first: tuple[float, float] | None = None  # a run that is resumed does not begin at the start

    def speed(at: float) -> str:
        nonlocal first
        now = perf_counter()
        first = first or (at, now)
        return f", {(at - first[0]) / (now - first[1]):.3g} s/s" if at > first[0] else ""

    def step(at: float) -> None:
        bar.show(at - start, f"t = {at:.3f} s of {end:g} s{speed(at)}")

    if not _shows():
        yield lambda at: tell(f"t = {at:.3f} s of {end:g} s")
        return
    with _Bar(what, end - start, remaining=True) as bar, telling(lambda stage: bar.show(0, stage)):
        yield step


@contextmanager
def counting(
    what: str, total: int, before: int = 0, said: Tell | None = None
) -> Iterator[Callable[[int, int], None]]:
    """A callback that is given how many points were computed, and how many of them failed; it shows
    how many there are of the total, so many of which were there before, how fast they come, and
    what time is left: in a bar, or where there is none in lines, now and then, to ``said``."""
    begun, done, failed, next_one = perf_counter(), 0, 0, FIRST

    def told(count: int, bad: int) -> tuple[str, float]:
        """What is said after so many more, and how many come in a second."""
        nonlocal done, failed
        done, failed = done + count, failed + bad
        rate = done / max(perf_counter() - begun, 1e-9)
        lost = f", {failed} failed" if failed else ""
        return f"{before + done} of {total} points, {rate:.3g} 1/s{lost}", rate

    def step(count: int, bad: int) -> None:
        bar.show(before + done + count, told(count, bad)[0])

    def line(count: int, bad: int) -> None:
        nonlocal next_one
        (text, rate), passed = told(count, bad), perf_counter() - begun
        if said is not None and rate and passed >= next_one:
            next_one = passed + min(passed, OFTEN)
            said(f"{what}: {text}, {duration((total - before - done) / rate)} left")

    if not _shows():
        yield (lambda *_: None) if said is None or _told.get() is not None else line
        return
    with _Bar(what, total, remaining=True) as bar, telling(lambda stage: bar.show(before, stage)):
        yield step


def announce(what: str, said: Tell) -> None:
    """Say what will be done where no bar shows it."""
    if not _shows() and _told.get() is None:
        said(what)


def duration(seconds: float) -> str:
    """Seconds, in the unit that suits them."""
    if not isfinite(seconds):
        return "-"
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if abs(seconds) >= 2 * size:
            return f"{seconds / size:.3g} {unit}"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if abs(seconds) >= size or size == 1e-9:
            return f"{seconds / size:.3g} {unit}"
    raise AssertionError


def _shows() -> bool:
    """Whether somebody sees a bar: in a terminal or a notebook, not behind a pool or a server, nor
    where somebody is told already."""
    terminal = sys.stderr is not None and sys.stderr.isatty()
    alone = multiprocessing.parent_process() is None and current_thread() is main_thread()
    return (terminal or _in_notebook()) and alone and _told.get() is None


def _in_notebook() -> bool:
    """Whether what is printed goes below the cell of a notebook."""
    return "ipykernel" in sys.modules


class _Bar:
    """A bar that appears after a second; it then moves on a thread of its own."""

    def __init__(self, what: str, total: float | None, remaining: bool = False):
        self._what, self._total = what, total
        self._far: dict[str, Any] = {"completed": 0.0, "at": ""}
        self._remaining = remaining
        self._drawn: _Drawn | None = None
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
        """Take it away."""
        self._timer.cancel()
        self._timer.join()
        if self._drawn is not None:
            self._drawn.stop()

    def show(self, completed: float, at: str) -> None:
        """How far it is, and what is said of it."""
        self._far = {"completed": completed, "at": at}
        if self._drawn is not None:
            self._drawn.update(**self._far)

    def _appear(self) -> None:
        kind = InNotebook if _in_notebook() else InTerminal
        self._drawn = kind(self._what, self._total, self._remaining)
        self._drawn.update(**self._far)  # what was shown meanwhile


_bars: list[_Bar] = []


def remove_bars() -> None:
    """Take away what is seen, before the program ends at once."""
    for bar in _bars:
        bar.stop()


class _Drawn(Protocol):
    """A bar that can be seen."""

    def update(self, completed: float, at: str) -> None:
        """How far it is, and what is said of it."""

    def stop(self) -> None:
        """Take it away."""


class InTerminal:
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
        """How far it is, and what is said of it."""
        self._bar.update(self._task, completed=completed, at=at)

    def stop(self) -> None:
        """Take it away."""
        self._bar.stop()


class InNotebook:
    """A bar of the browser's own below a cell, and a line of text where there is no browser."""

    def __init__(self, what: str, total: float | None, remaining: bool):
        from IPython.display import display

        self._what, self._total, self._remaining = what, total, remaining
        self._begun = self._told = perf_counter()
        self._first: float | None = None
        self._place: Any = display(self._seen(0.0, ""), raw=True, display_id=True)

    def update(self, completed: float, at: str) -> None:
        """How far it is, and what is said of it; told ten times a second at most."""
        now = perf_counter()
        if self._first is None:  # a run that is resumed does not begin at the start
            self._first = completed
        if now - self._told >= TOLD:
            self._told = now
            self._place.update(self._seen(completed, at), raw=True)

    def stop(self) -> None:
        """Take it away."""
        self._place.update({"text/plain": "", "text/html": ""}, raw=True)

    def _seen(self, completed: float, at: str) -> dict[str, str]:
        words = ", ".join(filter(None, (self._what, at, self._left(completed))))
        value = "" if self._total is None else f' max="{self._total}" value="{completed}"'
        html = f"<progress{value}></progress> {escape(words)}"
        return {"text/plain": words, "text/html": html}

    def _left(self, completed: float) -> str:
        """What time is left, where that can be told."""
        done = completed - (self._first or 0.0)
        if not (self._remaining and self._total and done > 0):
            return ""
        left = (perf_counter() - self._begun) * (self._total - completed) / done
        return f"{left:.0f} s left"
