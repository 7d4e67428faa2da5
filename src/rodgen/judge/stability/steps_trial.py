"""The largest stable step by trying: does a disturbance in the fastest mode grow from step to step?

The straight free rod is disturbed in its fastest mode alone, and so little that the motion is
linear. The compiled method takes a few hundred steps, and of every one of them position and
velocity in that mode are known; they follow from those of the step before by a matrix of 2 by 2,
which is fitted, and its spectral radius is the growth. So a growth of one in 10^9 a step is seen,
which Euler's method needs, and beats between its two vectors are not taken for growth.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

import rodgen

Array = NDArray[np.float64]

AMPLITUDE = 1e-8  # rad: what is not linear is its square
STEPS = 300
BLOCK = 30  # steps of dop853 between two looks of its own at its limit, which it is kept from
GROWN = 1e3  # times the disturbance: no fit is needed to call this growth
DIED = 1e-6  # of the largest motion in the mode, below which it is not looked at
SLACK = 1e-9  # of the growth of a step, from rounding
CLOSE = 1e-3  # of the step, to which the interval is halved
LOW, HIGH = 1e-3, 4.0  # h |lambda| where the search starts
FIXED = ("euler", "semi_implicit_euler", "rk4", "thesis_runge_kutta")


@dataclass(frozen=True, eq=False)
class Mode:
    """The fastest mode of a straight rod: its frequency omega [rad/s] without damping, shape (half
    of the states,), and its partner, by which positions are multiplied for their share of it."""

    omega: float
    shape: Array
    partner: Array


@dataclass(frozen=True, eq=False)
class Trial:
    """A straight rod at rest, its parameters and its fastest mode."""

    model: ModuleType
    p: Array
    mode: Mode

    def run(self, method: str, **more: Any) -> Any:
        """A run from a disturbance, in position and in velocity."""
        q = AMPLITUDE * self.mode.shape
        y = np.concatenate((q, 0.3 * self.mode.omega * q))
        return self.model.Run(method, 0.0, y, self.p, **more)

    def coordinates(self, trace: Array) -> Array:
        """Position and velocity over omega in the mode (K, 2) from the lines of a trace."""
        half = len(self.mode.shape)
        q, v = trace[:, 1 : 1 + half], trace[:, 1 + half : 1 + 2 * half]
        with np.errstate(all="ignore"):
            return np.column_stack((q @ self.mode.partner, v @ self.mode.partner / self.mode.omega))


def straight(links: int, values: dict[str, float]) -> Trial:
    """The free rod at rest along x; values: parameters, internal_damping among them."""
    model = rodgen.build(rodgen.Structure(links, terms=("internal_damping",)), "c")
    p = model.parameters(**values)
    return Trial(model, p, fastest_mode(model, p))


def fastest_mode(model: ModuleType, p: Array) -> Mode:
    """Of M x'' = -K x, dense, by LAPACK: not the iteration by which rodgen itself finds it."""
    rest = np.zeros(len(model.STATE))
    half = len(rest) // 2
    M = model.mass_matrix(rest, p)
    K = -M @ model.jac(0.0, rest, p)[half:, :half]
    K = (K + K.T) / 2  # symmetric but for rounding
    values, vectors = eigh(K, M, subset_by_index=[half - 1, half - 1])
    shape = vectors[:, 0] / np.abs(vectors[:, 0]).max()
    return Mode(math.sqrt(values[0]), shape, M @ shape / (shape @ M @ shape))


def grows(trial: Trial, method: str, step: float) -> bool:
    """Whether a disturbance in the fastest mode grows with such steps [s]."""
    z = trial.coordinates(taken(trial, method, step))
    size = np.hypot(*z.T)
    if not np.isfinite(size).all() or size.max() > GROWN * size[0]:
        return True
    return radius(z) > 1 + SLACK


def radius(z: Array) -> float:
    """Spectral radius of the matrix that takes every line of z (K, 2) to the next."""
    # What has died out is rounding of other modes.
    size = np.hypot(*z[:-1].T)
    kept = size > DIED * size.max()
    before, after = (part[kept] / size[kept, None] for part in (z[:-1], z[1:]))
    matrix = np.linalg.lstsq(before, after, rcond=None)[0]
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def taken(trial: Trial, method: str, step: float, steps: int = STEPS) -> Array:
    """Lines t, y, dy of steps of this length by the compiled method; fewer where it fails."""
    fixed = method in FIXED
    # Of dop853, error control accepts all, and its own look at the limit is put off.
    how = {"step": step} if fixed else {"step": step, "rtol": 1e300, "atol": 1e300}
    run = trial.run(method, **how)
    trace = np.full((steps + 1, 1 + 2 * len(trial.model.STATE)), np.nan)
    states = len(trial.model.STATE)
    trace[0, 1 : 1 + states] = run.state[:states]
    run.begin(1e6 * step)
    nothing = np.empty((0, len(run.state)))
    at = 1
    while at <= steps:
        count = min(steps + 1 - at, steps if fixed else BLOCK)
        if not fixed:
            run.numbers.looked, run.numbers.most, run.numbers.step = 0, step, 1e300
        status, _ = run.on(count, np.empty(0), nothing, trace[at:])
        if status < 0:
            break
        at += count
    return trace


def largest(grows_with: Callable[[float], bool], rate: float) -> float:
    """The largest step [s] with which nothing grows, to CLOSE of it; 0 where there is none.

    rate: |lambda| [1/s], from which the search starts; its end is not bound by it.
    """
    low, high = LOW / rate, HIGH / rate
    if grows_with(low):
        return 0.0
    while not grows_with(high):
        low, high = high, 2 * high
    while high > low * (1 + CLOSE):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if grows_with(middle) else (middle, high)
    return math.sqrt(low * high)


def own_step(trial: Trial, steps: int = STEPS) -> tuple[float, float]:
    """Of dop853 with tolerances that everything keeps: the step [s] that it takes (median of the
    second half), and by what the disturbance has grown there."""
    run = trial.run("dop853", rtol=1e-2, atol=1.0)
    trace = np.full((steps, 1 + 2 * len(trial.model.STATE)), np.nan)
    run.begin(1e9 / trial.mode.omega)
    start = AMPLITUDE * math.hypot(1.0, 0.3)
    run.on(steps, np.empty(0), np.empty((0, len(run.state))), trace)
    late = trace[steps // 2 :]
    size = np.hypot(*trial.coordinates(late).T)
    return float(np.median(np.diff(late[:, 0]))), float(size.max() / start)
