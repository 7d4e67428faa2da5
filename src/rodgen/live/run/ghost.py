"""A run that is kept beside another one, to compare with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rodgen.integrate.stepper import Array
from rodgen.live.catalogue import Catalogue
from rodgen.live.run.curves import resample
from rodgen.live.run.plot import Plot
from rodgen.live.run.plot_spec import LONGEST
from rodgen.live.samples import Store
from rodgen.scene import Scene

LEAST = 4  # samples, of which values between them are made


class Ghost:
    """The samples of a run, and what they are of: store, which is not added to any more, scene,
    catalogue with its module. To be used from one thread at a time."""

    def __init__(self, store: Store, scene: Scene, catalogue: Catalogue):
        self.store, self.scene, self.catalogue = store, scene, catalogue
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

    def rows(self, plot: Plot) -> Array:
        """What a plot over time shows of this run, as the plot itself would; no rows where this rod
        has not all of its quantities."""
        if plot.spec.kind != "time" or not self._has(plot.names):
            return np.zeros((0, 1 + len(plot.names)))
        return Plot(replace(plot.spec, window=LONGEST), self.catalogue).backlog(self.store.chunks())

    def values(self, names: tuple[str, ...], times: Array) -> Array:
        """Quantities at other times, (N, names), by cubics through the samples around them;
        not-a-number where this run has none."""
        found = np.full((len(times), len(names)), np.nan)
        t, columns = self._every(names)
        inside = (times >= t[0]) & (times <= t[-1]) if len(t) >= LEAST else np.zeros(0, dtype=int)
        for k in range(len(names) if np.any(inside) else 0):
            found[inside, k] = resample(t, columns[:, k], times[inside])
        return found

    def _has(self, names: tuple[str, ...]) -> bool:
        return all(name in self.catalogue.quantities for name in names)

    def _every(self, names: tuple[str, ...]) -> tuple[Array, Array]:
        """Times and values of all samples; of two at one time, the later one."""
        if names not in self._columns:
            pieces = list(self.store.chunks()) if self._has(names) else []
            t = np.concatenate([np.zeros(0), *(piece.t for piece in pieces)])
            columns = [self.catalogue.columns(names, piece) for piece in pieces]
            last = np.diff(t, append=np.inf) > 0
            values = np.concatenate([np.zeros((0, len(names))), *columns])
            self._columns[names] = t[last], values[last]
        return self._columns[names]
