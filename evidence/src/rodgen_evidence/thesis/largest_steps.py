"""Table 4.1: the largest stable steps of the three methods, and the rod that they ask for."""

from __future__ import annotations

import math
import warnings
from typing import Any, NamedTuple

import numpy as np
from pandas import DataFrame

from rodgen.errors import DoubtWarning
from rodgen.integrate import RunError, simulate
from rodgen.integrate.stability import step_limit
from rodgen_evidence.thesis import data, scenes
from rodgen_evidence.thesis.data import unit
from rodgen_evidence.thesis.special_times import fastest
from rodgen_evidence.thesis.table import LINKS, VERDICT, Remark, ThesisTable, column

# Assumed: internal damping, without which no step of Euler's method is stable. The round value
# with which four of its five largest steps come out as they are printed (see below).
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
    LINKS,
    column("method", "method"),
    column("thesis", "thesis: largest step", "s", ".3g"),
    column("tried", "ours: largest by trying", "s", ".4g"),
    column("limit", "theory, damped as assumed", "s", ".4g"),
    column("undamped", "theory, undamped", "s", ".4g"),
    column("ratio", "thesis over theory", "", ".3f"),
    VERDICT,
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
    return step_limit(method, complex(real, math.sqrt(omega**2 - real**2)))


def stays(links: int, method: str, step: float) -> bool:
    """Whether a slightly bent rod stays about as bent over STEPS steps [s]."""
    # Every mode is disturbed, the fastest, in which neighbours turn oppositely, among them.
    jagged = [1e-4 * ((2 * i + 1) / links - 1) ** 3 + 1e-6 * (-1) ** i for i in range(links)]
    span = step * STEPS[method]
    scene = scenes.long_rod(
        links,
        loads={"internal_damping": {"coefficient": DAMPING}},
        initial={"phi": jagged},
        method=method,
        step=step,
        span=[0.0, span],
        output_every=span / 20,
    )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DoubtWarning)
            phi = simulate(scene).phi
    except RunError:
        return False
    bend = np.ptp(phi, axis=1)
    return bool(np.isfinite(bend).all() and bend.max() < GROWN * bend[0])


def largest_step(links: int, method: str) -> float:
    """The largest step [s] with which the rod stays bounded, by halving an interval."""
    low = high = theory(links, method, DAMPING)
    while not stays(links, method, low):
        low /= 1.3
    while stays(links, method, high):
        high *= 1.3
    while high / low > 1 + CLOSENESS[method]:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stays(links, method, middle) else (low, middle)
    return low


def table_4_1() -> ThesisTable:
    """Largest steps of every method."""
    rows = DataFrame(map(_row, data.by_method(data.TABLE_4_1).itertuples()))
    table = ThesisTable("4.1", "Largest stable step", COLUMNS_4_1, rows)
    table.conditions = ["none: neither rod, damping, motion nor span is given"]
    table.assumed = [
        f"The free rod of 3.3 with m = {scenes.MASS:g} kg and c_int = {DAMPING:g} m^2/s, values "
        "fitted to this table (see below).",
        "Tried: a bend of 1e-4 rad with all modes in it, called unstable if it grows "
        f"{GROWN:g} times in {STEPS['euler']} steps of Euler's and "
        f"{STEPS['semi_implicit_euler']} steps of the other methods; interval halved to "
        f"{100 * CLOSENESS['euler']:g} and {100 * CLOSENESS['semi_implicit_euler']:g} %.",
    ]
    table.notes = [*notes_on_steps(), note_on_masses()]
    return table


def count_matches(mass: float) -> int:
    """Count the printed steps that are the theory's limits, rounded down, with a mass [kg] and the
    product of mass and internal damping kept."""
    damping = DAMPING * scenes.MASS / mass
    return sum(
        is_rounded_down(row.printed, theory(row.links, row.method, damping, mass))
        for row in data.by_method(data.TABLE_4_1).itertuples()
    )


def note_on_masses() -> Remark:
    """The masses that two columns ask for, beside each other."""
    semi, kutta = (common(masses(method))[0] for method in UNDAMPED)
    low, high = max(semi.low, kutta.low), min(semi.high, kutta.high)
    both = f"overlap from {low:.1f} to {high:.1f} kg" if low < high else "do not overlap"
    counts = {mass / 10: count_matches(mass / 10) for mass in TENTHS}
    most = max(counts.values())
    best = [mass for mass, count in counts.items() if count == most]
    return Remark(
        "consistent",
        f"The masses of the semi-implicit Euler and the Runge-Kutta column {both}. With the "
        f"damping assumed, and c_int M kept, {best[0]:.1f} to {best[-1]:.1f} kg reproduce {most} "
        f"of the {data.TABLE_4_1[[*data.METHODS]].size} steps; {scenes.MASS:g} kg, the round mass "
        "that is assumed all the same, "
        f"{count_matches(scenes.MASS)}.",
    )


