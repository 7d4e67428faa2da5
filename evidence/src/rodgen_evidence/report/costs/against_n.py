"""Costs of everything against the number of links, and their exponents.

A free uniform rod with thrust; for implicit steps with internal damping as well. Batches of all
that is compared take turns, and medians are kept. What fails is a row that says why.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from functools import partial
from types import ModuleType

import numpy as np
from pandas import DataFrame
from scipy.integrate import Radau

import rodgen
from rodgen.analyse.precision.contestant import Measurement
from rodgen.integrate.stability import dominant
from rodgen_evidence.report.costs.cost_rows import (
    DAMPED,
    THRUST,
    VALUES,
    Array,
    built,
    compare_costs,
    parameter_vector,
    scene,
)
from rodgen_evidence.report.costs.rates import jacobians, rates, set_up
from rodgen_evidence.report.interleaved_timing import Batch, calls
from rodgen_evidence.report.peers import RATES
from rodgen_evidence.report.unit import Unit

LINKS = (10, 20, 50, 100, 200, 500, 1000, 2000)
QUICK = (10, 50)
ANALYSED = 200  # links: of what makes eigenvalues
LIMIT, PEER_LIMIT = 240.0, 120.0  # s
PEER = "rodgen_evidence.report.costs.rates:of_peer"


def units(_: object, quick: bool, *__: object) -> list[Unit]:
    """Plan units by number of links, then by peer; the scenes of the report have no part in it."""
    chosen, call = list(QUICK if quick else LINKS), f"{__name__}:costs"
    made = [
        Unit("costs", f"costs-n{n}", call, {"links": n, "quick": quick}, limit=LIMIT)
        for n in chosen
    ]
    for name in RATES:
        plain = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")
        asked = {"name": name, "links": [50] if quick else chosen, "quick": quick}
        made.append(Unit("costs", f"costs-peer-{plain}", PEER, asked, limit=PEER_LIMIT))
    return made


def costs(links: int, quick: bool = False) -> list[Measurement]:
    """All of one number of links: set-up from cold, then evaluations, steps, jobs, analyses."""
    rows, module = set_up(links, quick)
    rows += rates(links, module, quick)
    rows += jacobians(links, module, quick)
    rows += jobs(links, module, quick)
    if not quick or links == QUICK[-1]:  # another module is to be made for them
        rows += implicit_steps(links, quick)
    return rows + (analyses(links, quick) if links <= ANALYSED else [])


def fits(rows: DataFrame) -> DataFrame:
    """Exponents of the seconds by n, per what and who, over the upper half of its numbers of links.

    A line of least squares through the logarithms; nan where there are not two.
    """
    good = rows[(rows["failed"] == "") & (rows["seconds"] > 0)].sort_values("n")
    found = []
    for (what, who), some in good.groupby(["what", "who"]):
        upper = some[len(some) // 2 :] if len(some) > 3 else some
        x, y = np.log(upper["n"]), np.log(upper["seconds"])
        several = upper["n"].nunique() > 1
        exponent = np.polyfit(x - x.mean(), y, 1)[0] if several else math.nan
        first, last = upper["n"].iloc[[0, -1]]
        found.append((what, who, exponent, first, last, len(upper)))
    return DataFrame(found, columns=["what", "who", "exponent", "from", "to", "points"])


# Implicit steps, whole jobs and analyses ----------------------------------------------------------

STEPS = 1000  # of a job, by rk4
OF_LIMIT = 0.5  # of the largest stable step
TIMES = 3  # a job is run
TAKEN, SCIPY_TAKEN = 30, 8  # implicit steps at a time
MOST_SCIPY, MOST_DENSE_JOB = 200, 100  # links
SPAN = 10.0  # s, that the implicit methods could go
TOLERANCES = {"rtol": 1e-6, "atol": 1e-8}


def implicit_steps(links: int, quick: bool) -> list[Measurement]:
    """One accepted step with all its iterations, evaluations and factorisations, of a strongly
    damped rod from its start on; SciPy's with dense matrices."""
    given: dict[str, Callable[[], Batch]] = {
        f"rodgen C, {method}": partial(_ours, links, method) for method in ("gauss", "radau")
    }
    if links <= MOST_SCIPY:
        given["SciPy Radau on rodgen C"] = partial(_scipy, links)
    return compare_costs("implicit step", links, given, quick)


def _damped_rod(links: int) -> tuple[ModuleType, Array, Array]:
    """The module of the damped rod, its start and its parameters."""
    module = built(links, DAMPED)
    return (
        module,
        scene(links, VALUES["internal_damping"]).initial_state(),
        parameter_vector(module),
    )


def _ours(links: int, method: str) -> Batch:
    module, y, p = _damped_rod(links)
    nothing = np.empty(0), np.empty((0, len(y) + len(module.WORKS)))

    def once() -> float:
        run = module.Run(method, 0.0, y, p, **TOLERANCES)
        run.begin(SPAN)
        start = time.perf_counter()
        status, _ = run.advance(TAKEN, *nothing)
        taken = time.perf_counter() - start
        if status < 0:
            raise ArithmeticError(f"{method} ends with status {status}")
        return taken / int(run.numbers.steps)

    return lambda number: sum(once() for _ in range(number))


def _scipy(links: int) -> Batch:
    module, y, p = _damped_rod(links)

    def once() -> float:
        solver = Radau(
            lambda t, at: module.rhs(t, at, p),
            *(0.0, y, SPAN),
            jac=lambda t, at: module.jac(t, at, p),
            **TOLERANCES,
        )
        start = time.perf_counter()
        for _ in range(SCIPY_TAKEN):
            solver.step()
        return (time.perf_counter() - start) / SCIPY_TAKEN

    return lambda number: sum(once() for _ in range(number))


def jobs(links: int, module: ModuleType, quick: bool) -> list[Measurement]:
    """STEPS steps of rk4 by rodgen.simulate, with the samples at both ends."""
    modules: dict[str, Callable[[], ModuleType]] = {"rodgen C": lambda: module}
    if not quick:
        modules["rodgen NumPy"] = partial(built, links, THRUST, "numpy")
    if links <= MOST_DENSE_JOB and not quick:
        modules["rodgen NumPy, dense"] = partial(built, links, THRUST, "numpy", "dense")
    free = scene(links)
    p = module.parameters(**free.parameters)
    step = float(OF_LIMIT * np.sqrt(8) / dominant(module, 0.0, free.initial_state(), p).rate)
    span = step * STEPS
    job = scene(links, method="rk4", step=step, span=[0.0, span], output_every=span)

    def batch(model: Callable[[], ModuleType]) -> Batch:
        return calls(partial(rodgen.simulate, job, model=model()))

    made = {who: partial(batch, model) for who, model in modules.items()}
    return compare_costs(f"job: {STEPS} steps of rk4", links, made, quick, TIMES)


def analyses(links: int, quick: bool) -> list[Measurement]:
    """Critical thrust and natural modes; set-up is done before."""
    free = scene(links)
    critical, modes = (
        partial(rodgen.critical_load, free),
        partial(rodgen.natural_modes, free, 10),
    )
    return [
        *compare_costs("critical force", links, {"rodgen": lambda: calls(critical)}, quick, TIMES),
        *compare_costs("ten natural modes", links, {"rodgen": lambda: calls(modes)}, quick, TIMES),
    ]
