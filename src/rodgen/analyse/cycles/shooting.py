"""Periodic motions by multiple shooting: runs over equal segments of the period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rodgen.analyse.cycles.closing import Lap, Linearised, Newton, Orbit
from rodgen.analyse.cycles.flow import Flow
from rodgen.arrays import Array

SEGMENTS = 4


def _segments(orbit: Orbit) -> list[tuple[float, Array, float]]:
    """Start [s], state and span [s] of every segment."""
    share = orbit.period / len(orbit.x)
    return [(orbit.t + i * share, x, share) for i, x in enumerate(orbit.x)]


@dataclass(frozen=True)
class Shooting(Newton[Orbit]):
    """Runs of a flow over so many segments of the period."""

    segments: int = SEGMENTS

    def found(self, lap: Lap) -> Orbit:
        flow = self.flow.suited(lap.t, lap.at(np.zeros(())), lap.period)
        return replace(self, flow=flow).solved(lap.orbit(self.segments))

    def path(self, orbit: Orbit, count: int) -> Array:
        flow = self.flow.suited(orbit.t, orbit.x[0], orbit.period)
        return cut(flow, orbit.t, orbit.x[0], orbit.period, count)

    def linearised(self, orbit: Orbit) -> Linearised:
        made = [self.flow.with_tangents(t, x, span) for t, x, span in _segments(orbit)]
        ends = [end for end, _ in made]
        return self.joined(orbit, [G for _, G in made], self._by_period(orbit, ends), ends)

    def anew(self, orbit: Orbit, by: Linearised) -> Linearised:
        """Derivatives cost ten times what the residuals do."""
        ends = [self.flow.carried(t, x, span) for t, x, span in _segments(orbit)]
        return self.joined(orbit, by.G, self._by_period(orbit, ends), ends)._replace(G=by.G)

    def within(self, orbit: Orbit, at: Linearised, share: float, d: Array, longer: float) -> Orbit:
        return replace(orbit, x=orbit.x + share * d, period=orbit.period + share * longer)

    def _by_period(self, orbit: Orbit, ends: Sequence[Array]) -> list[Array]:
        return [
            self.flow.rates(t + span, end) / len(orbit.x)
            for (t, _, span), end in zip(_segments(orbit), ends, strict=True)
        ]


def cut(flow: Flow, t: float, x: Array, period: float, segments: int) -> Array:
    """States (segments, size) at the starts of equal segments of a motion from x at time t [s]."""
    states = [x]
    for i in range(segments - 1):
        share = period / segments
        states.append(flow.carried(t + i * share, states[-1], share))
    return np.array(states)
