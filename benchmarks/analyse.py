"""Times of analyses, each beside the plain way to the same number, in turns in the same run.

    python benchmarks/analyse.py

Modules are emitted and loaded before the clock starts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import rodgen
from rodgen.judge.timing import calls, interleaved
from rodgen.scene import Scene

ROD = {"length": 5.0, "bending_stiffness": 100.0, "mass": 50.0}
THRUST: dict[str, Any] = {"follower": {"force": 50.0}}
WEIGHT: dict[str, Any] = {"gravity": {}}
DIGITS = 1e-10


def scene(links: int, boundary: str, loads: dict[str, Any]) -> Scene:
    table = {"name": "rod", "rod": ROD | {"links": links, "boundary": boundary}, "loads": loads}
    return Scene.from_dict(table)


def bisected(given: Scene, low: float, high: float) -> Callable[[], float]:
    """The critical force by bisection with all eigenvalues of jac, of a bracket that is known.

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


def main() -> None:
    table = Table(title="analyses")
    for name in ("what", "time", "the plain way", "time", "ratio"):
        table.add_column(name)
    pairs: list[tuple[str, Callable[[], object], str, Callable[[], object]]] = []
    for links in (10, 50):
        given = scene(links, "free", THRUST)
        force = rodgen.critical_force(given).force
        pairs.append(
            (
                f"critical force, free, n={links}",
                lambda given=given: rodgen.critical_force(given),
                "bisection with jac, bracket of 5 % known",
                bisected(given, 0.97 * force, 1.02 * force),
            )
        )
    damped = scene(50, "free", THRUST | {"internal_damping": {"coefficient": 0.01}})
    small, large = (scene(n, "clamped", WEIGHT) for n in (1000, 10000))
    pairs += [
        (
            "critical force, n=50, internal damping",
            lambda: rodgen.critical_force(damped),
            "without damping",
            lambda: rodgen.critical_force(scene(50, "free", THRUST)),
        ),
        (
            "10 modes, free, n=50",
            lambda: rodgen.natural_modes(scene(50, "free", {})),
            "all eigenvalues of jac",
            dense(scene(50, "free", {})),
        ),
        (
            "10 modes, free, n=200",
            lambda: rodgen.natural_modes(scene(200, "free", {})),
            "all eigenvalues of jac",
            dense(scene(200, "free", {})),
        ),
        (
            "equilibrium, n=10000",
            lambda: rodgen.static_equilibrium(large),
            "n=1000",
            lambda: rodgen.static_equilibrium(small),
        ),
    ]
    for name, ours, other_name, other in pairs:
        times = interleaved({"ours": calls(ours), "other": calls(other)}, rounds=9, seconds=0.1)
        table.add_row(
            name,
            f"{1e3 * times.median('ours'):.3g} ms",
            other_name,
            f"{1e3 * times.median('other'):.3g} ms",
            f"{times.ratio('ours', 'other'):.2g}",
        )
    Console().print(table)


if __name__ == "__main__":
    main()
