"""Periodic motions by multiple shooting: Newton's method on the states where segments start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from rodgen.analyse.cycles.elimination import Complex, Condensed
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.errors import AnalysisError
from rodgen.integrate.stepper import Array

ITERATIONS = 20
DONE = 1e-11  # of the size of the motion: the last correction of Newton's method
ROUNDED = 1e-8  # likewise, of a correction that no longer shrinks
LONGEST = 0.5  # the largest share by which a correction changes the period or the motion
CHORD, QUICK = 1e-2, 0.2  # corrections from which older derivatives will do, while they shrink so
LOST, NEARBY = 30.0, 1e-3  # times the least residual, or of the motion: Newton's method is lost
PATIENCE, HOPE = 4, 0.3  # iterations in which the residual has to shrink so much
FARTHEST = 1.5  # times the period that it began with, or a part of it


@dataclass(frozen=True)
class Orbit:
    """x: states that count at the starts of m equal segments (m, size); t: the first start [s];
    period [s]; angle: by which the whole rod has turned after it [rad]; scale: the size of the
    motion; condensed: the segments'
    derivatives; residual, change: of the closing and the last correction, over the size of the
    motion; iterations: of Newton's method."""

    x: Array
    t: float
    period: float
    angle: float
    scale: float
    condensed: Condensed | None = field(default=None, repr=False)
    residual: float = np.inf
    change: float = np.inf
    iterations: int = 0


class Linearised(NamedTuple):
    """Derivatives of segments G_i (m, size, size), columns by period and by angle B_i (m, size, k),
    and residuals r_i (m, size), as `elimination` has them."""

    G: list[Array]
    B: list[Array]
    r: list[Array]


def _segments(orbit: Orbit) -> list[tuple[float, Array, float]]:
    """Start [s], state and span [s] of every segment."""
    share = orbit.period / len(orbit.x)
    return [(orbit.t + i * share, x, share) for i, x in enumerate(orbit.x)]


