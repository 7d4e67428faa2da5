"""Plots of a live run: the rows that go to the page as samples come."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Any, Protocol

import numpy as np

from rodgen.arrays import Array
from rodgen_live.plot_quantities import KINDS, PERIODS, TURNS, Catalogue, PlotQuantity
from rodgen_live.run.plot_spec import PlotSpec, title_of
from rodgen_live.run.sample_curves import (
    MOST_ROWS,
    PoincareSection,
    Window,
    spectrum,
    thin,
)
from rodgen_live.sample_store import Chunk

# Over time energy in gravity counts from there: else a height far from zero swamps all.
FROM_START = {"gravity_energy": "from the start", "total_energy": "with gravity from the start"}
PLANES = "phase", "poincare"  # plots of one quantity over another
TURNED = "time", "phase", "poincare", "profile"  # plots of angles without their whole turns
NO_JUMPS = {"period": 0.0, "turn": 0.0}
MOST_SERIES = 200  # of one plot; of more, every k-th is shown
SPECTRA = 0.25  # seconds of wall time between two
PIECE = 1024  # samples that are taken at once
# Of a spectrum on linear axes: what part of its peak is not seen; how many times as far as the
# last frequency that is, it goes, and how many frequencies at least.
UNSEEN, BEYOND, LEAST_BINS = 1e-2, 2, 32


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
        # Quantities in the row of a sample, the last of a section that which reaches the value.
        over = (spec.x,) if spec.kind in PLANES else ()
        reached = (spec.when,) if spec.kind == "poincare" else ()
        self._row_names = ("t", *over, *self.names, *reached)
        self.width = 2 if self.replaces else len(self._row_names) - len(reached)
        heavy = spec.kind == "time" and "gravity_energy" in catalogue.quantities
        self._from_start = FROM_START if heavy else {}
        self._least = {"x": catalogue.error_level([spec.x]), "y": catalogue.error_level(self.names)}
        self.reset()

    def reset(self) -> None:
        """Forget all samples, as before the first chunk."""
        self._window, spec = Window(self.spec.window), self.spec
        period = PERIODS.get(spec.when, 0.0)
        self._section = PoincareSection(spec.value, spec.direction, spec.every, period)
        self._before: Chunk | None = None
        self._due, self.owes = -np.inf, False

    def feed(self, chunk: Chunk) -> Array | None:
        """Take up a chunk; returns rows to append, of t and the values at that time, or None where
        there are none (always of profile and spectrum)."""
        kind = self.spec.kind
        if not len(chunk) or kind == "profile":
            return None
        if kind == "spectrum":
            self._window.feed(chunk.t, self.catalogue.columns(self.names, chunk)[:, 0])
            return None
        rows = self.catalogue.columns(self._row_names, chunk)
        if kind == "time":
            rows -= np.where(np.isin(self._row_names, list(self._from_start)), chunk.raised, 0.0)
        elif kind == "difference":
            beside = self.beside
            rows[:, 1:] -= (
                beside.values(self.names, self.catalogue, rows[:, 0]) if beside else np.nan
            )
        elif kind == "poincare":
            joined = self._before is None or chunk.goes_on_from(self._before)
            self._before = chunk.last()
            rows = self._section.feed(rows, joined)
        return rows if len(rows) else None

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
        if self.spec.axes == "linear" and len(rows):  # beyond, nothing would be seen of it
            seen = np.flatnonzero(rows[:, 1] > UNSEEN * rows[:, 1].max())
            rows = rows[: BEYOND * (int(seen[-1]) if len(seen) else 0) + LEAST_BINS]
        self._due = self._clock() + SPECTRA
        return rows if len(rows) or before is not None else None

    def backlog(self, before: Iterable[Chunk]) -> Array:
        """Rows of the samples before the plot was there, at most 5000: of a curve those of the last
        ``window`` seconds, thinned but with its extremes, of a section the last points; and the
        present of the others. Rows of later chunks follow these."""
        self.reset()
        chunks = [chunk for chunk in before if len(chunk)]
        if chunks and self.spec.kind != "poincare":
            since = chunks[-1].t[-1] - self.spec.window
            chunks = [one.select(slice(int(np.searchsorted(one.t, since)), None)) for one in chunks]
        pieces = (
            chunk.select(slice(first, first + PIECE))
            for chunk in chunks
            for first in range(0, len(chunk), PIECE)
        )
        rows = [found for piece in pieces if (found := self.feed(piece)) is not None]
        if self.replaces:
            found = self.current_rows(chunks[-1]) if chunks else None
            return np.zeros((0, 2)) if found is None else found
        every = np.concatenate(rows) if rows else np.zeros((0, self.width))
        return every[-MOST_ROWS:] if self.spec.kind == "poincare" else thin(every)

    def to_json(self) -> dict[str, Any]:
        """Specification of the plot that the page draws it by, as JSON (see elements.Plots)."""
        log = {"x": self.spec.axes == "log", "y": self.spec.axes != "linear"}
        axes: dict[str, dict[str, Any]] = {
            name: {"label": label, "unit": unit, "log": log[name], "least": self._least[name]}
            for name, (label, unit) in zip("xy", self._axes(), strict=True)
        }
        axes["x"] |= self._jumps(self.spec.x) if self.spec.kind in PLANES else NO_JUMPS
        some = f", one in {self.stride}" if self.stride > 1 else ""
        return {
            "id": self.spec.id,
            "kind": "time" if self.spec.kind == "difference" else self.spec.kind,
            "title": title_of(self.spec, self.catalogue) + some,
            **axes,
            "series": [self._series(self.catalogue.quantities[name]) for name in self.names],
            "window": self.spec.window,
            "wrapped": self.spec.wrapped,
        }

    def _series(self, one: PlotQuantity) -> dict[str, Any]:
        found = {**one._asdict(), **self._jumps(one.name)}
        if words := self._from_start.get(one.name):
            found["name"] += f"_{words.replace(' ', '_')}"
            found["label"] += f" {words}"
        return {key: found[key] for key in ("name", "label", "unit", *NO_JUMPS)}

    def _jumps(self, name: str) -> dict[str, float]:
        """Period by which a quantity jumps, and the whole turn that can be taken from it."""
        turns = self.spec.kind in TURNED
        kind = self.catalogue.quantities[name].kind
        return {"period": PERIODS.get(name, 0.0), "turn": TURNS.get(kind, 0.0) * turns}

    def _axes(self) -> tuple[tuple[str, str], tuple[str, str]]:
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
