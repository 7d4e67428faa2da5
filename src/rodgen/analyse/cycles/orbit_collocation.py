"""Periodic motions by collocation: the whole period at once, as polynomials on a mesh of it.

The states at the nodes of an interval follow from the state at its start by linear equations, which
are condensed to the derivatives of its end: what is left are segments as of shooting. Angles are
integrals of their rates, which alone are unknowns in the nodes.

The nodes are those of Radau IIA, of order 2 s - 1 for s stages, the last at the end of the step
(E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.5). Gauss nodes have
one order more, but carry a motion that decays at once on, with or without a change of sign: for a
stiff rod they give multipliers that do not exist.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.polynomial import Polynomial

from rodgen.analyse.cycles.elimination import multiplier_difference
from rodgen.analyse.cycles.periodicity import Lap, Linearisation, NewtonSolver, Orbit
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

STAGES = 5
ORDER = 2 * STAGES - 1  # of states at the ends of steps
FIRST, GROWTH = 24, 1.7  # intervals at first, and times these for a finer mesh
LEAST_GROWTH, MOST_GROWTH, MARGIN = 1.3, 2.5, 1.2
MOST_FIRST, MOST, ROOM = 200, 600, 2e7  # the last: numbers in derivatives of the rates
ROUNDED = 0.2  # of the error of multipliers that are 1: what counts
QUADRATIC = 1e-6  # of the size of the motion: the last correction by derivatives of its own
ENOUGH = 1e-9  # what is left of the error of the period, the state and the larger multipliers


def _radau_nodes() -> tuple[Array, Array]:
    """Nodes (s,) of Radau IIA as shares of a step, and integrals (s, s), up to each node, of the
    polynomial through rates at them."""
    # The zeros of the derivative of order s - 1 of x^(s-1) (x - 1)^s.
    x = Polynomial([0.0, 1.0])
    c = np.sort((x ** (STAGES - 1) * (x - 1) ** STAGES).deriv(STAGES - 1).roots().real)
    c[-1] = 1.0
    powers = np.arange(STAGES)
    left = np.vander(c, STAGES, increasing=True)
    return c, (c[:, None] ** (powers + 1) / (powers + 1)) @ np.linalg.inv(left)


NODES, INTEGRALS = _radau_nodes()
POINTS = np.append(0.0, NODES)  # start and nodes, through whose states a polynomial goes
# Weights (s + 1,) of these states for its highest derivative, by the share of the step, over the
# factorial of its degree.
HIGHEST = 1 / (POINTS[:, None] - POINTS + np.eye(len(POINTS))).prod(axis=1)


def _interpolation_weights(shares: Array) -> Array:
    """Weights (K, s + 1) of the states at the start and at the nodes, to interpolate at shares (K,)
    of the step."""
    made = np.ones((len(shares), len(POINTS)))
    for j, node in enumerate(POINTS):
        for other in np.delete(POINTS, j):
            made[:, j] *= (shares - other) / (node - other)
    return made


@dataclass(frozen=True)
class CollocationOrbit(Orbit):
    """An orbit on a mesh. mesh: starts of the intervals as shares of the period, and 1 (m + 1,);
    inner: states at the nodes of intervals (m, s, size)."""

    mesh: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    inner: Array = field(default_factory=lambda: np.zeros(0), repr=False)

    @property
    def times(self) -> Array:
        """Times of the nodes (m, s) [s]."""
        lengths = np.diff(self.mesh)
        shares = self.mesh[:-1, None] + lengths[:, None] * NODES
        return self.t + self.period * shares

    @property
    def all_states(self) -> Array:
        """States at the start and the nodes of intervals (m, s + 1, size)."""
        return np.concatenate((self.x[:, None], self.inner), axis=1)

    def states(self, shares: Array) -> Array:
        """States (K, size) at shares (K,) of the period."""
        m = len(self.x)
        of = np.clip(np.searchsorted(self.mesh, shares, side="right") - 1, 0, m - 1)
        within = (shares - self.mesh[of]) / np.diff(self.mesh)[of]
        weights = _interpolation_weights(within)
        return np.asarray(np.einsum("kj,kji->ki", weights, self.all_states[of]))

    def interpolate(self, mesh: Array) -> CollocationOrbit:
        """Interpolate the orbit on another mesh."""
        shares = mesh[:-1, None] + np.diff(mesh)[:, None] * NODES
        inner = self.states(shares.ravel()).reshape(*shares.shape, -1)
        return replace(self, mesh=mesh, x=self.states(mesh[:-1]), inner=inner, change=np.inf)

    def refine_mesh(self, count: int) -> Array:
        """Mesh of so many intervals that equidistributes the error, estimated by the next
        derivative of the polynomials over the size of the motion (R. D. Russell, J. Christiansen,
        SIAM J. Numer. Anal. 15 (1978) 59)."""
        lengths = np.diff(self.mesh)
        scale = np.ptp(self.inner, axis=(0, 1))
        scale = np.maximum(scale, 1e-6 * scale.max())
        highest = np.einsum("j,mji->mi", HIGHEST, self.all_states) / scale
        highest = highest / lengths[:, None] ** STAGES
        apart = (lengths + np.roll(lengths, 1)) / 2
        jumps = np.linalg.norm(highest - np.roll(highest, 1, axis=0), axis=1) / apart
        density = ((jumps + np.roll(jumps, -1)) / 2) ** (1 / (STAGES + 1))
        density = np.maximum(density, 0.1 * (density @ lengths))
        grown = np.append(0.0, np.cumsum(density * lengths))
        mesh = np.interp(np.linspace(0.0, grown[-1], count + 1), grown, self.mesh)
        mesh[0], mesh[-1] = 0.0, 1.0
        return mesh

    @classmethod
    def from_lap(cls, lap: Lap, count: int) -> CollocationOrbit:
        """Make an orbit from a lap, on a mesh of so many equal intervals."""
        mesh = np.linspace(0.0, 1.0, count + 1)
        inner = lap.states(mesh[:-1, None] + np.diff(mesh)[:, None] * NODES)
        known = vars(lap.to_orbit(1)) | {"x": lap.states(mesh[:-1])}
        return cls(**known, mesh=mesh, inner=inner)


class OrbitCollocation(NewtonSolver[CollocationOrbit]):
    """Periodic motions of a flow by collocation on adaptive meshes.

    The unknowns in an interval are the rates at its nodes; `inner` of `Linearisation` has what they
    change by: columns for the defect, the state at the start, and the period.
    """

    def find_orbit(self, lap: Lap) -> CollocationOrbit:
        orbit = self._solve_coarse(lap)
        while True:
            count = self._next_count(orbit)
            before, orbit = (
                orbit,
                self.solve(orbit.interpolate(orbit.refine_mesh(count)), QUADRATIC),
            )
            finer = (count / len(before.x)) ** ORDER - 1
            orbit = replace(
                orbit,
                error=max(self._difference(orbit, before) / finer, self._trivial_error(orbit)),
            )
            if orbit.error <= ENOUGH or count == self._max_intervals:
                return orbit

    def _solve_coarse(self, lap: Lap) -> CollocationOrbit:
        """Solve on the coarsest mesh on which Newton's method converges."""
        count = FIRST
        while True:
            try:
                return self.solve(CollocationOrbit.from_lap(lap, count), QUADRATIC)
            except AnalysisError:
                count *= 2
                if count > min(MOST_FIRST, self._max_intervals):
                    raise

    @property
    def _max_intervals(self) -> int:
        """Largest number of intervals for which there is memory."""
        return int(min(MOST, ROOM / (STAGES * self.flow.quotient.size**2)))

    def _next_count(self, orbit: CollocationOrbit) -> int:
        """Number of intervals of the next mesh, from the error and the order of the method."""
        growth = GROWTH
        if orbit.error:
            growth = MARGIN * (orbit.error / ENOUGH) ** (1 / ORDER)
        growth = min(max(growth, LEAST_GROWTH), MOST_GROWTH)
        return min(self._max_intervals, round(growth * len(orbit.x)))

    def _difference(self, finer: CollocationOrbit, coarser: CollocationOrbit) -> float:
        """Difference of two solutions: relative to the period, to the size of the motion and to the
        largest multiplier."""
        return max(
            abs(finer.period / coarser.period - 1),
            float(np.abs(finer.x[0] - coarser.x[0]).max()) / finer.scale,
            multiplier_difference(finer.multipliers, coarser.multipliers),
        )

    def _trivial_error(self, orbit: CollocationOrbit) -> float:
        """Error of the multipliers that have to be 1, less a part that is rounding."""
        off = np.sort(np.abs(orbit.multipliers - 1))[: self.trivial]
        return ROUNDED * float(off.max(initial=0.0))

    def path(self, orbit: CollocationOrbit, count: int) -> Array:
        return orbit.states(np.arange(count) / count)

    def linearise(self, orbit: CollocationOrbit) -> Linearisation:
        orbit = self._replace_states(orbit, orbit.x, orbit.period, orbit.inner)
        q, A, shares = self.flow.quotient, INTEGRALS, np.diff(orbit.mesh)
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
        return self.assemble(orbit, list(G[..., 1:-1]), list(G[..., -1]), list(ends), found)

    def update_residuals(self, orbit: CollocationOrbit, by: Linearisation) -> Linearisation:
        """Linearise again: derivatives cost little beside the rest."""
        return self.linearise(orbit)

    def apply_correction(
        self, orbit: CollocationOrbit, at: Linearisation, share: float, d: Array, longer: float
    ) -> CollocationOrbit:
        constant, by_start, by_period = at.inner[..., 0], at.inner[..., 1:-1], at.inner[..., -1]
        change = constant + (by_start @ d[:, None, :, None])[..., 0] + longer * by_period
        inner = orbit.inner.copy()
        inner[..., self.flow.quotient.positions :] += share * change
        return self._replace_states(
            orbit, orbit.x + share * d, orbit.period + share * longer, inner
        )

    def _replace_states(
        self, orbit: CollocationOrbit, x: Array, period: float, inner: Array
    ) -> CollocationOrbit:
        """Replace the states; positions at the nodes follow from the rates there."""
        q, inner = self.flow.quotient, inner.copy()
        slope = INTEGRALS @ inner[..., q.led]
        h = period * np.diff(orbit.mesh)[:, None, None]
        inner[..., : q.positions] = x[:, None, : q.positions] + h * slope
        return replace(orbit, x=x, period=period, inner=inner)
