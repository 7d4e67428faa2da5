"""Periodic motions by multiple shooting: runs over equal segments of the period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rodgen.analyse.cycles.periodicity import Lap, Linearisation, NewtonSolver, Orbit
from rodgen.arrays import Array

SEGMENTS = 4


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
