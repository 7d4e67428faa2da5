"""Periodic motions by collocation: the whole period at once, as polynomials on a mesh of it.

The states at the nodes of an interval follow from the state at its start by linear equations, which
are condensed to the derivatives of its end: what is left are segments as of shooting. Angles are
integrals of their rates, which alone are unknowns in the nodes.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from rodgen.analyse.cycles.closing import Lap, Linearised, Newton, Orbit
from rodgen.analyse.cycles.elimination import apart
from rodgen.analyse.cycles.nodes import Nodes, radau
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

STAGES = 5
FIRST, GROWTH = 24, 1.7  # intervals at first, and times these for a finer mesh
LEAST_GROWTH, MOST_GROWTH, MARGIN = 1.3, 2.5, 1.2
MOST_FIRST, MOST, ROOM = 200, 600, 2e7  # the last: numbers in derivatives of the rates
ROUNDED = 0.2  # of the error of multipliers that are 1: what counts
QUADRATIC = 1e-6  # of the size of the motion: the last correction by derivatives of its own
ENOUGH = 1e-9  # what is left of the error of the period, the state and the larger multipliers


@dataclass(frozen=True)
class Collocated(Orbit):
    """mesh: shares of the period at the starts of intervals, and 1 (m + 1,); inner: states at the
    nodes of intervals (m, s, size)."""

    mesh: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    inner: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    nodes: Nodes = field(default_factory=lambda: radau(STAGES), repr=False)

    @property
    def times(self) -> Array:
        """Of the nodes (m, s) [s]."""
        lengths = np.diff(self.mesh)
        shares = self.mesh[:-1, None] + lengths[:, None] * self.nodes.c
        return self.t + self.period * shares

    @property
    def all(self) -> Array:
        """States at the start and the nodes of intervals (m, s + 1, size)."""
        return np.concatenate((self.x[:, None], self.inner), axis=1)

    def at(self, shares: Array) -> Array:
        """States (K, size) at shares (K,) of the period."""
        m = len(self.x)
        of = np.clip(np.searchsorted(self.mesh, shares, side="right") - 1, 0, m - 1)
        within = (shares - self.mesh[of]) / np.diff(self.mesh)[of]
        weights = self.nodes.between(within)
        return np.asarray(np.einsum("kj,kji->ki", weights, self.all[of]))

    def on(self, mesh: Array) -> Collocated:
        """On another mesh."""
        shares = mesh[:-1, None] + np.diff(mesh)[:, None] * self.nodes.c
        inner = self.at(shares.ravel()).reshape(*shares.shape, -1)
        return replace(self, mesh=mesh, x=self.at(mesh[:-1]), inner=inner, change=np.inf)

    def refined(self, count: int) -> Array:
        """A mesh of so many intervals, on which the next derivative of the polynomials, over the
        size of the motion, gives all intervals the same error (R. D. Russell, J. Christiansen,
        SIAM J. Numer. Anal. 15 (1978) 59)."""
        lengths, degree = np.diff(self.mesh), self.nodes.degree
        scale = np.ptp(self.inner, axis=(0, 1))
        scale = np.maximum(scale, 1e-6 * scale.max())
        highest = np.einsum("j,mji->mi", self.nodes.highest, self.all) / scale
        highest = highest / lengths[:, None] ** degree
        apart = (lengths + np.roll(lengths, 1)) / 2
        jumps = np.linalg.norm(highest - np.roll(highest, 1, axis=0), axis=1) / apart
        density = ((jumps + np.roll(jumps, -1)) / 2) ** (1 / (degree + 1))
        density = np.maximum(density, 0.1 * (density @ lengths))
        grown = np.append(0.0, np.cumsum(density * lengths))
        mesh = np.interp(np.linspace(0.0, grown[-1], count + 1), grown, self.mesh)
        mesh[0], mesh[-1] = 0.0, 1.0
        return mesh

    @classmethod
    def by(cls, lap: Lap, count: int) -> Collocated:
        """Of a motion, on a mesh of so many equal intervals."""
        mesh, nodes = np.linspace(0.0, 1.0, count + 1), radau(STAGES)
        inner = lap.at(mesh[:-1, None] + np.diff(mesh)[:, None] * nodes.c)
        known = vars(lap.orbit(1)) | {"x": lap.at(mesh[:-1])}
        return cls(**known, mesh=mesh, inner=inner, nodes=nodes)


class Collocation(Newton[Collocated]):
    """Collocation of the motions of a flow.

    The unknowns in an interval are the rates in its nodes; what they change by: columns for the
    defect, for the state at its start, and for the length of the period.
    """

    def found(self, lap: Lap) -> Collocated:
        orbit = self._first(lap)
        while True:
            count = self._wanted(orbit)
            before, orbit = orbit, self.solved(orbit.on(orbit.refined(count)), QUADRATIC)
            finer = (count / len(before.x)) ** orbit.nodes.order - 1
            orbit = replace(orbit, error=max(self._apart(orbit, before) / finer, self._off(orbit)))
            if orbit.error <= ENOUGH or count == self._most:
                return orbit

    def _first(self, lap: Lap) -> Collocated:
        """The solution on the coarsest mesh on which Newton's method finds it."""
        count = FIRST
        while True:
            try:
                return self.solved(Collocated.by(lap, count), QUADRATIC)
            except AnalysisError:
                count *= 2
                if count > min(MOST_FIRST, self._most):
                    raise

    @property
    def _most(self) -> int:
        """Intervals for which there is room."""
        return int(min(MOST, ROOM / (STAGES * self.flow.quotient.size**2)))

    def _wanted(self, orbit: Collocated) -> int:
        """Intervals of the next mesh, by the order of what is left of the error."""
        growth = GROWTH
        if orbit.error:
            growth = MARGIN * (orbit.error / ENOUGH) ** (1 / orbit.nodes.order)
        growth = min(max(growth, LEAST_GROWTH), MOST_GROWTH)
        return min(self._most, round(growth * len(orbit.x)))

    def _apart(self, finer: Collocated, coarser: Collocated) -> float:
        """By how much two solutions differ: relative to the period, to the size of the motion and
        to the largest multiplier."""
        return max(
            abs(finer.period / coarser.period - 1),
            float(np.abs(finer.x[0] - coarser.x[0]).max()) / finer.scale,
            apart(finer.multipliers, coarser.multipliers),
        )

    def _off(self, orbit: Collocated) -> float:
        """By how much multipliers that have to be 1 are not; some of that is rounding."""
        off = np.sort(np.abs(orbit.multipliers - 1))[: self.trivial]
        return ROUNDED * float(off.max(initial=0.0))

    def path(self, orbit: Collocated, count: int) -> Array:
        return orbit.at(np.arange(count) / count)

    def linearised(self, orbit: Collocated) -> Linearised:
        orbit = self._led(orbit, orbit.x, orbit.period, orbit.inner)
        q, A, shares = self.flow.quotient, orbit.nodes.A, np.diff(orbit.mesh)
        m, s, size = orbit.inner.shape
        T, R, led = np.arange(q.positions), np.arange(q.positions, size), q.led - q.positions
        h = orbit.period * shares[:, None, None]
        f, J = self.flow.derivatives(orbit.times.ravel(), orbit.inner.reshape(m * s, size))
        f, J = f[:, R].reshape(m, s, -1), J[:, R].reshape(m, s, len(R), size)
        J_T, W = J[..., T], orbit.inner[..., R]
        M = J[..., R].transpose(0, 2, 1, 3)[:, None] * A[:, None, :, None] * -h[..., None, None]
        twice = (A[:, None] * A.T).reshape(s * s, s) @ J_T.reshape(m, s, -1)
        twice = twice.reshape(m, s, s, len(R), len(T)).transpose(0, 1, 3, 2, 4)
        M[..., led] -= twice * h[..., None, None] ** 2
        M = M.reshape(m, s * len(R), s * len(R))
        M[:, np.arange(s * len(R)), np.arange(s * len(R))] += 1.0
        gained, slope = A @ f, A @ W[..., led]
        through = (A @ J_T.reshape(m, s, -1)).reshape(J_T.shape)
        right = np.zeros((m, s, len(R), size + 2))
        right[..., 0] = orbit.x[:, None, R] + h * gained - W
        right[..., 1 + T] = h[..., None] * through
        right[..., 1 + R] = np.eye(len(R))
        right[..., -1] = gained + h * (A @ (J_T @ slope[..., None])[..., 0])
        right[..., -1] *= shares[:, None, None]
        found = np.linalg.solve(M, right.reshape(m, s * len(R), -1)).reshape(right.shape)
        # Ends: the rates of the last node, and positions, which are integrals.
        G = np.empty((m, size, size + 2))
        G[:, R] = found[:, -1]
        G[:, T] = h * np.tensordot(A[-1], found[:, :, led], (0, 1))
        G[:, T, 1 + T] += 1.0
        G[:, T, -1] += shares[:, None] * slope[:, -1]
        ends = orbit.inner[:, -1] + G[..., 0]
        return self.joined(orbit, list(G[..., 1:-1]), list(G[..., -1]), list(ends), found)

    def anew(self, orbit: Collocated, by: Linearised) -> Linearised:
        """Derivatives cost little beside the rest."""
        return self.linearised(orbit)

    def within(
        self, orbit: Collocated, at: Linearised, share: float, d: Array, longer: float
    ) -> Collocated:
        constant, by_start, by_period = at.inner[..., 0], at.inner[..., 1:-1], at.inner[..., -1]
        change = constant + (by_start @ d[:, None, :, None])[..., 0] + longer * by_period
        inner = orbit.inner.copy()
        inner[..., self.flow.quotient.positions :] += share * change
        return self._led(orbit, orbit.x + share * d, orbit.period + share * longer, inner)

    def _led(self, orbit: Collocated, x: Array, period: float, inner: Array) -> Collocated:
        """With the positions that follow from the rates in the nodes."""
        q, inner = self.flow.quotient, inner.copy()
        slope = orbit.nodes.A @ inner[..., q.led]
        h = period * np.diff(orbit.mesh)[:, None, None]
        inner[..., : q.positions] = x[:, None, : q.positions] + h * slope
        return replace(orbit, x=x, period=period, inner=inner)
