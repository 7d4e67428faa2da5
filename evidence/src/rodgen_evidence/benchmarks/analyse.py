"""Times of analyses, each beside the plain way to the same number, in turns in the same run.

    python -m rodgen_evidence.benchmarks.analyse

Modules are emitted and loaded before the clock starts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

import rodgen
from rodgen.scene import Scene
from rodgen_evidence.benchmarks import Times
from rodgen_evidence.report.cases import ROD
from rodgen_evidence.report.interleaved_timing import calls, time_in_turns

THRUST: dict[str, Any] = {"follower": {"force": 50.0}}
WEIGHT: dict[str, Any] = {"gravity": {}}
DIGITS = 1e-10


def scene(links: int, boundary: str, loads: dict[str, Any]) -> Scene:
    table = {"name": "rod", "rod": ROD | {"links": links, "boundary": boundary}, "loads": loads}
    return Scene.from_dict(table)


def bisection(given: Scene, low: float, high: float) -> Callable[[], float]:
    """Search of the critical force by bisection of a known bracket, with all eigenvalues of jac.

    Close to the meeting of two frequencies they are right to the square root of rounding alone,
    so this cannot reach the digits that it is stopped at.
    """
    model = rodgen.build(given)
    y = given.initial_state()

    def stable(force: float) -> bool:
        p = model.parameters(**given.parameters | {"follower_force": force})
        values = np.linalg.eigvals(model.jac(0.0, y, p))
        return bool(values.real.max() < 1e-4 * np.abs(values).max() ** 0.5)

    def search() -> float:
        a, b = low, high
        while b - a > DIGITS * b:
            middle = (a + b) / 2
            a, b = (middle, b) if stable(middle) else (a, middle)
        return b

    return search


def dense(given: Scene) -> Callable[[], object]:
    """All eigenvalues of jac."""
    model = rodgen.build(given)
    y, p = given.initial_state(), model.parameters(**given.parameters)
    return lambda: np.linalg.eigvals(model.jac(0.0, y, p))


def analyse(
    critical: Sequence[int] = (10, 50),
    modes: Sequence[int] = (50, 200),
    static: int = 10000,
    rounds: int = 9,
) -> Times:
    """Critical forces and modes of so many links, an equilibrium of so many and of a tenth."""
    table = Times("analyses")

    def beside(
        what: str, ours: Callable[[], object], other: str, its: Callable[[], object]
    ) -> None:
        both = {"ours": calls(ours), "other": calls(its)}
        times = time_in_turns(both, rounds=rounds, seconds=0.1)
        table.add(what, times["ours"], other, times["other"])

    for links in critical:
        given = scene(links, "free", THRUST)
        force = rodgen.critical_load(given).value
        plain = bisection(given, 0.97 * force, 1.02 * force)
        found = partial(rodgen.critical_load, given)
        beside(f"critical force, free, n={links}", found, "bisection, bracket of 5 % known", plain)
    damped = scene(links, "free", THRUST | {"internal_damping": {"coefficient": 0.01}})
    what = f"critical force, n={links}, internal damping"
    beside(what, partial(rodgen.critical_load, damped), "without damping", found)
    for links in modes:
        given = scene(links, "free", {})
        shapes = partial(rodgen.natural_modes, given)
        beside(f"10 modes, free, n={links}", shapes, "all eigenvalues of jac", dense(given))
    many, few = (
        partial(rodgen.static_equilibrium, scene(links, "clamped", WEIGHT))
        for links in (static, static // 10)
    )
    beside(f"equilibrium, n={static}", many, f"n={static // 10}", few)
    return table


if __name__ == "__main__":
    analyse().show()
