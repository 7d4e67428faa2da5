"""Section "steps": largest stable steps, found by trying, beside theory."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pandas import DataFrame
from scipy.linalg import eigh

import rodgen
from rodgen.analyse.precision.contestant import Measurement
from rodgen.integrate.stability import dominant, step_limit
from rodgen_evidence.report import cases
from rodgen_evidence.report.unit import Unit
from rodgen_evidence.thesis.data import METHODS, TABLE_4_1
from rodgen_evidence.thesis.largest_steps import DAMPING, NAMES

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
    """Fastest mode of M x'' = -K x, dense, by LAPACK: not by the iteration of rodgen itself."""
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


def taken(trial: Trial, method: str, step: float) -> Array:
    """Lines t, y, dy of steps of this length by the compiled method; fewer where it fails."""
    fixed = method in FIXED
    # Of dop853, error control accepts all, and its own look at the limit is put off.
    how = {"step": step} if fixed else {"step": step, "rtol": 1e300, "atol": 1e300}
    run = trial.run(method, **how)
    trace = np.full((STEPS + 1, 1 + 2 * len(trial.model.STATE)), np.nan)
    states = len(trial.model.STATE)
    trace[0, 1 : 1 + states] = run.state[:states]
    run.begin(1e6 * step)
    nothing = np.empty((0, len(run.state)))
    at = 1
    while at <= STEPS:
        count = min(STEPS + 1 - at, STEPS if fixed else BLOCK)
        if not fixed:
            run.numbers.looked, run.numbers.most, run.numbers.step = 0, step, 1e300
        status, _ = run.advance(count, np.empty(0), nothing, trace[at:])
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


def own_step(trial: Trial) -> tuple[float, float]:
    """Step [s] that dop853 takes with tolerances that everything keeps (median of the second half),
    and by what the disturbance has grown there."""
    run = trial.run("dop853", rtol=1e-2, atol=1.0)
    trace = np.full((STEPS, 1 + 2 * len(trial.model.STATE)), np.nan)
    run.begin(1e9 / trial.mode.omega)
    start = AMPLITUDE * math.hypot(1.0, 0.3)
    run.advance(STEPS, np.empty(0), np.empty((0, len(run.state))), trace)
    late = trace[STEPS // 2 :]
    size = np.hypot(*trial.coordinates(late).T)
    return float(np.median(np.diff(late[:, 0]))), float(size.max() / start)


LINKS = (2, 5, 10, 20, 50, 100, 200, 500, 1000)
QUICK = (2, 10, 50)
RATIOS = (0.0, 0.1, 1.0, 10.0)  # damping over the critical one of the fastest mode
LIMIT = 300.0  # s
# Without damping its coefficient is zero, so that one module does for all.
ROD = {**cases.ROD, "internal_damping": 0.0}
OFF = 0.05  # from theory, from which on a largest stable step is named
OWN = "dop853, its own"  # the step that it takes, not the one that it could


def units(_: object, quick: bool, *__: object) -> list[Unit]:
    """Plan units by number of links, and of table 4.1; the scenes of the report have no part."""
    call = f"{__name__}:against_links"
    made = [
        Unit("steps", f"steps-n{n}", call, {"links": n}, timed=False, limit=LIMIT)
        for n in (QUICK if quick else LINKS)
    ]
    printed = [links for links in TABLE_4_1["links"].tolist() if not quick or links in QUICK]
    table = {"links": printed}
    return [*made, Unit("steps", "steps-table", f"{__name__}:table_4_1", table, timed=False)]


def against_links(links: int, ratios: Sequence[float] = RATIOS) -> list[Measurement]:
    """All methods at all damping ratios."""
    rows: list[Measurement] = []
    for ratio in ratios:
        trial, text = straight(links, values(links, ratio)), describe_damping(ratio)
        rows += [row(trial, method, text, ratio) for method in (*FIXED, "dop853")]
        rows.append(own_row(trial, text, ratio))
    return rows


def table_4_1(links: Sequence[int]) -> list[Measurement]:
    """The thesis's three methods at its numbers of links, with the damping that its table fits."""
    rows: list[Measurement] = []
    text = f"c_int = {DAMPING:g} m^2/s, fitted to table 4.1"
    for printed in TABLE_4_1[TABLE_4_1["links"].isin(links)].itertuples():
        trial = straight(printed.links, {**ROD, "internal_damping": DAMPING})
        ratio = damping_ratio(trial, DAMPING)
        for method in METHODS:
            made = row(trial, method, text, ratio)
            made["printed"] = float(getattr(printed, method))
            made["how"] = f"{made['how']}; printed: {NAMES[method]}"
            rows.append(made)
    return rows


