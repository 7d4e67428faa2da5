"""A run that is kept beside another one, to compare with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rodgen.arrays import Array
from rodgen.live.catalogue import Catalogue
from rodgen.live.run.curves import resample
from rodgen.live.run.plot import Plot
from rodgen.live.run.plot_spec import LONGEST, counterpart
from rodgen.live.samples import Chunk, Store

LEAST = 4  # samples, of which values between them are made


class Ghost:
    """The samples of a run, and what they are of: store, which is not added to any more, catalogue
    with its module. To be used from one thread at a time."""

    def __init__(self, store: Store, catalogue: Catalogue):
        self.store, self.catalogue = store, catalogue
        self._columns: dict[tuple[str, ...], tuple[Array, Array]] = {}

    def joints(self, t: float) -> Array:
        """Places of the joints at a time [m], (joints, 2), on a line between two samples; none of
        a time at which this run was not."""
        first, last = self.store.span
        if not first <= t <= last:
            return np.zeros((0, 2))
        near = self.store.near(t)
        other = self.store.near(t, 1 if near.t[0] < t else -1)
        gap = other.t[0] - near.t[0]
        share = (t - near.t[0]) / gap if gap else 0.0
        model = self.catalogue.model
        here, there = (model.joints(sample.y[0], sample.p) for sample in (near, other))
        found: Array = here + share * (there - here)
        return found

    def rows(self, plot: Plot, seen: Chunk) -> Array:
        """What a plot shows of this run, as the plot itself would: along the rod what is of the
        time of a sample that is seen, a spectrum of the last seconds, else everything. Energies
        count from where the other run begins. No rows where this rod has not all of its
        quantities."""
        beside = self._same(plot)
        if beside is None:
            return np.zeros((0, plot.width))
        if plot.spec.kind != "profile":
            return beside.backlog(self.store.chunks(), self._here(plot.first))
        t, (first, last) = float(seen.t[-1]), self.store.span
        found = beside.present(self.store.near(t)) if first <= t <= last else None
        return np.zeros((0, plot.width)) if found is None else found

    def _same(self, plot: Plot) -> Plot | None:
        """A plot for the rows of this run."""
        spec = plot.spec
        if spec.kind == "difference":
            return None
        if spec.kind == "profile":
            return Plot(spec, self.catalogue) if spec.y[0] in self.catalogue.along else None
        names = self._named((*plot.names, spec.x, *filter(None, [spec.when])), plot.catalogue)
        if names is None:
            return None
        y, (x, *when) = names[: len(plot.names)], names[len(plot.names) :]
        window = spec.window if spec.kind == "spectrum" else LONGEST
        own = replace(spec, y=y, x=x, when="".join(when), window=window)
        return Plot(own, self.catalogue)

    def _here(self, sample: Chunk | None) -> Chunk | None:
        """A sample of the other run, with the parameters of this one."""
        first = next(iter(self.store.chunks()))
        same = sample is not None and sample.y.shape[1] == first.y.shape[1]
        return replace(sample, p=first.p) if sample is not None and same else None

    def values(self, names: tuple[str, ...], of: Catalogue, times: Array) -> Array:
        """Quantities of a rod at other times, (N, names), by cubics through the samples around
        them; not-a-number where this run has none."""
        found = np.full((len(times), len(names)), np.nan)
        if (own := self._named(names, of)) is None:
            return found
        t, columns = self._every(own)
        inside = (times >= t[0]) & (times <= t[-1]) if len(t) >= LEAST else np.zeros(0, dtype=int)
        for k in range(len(names) if np.any(inside) else 0):
            found[inside, k] = resample(t, columns[:, k], times[inside])
        return found

    def _named(self, names: tuple[str, ...], of: Catalogue) -> tuple[str, ...] | None:
        """What quantities of a rod are called in this one: the tail's are those of this tail. None
        where this one has not all of them."""
        found = [counterpart(name, of, self.catalogue) for name in names]
        own = tuple(name for name in found if name is not None)
        return own if len(own) == len(names) else None

    def _every(self, names: tuple[str, ...]) -> tuple[Array, Array]:
        """Times and values of all samples; of two at one time, the later one."""
        if names not in self._columns:
            pieces = list(self.store.chunks())
            t = np.concatenate([np.zeros(0), *(piece.t for piece in pieces)])
            columns = [self.catalogue.columns(names, piece) for piece in pieces]
            last = np.diff(t, append=np.inf) > 0
            values = np.concatenate([np.zeros((0, len(names))), *columns])
            self._columns[names] = t[last], values[last]
        return self._columns[names]
