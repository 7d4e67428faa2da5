"""Periodic motions by multiple shooting: Newton's method on the states where segments start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rodgen.analyse.cycles.elimination import Complex, Condensed
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.errors import AnalysisError
from rodgen.integrate.stepper import Array

ITERATIONS = 30
DONE = 1e-11  # of the size of the motion: the last correction of Newton's method
ROUNDED = 1e-8  # likewise, of a correction that no longer shrinks
LONGEST = 0.5  # the largest share by which a correction changes the period or the motion


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


@dataclass(frozen=True)
class Shooting:
    """What closes a motion: after a period (forced: that is given) it is where it began, turned by
    an angle (turns: that is sought as well).

    gradients: of conserved quantities at a state (size,), (count, size): where there are any, the
    values that the first state has are kept, for such motions come in families.
    """

    flow: Flow
    forced: bool = False
    conserved: Sequence[object] = ()

    @property
    def turns(self) -> bool:
        """Whether the angle after a period is an unknown."""
        return self.flow.quotient.turns

    @property
    def trivial(self) -> int:
        """How many multipliers are 1 whatever the motion."""
        return (not self.forced) + self.turns

    def linearised(self, orbit: Orbit) -> tuple[list[Array], list[Array], list[Array]]:
        """Derivatives of segments G_i, columns by period and by angle B_i, and residuals r_i, as
        `elimination` has them. Raises AnalysisError."""
        count, q = len(orbit.x), self.flow.quotient
        share = orbit.period / count
        G, B, r = list[Array](), list[Array](), list[Array]()
        for i, x in enumerate(orbit.x):
            start = orbit.t + i * share
            end, grown = self.flow.with_tangents(start, x, share)
            columns = [] if self.forced else [self.flow.rates(start + share, end) / count]
            last = i == count - 1
            if last:
                end, grown = q.turned(end, -orbit.angle), q.turned_columns(grown, -orbit.angle)
                columns = [q.turned_columns(one[:, None], -orbit.angle)[:, 0] for one in columns]
            if self.turns:
                columns.append(-q.turning(end) if last else np.zeros(len(x)))
            G.append(grown)
            B.append(np.array(columns).reshape(-1, len(x)).T)
            r.append(orbit.x[(i + 1) % count] - end)
        return G, B, r

    def conditions(self, orbit: Orbit) -> Array:
        """Directions (k, size) in which the first state is not to move: along the motion, unless it
        is forced, and as the rod turns."""
        ways = [] if self.forced else [self.flow.rates(orbit.t, orbit.x[0])]
        ways += [self.flow.quotient.turning(orbit.x[0])] * self.turns
        return np.array([way / np.linalg.norm(way) for way in ways]).reshape(-1, orbit.x.shape[1])

    def solved(self, orbit: Orbit) -> Orbit:
        """The periodic motion by an orbit, with its segments' derivatives. Raises AnalysisError."""
        before, kept = np.inf, orbit
        for iteration in range(1, ITERATIONS + 1):
            G, B, r = self.linearised(kept)
            residual = float(np.abs(r).max()) / kept.scale
            condensed = Condensed.of(G, B, r)
            if kept.change <= DONE or (kept.change <= ROUNDED and kept.change >= 0.5 * before):
                return replace(kept, condensed=condensed, residual=residual)
            ways = self.conditions(kept)
            rows = np.hstack((ways, np.zeros((len(ways), len(ways)))))
            d, more = condensed.solved(rows, np.zeros(len(ways)))
            if not (np.isfinite(d).all() and np.isfinite(more).all()):
                break
            before = kept.change
            kept = replace(self._moved(kept, d, more), iterations=iteration)
            if not kept.period > 0:
                break
        raise AnalysisError(
            f"Newton's method found no periodic motion near a period of {orbit.period:.6g} s "
            f"({kept.iterations} iterations, the last correction {kept.change:.1e} of its size)"
        )

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