def values(links: int, ratio: float) -> dict[str, float]:
    """Parameters with internal damping of this share of the critical one of the fastest mode."""
    trial = undamped_rod(links)
    return {**ROD, "internal_damping": ratio / damping_ratio(trial, 1.0)}


def damping_ratio(trial: Trial, coefficient: float) -> float:
    """Damping ratio of the fastest mode.

    Damping is proportional to stiffness, c_int m over k = EI/l, so that of a mode of frequency
    omega the ratio is c_int m omega/(2 k).
    """
    n = trial.model.N
    m, k = ROD["mass"] / n, ROD["bending_stiffness"] * n / ROD["length"]
    return float(coefficient * m * trial.mode.omega / (2 * k))


@cache
def undamped_rod(links: int) -> Trial:
    """The rod without damping."""
    return straight(links, ROD)


def describe_damping(ratio: float) -> str:
    """Describe a damping ratio."""
    return f"{ratio:g} of the critical one of the fastest mode" if ratio else "none"


def many_links(links: int) -> float:
    """4 sqrt(3) n^2 sqrt(EI/(M L^3)) [rad/s]: the fastest mode of many uniform links."""
    stiffness = ROD["bending_stiffness"] / (ROD["mass"] * ROD["length"] ** 3)
    return 4 * math.sqrt(3 * stiffness) * links**2


def eigenvalues(omega: float, ratio: float) -> tuple[complex, complex]:
    """Roots of z^2 + 2 ratio omega z + omega^2 [1/s]: the larger, or of two alike in size that of
    positive imaginary part, and its partner."""
    root = cmath.sqrt(ratio**2 - 1)
    sign = -1 if root.real else 1
    return omega * (-ratio + sign * root), omega * (-ratio - sign * root)


def row(trial: Trial, method: str, damping: str, ratio: float) -> Measurement:
    """A method's largest stable step, tried and as theory has it."""
    rate = abs(eigenvalues(trial.mode.omega, ratio)[0])
    found = largest(lambda step: grows(trial, method, step), rate)
    how = "interval halved until a disturbance of the fastest mode neither grows nor dies"
    return _row(trial, method, damping, ratio, found, how)


def own_row(trial: Trial, damping: str, ratio: float) -> Measurement:
    """The step that dop853 takes by itself where its tolerances ask for nothing."""
    found, growth = own_step(trial)
    how = f"the step that it takes where every error is tolerated; disturbance {growth:.3g}-fold"
    return _row(trial, OWN, damping, ratio, found, how) | {"growth": growth}


def _row(
    trial: Trial, method: str, damping: str, ratio: float, found: float, how: str
) -> Measurement:
    value, partner = eigenvalues(trial.mode.omega, ratio)
    theory = step_limit("dop853" if method == OWN else method, value, partner)
    iterated = dominant(trial.model, 0.0, np.zeros(len(trial.model.STATE)), trial.p)
    return {
        "method": method,
        "n": trial.model.N,
        "damping": damping,
        "damping_ratio": ratio,
        "rate": abs(value),
        "rate_iterated": iterated.rate,
        "rate_many": many_links(trial.model.N),
        "found": found,
        "theory": theory,
        "off": found / theory - 1 if theory else (None if found else 0.0),
        "printed": None,
        "growth": None,
        "how": how,
        "failed": "",
    }


def off_theory(rows: DataFrame) -> DataFrame:
    """Largest stable steps that are not where theory has them."""
    return rows[rows["off"].abs() > OFF]