def _row(printed: Any) -> dict[str, float | str]:
    links, method, step = printed.links, printed.method, float(printed.printed)
    expected = theory(links, method, DAMPING)
    return {
        "links": links,
        "method": NAMES[method],
        "thesis": step,
        "tried": largest_step(links, method),
        "limit": expected,
        "undamped": theory(links, method, 0.0),
        "ratio": step / expected,
        "verdict": rounded_down(printed.printed, expected),
    }


def is_rounded_down(printed: str, value: float) -> bool:
    """Whether a value without its further digits is the printed one."""
    last = unit(printed)
    return math.floor(value / last * (1 + 1e-9)) == round(float(printed) / last)


def rounded_down(printed: str, value: float) -> str:
    """Verdict on a printed limit, which is taken as rounded down to its digits."""
    if is_rounded_down(printed, value):
        return f"reproduced: {value:.3g} s, rounded down"
    return f"not reproduced: {float(printed) / value:.2f} of the limit"


# Which mass and which damping the printed steps ask for ------------------------------------------

UNDAMPED = {"semi_implicit_euler": 2.0, "thesis_runge_kutta": step_limit("thesis_runge_kutta", 1j)}


class Interval(NamedTuple):
    """Values that a printed step, taken as rounded down to its digits, allows: low <= x < high."""

    links: int
    low: float
    high: float


def masses(method: str) -> tuple[Interval, ...]:
    """Masses [kg] with which h omega = limit, omega that of the fastest mode, gives the printed
    steps of a method: omega^2 is proportional to 1/M."""
    bound = UNDAMPED[method]

    def mass(links: int, step: float) -> float:
        return scenes.MASS * (fastest(links) * step / bound) ** 2

    return tuple(Interval(n, mass(n, low), mass(n, high)) for n, low, high in _steps(method))


def dampings() -> tuple[Interval, ...]:
    """c_int M [kg m^2/s] with which h = c_int M L/(EI n^2) gives the printed steps of Euler's."""
    scale = scenes.STIFFNESS / scenes.LENGTH
    return tuple(
        Interval(n, low * n**2 * scale, high * n**2 * scale) for n, low, high in _steps("euler")
    )


def common(intervals: tuple[Interval, ...]) -> tuple[Interval, tuple[int, ...]]:
    """Interval that most of the intervals share, and the links of those that do."""
    best: tuple[int, ...] = ()
    for at in (i.low for i in intervals):
        holding = tuple(i.links for i in intervals if i.low <= at < i.high)
        best = holding if len(holding) > len(best) else best
    kept = [i for i in intervals if i.links in best]
    return Interval(0, max(i.low for i in kept), min(i.high for i in kept)), best


def slope(method: str) -> float:
    """Exponent p of h ~ n^-p between the first and the last but one printed step."""
    ends = np.log(data.TABLE_4_1[["links", method]].astype(float)).iloc[[0, -2]].diff()
    return float(-ends[method].iloc[1] / ends["links"].iloc[1])


def notes_on_steps() -> list[Remark]:
    """Remarks on the rod that table 4.1 was made with."""
    semi, links = common(masses("semi_implicit_euler"))
    kutta, kutta_links = common(masses("thesis_runge_kutta"))
    product, euler_links = common(dampings())
    return [
        Remark(
            "consistent",
            f"Semi-implicit Euler: h = 2/omega gives the printed steps, rounded down, of n = "
            f"{_list(links)} with a mass from {semi.low:.1f} to {semi.high:.1f} kg. 50, the number "
            "of grams in 3.2, lies in it; "
            f"{scenes.MASS:g} kg is assumed. The others ask for another mass.",
        ),
        Remark(
            "consistent",
            "Runge-Kutta: the limit of the method as listed, h omega = "
            f"{UNDAMPED['thesis_runge_kutta']:.3f}, gives the steps of n = {_list(kutta_links)} "
            f"with {kutta.low:.1f} to {kutta.high:.1f} kg. That of the classical method, 2.828, "
            "would be larger than the semi-implicit one; the printed steps of both are nearly "
            "equal, as those of the listing are. The step at n = 10 is 5 times that at n = 20, "
            "where theory has 4.",
        ),
        Remark(
            "shown",
            "Euler: without damping no step is stable. With the internal damping of the thesis all "
            "modes have the limit h = c_int M L/(EI n^2), which falls with n^2; a growth that is "
            "not seen within a fixed span would let it fall with n^4, external damping too. The "
            f"printed steps fall with n^{slope('euler'):.2f} from n = 10 to 40.",
        ),
        Remark(
            "consistent",
            f"Those of n = {_list(euler_links)} follow with c_int M from {product.low:.3g} to "
            f"{product.high:.3g} kg m^2/s, thus with {scenes.MASS:g} kg and c_int = {DAMPING:g} "
            "m^2/s. The step at n = 50 is a fifth of that.",
        ),
    ]


def _steps(method: str) -> list[tuple[int, float, float]]:
    """Links, the printed step, and one unit of its last digit more."""
    pairs = zip(data.TABLE_4_1["links"], data.TABLE_4_1[method], strict=True)
    return [(links, float(text), float(text) + unit(text)) for links, text in pairs]


def _list(links: tuple[int, ...]) -> str:
    return ", ".join(map(str, links))
