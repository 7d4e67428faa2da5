"""Savings of a module that holds only what its scene needs.

Beside it one that has every load, those that the scene lacks with coefficients of zero; how the
rod is held stays. Both must give the same motion to rounding, or the row says that they do not.
"""

from __future__ import annotations

import copy
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from pandas import DataFrame

import rodgen
from rodgen.analyse.precision.contestant import Measurement, describe_error
from rodgen.integrate.stability import dominant
from rodgen.loading import sources
from rodgen.scene import Scene
from rodgen_evidence.report.cases import Case
from rodgen_evidence.report.costs.cold import cold, environment, scratch
from rodgen_evidence.report.costs.cost_rows import Array
from rodgen_evidence.report.interleaved_timing import calls, time_in_turns
from rodgen_evidence.report.unit import Unit

PLAIN, WHOLE = "as the scene", "every term, at zero"
NOTHING: dict[str, dict[str, float]] = {
    "follower": {"force": 0.0},
    "gravity": {"g": 0.0},
    "internal_damping": {"coefficient": 0.0},
    "external_damping": {"coefficient": 0.0},
    "tip": {"x": 0.0, "y": 0.0},
}
SAVED = (
    *("operations", "source_bytes", "object_bytes", "generate", "compile", "rhs"),
    *("run", "run_dop853"),
)
MOST, MOST_QUICK = 200, 1  # links; scenes of the short report
LIMIT = 240.0  # s
STEPS, OF_LIMIT = 1000, 0.4  # of rk4, and their length over the largest stable one
RTOL = 1e-8
ROUNDS, QUICK_ROUNDS = 7, 3
# Relative differences of the rates: some hundred roundings, times the condition of many links;
# and of the motion after STEPS steps, in which they add up and grow.
SAME_RATES, SAME_MOTION = 1e-10, 1e-7


def units(cases: Sequence[Case], quick: bool, *_: object) -> list[Unit]:
    """One per structure, so that scenes that share a module do not have it made again."""
    chosen = [case for case in cases if case.scene["rod"]["links"] <= MOST]
    chosen = chosen[:MOST_QUICK] if quick else chosen
    by_structure: dict[str, list[Case]] = {}
    for case in chosen:
        by_structure.setdefault(Scene.from_dict(case.scene).structure.hash, []).append(case)
    return [
        Unit(
            "leaving_out",
            f"leaving_out-{some[0].name}",
            f"{__name__}:measure_savings",
            {"scenes": [case.scene for case in some], "quick": quick},
            limit=LIMIT,
        )
        for some in by_structure.values()
    ]


def savings(rows: DataFrame) -> DataFrame:
    """Every term at zero coefficients over the scene's own module, by scene."""
    costs = rows.reindex(columns=["scene", "variant", *SAVED])[rows["failed"] == ""]
    by = costs.set_index(["scene", "variant"]).astype(float)
    own, whole = (by[by.index.get_level_values(1) == name].droplevel(1) for name in (PLAIN, WHOLE))
    return (whole / own).dropna(how="all")


def with_every_term(table: dict[str, Any]) -> dict[str, Any]:
    """The scene's tables with the loads that it lacks at zero."""
    whole = copy.deepcopy(table)
    loads = whole.setdefault("loads", {})
    for name, values in NOTHING.items():
        loads.setdefault(name, dict(values))
    return whole


def measure_savings(scenes: Sequence[dict[str, Any]], quick: bool = False) -> list[Measurement]:
    """Measure the savings of scenes that have one structure."""
    variants = {PLAIN: scenes[0], WHOLE: with_every_term(scenes[0])}
    with ExitStack() as stack, ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        # Side by side, a core for each: what disturbs one disturbs the other.
        folders = {variant: stack.enter_context(scratch()) for variant in variants}
        futures = {v: pool.submit(cold, variants[v], folders[v]) for v in variants}
        try:
            made = {v: set_up(variants[v], futures[v].result(), folders[v]) for v in variants}
        except Exception as error:  # of a compiler, say
            return [empty(s, v, failed=describe_error(error)) for s in scenes for v in variants]
        models = {v: made_model for v, (_, made_model) in made.items()}
        sizes = {v: size for v, (size, _) in made.items()}
        return [row for table in scenes for row in compare_modules(table, models, sizes, quick)]


def empty(table: dict[str, Any], variant: str, **more: Any) -> Measurement:
    """The columns of a row."""
    none = dict.fromkeys((*SAVED, "same_rates", "same_motion"))
    names = {"scene": table["name"], "n": table["rod"]["links"], "variant": variant}
    return {**names, **none, "failed": "", **more}


