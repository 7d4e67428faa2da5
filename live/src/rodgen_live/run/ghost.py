"""A kept run that another one is compared with."""

from __future__ import annotations

import numpy as np

from rodgen.arrays import Array
from rodgen.loading.generated_module import call_module
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run.plot import Plot
from rodgen_live.run.plot_spec import LONGEST, counterpart, transfer
from rodgen_live.run.sample_curves import resample
from rodgen_live.sample_store import Chunk, SampleStore

LEAST = 4  # samples, of which values between them are made


class Ghost:
    """A kept run: its store, which is not added to any more, and its catalogue with the module. To
    be used from one thread at a time."""

    def __init__(self, store: SampleStore, catalogue: Catalogue):
        self.store, self.catalogue = store, catalogue
        self._columns: dict[tuple[str, ...], tuple[Array, Array]] = {}

    def joints(self, t: float) -> Array:
        """Positions of the joints at a time [m], (joints, 2), linear between two samples; none
        outside the span of this run."""
        first, last = self.store.span
        if not first <= t <= last:
            return np.zeros((0, 2))
        near = self.store.nearest(t)
        other = self.store.nearest(t, 1 if near.t[0] < t else -1)
        gap = other.t[0] - near.t[0]
        share = (t - near.t[0]) / gap if gap else 0.0
        model, both = self.catalogue.model, (near, other)
        here, there = (call_module(model, "joints", one.t[0], one.y[0], one.p) for one in both)
        return np.asarray(here + share * (there - here))

    def rows(self, plot: Plot, seen: Chunk) -> Array:
        """Rows of a plot for this run: of a profile those at the time of the seen sample, of a
        spectrum those of the last seconds, else all. No rows where this rod lacks one of its
        quantities."""
        beside = self._own_plot(plot)
        if beside is None:
            return np.zeros((0, plot.width))
        if plot.spec.kind != "profile":
            return beside.backlog(self.store.chunks())
        t, (first, last) = float(seen.t[-1]), self.store.span
        found = beside.current_rows(self.store.nearest(t)) if first <= t <= last else None
        return np.zeros((0, plot.width)) if found is None else found

    def _own_plot(self, plot: Plot) -> Plot | None:
        """The plot as one of this run; None for a difference, or where a quantity is lacking."""
        spec = plot.spec
        if spec.kind == "difference":
            return None
        names = spec.y if spec.kind == "profile" else plot.names
        window = spec.window if spec.kind == "spectrum" else LONGEST
        wanted = spec.model_copy(update={"y": names, "window": window})
        own = transfer(wanted, spec.id, plot.catalogue, self.catalogue)
        return Plot(own, self.catalogue) if own and len(own.y) == len(names) else None

    def values(self, names: tuple[str, ...], of: Catalogue, times: Array) -> Array:
        """Interpolate quantities of a rod at other times by cubics, (N, names); not-a-number where
        this run has none. of: the catalogue that names them."""
        found = np.full((len(times), len(names)), np.nan)
        own = tuple(filter(None, (counterpart(name, of, self.catalogue) for name in names)))
        if len(own) < len(names):
            return found
        t, columns = self._all_samples(own)
        inside = (times >= t[0]) & (times <= t[-1]) if len(t) >= LEAST else np.zeros(0, dtype=int)
        for k in range(len(names) if np.any(inside) else 0):
            found[inside, k] = resample(t, columns[:, k], times[inside])
        return found

    def _all_samples(self, names: tuple[str, ...]) -> tuple[Array, Array]:
        """Times and values of all samples; of two at one time, the later one."""
        if names not in self._columns:
            pieces = list(self.store.chunks())
            t = np.concatenate([np.zeros(0), *(piece.t for piece in pieces)])
            columns = [self.catalogue.columns(names, piece) for piece in pieces]
            last = np.diff(t, append=np.inf) > 0
            values = np.concatenate([np.zeros((0, len(names))), *columns])
            self._columns[names] = t[last], values[last]
        return self._columns[names]
