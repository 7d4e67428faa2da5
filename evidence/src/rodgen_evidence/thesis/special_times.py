"""Times of a simulated second of the special model, by method and target."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import lru_cache

from rodgen.errors import DoubtWarning, InputError
from rodgen.integrate import simulate
from rodgen.integrate.stability import dominant
from rodgen.loading import BuildError, build
from rodgen_evidence.thesis import scenes

STEPS = {"c": 20000, "numpy": 400}  # timed
SAFETY = 0.9  # of the largest stable step, where no step is given
ROUND = 2  # significant digits of a number of times


@lru_cache(maxsize=32)
def fastest(links: int) -> float:
    """Frequency of the fastest bending mode of the free rod of 3.3 with uniform links [rad/s]: for
    many of them 4 sqrt(3) n^2 sqrt(EI / (M L^3))."""
    scene = scenes.long_rod(links)
    model = build(scene, "numpy")
    return dominant(model, 0.0, scene.initial_state(), model.parameters(**scene.parameters)).rate


def largest_step(links: int) -> float:
    """The step [s] that is timed where none is given."""
    return SAFETY * 2 / fastest(links)


def times(factors: Sequence[float]) -> str:
    """Describe by how much run times were multiplied, from the least to the largest factor."""
    least, most = (f"{float(f'{f:.{ROUND}g}'):g}" for f in (min(factors), max(factors)))
    return f"{least} times" if least == most else f"{least} to {most} times"


@lru_cache(maxsize=64)
def special_seconds(
    links: int, method: str, target: str, step: float | None = None, damping: float = 0.0
) -> float:
    """Run time [s] of one simulated second; nan where the target cannot be built.

    step [s]: by default 0.9 of the largest stable one; damping: internal, [m^2/s].
    """
    h = step or largest_step(links)
    steps = STEPS[target]
    loads = {"internal_damping": {"coefficient": damping}} if damping else {}
    scene = scenes.long_rod(
        links,
        loads=loads,
        initial={"phi": "0.001*(2*s - 1)**3"},
        method=method,
        step=h,
        span=[0.0, h * steps],
        output_every=h * steps,
    )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DoubtWarning)
            first, second = (simulate(scene, target=target).stats.wall_seconds for _ in range(2))
    except (BuildError, InputError):
        return float("nan")
    return min(first, second) / (h * steps)
