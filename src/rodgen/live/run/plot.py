"""The plots of a live run: which rows go to the page as samples come."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np

from rodgen.arrays import Array
from rodgen.live.catalogue import KINDS, PERIODS, TURNS, Catalogue, Shown
from rodgen.live.run.curves import MOST_ROWS, Condition, Section, Window, spectrum, thin
from rodgen.live.run.plot_spec import PlotSpec, title_of
from rodgen.live.samples import Chunk

# Over time energy in gravity counts from there: else a height far from zero swamps all.
FROM_START = {"gravity_energy": "from the start", "total_energy": "with gravity from the start"}
TURNED = "time", "phase", "poincare", "profile"  # plots of angles without their whole turns
NO_JUMPS = {"period": 0.0, "turn": 0.0}
MOST_SERIES = 200  # of one plot; of more, every k-th is shown
SPECTRA = 0.25  # seconds of wall time between two
PIECE = 1024  # samples that are taken at once


class Beside(Protocol):
    """A run to compare with."""

    def values(self, names: tuple[str, ...], of: Catalogue, times: Array) -> Array:
        """Quantities of a rod at times, (N, names); not-a-number where this run has none."""


class Plot:
    """A plot and what it keeps of the run; beside: another run, which differences are from.

    `feed` with every chunk, in order; what it gives is appended. `present` when a picture is
    drawn; what it gives replaces what is there. `backlog` first, for a plot that is added to a run
    that has gone on for a while. owes: whether a spectrum is to come that was not due when
    `present` was asked. Use from one thread at a time.
    """

    def __init__(
        self, spec: PlotSpec, catalogue: Catalogue, clock: Callable[[], float] = time.monotonic
    ):
        self.beside: Beside | None = None
        self.spec, self.catalogue, self._clock = spec, catalogue, clock
        every = tuple(dict.fromkeys(name for one in spec.y for name in catalogue.expand(one)))
        # Of too many, one in so many is shown.
        self.stride = -(-len(every) // (MOST_ROWS if spec.kind == "profile" else MOST_SERIES))
        self.names = every[:: self.stride]
        self.replaces = spec.kind in ("profile", "spectrum")
        self._window = Window(spec.window)
        period = PERIODS.get(spec.when, 0.0)
        condition = Condition(spec.value, spec.direction, spec.every, period)
        self._section = Section(condition)
        self._least = {"x": catalogue.least([spec.x]), "y": catalogue.least(self.names)}
        self.reset()

    def reset(self) -> None:
        """Forget all samples, as before the first chunk."""
        self._window.reset()
        self._section.reset()
        self._before: Chunk | None = None
        self._due, self.owes = -np.inf, False
        self.first: Chunk | None = None  # sample of the run, from which energies count
        self._start = 0.0  # energy in gravity there [J]

    def feed(self, chunk: Chunk) -> Array | None:
        """Rows to append: t and what is shown at that time; or None where there are none (always
        of profile and spectrum)."""
        if not len(chunk):
            return None
        rows = self._fed(chunk)
        return rows if rows is not None and len(rows) else None

    def _fed(self, chunk: Chunk) -> Array | None:
        match self.spec.kind:
            case "time":
                return self.catalogue.columns(self._row, chunk) - self._offsets(chunk)
            case "phase":
                return self.catalogue.columns(self._row, chunk)
            case "difference":
                return self._less(self.catalogue.columns(self._row, chunk))
            case "poincare":
                joined = self._before is None or _smooth(self._before, chunk)
                self._before = chunk.last()
                return self._section.feed(self.catalogue.columns(self._row, chunk), joined)
            case "spectrum":
                self._window.feed(chunk.t, self.catalogue.columns(self.names, chunk)[:, 0])
        return None

    def _offsets(self, chunk: Chunk) -> Array:
        """What the columns of a row over time are counted from, of the first sample of the run."""
        raised = np.isin(self._row, self._raised)
        if self.first is None and raised.any():
            self._count_from(chunk.some(slice(1)))
        return np.where(raised, self._start, 0.0)

    def _count_from(self, first: Chunk) -> None:
        self.first = first
        self._start = float(self.catalogue.columns(("gravity_energy",), first)[0, 0])

    @property
    def _raised(self) -> tuple[str, ...]:
        """Quantities that are counted from the start."""
        heavy = self.spec.kind == "time" and "gravity_energy" in self.catalogue.quantities
        return tuple(FROM_START) if heavy else ()

    def _less(self, rows: Array) -> Array:
        """The rows, less those of the run beside this one; not-a-number where there is none."""
        rows[:, 1:] -= (
            self.beside.values(self.names, self.catalogue, rows[:, 0]) if self.beside else np.nan
        )
        return rows

    def present(self, chunk: Chunk, before: Iterable[Chunk] | None = None) -> Array | None:
        """Rows that replace those there, of the last sample: a profile, or a spectrum at most four
        times a second; None where there is nothing new (always of the other kinds). before: of a
        sample of the past, those that lead to it."""
        if self.spec.kind == "profile" and len(chunk):
            values = self.catalogue.columns(self.names, chunk)[-1]
            along = self.catalogue.along[self.spec.y[0]]
            return np.stack((along[:: self.stride], values), axis=1)
        if self.spec.kind == "spectrum":
            self.owes = self._clock() < self._due
            return None if self.owes else self._spectrum(before)
        return None

    def _spectrum(self, before: Iterable[Chunk] | None) -> Array | None:
        window = self._window
        if before is not None:
            window = Window(self.spec.window)
            for chunk in before:
                window.feed(chunk.t, self.catalogue.columns(self.names, chunk)[:, 0])
        period = PERIODS.get(self.names[0])
        x = np.unwrap(window.x, period=period) if period else window.x
        rows = spectrum(window.t, x)
        self._due = self._clock() + SPECTRA
        return rows if len(rows) or before is not None else None

    def backlog(self, before: Iterable[Chunk], first: Chunk | None = None) -> Array:
        """Rows of what was before the plot was there, at most 5000: of a curve those of the last
        ``window`` seconds, thinned but with its extremes, of a section the last points; and the
        present of the others. Chunks that are fed later follow these. first: the sample from which
        energies count, by default the first of all."""
        self.reset()
        chunks = [chunk for chunk in before if len(chunk)]
        if chunks and self.spec.kind == "time":
            self._offsets(first or chunks[0])
        if self.spec.kind != "poincare":
            chunks = _since(chunks, self.spec.window)
        rows = [found for chunk in _pieces(chunks) if (found := self.feed(chunk)) is not None]
        if self.replaces:
            found = self.present(chunks[-1]) if chunks else None
            return np.zeros((0, 2)) if found is None else found
        every = np.concatenate(rows) if rows else np.zeros((0, self.width))
        return every[-MOST_ROWS:] if self.spec.kind == "poincare" else thin(every)

    @property
    def width(self) -> int:
        """How many columns a row has."""
        if self.replaces:
            return 2
        unseen = self.spec.kind == "poincare"  # what reaches the value
        return len(self._row) - unseen

    @property
    def _row(self) -> tuple[str, ...]:
        """The quantities in the row of a sample."""
        match self.spec.kind:
            case "phase":
                return ("t", self.spec.x, *self.names)
            case "poincare":
                return ("t", self.spec.x, *self.names, self.spec.when)
        return ("t", *self.names)

    def to_json(self) -> dict[str, Any]:
        """What the page needs to draw it."""
        x, y = self._axes()
        plane = self.spec.kind in ("phase", "poincare")
        return {
            "id": self.spec.id,
            "kind": "time" if self.spec.kind == "difference" else self.spec.kind,
            "title": title_of(self.spec, self.catalogue) + _thinned_out(self.stride),
            "x": {
                "label": x[0],
                "unit": x[1],
                "log": self.spec.axes == "log",
                "least": self._least["x"],
                **(self._jumps(self.spec.x) if plane else NO_JUMPS),
            },
            "y": {
                "label": y[0],
                "unit": y[1],
                "log": self.spec.axes != "linear",
                "least": self._least["y"],
            },
            "series": [self._series(self.catalogue.quantities[name]) for name in self.names],
            "window": self.spec.window,
            "wrapped": self.spec.wrapped,
        }

    def _series(self, one: Shown) -> dict[str, Any]:
        """Name, label, unit of a curve, and how it jumps."""
        found = {**one._asdict(), **self._jumps(one.name)}
        if one.name in self._raised:
            words = FROM_START[one.name]
            found["name"] += f"_{words.replace(' ', '_')}"
            found["label"] += f" {words}"
        return {key: found[key] for key in ("name", "label", "unit", *NO_JUMPS)}

    def _jumps(self, name: str) -> dict[str, float]:
        """By what a quantity jumps, and the whole turn that can be taken from it."""
        turns = self.spec.kind in TURNED
        kind = self.catalogue.quantities[name].kind
        return {"period": PERIODS.get(name, 0.0), "turn": TURNS.get(kind, 0.0) * turns}

    def _axes(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Label and unit of x and y."""
        quantities = [self.catalogue.quantities[name] for name in self.names]
        units = {q.unit for q in quantities}
        kinds = {q.kind for q in quantities}
        label = KINDS[quantities[0].kind].symbol if len(kinds) == 1 else ""
        y = (quantities[0].label if len(quantities) == 1 else label, "".join(units))
        if len(units) > 1:  # no axis of one unit: the series tell
            y = ("", "")
        match self.spec.kind:
            case "phase" | "poincare":
                x = self.catalogue.quantities[self.spec.x]
                return (x.label, x.unit), y
            case "profile":
                return ("position along the rod, 0 at joint 0, 1 at the tail", ""), y
            case "spectrum":
                return ("frequency", "Hz"), (f"amplitude of {y[0]}", y[1])
            case "difference":
                y = (f"difference of {y[0]}" if y[0] else "", y[1])
        return ("t", "s"), y


