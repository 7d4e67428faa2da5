"""The record of a scene: errors and times of every method at every tolerance."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import rodgen
from rodgen.integrate.methods.method_choice import fastest_motion
from rodgen.integrate.stepper import StepError
from rodgen.system import System
from rodgen_evidence.tolerance.measure.error_kinds import ATOL, Array, apart, quantities
from rodgen_evidence.tolerance.measure.random_rods import random_tables
from rodgen_evidence.tolerance.measure.tight_pair import TightPair, tight_pair
from rodgen_evidence.tolerance.measure.timed_runs import time_run

Record = dict[str, Any]

RTOLS = 1e-4, 1e-6, 1e-8, 1e-10
METHODS = "dop853", "gauss", "radau", "rk45"
AUTO, SLOW = "auto", "rk45"
PATIENCE = 1.5  # seconds of a run
TIMES_LONGER = 20.0  # than dop853, that rk45 may take


def measure_scene(seed: int, rtols: tuple[float, ...] = RTOLS) -> Record:
    """Measure the scene of a number; return its record."""
    scene = rodgen.Scene.from_dict(random_tables(seed))
    model = rodgen.build(scene, "c")
    for method in ("gauss", "dop853"):  # what they need is compiled before they are timed
        time_run(
            scene, model, method, 1e-3, PATIENCE, 1, span=(0.0, 1e-6 * scene.integrate.span[1])
        )
    pair = tight_pair(scene, model)
    found: Record = {"features": features(scene, model)}
    if pair is None:
        return found | {"reference": None, "runs": []}
    found["reference"] = {
        "methods": pair.methods,
        "size": pair.size,
        "errors": pair.errors,
        "growth": pair.growth,
    }
    return found | {"runs": [*runs(scene, model, pair, rtols)]}


def runs(
    scene: rodgen.Scene, model: ModuleType, pair: TightPair, rtols: tuple[float, ...]
) -> list[Record]:
    """A row for every method and tolerance; that of auto is the row of the method that it takes,
    where that one is among them."""
    found: list[Record] = []
    slow = False
    for rtol in rtols:
        rows: dict[str, Record] = {}
        for method in METHODS:
            patience = PATIENCE
            if method == SLOW:
                if slow or rows["dop853"]["seconds"] is None:
                    continue
                patience = min(PATIENCE, TIMES_LONGER * rows["dop853"]["seconds"])
            rows[method] = run(scene, model, method, rtol, pair.values, patience)
            slow |= method == SLOW and rows[method]["seconds"] is None
        asked = scene.with_integrate(method=AUTO, rtol=rtol, atol=ATOL * rtol)
        chosen = rodgen.choose(asked, model).method
        own = rows.get(chosen) or run(scene, model, AUTO, rtol, pair.values, PATIENCE)
        found += [*rows.values(), own | {"method": AUTO, "chosen": chosen}]
    return found


def run(
    scene: rodgen.Scene,
    model: ModuleType,
    method: str,
    rtol: float,
    reference: dict[str, Array],
    patience: float = PATIENCE,
) -> Record:
    """The row of one run; errors and seconds are None where it did not come to its end."""
    done = time_run(scene, model, method, rtol, patience)
    row: Record = {"method": method, "rtol": rtol, "warned": done.warned, "ended": done.ended}
    if done.solution is None:
        return row | {"errors": None, "seconds": None, "steps": None}
    errors = apart(reference, quantities(done.solution))
    return row | {
        "errors": errors,
        "seconds": done.seconds,
        "steps": done.solution.stats.nsteps,
    }


def features(scene: rodgen.Scene, model: ModuleType) -> Record:
    """Features by which `auto` judges, and parts of the scene."""
    span = scene.integrate.span[1] - scene.integrate.span[0]
    found: Record = {"n": scene.rod.links, "boundary": scene.rod.boundary, "span": span}
    found["loads"] = [*scene.structure.terms]
    try:
        fastest = fastest_motion(System.of(scene), model)
    except StepError:
        return found | {"cycles": None, "damping": None, "growth": None}
    growth = max(fastest.value.real, fastest.partner.real) / (fastest.rate or 1.0)
    return found | {"cycles": fastest.rate * span, "damping": fastest.damping, "growth": growth}
