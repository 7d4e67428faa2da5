"""Many runs of rodgen beside heyoka's batch propagation, at equal error, on one core.

python -m rodgen_evidence.benchmarks.many_heyoka [LINKS] [RODS] [plain]

Free rods under a thrust that differs from rod to rod; what is compared is the state at the end,
against runs at a much smaller tolerance, of which the first and the last are checked by another
method. heyoka (in the extra `peers` of this package) has the O(n) expressions of
rodgen_evidence.report.peers.chain_accelerations, with the thrust as a runtime parameter, as many
rods side by side as it recommends, in compact mode; with `plain` in the other one, whose code is
straight, faster, and slow to compile. Nothing is sampled by either.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

import rodgen
from rodgen_evidence.benchmarks import Times
from rodgen_evidence.benchmarks.many import SPAN, best
from rodgen_evidence.report.costs.cost_rows import VALUES, Array, scene

RTOLS = (1e-4, 1e-6, 1e-8, 1e-10)
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-9, 1e-12)  # of a step of a Taylor series
EXACT = 1e-13  # relative tolerance of what errors are measured against
SIDE = 512  # rods that rodgen is given at once at least, so that what Python takes is as in studies


class Point(NamedTuple):
    """Time of a run [s] and its largest error: rms over the angles of a rod [rad]."""

    seconds: float
    error: float


def thrusts(rods: int) -> Array:
    """The thrusts of so many rods [N]."""
    made: Array = np.linspace(0.5, 1.5, rods) * VALUES["follower_force"]
    return made


def _error(y: Array, exact: Array, links: int) -> float:
    """The largest of all rods, of the angles."""
    off = (y - exact)[:, 2 : 2 + links]
    return float(np.sqrt((off**2).mean(axis=1)).max())


def of_rodgen(links: int, rods: int, rounds: int) -> tuple[Array, list[Point]]:
    """States at the end that are as good as exact (rods, states), and a point for every
    tolerance."""
    of = scene(links)
    model = rodgen.build(of, "c", parts=("rhs", "flow", "power", "lanes"))
    p = np.tile(model.parameters(**of.parameters), (rods, 1))
    p[:, model.PARAMETERS.index("follower_force")] = thrusts(rods)
    y0, times = of.initial_state(), max(1, SIDE // rods)
    many = np.tile(p, (times, 1))

    def run(p: Array, method: str, rtol: float) -> rodgen.Ensemble:
        return rodgen.simulate_many(
            model, p, y0, span=[0.0, SPAN], method=method, rtol=rtol, atol=1e-3 * rtol,
            output_every=SPAN,
        )  # fmt: skip

    exact, ends = run(p, "dop853", EXACT).y, [0, -1]
    off = _error(run(p[ends], "rk45", EXACT).y, exact[ends], links)
    print(f"what errors are measured against: rk45 differs by {off:.1e} rad", flush=True)
    points = []
    for rtol in RTOLS:
        seconds = best(rounds, partial(run, many, "dop853", rtol)) / len(many)
        points.append(Point(seconds, _error(run(p, "dop853", rtol).y, exact, links)))
    return exact, points


def of_heyoka(links: int, exact: Array, rounds: int, compact: bool) -> list[Point]:
    """A point for every tolerance, and what compiling took [s]."""
    import heyoka as hy

    from rodgen_evidence.report.peers import chain_accelerations
    from rodgen_evidence.report.peers.heyoka_rod import SYMBOLS

    of, rods, width = scene(links), len(exact), hy.recommended_simd_size()
    unknown = [hy.make_vars(*(f"{name}{i}" for i in range(links + 2))) for name in "qu"]
    given = {**of.parameters, "follower_force": hy.par[0]}
    rates = chain_accelerations.accelerations(of.structure, given, unknown[0], unknown[1], SYMBOLS)
    system = list(zip([*unknown[0], *unknown[1]], [*unknown[1], *rates], strict=True))
    start = np.tile(of.initial_state()[:, None], (1, width))
    forces = np.resize(thrusts(rods), (-(-rods // width), width))
    points = []
    for tolerance in TOLERANCES:
        begun = time.perf_counter()
        batch = hy.taylor_adaptive_batch(
            system, start, pars=forces[:1], tol=tolerance, compact_mode=compact
        )
        what = f"heyoka, tolerance {tolerance:g}, order {batch.order}"
        print(f"{what}: compiled in {time.perf_counter() - begun:.1f} s", flush=True)

        def run(batch: hy.taylor_adaptive_batch_dbl = batch) -> Array:
            ends = []
            for some in forces:
                batch.set_time(0.0)
                batch.state[:], batch.pars[0] = start, some
                batch.propagate_until(SPAN)
                ends.append(batch.state.T.copy())
            return np.concatenate(ends)[:rods]

        points.append(Point(best(rounds, run) / forces.size, _error(run(), exact, links)))
    return points


def at(error: float, points: Sequence[Point]) -> float:
    """The time at an error [s], between points straight on logarithmic axes, beyond them that of
    the nearest."""
    ordered = sorted(points, key=lambda one: one.error)
    logs = np.log([[one.error, one.seconds] for one in ordered])
    return float(np.exp(np.interp(np.log(error), logs[:, 0], logs[:, 1])))


def many_heyoka(
    links: int = 20,
    rods: int = 64,
    compact: bool = True,
    rounds: int = 5,
    peer: Callable[[int, Array, int, bool], list[Point]] = of_heyoka,
) -> Times:
    """A row for every tolerance of rodgen."""
    times = Times("many runs, at equal error")
    exact, ours = of_rodgen(links, rods, rounds)
    theirs = peer(links, exact, rounds, compact)
    for one in theirs:
        print(f"heyoka: {1e3 * one.seconds:.4f} ms a run, error {one.error:.1e} rad")
    for rtol, one in zip(RTOLS, ours, strict=True):
        what = f"n={links}, rtol={rtol:g}: error {one.error:.1e} rad"
        times.add(what, one.seconds, "heyoka at this error", at(one.error, theirs))
    return times


if __name__ == "__main__":
    given = [int(one) for one in sys.argv[1:] if one.isdigit()]
    links, rods = [*given, *(20, 64)[len(given) :]]
    many_heyoka(links, rods, compact="plain" not in sys.argv).show()