def _thinned_out(stride: int) -> str:
    """Says which of the quantities are shown, where not all are."""
    teens = stride // 10 % 10 == 1
    ending = "th" if teens else {1: "st", 2: "nd", 3: "rd"}.get(stride % 10, "th")
    return f", every {stride}{ending}" if stride > 1 else ""


def _smooth(before: Chunk, after: Chunk) -> bool:
    """Whether nothing was changed, and nobody kicked the rod, between two chunks."""
    same = before.p is after.p or np.array_equal(before.p, after.p)
    return same and (before.given, before.start) == (after.given, after.start)


def _since(chunks: Sequence[Chunk], seconds: float) -> list[Chunk]:
    """The samples of the last seconds, since the run started again at the latest."""
    found: list[Chunk] = []
    for chunk in reversed(chunks):
        if found and chunk.t[-1] > found[-1].t[0]:
            break
        first = int(np.searchsorted(chunk.t, chunks[-1].t[-1] - seconds))
        if first == len(chunk):
            break
        found.append(chunk.some(slice(first, None)))
    return found[::-1]


def _pieces(chunks: Sequence[Chunk]) -> Iterator[Chunk]:
    """Samples in chunks that are not too large for what is made of them."""
    for chunk in chunks:
        for first in range(0, len(chunk), PIECE):
            yield chunk.some(slice(first, first + PIECE))
