"""Samples and work along a run: dense output at the sample times, quadrature over every step."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import ModuleType

import numpy as np

from rodgen.integrate.stepper import Array, Interpolant

# Gauss-Legendre on [0, 1]: exact to order 8, beyond every interpolant in use.
NODES, WEIGHTS = (
    (np.polynomial.legendre.leggauss(4)[0] + 1) / 2,
    (np.polynomial.legendre.leggauss(4)[1] / 2),
)
BUFFER = 256  # steps whose power is evaluated at once


class Collector:
    """States at the sample times, and the work of every load up to them."""

    def __init__(self, times: Array, y0: Array, model: ModuleType, p: Array):
        self.times, self.p = times, p
        self.states = np.empty((len(times), len(y0)))
        self.states[0] = y0
        self.count = 1
        power: Callable[[Array, Array, Array], Mapping[str, Array]] | None
        power = getattr(model, "power", None)
        self._power = power
        with np.errstate(all="ignore"):  # of a state that cannot be integrated
            terms = list(power(times[0], y0, p)) if power else []
        self.work = {term: np.zeros(len(times)) for term in terms}
        self._sum = dict.fromkeys(terms, 0.0)
        self._nodes: list[tuple[Array, Array, Array, list[int]]] = []

    def add(self, t0: float, t1: float, y1: Array, interpolant: Callable[[], Interpolant]) -> None:
        """Take in a step from t0 to t1 that ends in y1.

        The count moves last: an interrupt at any moment leaves only samples that are whole.
        """
        first, last = self.count, int(np.searchsorted(self.times, t1, side="right"))
        inside = self.times[first:last]
        if not len(inside) and not self._power:
            return
        # A sample at the very end of the step is its state, not an interpolation.
        ends_here = len(inside) > 0 and inside[-1] == t1
        between = inside[:-1] if ends_here else inside
        if len(between) or self._power:
            at = interpolant()
        if len(between):
            self.states[first : first + len(between)] = at(between)
        if ends_here:
            self.states[last - 1] = y1
        if self._power:
            edges = np.concatenate(([t0], between, [t1]))
            widths = np.diff(edges)
            nodes = (edges[:-1, None] + widths[:, None] * NODES).ravel()
            # Which sample each stretch ends at; the last stretch may end at none.
            samples = list(range(first, last)) + ([] if ends_here else [-1])
            self._nodes.append((nodes, at(nodes), widths, samples))
        self.count = last
        if len(self._nodes) >= BUFFER:
            self.flush()

    def flush(self) -> None:
        """Integrate the power over the steps that wait."""
        if not self._nodes or not self._power:
            return
        nodes, states, widths, samples = zip(*self._nodes, strict=True)
        power = self._power(np.concatenate(nodes), np.concatenate(states), self.p)
        width = np.concatenate(widths)
        ends = np.array([sample for some in samples for sample in some])
        sums = {}
        for term, values in power.items():
            stretches = width * (values.reshape(-1, len(NODES)) @ WEIGHTS)
            totals = self._sum[term] + np.cumsum(stretches)
            self.work[term][ends[ends >= 0]] = totals[ends >= 0]
            sums[term] = float(totals[-1])
        # Only now: an interrupt before this line has the same steps integrated again.
        self._sum, self._nodes = sums, []