@dataclass(frozen=True)
class Shooting:
    """What closes a motion: after a period (forced: that is given) it is where it began, turned by
    an angle (turns: that is sought as well)."""

    flow: Flow
    forced: bool = False

    @property
    def turns(self) -> bool:
        """Whether the angle after a period is an unknown."""
        return self.flow.quotient.turns

    @property
    def trivial(self) -> int:
        """How many multipliers are 1 whatever the motion."""
        return (not self.forced) + self.turns

    def linearised(self, orbit: Orbit) -> Linearised:
        """Derivatives and residuals at an orbit. Raises AnalysisError."""
        made = [self.flow.with_tangents(t, x, span) for t, x, span in _segments(orbit)]
        ends, grown = [end for end, _ in made], [G for _, G in made]
        grown[-1] = self.flow.quotient.turned_columns(grown[-1], -orbit.angle)
        return Linearised(grown, self._columns(orbit, ends), self._residuals(orbit, ends))

    def anew(self, orbit: Orbit, by: Linearised) -> Linearised:
        """With the derivatives of an orbit close by, which cost ten times what the residuals do.
        Raises AnalysisError."""
        ends = [self.flow.carried(t, x, span) for t, x, span in _segments(orbit)]
        return Linearised(by.G, self._columns(orbit, ends), self._residuals(orbit, ends))

    def _columns(self, orbit: Orbit, ends: Sequence[Array]) -> list[Array]:
        """Derivatives of the ends of segments by the period and by the angle (size, k)."""
        count, q = len(orbit.x), self.flow.quotient
        made = list[Array]()
        for (t, x, span), end in zip(_segments(orbit), ends, strict=True):
            last = len(made) == count - 1
            ways = [] if self.forced else [self.flow.rates(t + span, end) / count]
            if last:
                ways = [q.turned_columns(way[:, None], -orbit.angle)[:, 0] for way in ways]
            if self.turns:
                way = -q.turning(q.turned(end, -orbit.angle)) if last else np.zeros(len(x))
                ways.append(way)
            made.append(np.array(ways).reshape(-1, len(x)).T)
        return made

    def _residuals(self, orbit: Orbit, ends: Sequence[Array]) -> list[Array]:
        """By how much segments miss where the next ones begin."""
        last = self.flow.quotient.turned(ends[-1], -orbit.angle)
        after = [*orbit.x[1:], orbit.x[0]]
        return [x - end for x, end in zip(after, [*ends[:-1], last], strict=True)]

    def directions(self, orbit: Orbit) -> Array:
        """In which the first state (k, size) is not to move: along the motion, unless it is forced,
        and as the rod turns."""
        ways = [] if self.forced else [self.flow.rates(orbit.t, orbit.x[0])]
        ways += [self.flow.quotient.turning(orbit.x[0])] * self.turns
        return np.array(ways).reshape(-1, orbit.x.shape[1])

    def solved(self, orbit: Orbit) -> Orbit:
        """The periodic motion by an orbit, with its segments' derivatives. Raises AnalysisError."""
        kept, at, least = orbit, self.linearised(orbit), list[float]()
        while kept.iterations < ITERATIONS:
            residual = float(np.abs(at.r).max()) / kept.scale
            least.append(min([residual, *least[-1:]]))
            if not residual <= LOST * max(least[-1], NEARBY):
                break
            if len(least) > PATIENCE and least[-1] > HOPE * least[-1 - PATIENCE]:
                break
            before = kept.change
            kept = replace(self._corrected(kept, at), residual=residual)
            if not 1 / FARTHEST < kept.period / orbit.period < FARTHEST:
                break
            if kept.change <= DONE or (kept.change <= ROUNDED and kept.change >= 0.5 * before):
                return self.closed(kept)
            near = kept.change < CHORD and kept.change < QUICK * before
            at = self.anew(kept, at) if near else self.linearised(kept)
        raise AnalysisError(
            f"Newton's method found no periodic motion near a period of {orbit.period:.6g} s "
            f"({kept.iterations} iterations, the last correction {kept.change:.1e} of its size)"
        )

    def closed(self, orbit: Orbit) -> Orbit:
        """An orbit that closes, with its derivatives. Raises AnalysisError."""
        at = self.linearised(orbit)
        residual = float(np.abs(at.r).max()) / orbit.scale
        return replace(orbit, condensed=Condensed.of(at.G, at.B, at.r), residual=residual)

    def _corrected(self, orbit: Orbit, at: Linearised) -> Orbit:
        """After one correction. Raises AnalysisError."""
        ways = self.directions(orbit)
        ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        rows = np.hstack((ways, np.zeros((len(ways), len(ways)))))
        d, more = Condensed.of(at.G, at.B, at.r).solved(rows, np.zeros(len(ways)))
        if not (np.isfinite(d).all() and np.isfinite(more).all()):
            raise AnalysisError("Newton's method leaves the range of numbers")
        return self._moved(orbit, d, more)

    def _moved(self, orbit: Orbit, d: Array, more: Array) -> Orbit:
        change = float(np.abs(d).max()) / orbit.scale
        longer = 0.0 if self.forced else float(more[0])
        turn = float(more[-1]) if self.turns else 0.0
        most = max(change, abs(longer) / orbit.period)
        share = min(1.0, LONGEST / most) if most else 1.0
        return replace(
            orbit,
            x=orbit.x + share * d,
            period=orbit.period + share * longer,
            angle=orbit.angle + share * turn,
            change=most,
            iterations=orbit.iterations + 1,
        )


def multipliers(orbit: Orbit) -> Complex:
    """Of an orbit that was solved, the largest first."""
    assert orbit.condensed is not None
    return orbit.condensed.multipliers()


def cut(flow: Flow, t: float, x: Array, period: float, segments: int) -> Array:
    """States (segments, size) at the starts of equal segments of a motion from x at time t [s]."""
    states = [x]
    for i in range(segments - 1):
        share = period / segments
        states.append(flow.carried(t + i * share, states[-1], share))
    return np.array(states)
