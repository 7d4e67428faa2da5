"""Times of limit cycles beside AUTO-07p's and SciPy's collocation of the same equations.

python -m rodgen_evidence.benchmarks.cycles

All begin with the same run near the cycle and call the same compiled module. Each has the
coarsest settings of its own with which the period is right to 1e-8; the reference is rodgen's by
shooting. AUTO-07p comes with bifpy (the extra `peers` of this package), whose callbacks
are Python's, as SciPy's are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from types import ModuleType
from typing import Any

import numpy as np
from scipy.integrate import solve_bvp

import rodgen
from rodgen.arrays import Array
from rodgen_evidence.benchmarks import Times
from rodgen_evidence.benchmarks.clusters import processor_time
from rodgen_evidence.benchmarks.many import best

RIGHT = 1e-8  # of the period
SPAN = 60.0  # s, of a run to a cycle
OFF = 1e-3  # by which the start is wrong
SHOTS, REFERENCE = 3, 5  # segments; those of the period that is right
NODES = (20, 40, 80, 160, 320)  # intervals of AUTO-07p's mesh
TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)  # of SciPy's residuals
FORCE = 22.0  # N
MOST = 20000  # nodes of SciPy's mesh


@dataclass(frozen=True)
class Start:
    """A scene, its module, and a motion over nearly a period: times (points,) from 0 to 1, states
    (states, points)."""

    scene: rodgen.Scene
    model: ModuleType
    p: Array
    period: float
    times: Array
    states: Array

    @classmethod
    def of(cls, links: int) -> Start:
        """Near the cycle of a clamped column of so many links, beyond its flutter."""
        scene = rodgen.Scene.from_dict(
            {
                "name": "column",
                "rod": {"links": links, "length": 1, "mass": 1, "bending_stiffness": 1}
                | {"boundary": "clamped"},
                "loads": {"follower": {"force": FORCE}, "material_damping": {"time": 0.005}},
                "initial": {"phi": "0.1*s"},
                "integrate": {"span": [0.0, SPAN], "output_every": 0.02},
            }
        )
        cycle = rodgen.find_cycle(scene)
        model = rodgen.build(scene, "c", parts=("rhs", "jac", "batch"))
        p = model.parameters(**scene.parameters)
        motion = cycle.motion
        shown = slice(None, None, max(1, len(motion.t) // 200))
        times = (motion.t[shown] - motion.t[0]) / cycle.period
        states = motion.y[shown].T * (1 + OFF)
        return cls(scene, model, p, cycle.period * (1 + OFF), times, states)

    @property
    def y0(self) -> Array:
        return self.states[:, 0]


def of_rodgen(start: Start, segments: int | None = None) -> float:
    """The period [s], multipliers with it: by collocation, or by shooting in so many segments."""
    found = rodgen.find_cycle(
        start.scene, y0=start.y0, period=start.period, segments=segments, target="c"
    )
    return found.period


def of_scipy(start: Start, tolerance: float) -> float:
    """The period [s] by collocation of fourth order; there are no multipliers."""
    model, p, size = start.model, start.p, len(start.y0)
    anchor = start.y0[0]

    def rates(s: Array, y: Array, T: Array) -> Array:
        out = np.empty((y.shape[1], size))
        model.rhs_batch(0.0, np.ascontiguousarray(y.T), p, out)
        return np.asarray(T[0] * out.T)

    def derivatives(s: Array, y: Array, T: Array) -> tuple[Array, Array]:
        J = np.stack([model.jac(0.0, one, p) for one in np.ascontiguousarray(y.T)], axis=-1)
        return T[0] * J, (rates(s, y, T) / T[0])[:, None]

    found = solve_bvp(
        rates,
        lambda a, b, T: np.append(a - b, a[0] - anchor),
        start.times,
        start.states,
        [start.period],
        tol=tolerance,
        fun_jac=derivatives,
        max_nodes=MOST,
    )
    if not found.success:
        raise RuntimeError(found.message)
    return float(found.p[0])


def of_auto(start: Start, intervals: float) -> float:
    """The period [s] by AUTO-07p's collocation of fourth degree, multipliers with it: by one step
    along a parameter that changes nothing, which corrects the orbit that is given."""
    from bifpy import auto

    model, p, size = start.model, start.p, len(start.y0)
    y = np.empty(size)

    def rates(state: Any, parameters: Any) -> Any:
        y[:] = state
        return model.rhs(0.0, y, p)

    def jacobian(state: Any, parameters: Any) -> Any:
        y[:] = state
        return model.jac(0.0, y, p), np.zeros((size, 2))

    def first(state: Any, parameters: Any, time: float) -> None:
        parameters[0] = 0.0
        parameters[auto.PERIOD_INDEX - 1] = start.period

    settings = {
        "ips": auto.IPS_PERIODIC_ORBIT,
        "ndim": size,
        "npar": 1,
        "nmx": 2,
        "ntst": int(intervals),
        "ncol": 4,
        "iad": 1,
        "jac": 1,
        "epsl": 1e-10,
        "epsu": 1e-10,
        "isp": 2,
        "ilp": 0,
        "npr": 1,
        "ds": 1e-3,
    }
    orbit = (start.times.tolist(), start.states.T.tolist())
    free = [1, auto.PERIOD_INDEX]
    found = auto.run(rates, first, settings, icu=free, dat=orbit, jac=jacobian)
    return float(found.branches[0].points[-1].parameters[-1])


def coarsest(solve: Callable[[float], float], settings: Sequence[float], period: float) -> float:
    """The first of the settings, each finer than the one before, with which the period is right.
    Raises RuntimeError where none is."""
    for one in settings:
        if abs(solve(one) / period - 1) <= RIGHT:
            return one
    raise RuntimeError(f"a period that is right to {RIGHT:g} was not found by any of {settings}")


def cycles(links: Sequence[int] = (2, 5, 10), rounds: int = 3) -> Times:
    """A row for every column and peer."""
    times = Times(f"A limit cycle, its period right to {RIGHT:g}")
    for n in links:
        start = Start.of(n)
        period = of_rodgen(start, REFERENCE)
        peers: list[tuple[str, Callable[[float], float], Sequence[float]]]
        peers = [("solve_bvp, no multipliers", partial(of_scipy, start), TOLERANCES)]
        if find_spec("bifpy"):
            peers.append(("AUTO-07p", partial(of_auto, start), NODES))
        ours = best(rounds, partial(of_rodgen, start), processor_time)
        shot = best(rounds, partial(of_rodgen, start, SHOTS), processor_time)
        what = f"{n} links, {2 * n - 1} multipliers"
        times.add(what, ours, f"shooting in {SHOTS} segments", shot)
        for name, solve, settings in peers:
            one = coarsest(solve, settings, period)
            theirs = best(rounds, partial(solve, one), processor_time)
            times.add(what, ours, f"{name}, {one:g}", theirs)
    if not find_spec("bifpy"):
        print("bifpy is not installed: AUTO-07p is no peer")
    return times


if __name__ == "__main__":
    cycles().show()
