"""Plots of a live run: the rows that go to the page as samples come."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np

from rodgen.arrays import Array
from rodgen_live.plot_quantities import KINDS, PERIODS, TURNS, Catalogue, PlotQuantity
from rodgen_live.run.plot_spec import PlotSpec, title_of
from rodgen_live.run.sample_curves import (
    MOST_ROWS,
    PoincareSection,
    SectionCondition,
    Window,
    spectrum,
    thin,
)
from rodgen_live.sample_store import Chunk

# Over time energy in gravity counts from there: else a height far from zero swamps all.
FROM_START = {"gravity_energy": "from the start", "total_energy": "with gravity from the start"}
TURNED = "time", "phase", "poincare", "profile"  # plots of angles without their whole turns
NO_JUMPS = {"period": 0.0, "turn": 0.0}
MOST_SERIES = 200  # of one plot; of more, every k-th is shown
SPECTRA = 0.25  # seconds of wall time between two
PIECE = 1024  # samples that are taken at once


class ReferenceRun(Protocol):
    """Interface of a run to compare with."""

    def values(self, names: tuple[str, ...], of: Catalogue, times: Array) -> Array:
        """Values of quantities at times, (N, names); not-a-number where this run has none."""


class Plot:
    """A plot and what it keeps of the run; beside: another run, which differences are from.

    `feed` takes every chunk, in order, and gives rows to append. `current_rows` gives rows that
    replace those on the page, when a picture is drawn. `backlog` comes first, for a plot that is
    added to a run that has gone on for a while. owes: whether a spectrum is to come that was not
    due when `current_rows` was called. Use from one thread at a time.
    """

    def __init__(
        self, spec: PlotSpec, catalogue: Catalogue, clock: Callable[[], float] = time.monotonic
    ):
        self.beside: ReferenceRun | None = None
        self.spec, self.catalogue, self._clock = spec, catalogue, clock
        every = tuple(dict.fromkeys(name for one in spec.y for name in catalogue.expand(one)))
        # Of too many, one in so many is shown.
        self.stride = -(-len(every) // (MOST_ROWS if spec.kind == "profile" else MOST_SERIES))
        self.names = every[:: self.stride]
        self.replaces = spec.kind in ("profile", "spectrum")
        self._window = Window(spec.window)
        period = PERIODS.get(spec.when, 0.0)
        condition = SectionCondition(spec.value, spec.direction, spec.every, period)
        self._section = PoincareSection(condition)
        self._least = {"x": catalogue.error_level([spec.x]), "y": catalogue.error_level(self.names)}
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
        """Take up a chunk; returns rows to append, of t and the values at that time, or None where
        there are none (always of profile and spectrum)."""
        if not len(chunk):
            return None
        rows = self._new_rows(chunk)
        return rows if rows is not None and len(rows) else None

    def _new_rows(self, chunk: Chunk) -> Array | None:
        match self.spec.kind:
            case "time":
                return self.catalogue.columns(self._row_names, chunk) - self._offsets(chunk)
            case "phase":
                return self.catalogue.columns(self._row_names, chunk)
            case "difference":
                return self._subtract_reference(self.catalogue.columns(self._row_names, chunk))
            case "poincare":
                joined = self._before is None or _is_smooth(self._before, chunk)
                self._before = chunk.last()
                return self._section.feed(self.catalogue.columns(self._row_names, chunk), joined)
            case "spectrum":
                self._window.feed(chunk.t, self.catalogue.columns(self.names, chunk)[:, 0])
        return None

    def _offsets(self, chunk: Chunk) -> Array:
        """Offsets of the columns over time: the energy in gravity at the start, or 0."""
        raised = np.isin(self._row_names, self._energies_from_start)
        if self.first is None and raised.any():
            self._set_energy_origin(chunk.select(slice(1)))
        return np.where(raised, self._start, 0.0)

    def _set_energy_origin(self, first: Chunk) -> None:
        self.first = first
        self._start = float(self.catalogue.columns(("gravity_energy",), first)[0, 0])

    @property
    def _energies_from_start(self) -> tuple[str, ...]:
        """Energies that are counted from the start."""
        heavy = self.spec.kind == "time" and "gravity_energy" in self.catalogue.quantities
        return tuple(FROM_START) if heavy else ()

    def _subtract_reference(self, rows: Array) -> Array:
        """Subtract the values of the run beside this one; not-a-number where there is none."""
        rows[:, 1:] -= (
            self.beside.values(self.names, self.catalogue, rows[:, 0]) if self.beside else np.nan
        )
        return rows

    def current_rows(self, chunk: Chunk, before: Iterable[Chunk] | None = None) -> Array | None:
        """Rows that replace those on the page, at the last sample: a profile, or a spectrum at most
        four times a second; None where there is nothing new (always of the other kinds). before:
        for a sample of the past, those that lead to it."""
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
        """Rows of the samples before the plot was there, at most 5000: of a curve those of the last
        ``window`` seconds, thinned but with its extremes, of a section the last points; and the
        present of the others. Rows of later chunks follow these. first: the sample from which
        energies count, by default the first of all."""
        self.reset()
        chunks = [chunk for chunk in before if len(chunk)]
        if chunks and self.spec.kind == "time":
            self._offsets(first or chunks[0])
        if self.spec.kind != "poincare":
            chunks = _last_seconds(chunks, self.spec.window)
        rows = [found for chunk in _split_chunks(chunks) if (found := self.feed(chunk)) is not None]
        if self.replaces:
            found = self.current_rows(chunks[-1]) if chunks else None
            return np.zeros((0, 2)) if found is None else found
        every = np.concatenate(rows) if rows else np.zeros((0, self.width))
        return every[-MOST_ROWS:] if self.spec.kind == "poincare" else thin(every)

    @property
    def width(self) -> int:
        """Number of columns of a row."""
        if self.replaces:
            return 2
        unseen = self.spec.kind == "poincare"  # the quantity that reaches the value
        return len(self._row_names) - unseen

    @property
    def _row_names(self) -> tuple[str, ...]:
        """Quantities in the row of a sample."""
        match self.spec.kind:
            case "phase":
                return ("t", self.spec.x, *self.names)
            case "poincare":
                return ("t", self.spec.x, *self.names, self.spec.when)
        return ("t", *self.names)

    def to_json(self) -> dict[str, Any]:
        """Specification of the plot that the page draws it by, as JSON (see elements.Plots)."""
        x, y = self._axes()
        plane = self.spec.kind in ("phase", "poincare")
        return {
            "id": self.spec.id,
            "kind": "time" if self.spec.kind == "difference" else self.spec.kind,
            "title": title_of(self.spec, self.catalogue) + _stride_suffix(self.stride),
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

    def _series(self, one: PlotQuantity) -> dict[str, Any]:
        """Name, label and unit of a curve, and how it jumps."""
        found = {**one._asdict(), **self._jumps(one.name)}
        if one.name in self._energies_from_start:
            words = FROM_START[one.name]
            found["name"] += f"_{words.replace(' ', '_')}"
            found["label"] += f" {words}"
        return {key: found[key] for key in ("name", "label", "unit", *NO_JUMPS)}

    def _jumps(self, name: str) -> dict[str, float]:
        """Period by which a quantity jumps, and the whole turn that can be taken from it."""
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


def _stride_suffix(stride: int) -> str:
    """End of the title where only every k-th quantity is shown."""
    teens = stride // 10 % 10 == 1
    ending = "th" if teens else {1: "st", 2: "nd", 3: "rd"}.get(stride % 10, "th")
    return f", every {stride}{ending}" if stride > 1 else ""


def _is_smooth(before: Chunk, after: Chunk) -> bool:
    """Whether neither a change nor a kick lies between two chunks."""
    same = before.p is after.p or np.array_equal(before.p, after.p)
    return same and (before.given, before.start) == (after.given, after.start)


def _last_seconds(chunks: Sequence[Chunk], seconds: float) -> list[Chunk]:
    """Samples of the last seconds, since the run started again at the latest."""
    found: list[Chunk] = []
    for chunk in reversed(chunks):
        if found and chunk.t[-1] > found[-1].t[0]:
            break
        first = int(np.searchsorted(chunk.t, chunks[-1].t[-1] - seconds))
        if first == len(chunk):
            break
        found.append(chunk.select(slice(first, None)))
    return found[::-1]


def _split_chunks(chunks: Sequence[Chunk]) -> Iterator[Chunk]:
    """Split chunks into ones of at most PIECE samples."""
    for chunk in chunks:
        for first in range(0, len(chunk), PIECE):
            yield chunk.select(slice(first, first + PIECE))
