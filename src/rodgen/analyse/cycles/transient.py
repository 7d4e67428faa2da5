"""Runs that settle on a periodic motion: whether one has come near it, and the period."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rodgen.analyse.cycles.symmetry import SymmetryReduction
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import RunError
from rodgen.system import System

SAMPLES = 20_000  # of a run: tens of every turn of the slowest motions
PER_PERIOD = 64  # samples of a run under loads that repeat
LAP = 256  # samples of a period, from which Newton's method begins
AWAY = 0.3  # of the farthest that a motion goes away, before it can be said to come back
NEAR = 0.1  # likewise, from where Newton's method is tried
ALIKE = 1.5, 1e-3  # times the nearest return, and beside it: a return that counts as much
MOST_PERIODS = 32  # of loads, after which a motion is expected back


@dataclass(frozen=True)
class Return:
    """Return of a run to an earlier state. x: the reduced state (size,) at a time t [s]; period
    [s]; angle: by which the rod is turned [rad]; distance: from where it was a period before, as a
    share of the farthest that it goes away; scale: `extent` of the motion."""

    t: float
    x: Array = field(repr=False)
    period: float
    angle: float
    distance: float
    scale: float


def run_from(
    system: System, y: Array, t: float, span: float, every: float, target: str | None = None
) -> tuple[Array, Array]:
    """Run a system from y at a time t [s]: times (K,) and states (K, states). Raises
    AnalysisError."""
    try:
        made = system.with_settings(span=[t, t + span], output_every=every).at(y0=y)
        run = simulate(made, target=target)
    except RunError as error:
        raise AnalysisError(f"the run up to {t + span:g} s cannot be finished: {error}") from error
    return run.t, run.y


def last_return(
    t: Array, x: Array, quotient: SymmetryReduction, forced: float = 0.0
) -> Return | None:
    """Find the nearest earlier passage of a motion by its last state; None where there is none.

    t (K,), x (K, size): of the run, forced: the period of its loads [s], if they repeat; the period
    sought is then a whole multiple of it.
    """
    shape, angles = _turn_back(x, quotient)
    away = shape - shape.mean(axis=0)
    scales = _scales(away, quotient)
    laps = np.zeros(len(t))
    if not quotient.turns and len(quotient.angles):
        mean = shape[:, quotient.angles].mean(axis=1)
        laps = 2 * np.pi * np.round((mean - mean[-1]) / (2 * np.pi))
        shape = shape.copy()
        shape[:, quotient.angles] -= laps[:, None]
    distance = np.linalg.norm((shape - shape[-1]) / scales, axis=1)
    farthest = distance.max()
    if not (np.isfinite(farthest) and farthest > 0):
        return None
    found = _forced_returns(t, distance, forced) if forced else _free_returns(t, distance)
    near = [(lag, d, at) for lag, d, at in found if d <= NEAR * farthest]
    if not near:
        return None
    best = min(d for _, d, _ in near)
    lag, d, at = next(one for one in near if one[1] <= max(ALIKE[0] * best, ALIKE[1] * farthest))
    turned = angles[-1] - angles[at] if quotient.turns else laps[-1] - laps[at]
    recent = x[t >= t[-1] - 2 * lag]
    return Return(
        t=float(t[-1]),
        x=x[-1].copy(),
        period=lag,
        angle=float(turned),
        distance=float(d / farthest),
        scale=extent(recent, quotient),
    )


def extent(x: Array, quotient: SymmetryReduction) -> float:
    """Largest deviation of a state from the middle of a motion x (K, size), apart from turning the
    whole rod where that is a symmetry."""
    shape = _turn_back(x, quotient)[0]
    return float((shape.max(axis=0) - shape.min(axis=0)).max()) / 2


def _turn_back(x: Array, quotient: SymmetryReduction) -> tuple[Array, Array]:
    """Turn states back by the mean of their angles, where turning is a symmetry. Returns the states
    and these angles."""
    angles = np.zeros(len(x))
    if not quotient.turns:
        return x, angles
    angles = x[:, quotient.angles].mean(axis=1)
    back = np.array([quotient.rotate(one, -angle) for one, angle in zip(x, angles, strict=True)])
    return back, angles


def _scales(away: Array, quotient: SymmetryReduction) -> Array:
    """Scales (size,) to compare states by: the largest of positions, and of all others."""
    sizes = away.std(axis=0)
    made = np.ones(len(sizes))
    for part in (slice(None, quotient.positions), slice(quotient.positions, None)):
        largest = sizes[part].max(initial=0.0)
        made[part] = largest if largest > 0 else 1.0
    return made


def _free_returns(t: Array, distance: Array) -> list[tuple[float, float, int]]:
    """Find the earlier passages near the last state: how long before the end [s], how near, and the
    sample; the latest first."""
    gone = np.flatnonzero(distance > AWAY * distance.max())
    last = int(gone[-1]) if len(gone) else 0
    square = distance[: last + 1] ** 2
    low = np.flatnonzero((square[1:-1] <= square[:-2]) & (square[1:-1] < square[2:])) + 1
    found = []
    for k in low[::-1].tolist():
        before, here, after = square[k - 1 : k + 2]
        bend = before - 2 * here + after
        shift = 0.5 * (before - after) / bend if bend > 0 else 0.0
        nearest = max(0.0, here - 0.25 * (before - after) * shift)
        at = t[k] + shift * (t[k + 1] - t[k])
        found.append((float(t[-1] - at), float(np.sqrt(nearest)), k))
    return found


def _forced_returns(t: Array, distance: Array, period: float) -> list[tuple[float, float, int]]:
    """Compare with the last state whole periods earlier; returns as `_free_returns`."""
    most = min(MOST_PERIODS, int((t[-1] - t[0]) / period * (1 + 1e-9)))
    at = [len(t) - 1 - k * PER_PERIOD for k in range(1, most + 1)]
    return [
        (k * period, float(distance[one]), one) for k, one in enumerate(at, start=1) if one >= 0
    ]
