"""Periodic motions by Newton's method: states where parts of the period start, so that each part
leads to the next one, and the last one back to the first."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from rodgen.analyse.cycles.elimination import Complex, Condensed
from rodgen.analyse.cycles.flow import Flow
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.progress import tell

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
    """x: states that count at the starts of m parts of the period (m, size); t: the first start
    [s]; period [s]; angle: by which the whole rod has turned after it [rad]; scale: the size of the
    motion; condensed: the parts' derivatives; residual, change: of the closing and the last
    correction, over the size of the motion; iterations: of Newton's method; error: of the period
    and the larger multipliers by how these have changed from mesh to mesh, where there is one;
    leading: the multipliers where not all are computed."""

    x: Array
    t: float
    period: float
    angle: float
    scale: float
    condensed: Condensed | None = field(default=None, repr=False)
    residual: float = np.inf
    change: float = np.inf
    iterations: int = 0
    error: float = 0.0
    leading: Complex | None = field(default=None, repr=False)

    @property
    def multipliers(self) -> Complex:
        """Of an orbit that was solved, the largest first: all of them, or the leading ones."""
        if self.leading is not None:
            return self.leading
        assert self.condensed is not None
        return self.condensed.multipliers()


@dataclass(frozen=True)
class Lap:
    """A motion from t [s] on that nearly comes back after a period [s], turned by an angle [rad];
    scale: its size; way: its states that count, by the time since t."""

    t: float
    period: float
    angle: float
    scale: float
    way: CubicHermiteSpline = field(repr=False)

    def at(self, shares: Array) -> Array:
        """States (..., size) at shares (...) of the period."""
        return np.asarray(self.way(shares * self.period))

    def orbit(self, segments: int) -> Orbit:
        """With its states at the starts of equal segments."""
        x = self.at(np.arange(segments) / segments)
        return Orbit(x, self.t, self.period, self.angle, self.scale)


class Linearised(NamedTuple):
    """Derivatives of parts G_i (m, size, size), columns by period and by angle B_i (m, size, k),
    and residuals r_i (m, size), as `elimination` has them; inner: what is within them."""

    G: list[Array]
    B: list[Array]
    r: list[Array]
    inner: Any = None


O = TypeVar("O", bound=Orbit)


@dataclass(frozen=True)
class Closing(ABC, Generic[O]):
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

    @abstractmethod
    def found(self, lap: Lap) -> O:
        """The periodic motion by one that nearly is. Raises AnalysisError."""

    @abstractmethod
    def path(self, orbit: O, count: int) -> Array:
        """States (count, size) at equal times of the period, from its start on."""

    def directions(self, orbit: Orbit) -> Array:
        """In which the first state (k, size) is not to move: along the motion, unless it is forced,
        and as the rod turns."""
        ways = [] if self.forced else [self.flow.rates(orbit.t, orbit.x[0])]
        ways += [self.flow.quotient.turning(orbit.x[0])] * self.turns
        return np.array(ways).reshape(-1, orbit.x.shape[1])


@dataclass(frozen=True)
class Newton(Closing[O]):
    """Newton's method for all states at the starts of parts."""

    @abstractmethod
    def linearised(self, orbit: O) -> Linearised:
        """Derivatives and residuals at an orbit. Raises AnalysisError."""

    @abstractmethod
    def anew(self, orbit: O, by: Linearised) -> Linearised:
        """With the derivatives of an orbit close by, where these cost much. Raises
        AnalysisError."""

    @abstractmethod
    def within(self, orbit: O, at: Linearised, share: float, d: Array, longer: float) -> O:
        """An orbit of which the starts of the parts and the period have changed by a share of d
        (m, size) and of so much [s], with what is within the parts."""

    def joined(
        self,
        orbit: Orbit,
        G: Sequence[Array],
        by_period: Sequence[Array],
        ends: Sequence[Array],
        inner: Any = None,
    ) -> Linearised:
        """Of the derivatives of the ends of parts (m, size) by their starts and by the period."""
        q = self.flow.quotient
        grown, ways = list(G), [one[:, None] for one in by_period]
        grown[-1] = q.turned_columns(grown[-1], -orbit.angle)
        ways[-1] = q.turned_columns(ways[-1], -orbit.angle)
        last = q.turned(ends[-1], -orbit.angle)
        columns = []
        for at, way in enumerate(ways):
            made = [] if self.forced else [way[:, 0]]
            if self.turns:
                made.append(-q.turning(last) if at == len(ways) - 1 else np.zeros(len(last)))
            columns.append(np.array(made).reshape(-1, len(last)).T)
        after = [*orbit.x[1:], orbit.x[0]]
        residuals = [x - end for x, end in zip(after, [*ends[:-1], last], strict=True)]
        return Linearised(grown, columns, residuals, inner)

    def solved(self, orbit: O, done: float = DONE) -> O:
        """The periodic motion by an orbit, with its parts' derivatives; done: the last correction,
        over the size of the motion. Raises AnalysisError."""
        kept, at, least = orbit, self.linearised(orbit), list[float]()
        while kept.iterations - orbit.iterations < ITERATIONS:
            residual = float(np.abs(at.r).max()) / kept.scale
            tell(f"a period of {kept.period:.6g} s, closed to {residual:.1g}")
            least.append(min([residual, *least[-1:]]))
            if not residual <= LOST * max(least[-1], NEARBY):
                break
            if len(least) > PATIENCE and least[-1] > HOPE * least[-1 - PATIENCE]:
                break
            before = kept.change
            kept = replace(self._corrected(kept, at), residual=residual)
            if not 1 / FARTHEST < kept.period / orbit.period < FARTHEST:
                break
            if kept.change <= done or (kept.change <= ROUNDED and kept.change >= 0.5 * before):
                return self.closed(kept)
            near = kept.change < CHORD and kept.change < QUICK * before
            at = self.anew(kept, at) if near else self.linearised(kept)
        raise AnalysisError(
            f"Newton's method found no periodic motion near a period of {orbit.period:.6g} s "
            f"({kept.iterations} iterations, the last correction {kept.change:.1e} of its size)"
        )

    def closed(self, orbit: O) -> O:
        """An orbit that closes, with its derivatives. Raises AnalysisError."""
        at = self.linearised(orbit)
        residual = float(np.abs(at.r).max()) / orbit.scale
        return replace(orbit, condensed=Condensed.of(at.G, at.B, at.r), residual=residual)

    def _corrected(self, orbit: O, at: Linearised) -> O:
        """After one correction. Raises AnalysisError."""
        ways = self.directions(orbit)
        ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        rows = np.hstack((ways, np.zeros((len(ways), len(ways)))))
        d, more = Condensed.of(at.G, at.B, at.r).solved(rows, np.zeros(len(ways)))
        if not (np.isfinite(d).all() and np.isfinite(more).all()):
            raise AnalysisError("Newton's method leaves the range of numbers")
        change = float(np.abs(d).max()) / orbit.scale
        longer = 0.0 if self.forced else float(more[0])
        turn = float(more[-1]) if self.turns else 0.0
        most = max(change, abs(longer) / orbit.period)
        share = min(1.0, LONGEST / most) if most else 1.0
        return replace(
            self.within(orbit, at, share, d, longer),
            angle=orbit.angle + share * turn,
            change=most,
            iterations=orbit.iterations + 1,
        )
