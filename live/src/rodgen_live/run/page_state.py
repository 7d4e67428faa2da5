"""State of a page: what it has drawn of a run, and what is to be sent next."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import ModuleType
from typing import Any, Protocol

import numpy as np

from rodgen.arrays import Array
from rodgen_live.open_run import Live
from rodgen_live.panel_rows import RunStatus, row_texts
from rodgen_live.run.change_marks import ChangeMark, ChangeMarks
from rodgen_live.run.ghost import Ghost
from rodgen_live.run.message import Named, Trail, encode, ghost_array, pull_array, rod_arrays
from rodgen_live.run.plot import Plot
from rodgen_live.run.sample_curves import thin
from rodgen_live.sample_store import Chunk, SampleStore

AHEAD = 2  # messages that are sent before one is acknowledged
TEXTS = 0.2  # seconds between two of them
MOST_WAITING, LEAST = 2**18, 500  # numbers of a plot that wait for a page, rows at least
Send = Callable[[bytes], None]


class ShownRun(Protocol):
    """Interface of a run that a page shows; see LiveRun."""

    status: str
    begun: int
    repeats: bool
    live: Live
    model: ModuleType
    store: SampleStore
    marks: ChangeMarks
    plots: dict[str, Plot]
    past: Chunk | None
    ghost: Ghost | None
    keeps: bool

    @property
    def page_sample(self) -> Chunk:
        """Sample that the page looks at."""

    def run_status(self) -> RunStatus:
        """State of the run for the panel of values."""


class Connection:
    """Connection to a page: sends its messages, and knows the last that the page has drawn."""

    def __init__(self, send: Send):
        self.send, self.seen = send, 0


class PageState:
    """State of the one page that may look at a run. What it has not seen waits here, one message's
    worth: with a slow page, messages become fewer, not more.

    `attach`, `detach` and `acknowledge` come from one other thread, that of the pages; the rest is
    the run's own. Either writes attributes of its own, and reads those of the other once.
    """

    def __init__(self) -> None:
        self._page: Connection | None = None  # these two: of the thread of the pages
        self.came = 0  # how many pages have
        self._told: Connection | None = None  # the page to which the last message went
        self._frame = self._since = 0  # messages up to now, and before that page came
        self._trail = Trail()
        self._rows: dict[str, list[Array]] = {}
        self._replaced: set[str] = set()
        self._compared: set[str] = set()  # plots whose ghosts the page has not got
        self._texts: dict[str, str] = {}
        self._marks: tuple[ChangeMark, ...] | None = None  # that the page has
        self._texts_at = -np.inf
        self._dirty = True

    # The connection ----------------------------------------------------------------------------

    def attach(self, send: Send) -> None:
        """Send messages to a page from now on, the first with everything."""
        self._page = Connection(send)
        self.came += 1

    def detach(self, send: Send) -> None:
        """Send nothing more to a page that is gone."""
        if self._page is not None and self._page.send == send:
            self._page = None

    @property
    def has_page(self) -> bool:
        """Whether a page is attached."""
        return self._page is not None

    def acknowledge(self, frame: int) -> None:
        """Note that the page has drawn this message."""
        page = self._page
        if page is not None and page.seen < frame <= self._frame:
            page.seen = frame

    @property
    def is_due(self) -> bool:
        """Whether something is to be sent as soon as the page can take it."""
        page = self._page
        return page is not None and (self._dirty or page is not self._told)

    # What comes in -----------------------------------------------------------------------------

    def invalidate(self) -> None:
        """Mark texts and picture as out of date."""
        self._dirty = True
        self._texts_at = -np.inf

    def invalidate_picture(self) -> None:
        """Mark the picture as out of date."""
        self._dirty = True

    def add_samples(self, plots: Mapping[str, Plot], chunk: Chunk) -> None:
        """Add samples to the trail and the plots."""
        self._dirty = True
        self._trail.add(chunk)
        for name, plot in plots.items():
            rows = plot.feed(chunk)
            if rows is not None:
                self._queue_rows(name, rows)

    def _queue_rows(self, name: str, rows: Array) -> None:
        waiting = self._rows.setdefault(name, [])
        waiting.append(rows)
        if sum(part.size for part in waiting) > MOST_WAITING:
            rows = np.concatenate(waiting)
            self._rows[name] = [thin(rows, max(LEAST, len(rows) // 2))]

    def add_plot(self, plot: Plot, before: Iterable[Chunk]) -> None:
        """Add a plot, with rows of the samples before it."""
        name = plot.spec.id
        self._rows[name], self._dirty = [plot.backlog(before)], True
        self._replaced.add(name)
        self._compared.add(name)

    def resend_ghosts(self, plots: Iterable[str]) -> None:
        """Send the ghosts of these plots anew: the kept run is another, or there is none."""
        self._compared, self._dirty = set(plots), True

    def remove_plot(self, name: str) -> None:
        self._rows.pop(name, None)
        self._compared.discard(name)
        self._replaced.discard(name)

    def reset_run(self, plots: Mapping[str, Plot]) -> None:
        """Clear the trail and all rows, as the run has begun again with these plots."""
        self._rows, self._replaced = {}, set()
        self._trail.restart()
        for name, plot in plots.items():
            plot.reset()
            self._rows[name] = []
            self._replaced.add(name)
        self.invalidate()

    def reset_texts(self) -> None:
        """Send all texts anew."""
        self._texts = {}

    # What goes out -----------------------------------------------------------------------------

    def show(self, run: ShownRun) -> None:
        """Send a message if there is something to show and the page can take it."""
        page = self._page
        if page is not None and page is not self._told:
            self._begin_page(run)
        self._told = page
        if page is None or not self._dirty:
            return
        if self._frame - max(page.seen, self._since) >= AHEAD:
            return
        message = self._message(run, self._frame + 1)
        self._dirty = any(plot.owes for plot in run.plots.values())
        self._frame += 1
        page.send(message)

    def _begin_page(self, run: ShownRun) -> None:
        """Prepare to send everything to a page that has come."""
        self._since, self._texts, self._marks = self._frame, {}, None
        self._replaced.clear()
        self._trail.restart()
        for plot in run.plots.values():
            self.add_plot(plot, run.store.chunks())
        self.invalidate()

    def _message(self, run: ShownRun, frame: int) -> bytes:
        header: dict[str, Any] = {"frame": frame, "state": run.status, "begun": run.begun}
        header["repeats"] = run.repeats
        arrays: list[Named] = []
        if np.isfinite(run.page_sample.y[-1]).all():
            header["t"] = float(run.page_sample.t[-1])
            header["origin"], arrays = rod_arrays(run.model, run.page_sample)
            arrays.append(
                pull_array(
                    run.model, run.live.system_with_support, run.page_sample, header["origin"]
                )
            )
            if run.ghost:
                header["kept"] = run.ghost.store.span
                arrays.append(ghost_array(run.ghost.joints(header["t"]), header["origin"]))
            name = "trail!" if self._trail.anew else "trail"
            arrays.append((name, self._trail.pop(run.model, run.store).ravel()))
        header["line"] = self._timeline(run)
        now = time.perf_counter()
        if now - self._texts_at > TEXTS:
            self._texts_at = now
            header["texts"] = self._new_texts(run)
        arrays += self._plot_arrays(run)
        return encode(header, arrays)

    def _timeline(self, run: ShownRun) -> dict[str, Any]:
        """Header of the time line: its ends [s], the number of samples, the past time looked back
        at [s], if any; whether runs are kept; and all marks, if they have changed."""
        first, last = run.store.span if run.store.count else (run.page_sample.t[-1],) * 2
        past = None if run.past is None else float(run.past.t[-1])
        line: dict[str, Any] = {
            "from": float(first),
            "to": float(last),
            "count": run.store.count,
            "past": past,
            "keeps": run.keeps,
        }
        if run.marks.every != self._marks:
            self._marks = run.marks.every
            line["marks"] = self._marks
        return line

    def _new_texts(self, run: ShownRun) -> dict[str, str]:
        """Texts that have changed since the message before."""
        every = row_texts(run.live.system_with_support.scene, run.model, run.run_status())
        new = {key: text for key, text in every.items() if self._texts.get(key) != text}
        self._texts |= new
        return new

    def _plot_arrays(self, run: ShownRun) -> list[Named]:
        """Arrays of the rows of plots that wait, and of the ghosts beside them."""
        found: list[Named] = []
        for name, plot in run.plots.items():
            if name in self._compared or (run.ghost and plot.spec.kind == "profile"):
                rows = run.ghost.rows(plot, run.page_sample) if run.ghost else np.zeros(0)
                found.append((f"ghost:{name}", rows.ravel()))
        self._compared.clear()
        for name, plot in run.plots.items():
            waiting = self._rows.pop(name, [])
            present = (
                plot.current_rows(run.page_sample, _samples_before(run, plot))
                if plot.replaces
                else None
            )
            if present is not None:
                found.append((f"plot!{name}", present.ravel()))
            elif name in self._replaced:
                every = np.concatenate(waiting) if waiting else np.zeros(0)
                found.append((f"plot!{name}", every.ravel()))
            elif waiting:
                found.append((f"plot:{name}", np.concatenate(waiting).ravel()))
            self._replaced.discard(name)
        return found


def _samples_before(run: ShownRun, plot: Plot) -> Iterator[Chunk] | None:
    """Samples that lead to the one of the past which is looked at, in the window of a plot."""
    if run.past is None:
        return None
    t = float(run.past.t[-1])
    return run.store.chunks(t - plot.spec.window, t)
