"""Which mass and which damping the largest steps of table 4.1 ask for."""

from __future__ import annotations

import math
from typing import NamedTuple

from rodgen.integrate.stability import limit
from rodgen.thesis import data, scenes
from rodgen.thesis.table import Note
from rodgen.thesis.timing import fastest

UNDAMPED = {"semi_implicit_euler": 2.0, "thesis_runge_kutta": limit("thesis_runge_kutta", 1j)}


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
    """What most of the intervals share, and the links of those that do."""
    best: tuple[int, ...] = ()
    for at in (i.low for i in intervals):
        holding = tuple(i.links for i in intervals if i.low <= at < i.high)
        best = holding if len(holding) > len(best) else best
    kept = [i for i in intervals if i.links in best]
    return Interval(0, max(i.low for i in kept), min(i.high for i in kept)), best


def slope(method: str) -> float:
    """Exponent p of h ~ n^-p between the first and the last but one printed step."""
    first, last = data.TABLE_4_1[0], data.TABLE_4_1[-2]
    ratio = float(getattr(first, method)) / float(getattr(last, method))
    return math.log(ratio) / math.log(last.links / first.links)


def notes_on_steps(damping: float) -> list[Note]:
    """What table 4.1 tells of the rod it was made with."""
    semi, links = common(masses("semi_implicit_euler"))
    kutta, kutta_links = common(masses("thesis_runge_kutta"))
    product, euler_links = common(dampings())
    return [
        Note(
            "consistent",
            f"Semi-implicit Euler: h = 2/omega gives the printed steps, rounded down, of n = "
            f"{_list(links)} with a mass from {semi.low:.1f} to {semi.high:.1f} kg. 50, the number "
            "of grams in 3.2, lies in it; "
            f"{scenes.MASS:g} kg is assumed. The others ask for another mass.",
        ),
        Note(
            "consistent",
            "Runge-Kutta: the limit of the method as listed, h omega = "
            f"{UNDAMPED['thesis_runge_kutta']:.3f}, gives the steps of n = {_list(kutta_links)} "
            f"with {kutta.low:.1f} to {kutta.high:.1f} kg. That of the classical method, 2.828, "
            "would be larger than the semi-implicit one; the printed steps of both are nearly "
            "equal, as those of the listing are. The step at n = 10 is 5 times that at n = 20, "
            "where theory has 4.",
        ),
        Note(
            "shown",
            "Euler: without damping no step is stable. With the internal damping of the thesis all "
            "modes have the limit h = c_int M L/(EI n^2), which falls with n^2; a growth that is "
            "not seen within a fixed span would let it fall with n^4, external damping too. The "
            f"printed steps fall with n^{slope('euler'):.2f} from n = 10 to 40.",
        ),
        Note(
            "consistent",
            f"Those of n = {_list(euler_links)} follow with c_int M from {product.low:.3g} to "
            f"{product.high:.3g} kg m^2/s, thus with {scenes.MASS:g} kg and c_int = {damping:g} "
            "m^2/s. The step at n = 50 is a fifth of that.",
        ),
    ]


def _steps(method: str) -> list[tuple[int, float, float]]:
    """Links, the printed step, and one unit of its last digit more."""
    rows = []
    for row in data.TABLE_4_1:
        text = getattr(row, method)
        unit = 10.0 ** -len(text.partition(".")[2])
        rows.append((row.links, float(text), float(text) + unit))
    return rows


def _list(links: tuple[int, ...]) -> str:
    return ", ".join(map(str, links))
