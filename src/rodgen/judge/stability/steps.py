"""The largest stable step of every explicit method against the number of links.

Found by trying (see steps_trial), beside theory (rodgen.integrate.stability) and beside table 4.1
of the thesis. |lambda| stands beside what rodgen.integrate.spectrum finds by its iteration, and,
of the undamped rod of many links, 4 sqrt(3) n^2 sqrt(EI/(M L^3)).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from rodgen.integrate.spectrum import spectrum
from rodgen.integrate.stability import limit
from rodgen.judge.cases import Case
from rodgen.judge.stability.steps_trial import FIXED, Trial, grows, largest, own_step, straight
from rodgen.judge.unit import Row, Unit
from rodgen.thesis.data import METHODS, TABLE_4_1
from rodgen.thesis.methods import DAMPING, NAMES

LINKS = (2, 5, 10, 20, 50, 100, 200, 500, 1000)
QUICK = (2, 10, 50)
RATIOS = (0.0, 0.1, 1.0, 10.0)  # damping over the critical one of the fastest mode
LIMIT = 300.0  # s
# Without damping its coefficient is zero, so that one module does for all.
ROD = {"mass": 50.0, "length": 5.0, "bending_stiffness": 100.0, "internal_damping": 0.0}
OWN = "dop853, its own"  # the step that it takes, not the one that it could


def units(_: list[Case], quick: bool) -> list[Unit]:
    """By number of links, and the rods of table 4.1; the scenes of the report have no part."""
    call = f"{__name__}:against_links"
    made = [
        Unit("steps", f"steps-n{n}", call, {"links": n}, timed=False, limit=LIMIT)
        for n in (QUICK if quick else LINKS)
    ]
    printed = [row.links for row in TABLE_4_1 if not quick or row.links in QUICK]
    table = {"links": printed}
    return [*made, Unit("steps", "steps-table", f"{__name__}:table_4_1", table, timed=False)]


def against_links(links: int, ratios: Sequence[float] = RATIOS) -> list[Row]:
    """All methods at all damping ratios."""
    rows: list[Row] = []
    for ratio in ratios:
        trial, text = straight(links, values(links, ratio)), described(ratio)
        rows += [row(trial, method, text, ratio) for method in (*FIXED, "dop853")]
        rows.append(own_row(trial, text, ratio))
    return rows


def table_4_1(links: Sequence[int]) -> list[Row]:
    """The thesis's three methods at its numbers of links, with the damping that its table fits."""
    rows: list[Row] = []
    text = f"c_int = {DAMPING:g} m^2/s, fitted to table 4.1"
    for printed in (row for row in TABLE_4_1 if row.links in links):
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
    trial = undamped(links)
    return {**ROD, "internal_damping": ratio / damping_ratio(trial, 1.0)}


def damping_ratio(trial: Trial, coefficient: float) -> float:
    """Of the fastest mode: damping is proportional to stiffness, c_int m over k = EI/l, so that
    of a mode of frequency omega the ratio is c_int m omega/(2 k)."""
    n = trial.model.N
    m, k = ROD["mass"] / n, ROD["bending_stiffness"] * n / ROD["length"]
    return float(coefficient * m * trial.mode.omega / (2 * k))


@cache
def undamped(links: int) -> Trial:
    """The rod without damping."""
    return straight(links, ROD)


def described(ratio: float) -> str:
    """A damping ratio in words."""
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


def row(trial: Trial, method: str, damping: str, ratio: float) -> Row:
    """A method's largest stable step, tried and as theory has it."""
    rate = abs(eigenvalues(trial.mode.omega, ratio)[0])
    found = largest(lambda step: grows(trial, method, step), rate)
    how = "interval halved until a disturbance of the fastest mode neither grows nor dies"
    return _row(trial, method, damping, ratio, found, how)


def own_row(trial: Trial, damping: str, ratio: float) -> Row:
    """The step that dop853 takes by itself where its tolerances ask for nothing."""
    found, growth = own_step(trial)
    how = f"the step that it takes where every error is tolerated; disturbance {growth:.3g}-fold"
    return _row(trial, OWN, damping, ratio, found, how) | {"growth": growth}


def _row(trial: Trial, method: str, damping: str, ratio: float, found: float, how: str) -> Row:
    value, partner = eigenvalues(trial.mode.omega, ratio)
    theory = limit("dop853" if method == OWN else method, value, partner)
    iterated = spectrum(trial.model, 0.0, np.zeros(len(trial.model.STATE)), trial.p)
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
