"""Newton's method for periodic motions: unknown are the states where parts of the period start, so
that each part leads to the next one, and the last one back to the first."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from rodgen.analyse.cycles.elimination import Complex, CondensedSystem
from rodgen.analyse.cycles.flow import Flow
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.progress import report_stage

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
    """A periodic motion, or a guess of one. x: reduced states at the starts of m parts of the
    period (m, size); t: the first start [s]; period [s]; angle: by which the whole rod has turned
    after it [rad]; scale: the size of the motion; condensed: derivatives of the parts; residual,
    change: of the closing and of the last correction, over scale; iterations: of Newton's method;
    error: of the period and the larger multipliers, from their changes between meshes, where there
    is one; leading: the multipliers where not all are computed."""

    x: Array
    t: float
    period: float
    angle: float
    scale: float
    condensed: CondensedSystem | None = field(default=None, repr=False)
    residual: float = np.inf
    change: float = np.inf
    iterations: int = 0
    error: float = 0.0
    leading: Complex | None = field(default=None, repr=False)

    @property
    def multipliers(self) -> Complex:
        """Multipliers of a solved orbit, the largest first: all of them, or the leading ones."""
        if self.leading is not None:
            return self.leading
        assert self.condensed is not None
        return self.condensed.multipliers


@dataclass(frozen=True)
class Lap:
    """A run from t [s] on that nearly comes back after a period [s], turned by an angle [rad];
    scale: its size; way: its reduced states over the time since t."""

    t: float
    period: float
    angle: float
    scale: float
    way: CubicHermiteSpline = field(repr=False)

    def states(self, shares: Array) -> Array:
        """States (..., size) at shares (...) of the period."""
        return np.asarray(self.way(shares * self.period))

    def to_orbit(self, segments: int) -> Orbit:
        """Make an orbit with the states at the starts of equal segments."""
        x = self.states(np.arange(segments) / segments)
        return Orbit(x, self.t, self.period, self.angle, self.scale)


class Linearisation(NamedTuple):
    """Linearised closing as in `elimination`: derivatives of parts G (m, size, size), columns by
    period and angle B (m, size, k), residuals r (m, size); inner: data within the parts."""

    G: list[Array]
    B: list[Array]
    r: list[Array]
    inner: Any = None


O = TypeVar("O", bound=Orbit)


@dataclass(frozen=True)
class OrbitSolver(ABC, Generic[O]):
    """Interface of methods for periodic motions of a flow: after a period (forced: it is given) the
    state is where it began, turned by an angle (turns: it is unknown)."""

    flow: Flow
    forced: bool = False

    @property
    def turns(self) -> bool:
        """Whether the angle after a period is an unknown."""
        return self.flow.quotient.turns

    @property
    def trivial(self) -> int:
        """Number of multipliers that are 1 for every motion."""
        return (not self.forced) + self.turns

    @abstractmethod
    def find_orbit(self, lap: Lap) -> O:
        """Find the periodic motion near a lap. Raises AnalysisError."""

    def path(self, orbit: O, count: int) -> Array:
        """States (count, size) at equally spaced times of the period, from its start on."""
        flow = self.flow.choose_method(orbit.t, orbit.x[0], orbit.period)
        return flow.segment_states(orbit.t, orbit.x[0], orbit.period, count)

    def limit_correction(self, orbit: O, d: Array, more: Array) -> tuple[O, float, float]:
        """Limit a correction, d of the states and more of the period and the angle, to a share of
        it, by which the angle is corrected here. Returns the orbit, the share, and the whole
        change of the period [s]. Raises AnalysisError."""
        if not (np.isfinite(d).all() and np.isfinite(more).all()):
            raise AnalysisError("Newton's method leaves the range of numbers")
        longer = 0.0 if self.forced else float(more[0])
        turn = float(more[-1]) if self.turns else 0.0
        most = max(float(np.abs(d).max()) / orbit.scale, abs(longer) / orbit.period)
        share = min(1.0, LONGEST / most) if most else 1.0
        angle, iterations = orbit.angle + share * turn, orbit.iterations + 1
        return replace(orbit, angle=angle, change=most, iterations=iterations), share, longer

    def phase_directions(self, orbit: Orbit) -> Array:
        """Directions (k, size) in which the first state is not corrected: along the motion, unless
        it is forced, and as the rod turns."""
        ways = [] if self.forced else [self.flow.rates(orbit.t, orbit.x[0])]
        ways += [self.flow.quotient.turning(orbit.x[0])] * self.turns
        return np.array(ways).reshape(-1, orbit.x.shape[1])


@dataclass(frozen=True)
class NewtonSolver(OrbitSolver[O]):
    """Newton's method for the states at the starts of all parts of the period."""

    @abstractmethod
    def linearise(self, orbit: O) -> Linearisation:
        """Compute derivatives and residuals at an orbit. Raises AnalysisError."""

    @abstractmethod
    def update_residuals(self, orbit: O, by: Linearisation) -> Linearisation:
        """Compute the residuals at an orbit, with the derivatives of one close by if they cost
        much. Raises AnalysisError."""

    @abstractmethod
    def apply_correction(
        self, orbit: O, at: Linearisation, share: float, d: Array, longer: float
    ) -> O:
        """Correct an orbit by a share of d (m, size) at the starts of its parts and of the change
        `longer` of the period [s]; the states within the parts follow."""

    def assemble(
        self,
        orbit: Orbit,
        G: Sequence[Array],
        by_period: Sequence[Array],
        ends: Sequence[Array],
        inner: Any = None,
    ) -> Linearisation:
        """Assemble the linearised closing from the parts' ends (m, size) and their derivatives."""
        q = self.flow.quotient
        grown, ways = list(G), [one[:, None] for one in by_period]
        grown[-1] = q.rotate_columns(grown[-1], -orbit.angle)
        ways[-1] = q.rotate_columns(ways[-1], -orbit.angle)
        last = q.rotate(ends[-1], -orbit.angle)
        columns = []
        for at, way in enumerate(ways):
            made = [] if self.forced else [way[:, 0]]
            if self.turns:
                made.append(-q.turning(last) if at == len(ways) - 1 else np.zeros(len(last)))
            columns.append(np.array(made).reshape(-1, len(last)).T)
        after = [*orbit.x[1:], orbit.x[0]]
        residuals = [x - end for x, end in zip(after, [*ends[:-1], last], strict=True)]
        return Linearisation(grown, columns, residuals, inner)

    def solve(self, orbit: O, done: float = DONE) -> O:
        """Find the periodic motion near an orbit, with its parts' derivatives; done: the last
        correction, over the size of the motion. Raises AnalysisError."""
        kept, at, least = orbit, self.linearise(orbit), list[float]()
        while kept.iterations - orbit.iterations < ITERATIONS:
            residual = float(np.abs(at.r).max()) / kept.scale
            report_stage(f"a period of {kept.period:.6g} s, closed to {residual:.1g}")
            least.append(min([residual, *least[-1:]]))
            if not residual <= LOST * max(least[-1], NEARBY):
                break
            if len(least) > PATIENCE and least[-1] > HOPE * least[-1 - PATIENCE]:
                break
            before = kept.change
            kept = replace(self._correct(kept, at), residual=residual)
            if not 1 / FARTHEST < kept.period / orbit.period < FARTHEST:
                break
            if kept.change <= done or (kept.change <= ROUNDED and kept.change >= 0.5 * before):
                return self.complete(kept)
            near = kept.change < CHORD and kept.change < QUICK * before
            at = self.update_residuals(kept, at) if near else self.linearise(kept)
        raise AnalysisError(
            f"Newton's method found no periodic motion near a period of {orbit.period:.6g} s "
            f"({kept.iterations} iterations, the last correction {kept.change:.1e} of its size)"
        )

    def complete(self, orbit: O) -> O:
        """Complete a closed orbit by its derivatives and residual. Raises AnalysisError."""
        at = self.linearise(orbit)
        residual = float(np.abs(at.r).max()) / orbit.scale
        return replace(orbit, condensed=CondensedSystem.of(at.G, at.B, at.r), residual=residual)

    def _correct(self, orbit: O, at: Linearisation) -> O:
        """Apply one correction of Newton's method. Raises AnalysisError."""
        ways = self.phase_directions(orbit)
        ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        rows = np.hstack((ways, np.zeros((len(ways), len(ways)))))
        d, more = CondensedSystem.of(at.G, at.B, at.r).solve(rows, np.zeros(len(ways)))
        orbit, share, longer = self.limit_correction(orbit, d, more)
        return self.apply_correction(orbit, at, share, d, longer)
