"""Times of the points of studies, in one process, each beside what it is to be measured by.

python -m rodgen_evidence.benchmarks.study_points
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import rodgen
from rodgen.studies import adaptive
from rodgen.studies.sampling import points_at
from rodgen.studies.study import Study
from rodgen.studies.task import evaluate
from rodgen.system import System
from rodgen_evidence.benchmarks import Times
from rodgen_evidence.benchmarks.many import FEW, SETTINGS, best, inside
from rodgen_evidence.report.costs.cost_rows import VALUES, scene

FORCE, TIME, MASS = "loads.follower.force", "loads.material_damping.time", "rod.mass"
BECK: dict[str, Any] = {
    "name": "beck",
    "rod": {
        "links": 20,
        "length": 5.0,
        "bending_stiffness": 100.0,
        "mass": 20.0,
        "boundary": "clamped",
    },
    "loads": {"follower": {"force": 40.0}, "material_damping": {"time": 0.01}},
}
LIMIT = 240.0  # s, for a whole map on two cores


def compute(study: Study, at: list[int]) -> dict[str, Any]:
    """Compute some points of a study."""
    return evaluate(study, points_at(study, at))


def runs(times: Times, count: int, span: float) -> None:
    """Runs in a study, beside their own time in C and beside runs of scenes in a loop."""
    of = scene(20).with_integrate(**SETTINGS | {"span": [0.0, span]})
    forces = np.linspace(0.5, 1.5, count) * VALUES["follower_force"]
    keep = ["last(phi_19)", "max(phi_19)", "max(tip_x)"]
    study = Study.of(of, {FORCE: forces}, keep=keep)
    every = list(range(count))
    compute(study, every[:8])
    with inside() as taken:
        start = time.process_time()
        compute(study, every)
        whole = time.process_time() - start
    what = f"{count} runs of {span:g} s, n=20, in a study"
    times.add(what, whole / count, "their own time in C", sum(taken) / count)
    model = rodgen.build(of, "c")
    some, system = forces[:: max(1, count // FEW)].tolist(), System(of)

    def loop() -> None:
        for force in some:
            rodgen.simulate(system.at({"loads.follower.force": float(force)}), model=model)

    times.add(what, whole / count, "rodgen.simulate in a loop", best(1, loop) / len(some))


def critical(times: Times, count: int, size: int) -> None:
    """Critical forces over damping and mass, beside what a point of a whole map may take."""
    vary = {TIME: np.geomspace(1e-3, 3.0, size), MASS: np.linspace(10.0, 40.0, size)}
    study = Study.of(rodgen.Scene.from_dict(BECK), vary, analysis="critical")
    some = np.random.default_rng(1).choice(study.count, count, replace=False).tolist()
    compute(study, some[:2])
    taken = best(1, lambda: compute(study, some)) / count
    allowed = 2 * LIMIT / 200**2
    times.add("critical force of Beck's column, n=20", taken, "6 ms on each of two cores", allowed)


def border(times: Times, size: int) -> None:
    """The border of a map of stability, beside the whole map (from some of its points)."""
    vary = {FORCE: np.linspace(30.0, 130.0, size), TIME: np.geomspace(1e-3, 3.0, size)}
    of = rodgen.Scene.from_dict(BECK)
    study = Study.of(of, vary, analysis="modes", keep=["stable"])
    some = np.random.default_rng(1).choice(study.count, min(400, study.count), replace=False)
    compute(study, some[:2].tolist())
    point = best(1, lambda: compute(study, some.tolist())) / len(some)
    start = time.process_time()
    steps, values = adaptive.refinement_rounds(study), None
    while True:
        try:
            values = compute(study, next(steps) if values is None else steps.send(values))
        except StopIteration:
            break
    taken = time.process_time() - start
    times.add(f"border {size} x {size}", taken, "the whole map", point * study.count)


def study(count: int = 2000, few: int = 100, size: int = 200) -> Times:
    """Runs, critical forces and a map of stability; few: of the points of a map that is timed."""
    times = Times("studies")
    runs(times, count, 0.5)
    runs(times, count, 5.0)
    critical(times, few, size)
    border(times, size)
    return times


if __name__ == "__main__":
    study().show()
