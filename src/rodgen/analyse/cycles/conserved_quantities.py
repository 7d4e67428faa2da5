"""Conserved quantities of a rod without dissipation: energy and, where the rod may be turned,
angular momentum; of a free rod relative to its centre of gravity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodgen.analyse.cycles.flow import Flow
from rodgen.arrays import Array

NUDGE = 1e-5  # of differences of a gradient: errors are its square


@dataclass(frozen=True)
class ConservedQuantities:
    """Conserved quantities of a flow without dissipation."""

    flow: Flow

    def values(self, x: Array) -> Array:
        """Energy [J] and, where the rod may be turned, angular momentum [kg m^2/s], (k,)."""
        flow, q = self.flow, self.flow.quotient
        y = q.lift(x)
        half = len(y) // 2
        mass = flow.model.mass_matrix(y, flow.p)
        inner = np.setdiff1d(np.arange(half), q.kept[: q.positions])
        own = q.kept[: q.positions]
        if len(inner):  # joint 0 moves so that the centre of gravity rests
            lean = np.linalg.solve(mass[np.ix_(inner, inner)], mass[np.ix_(inner, own)])
            mass = mass[np.ix_(own, own)] - mass[np.ix_(own, inner)] @ lean
        u = x[q.positions :]
        at_rest = y.copy()
        at_rest[half:] = 0.0
        _, spring, gravity = flow.model.energy(at_rest, flow.p)
        potential = spring if len(inner) else spring + gravity
        energy = 0.5 * float(u @ mass @ u) + float(potential)
        turned = [float(q.turning(x)[: q.positions] @ mass @ u)] if q.turns else []
        return np.array([energy, *turned])

    def gradients(self, x: Array) -> Array:
        """Derivatives of the conserved quantities by the state (k, size)."""
        columns = []
        for k in range(len(x)):
            d = np.zeros(len(x))
            d[k] = NUDGE * max(1.0, float(np.abs(x).max()))
            columns.append((self.values(x + d) - self.values(x - d)) / (2 * d[k]))
        return np.array(columns).T
