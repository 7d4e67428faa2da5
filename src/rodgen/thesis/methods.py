"""Table 4.1: the largest stable steps of the three methods."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence

import numpy as np

from rodgen.integrate import RunError, StepWarning, simulate
from rodgen.integrate.stability import limit
from rodgen.thesis import data, scenes
from rodgen.thesis.step_fits import UNDAMPED, common, masses, notes_on_steps
from rodgen.thesis.table import Cell, Column, Note, Table
from rodgen.thesis.timing import fastest

# Assumed: internal damping, without which no step of Euler's method is stable. The round value
# with which four of its five largest steps come out as they are printed (see step_fits).
DAMPING = 0.01  # m^2/s
NAMES = {
    "euler": "Euler",
    "semi_implicit_euler": "semi-implicit Euler",
    "thesis_runge_kutta": "Runge-Kutta, as listed",
}
# Steps in which a motion must stay bounded: Euler's method turns unstable so gently that a
# step 3 % too long makes a motion 40 times larger only in this many.
STEPS = {"euler": 500_000, "semi_implicit_euler": 4000, "thesis_runge_kutta": 4000}
CLOSENESS = {"euler": 0.03, "semi_implicit_euler": 1e-3, "thesis_runge_kutta": 1e-3}
GROWN = 30.0  # times the first bend
TENTHS = range(300, 701)  # of a kg: masses that are tried

COLUMNS_4_1 = (
    Column("links", "links"),
    Column("method", "method"),
    Column("thesis", "thesis: largest step", "s", ".3g"),
    Column("tried", "ours: largest by trying", "s", ".4g"),
    Column("limit", "theory, damped as assumed", "s", ".4g"),
    Column("undamped", "theory, undamped", "s", ".4g"),
    Column("ratio", "thesis over theory", "", ".3f"),
    Column("verdict", "verdict"),
)


def theory(links: int, method: str, damping: float, mass: float = scenes.MASS) -> float:
    """Largest stable step [s] for small motions of the straight rod of a mass [kg].

    Internal damping is proportional to the stiffness, by beta = c_int m/k = c_int M L/(EI n^2):
    a mode of frequency omega has lambda = -beta omega^2/2 +- i omega sqrt(...). Euler's method then
    has the same limit, beta, for all modes; the others have theirs at the fastest one.
    """
    omega = fastest(links) * math.sqrt(scenes.MASS / mass)
    beta = damping * mass * scenes.LENGTH / (scenes.STIFFNESS * links**2)
    if method == "euler":  # in closed form: a weak damping is no rounding here
        return beta
    real = -beta * omega**2 / 2
    return limit(method, complex(real, math.sqrt(omega**2 - real**2)))


def stays(links: int, method: str, step: float, damping: float) -> bool:
    """Whether a slightly bent rod stays about as bent over STEPS steps [s]."""
    # Every mode is disturbed, the fastest, in which neighbours turn oppositely, among them.
    jagged = [1e-4 * ((2 * i + 1) / links - 1) ** 3 + 1e-6 * (-1) ** i for i in range(links)]
    span = step * STEPS[method]
    scene = scenes.long_rod(
        links,
        loads={"internal_damping": {"coefficient": damping}},
        initial={"phi": jagged},
        method=method,
        step=step,
        span=[0.0, span],
        output_every=span / 20,
    )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", StepWarning)
            phi = simulate(scene).phi
    except RunError:
        return False
    bend = np.ptp(phi, axis=1)
    return bool(np.isfinite(bend).all() and bend.max() < GROWN * bend[0])


def largest_step(links: int, method: str, damping: float = DAMPING) -> float:
    """The largest step [s] with which the rod stays bounded, by halving an interval."""
    low = high = theory(links, method, damping)
    while not stays(links, method, low, damping):
        low /= 1.3
    while stays(links, method, high, damping):
        high *= 1.3
    while high / low > 1 + CLOSENESS[method]:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stays(links, method, middle, damping) else (low, middle)
    return low


def table_4_1(links: Sequence[int] | None = None, methods: Sequence[str] = data.METHODS) -> Table:
    """Largest steps; links, methods: those of the rows."""
    printed = [row for row in data.TABLE_4_1 if links is None or row.links in links]
    rows = [_row_4_1(row, method) for method in methods for row in printed]
    table = Table("4.1", "Largest stable step", COLUMNS_4_1, rows)
    table.conditions = ["none: neither rod, damping, motion nor span is given"]
    table.assumed = [
        f"The free rod of 3.3 with m = {scenes.MASS:g} kg and c_int = {DAMPING:g} m^2/s, values "
        "fitted to this table (see below).",
        "Tried: a bend of 1e-4 rad with all modes in it, called unstable if it grows "
        f"{GROWN:g} times in {STEPS['euler']} steps of Euler's and "
        f"{STEPS['semi_implicit_euler']} steps of the other methods; interval halved to "
        f"{100 * CLOSENESS['euler']:g} and {100 * CLOSENESS['semi_implicit_euler']:g} %.",
    ]
    table.notes = [*notes_on_steps(DAMPING), note_on_masses()]
    return table


def reproduced(mass: float) -> int:
    """How many printed steps are the theory's limits, rounded down, with a mass [kg] and the
    product of mass and internal damping kept."""
    damping = DAMPING * scenes.MASS / mass
    return sum(
        is_rounded_down(getattr(row, method), theory(row.links, method, damping, mass))
        for method in data.METHODS
        for row in data.TABLE_4_1
    )


def note_on_masses() -> Note:
    """The masses that two columns ask for, beside each other."""
    semi, kutta = (common(masses(method))[0] for method in UNDAMPED)
    low, high = max(semi.low, kutta.low), min(semi.high, kutta.high)
    both = f"overlap from {low:.1f} to {high:.1f} kg" if low < high else "do not overlap"
    counts = {mass / 10: reproduced(mass / 10) for mass in TENTHS}
    most = max(counts.values())
    best = [mass for mass, count in counts.items() if count == most]
    rows = len(data.METHODS) * len(data.TABLE_4_1)
    return Note(
        "consistent",
        f"The masses of the semi-implicit Euler and the Runge-Kutta column {both}. With the "
        f"damping assumed, and c_int M kept, {best[0]:.1f} to {best[-1]:.1f} kg reproduce {most} "
        f"of the {rows} steps; {scenes.MASS:g} kg, the round mass that is assumed all the same, "
        f"{reproduced(scenes.MASS)}.",
    )


def _row_4_1(printed: data.OfMethods, method: str) -> dict[str, Cell]:
    text = getattr(printed, method)
    expected, tried = theory(printed.links, method, DAMPING), largest_step(printed.links, method)
    return {
        "links": printed.links,
        "method": NAMES[method],
        "thesis": float(text),
        "tried": tried,
        "limit": expected,
        "undamped": theory(printed.links, method, 0.0),
        "ratio": float(text) / expected,
        "verdict": rounded_down(text, expected),
    }


def is_rounded_down(printed: str, value: float) -> bool:
    """Whether a value without its further digits is the printed one."""
    unit = 10.0 ** -len(printed.partition(".")[2])
    return math.floor(value / unit * (1 + 1e-9)) == round(float(printed) / unit)


def rounded_down(printed: str, value: float) -> str:
    """Verdict on a printed limit, which is taken as rounded down to its digits."""
    if is_rounded_down(printed, value):
        return f"reproduced: {value:.3g} s, rounded down"
    return f"not reproduced: {float(printed) / value:.2f} of the limit"