def set_up(
    table: dict[str, Any], seconds: dict[str, float], folder: str
) -> tuple[Measurement, ModuleType]:
    """A module that lies in a cache of its own: its sizes beside its seconds; and it."""
    scene = Scene.from_dict(table)
    with environment(RODGEN_CACHE=folder):
        texts, model = sources(scene, "c"), rodgen.build(scene, "c")
    # The whole module, as it was made from cold, and parts of it, which the run asks for.
    stem = scene.structure.module_stem("c", "chain")
    libraries = [file for file in Path(folder).rglob("*.so") if file.name.startswith(stem)]
    sizes: Measurement = {
        "operations": model.PROVENANCE["operations"]["rhs"],
        "source_bytes": sum(len(t.encode()) for name, t in texts.items() if name[-2:] != "py"),
        "object_bytes": max(file.stat().st_size for file in libraries),
        **seconds,
    }
    return sizes, model


def compare_modules(
    table: dict[str, Any], models: dict[str, ModuleType], sizes: dict[str, Measurement], quick: bool
) -> list[Measurement]:
    """Compare both modules on one scene, timed in turns."""
    table = table | {"events": []}
    scenes = {PLAIN: Scene.from_dict(table), WHOLE: Scene.from_dict(with_every_term(table))}
    found: dict[str, Any] = {"failed": ""}
    times: dict[str, dict[str, float]] = {}
    try:
        jobs = job(scenes[PLAIN], models[PLAIN])
        rates, motion = difference(scenes, models, jobs["run"])
        found |= {"same_rates": rates, "same_motion": motion}
        check(rates, motion)  # what differs is not timed
        rounds = QUICK_ROUNDS if quick else ROUNDS
        runs = {what: _runs(scenes, models, how, rounds) for what, how in jobs.items()}
        times = {"rhs": _rates(scenes, models, rounds), **runs}
    except Exception as error:  # a scene of a user may fail in any way
        found["failed"] = describe_error(error)
    return [
        empty(table, v, **sizes[v], **found, **{what: taken[v] for what, taken in times.items()})
        for v in scenes
    ]


def job(scene: Scene, model: ModuleType) -> dict[str, dict[str, Any]]:
    """Settings of STEPS steps of rk4, and of dop853 over the same time."""
    start, end = scene.integrate.span
    y, p = scene.initial_state(), model.parameters(**scene.parameters)
    rate = dominant(model, start + 1e-9 * (end - start), y, p).rate
    step = OF_LIMIT * 2.785 / rate if rate else (end - start) / STEPS
    span = {"span": [start, start + STEPS * step], "output_every": STEPS * step}
    return {
        "run": {**span, "method": "rk4", "step": step},
        "run_dop853": {**span, "method": "dop853", "rtol": RTOL, "atol": RTOL / 100},
    }


def difference(
    scenes: dict[str, Scene], models: dict[str, ModuleType], how: dict[str, Any]
) -> tuple[float, float]:
    """Relative differences of both modules: of the rates at the start and at a state far from it,
    and of the states at the end of a run."""
    y = scenes[PLAIN].initial_state()
    far = y + 0.5 * np.random.default_rng(1).standard_normal(len(y))
    t = scenes[PLAIN].integrate.span[0]
    rates, ends = [], []
    for variant, model in models.items():
        p = model.parameters(**scenes[variant].parameters)
        rates.append([model.rhs(t, at, p) for at in (y, far)])
        ends.append(rodgen.simulate(scenes[variant], model=model, **how).y[-1])
    off = max(relative(a, b) for a, b in zip(*rates, strict=True))
    return off, relative(*ends)


def relative(a: Array, b: Array) -> float:
    """Largest difference over the largest entry."""
    off, size = float(np.abs(a - b).max()), float(np.abs(a).max())
    return off / size if size else off


def check(rates: float, motion: float) -> None:
    """Raise ArithmeticError where the differences are no rounding."""
    if not rates <= SAME_RATES:
        raise ArithmeticError(f"rates of both modules differ by {rates:.1e}")
    if not motion <= SAME_MOTION:
        raise ArithmeticError(f"motions by both modules differ by {motion:.1e}")


def _rates(
    scenes: dict[str, Scene], models: dict[str, ModuleType], rounds: int
) -> dict[str, float]:
    y = scenes[PLAIN].initial_state()
    batches = {}
    for variant, model in models.items():
        p = model.parameters(**scenes[variant].parameters)
        given = (y, p, np.empty_like(y)) if hasattr(model, "COMPILED") else (y, p)
        batches[variant] = calls(partial(model.rhs, scenes[PLAIN].integrate.span[0], *given))
    return time_in_turns(batches, 3 * rounds)


def _runs(
    scenes: dict[str, Scene], models: dict[str, ModuleType], how: dict[str, Any], rounds: int
) -> dict[str, float]:
    """Seconds of rodgen.simulate as a whole, by variant."""
    batches = {
        variant: calls(partial(rodgen.simulate, scenes[variant], model=model, **how))
        for variant, model in models.items()
    }
    return time_in_turns(batches, rounds)
