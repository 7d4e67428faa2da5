"""Periodic motions by multiple shooting, runs over equal segments of the period; and, for many
states, by the Newton-Picard method.

That is Newton's method in the directions of the few large multipliers, and Picard's iteration for
the rest, which damping makes small (K. Lust, D. Roose, A. Spence, A. R. Champneys, SIAM J. Sci.
Comput. 19 (1998) 1188).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rodgen.analyse.cycles.elimination import Complex
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.periodicity import (
    DONE,
    Lap,
    Linearisation,
    NewtonSolver,
    Orbit,
    OrbitSolver,
)
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.progress import report_stage

SEGMENTS = 4

# Of the Newton-Picard method.
LEADING = 10  # multipliers, unless others are asked for
GUARD = 4  # directions beside those that are asked for
SMALL = 0.3  # a multiplier below it is left to Picard's iteration
ITERATIONS = 60
SETTLED, ROUNDED = 1e-9, 1e-8  # of the multipliers; a correction that no longer shrinks


def _segments(orbit: Orbit) -> list[tuple[float, Array, float]]:
    """Start [s], state and span [s] of every segment."""
    share = orbit.period / len(orbit.x)
    return [(orbit.t + i * share, x, share) for i, x in enumerate(orbit.x)]


@dataclass(frozen=True)
class Shooting(NewtonSolver[Orbit]):
    """Multiple shooting: runs of a flow over equal segments of the period."""

    segments: int = SEGMENTS

    def find_orbit(self, lap: Lap) -> Orbit:
        flow = self.flow.choose_method(lap.t, lap.states(np.zeros(())), lap.period)
        return replace(self, flow=flow).solve(lap.to_orbit(self.segments))

    def linearise(self, orbit: Orbit) -> Linearisation:
        made = [self.flow.state_and_tangents_after(t, x, span) for t, x, span in _segments(orbit)]
        ends = [end for end, _ in made]
        return self.assemble(orbit, [G for _, G in made], self._by_period(orbit, ends), ends)

    def update_residuals(self, orbit: Orbit, by: Linearisation) -> Linearisation:
        """Compute the residuals alone: derivatives cost ten times as much."""
        ends = [self.flow.state_after(t, x, span) for t, x, span in _segments(orbit)]
        return self.assemble(orbit, by.G, self._by_period(orbit, ends), ends)._replace(G=by.G)

    def apply_correction(
        self, orbit: Orbit, at: Linearisation, share: float, d: Array, longer: float
    ) -> Orbit:
        return replace(orbit, x=orbit.x + share * d, period=orbit.period + share * longer)

    def _by_period(self, orbit: Orbit, ends: Sequence[Array]) -> list[Array]:
        return [
            self.flow.rates(t + span, end) / len(orbit.x)
            for (t, _, span), end in zip(_segments(orbit), ends, strict=True)
        ]


@dataclass(frozen=True)
class NewtonPicard(OrbitSolver[Orbit]):
    """Newton-Picard method. leading: how many multipliers are asked for.

    A basis of the directions that decay least is carried along the motion as tangents. What it has
    become after a period is the next basis: subspace iteration.
    """

    leading: int = LEADING

    def find_orbit(self, lap: Lap) -> Orbit:
        orbit = lap.to_orbit(1)
        flow = self.flow.choose_method(orbit.t, orbit.x[0], orbit.period)
        return replace(self, flow=flow)._solve(orbit)

    def _solve(self, orbit: Orbit) -> Orbit:
        size, q = orbit.x.shape[1], self.flow.quotient
        unit = np.where(np.arange(size) < q.positions, 1.0, 2 * np.pi / orbit.period)
        count = min(size, self.leading + GUARD)
        V = np.linalg.qr(np.random.default_rng(1).standard_normal((size, count)))[0]
        before: Complex | None = None
        for _ in range(ITERATIONS):
            last = orbit.change
            report_stage(f"a period of {orbit.period:.6g} s, corrected by {last:.1g}")
            moved, V, mu = self._correct(orbit, unit, V)
            off = np.inf
            if before is not None and len(before) == len(mu):
                off = max(float(np.abs(before - one).min()) for one in mu[: self.leading])
            still = moved.change <= DONE or (moved.change <= ROUNDED and moved.change >= last / 2)
            if still and off <= SETTLED:
                return replace(orbit, leading=mu[: self.leading])
            orbit, before = moved, mu
            if abs(mu[-1]) > SMALL and V.shape[1] < size:  # Picard's iteration would crawl
                more = np.random.default_rng(V.shape[1]).standard_normal((size, GUARD))
                V = np.linalg.qr(np.hstack((V, more)))[0][:, :size]
        raise AnalysisError(
            f"Newton's method and Picard's iteration found no periodic motion near a period of "
            f"{orbit.period:.6g} s (the last correction {orbit.change:.1e} of its size)"
        )

    def _correct(self, orbit: Orbit, unit: Array, V: Array) -> tuple[Orbit, Array, Complex]:
        """Apply one correction. Returns the orbit, the next basis, and the multipliers."""
        flow, q, x = self.flow, self.flow.quotient, orbit.x[0]
        end, W = flow.state_and_tangents_after(orbit.t, x, orbit.period, unit[:, None] * V)
        W = q.rotate_columns(W, -orbit.angle) / unit[:, None]
        here = q.rotate(end, -orbit.angle)
        r = (here - x) / unit
        ways = self._columns(flow, orbit, end, here) / unit[:, None]
        rows = self.phase_directions(orbit) * unit
        rows = rows / np.linalg.norm(rows, axis=1, keepdims=True)
        # Newton's equations in the basis; the rest is what a period makes of all that is known.
        k, H = V.shape[1], V.T @ W
        off_W, off_ways, off_r = (one - V @ (V.T @ one) for one in (W, ways, r))
        matrix = np.block([[H - np.eye(k), V.T @ ways], [rows @ (V + off_W), rows @ off_ways]])
        found = np.linalg.solve(matrix, -np.concatenate((V.T @ r, rows @ off_r)))
        p, more = found[:k], found[k:]
        d = unit * (V @ p + off_r + off_W @ p + off_ways @ more)
        moved, share, longer = self.limit_correction(orbit, d, more)
        moved = replace(
            moved,
            x=orbit.x + share * d,
            period=orbit.period + share * longer,
            residual=float(np.abs(here - x).max()) / orbit.scale,
        )
        mu = np.linalg.eigvals(H).astype(complex)
        return moved, np.linalg.qr(W)[0], mu[np.argsort(-np.abs(mu), kind="stable")]

    def _columns(self, flow: Flow, orbit: Orbit, end: Array, here: Array) -> Array:
        """Derivatives of the end of the period by its length and by the angle (size, k)."""
        q, ways = flow.quotient, list[Array]()
        if not self.forced:
            rates = flow.rates(orbit.t + orbit.period, end)
            ways.append(q.rotate_columns(rates[:, None], -orbit.angle)[:, 0])
        if self.turns:
            ways.append(-q.turning(here))
        return np.array(ways).reshape(-1, len(end)).T
