"""State of a page: what it has drawn of a run, and what is to be sent next."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable, Iterable
from types import ModuleType
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen_live.open_run import Live
from rodgen_live.panel_rows import RunStatus, TextRow, row_groups
from rodgen_live.run import message
from rodgen_live.run.change_history import ChangeMark, ChangeMarks
from rodgen_live.run.ghost import Ghost
from rodgen_live.run.plot import Plot
from rodgen_live.run.sample_curves import thin
from rodgen_live.sample_store import Chunk, SampleStore

AHEAD = 2  # messages that are sent before one is acknowledged
TEXTS = 0.2  # seconds between two of them
MOST_WAITING = 2**18  # numbers of a plot that wait for a page
TRAIL = "trail!"  # no name of a plot
LONGEST_TRAIL = 300  # samples that wait: more between two pictures cannot be told apart
Send = Callable[[bytes], None]


class ShownRun:
    """A run that a page shows. shown: the present sample; past: the earlier one that the page looks
    back at, or None; begun: how many times it has begun at a start; repeats: whether this run is
    like the one before; keeps: whether a run is kept when another begins; ghost: the one that is
    kept; told: called when something other than the picture has changed."""

    status: str
    live: Live
    model: ModuleType
    store: SampleStore
    marks: ChangeMarks
    plots: dict[str, Plot]
    shown: Chunk
    past: Chunk | None = None
    ghost: Ghost | None = None
    keeps = repeats = False
    begun = 0
    told: Callable[[], None]

    @property
    def page_sample(self) -> Chunk:
        """Sample that the page looks at: the present, or one of the past."""
        return self.past or self.shown

    @abstractmethod
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
        self._rows: dict[str, list[Array]] = {}  # that wait, by the name of a plot, or TRAIL
        self._replaced: set[str] = set()
        self._compared: set[str] = set()  # plots whose ghosts the page has not got
        self._texts: dict[str, str] = {}
        self.groups: dict[str, list[TextRow]] = {}  # rows of the panel of values, without texts
        self._marks: tuple[ChangeMark, ...] | None = None  # that the page has
        self._texts_at = -np.inf
        self._owes_texts = False  # whether the last picture came without its texts
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

    def add_samples(self, run: ShownRun, chunk: Chunk) -> None:
        """Add samples to the trail and the plots."""
        self._dirty = True
        apart = chunk.select(slice(None, None, max(1, len(chunk) // LONGEST_TRAIL)))
        self._queue_rows(TRAIL, message.trail_points(run.model, apart), LONGEST_TRAIL)
        for name, plot in run.plots.items():
            rows = plot.feed(chunk)
            if rows is not None:
                self._queue_rows(name, rows, MOST_WAITING // rows.shape[1])

    def _queue_rows(self, name: str, rows: Array, most: int) -> None:
        """Add rows that wait; of more than so many, half are dropped."""
        waiting = self._rows.setdefault(name, [])
        waiting.append(rows)
        if sum(map(len, waiting)) > most:
            self._rows[name] = [thin(np.concatenate(waiting), most // 2)]

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

    def resend(self, run: ShownRun) -> None:
        """Send the trail and the rows of all plots anew, from the samples that are kept."""
        self._rows, self._replaced = {TRAIL: [message.trail_so_far(run.model, run.store)]}, {TRAIL}
        for plot in run.plots.values():
            self.add_plot(plot, run.store.chunks())
        self.invalidate()

    # What goes out -----------------------------------------------------------------------------

    def show(self, run: ShownRun) -> None:
        """Send a message if there is something to show and the page can take it."""
        page = self._page
        if page is not None and page is not self._told:
            self._since, self._texts, self._marks = self._frame, {}, None
            self.resend(run)
        self._told = page
        late = self._owes_texts and time.perf_counter() - self._texts_at > TEXTS
        if page is None or not (self._dirty or late):
            return
        if self._frame - max(page.seen, self._since) >= AHEAD:
            return
        sent = self._message(run, self._frame + 1)
        self._dirty = any(plot.owes for plot in run.plots.values())
        self._frame += 1
        page.send(sent)

    def _message(self, run: ShownRun, frame: int) -> bytes:
        header: dict[str, Any] = {"frame": frame, "state": run.status, "begun": run.begun}
        header |= {"repeats": run.repeats, "line": self._timeline(run)}
        arrays: list[message.Named] = []
        seen = run.page_sample
        if np.isfinite(seen.y[-1]).all():
            header["t"] = float(seen.t[-1])
            system = run.live.system_with_support
            header["origin"], arrays = message.rod_arrays(run.model, system, seen)
            arrays.append(message.pull_array(run.model, system, seen, header["origin"]))
            if run.ghost:
                header["kept"] = run.ghost.store.span
                joints = run.ghost.joints(header["t"]) - np.array(header["origin"])
                arrays.append(("ghost", message.single_precision(joints)))
            anew, places = self._pop_rows(TRAIL)
            arrays.append(("trail!" if anew else "trail", places))
        now = time.perf_counter()
        self._owes_texts = now - self._texts_at <= TEXTS
        if not self._owes_texts:
            self._texts_at = now
            header["texts"] = self._new_texts(run)
        return message.encode(header, arrays + self._plot_arrays(run))

    def _timeline(self, run: ShownRun) -> dict[str, Any]:
        """Header of the time line: its ends [s], the number of samples, the past time looked back
        at [s], if any; whether runs are kept; and all marks, if they have changed."""
        first, last = run.store.span
        past = None if run.past is None else float(run.past.t[-1])
        line: dict[str, Any] = {"from": first, "to": last, "past": past}
        line |= {"count": run.store.count, "keeps": run.keeps}
        if run.marks.every != self._marks:
            line["marks"] = self._marks = run.marks.every
        return line

    def _new_texts(self, run: ShownRun) -> dict[str, str]:
        groups, every = {}, dict[str, str]()
        for title, rows in row_groups(run.run_status()).items():
            groups[title] = [row._replace(text=None) for row in rows]
            every |= {row.key: row.text for row in rows if row.text is not None}
        if groups != self.groups:
            self.groups = groups
            run.told()
        new = {key: text for key, text in every.items() if self._texts.get(key) != text}
        self._texts |= new
        return new

    def _pop_rows(self, name: str) -> tuple[bool, Array]:
        """Take the rows that wait, one after the other, and whether they replace those before."""
        anew, waiting = name in self._replaced, self._rows.pop(name, [])
        self._replaced.discard(name)
        return anew, np.concatenate([np.zeros(0), *(part.ravel() for part in waiting)])

    def _plot_arrays(self, run: ShownRun) -> list[message.Named]:
        """Arrays of the rows of plots that wait, and of the ghosts beside them."""
        found: list[message.Named] = []
        past = None if run.past is None else float(run.past.t[-1])
        for name, plot in run.plots.items():
            if name in self._compared or (run.ghost and plot.spec.kind == "profile"):
                rows = run.ghost.rows(plot, run.page_sample) if run.ghost else np.zeros(0)
                found.append((f"ghost:{name}", rows.ravel()))
            before = None if past is None else run.store.chunks(past - plot.spec.window, past)
            present = plot.current_rows(run.page_sample, before)
            anew, rows = self._pop_rows(name)
            if present is not None:
                anew, rows = True, present.ravel()
            if anew or len(rows):
                found.append((f"plot{'!' if anew else ':'}{name}", rows))
        self._compared.clear()
        return found
