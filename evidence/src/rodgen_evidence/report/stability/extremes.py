"""Section "extremes": what happens at the edges, case by method; numbers that are none."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType
from typing import Any

import numpy as np

import rodgen
from rodgen.analyse.precision.contestant import Measurement
from rodgen.errors import InputError
from rodgen.integrate import RunError
from rodgen_evidence.report.stability.extremes_case import Array, Tables, TrueMotion
from rodgen_evidence.report.stability.extremes_cases import GROUPS
from rodgen_evidence.report.stability.extremes_run import (
    LOST,
    REFUSED,
    RIGHT,
    STOPPED,
    WRONG,
    Said,
    digits,
    judge,
    row,
)
from rodgen_evidence.report.stability.extremes_truth import N, loaded_rod
from rodgen_evidence.report.unit import Unit

NONE = {"nan": float("nan"), "inf": float("inf"), "-inf": float("-inf")}
TINY = 5e-324
# Where a value of a scene stands; of these a negative one is refused as well.
PLACES = (
    *(("rod", "length"), ("rod", "mass"), ("rod", "bending_stiffness")),
    *(("loads", "follower", "force"), ("loads", "gravity", "g")),
    *(("loads", "internal_damping", "coefficient"), ("loads", "external_damping", "coefficient")),
    *(("initial", "phi"), ("initial", "omega"), ("integrate", "rtol"), ("integrate", "atol")),
)
ROUTES = {"c": ("c", "chain"), "numpy": ("numpy", "chain"), "numpy dense": ("numpy", "dense")}


NOTHING = TrueMotion(np.empty(0), "what is no number must not become one")


def invalid() -> list[Measurement]:
    """All of them take a second, so that the short report has them too."""
    return [*_scenes(), *_rates(), *_denormal()]


def _row(case: str, target: str, method: str, said: Said) -> Measurement:
    return row((INVALID, case, N), said, NOTHING, method, target)


def _with(tables: Tables, place: tuple[str, ...], value: Any) -> Tables:
    """The tables with another value at a place."""
    head, *rest = place
    if not rest:
        return {**tables, head: value}
    return {**tables, head: _with(tables.get(head, {}), tuple(rest), value)}


def _scenes() -> Iterator[Measurement]:
    """A scene refuses a value that is no number, wherever it stands, and a tolerance of 1e-15."""
    given = [(place, name, value) for place in PLACES for name, value in NONE.items()]
    too_tight = (("integrate", "rtol"), "1e-15", 1e-15)
    for place, name, value in [*given, too_tight]:
        yield _row(f"{'.'.join(place)} = {name}", "", "scene", _refusal(place, value))


def _refusal(place: tuple[str, ...], value: float) -> Said:
    try:
        rodgen.Scene.from_dict(_with(loaded_rod(), place, value))
    except InputError as error:
        return Said(REFUSED, said=str(error))
    return Said(WRONG, said="the scene takes it")


def _rates() -> Iterator[Measurement]:
    """rhs with one state or parameter that is no number: the rates are none, or those of it."""
    scene = rodgen.Scene.from_dict(loaded_rod())
    for name, route in ROUTES.items():
        model = rodgen.build(scene, *route)
        p, y = model.parameters(**scene.parameters), scene.initial_state()
        for kind, value in NONE.items():
            for what, names in (("y", model.STATE), ("p", model.PARAMETERS)):
                given = model, what, value, y, p
                finite = [one for at, one in enumerate(names) if _hides(*given, at)]
                said = (
                    Said(WRONG, said=f"finite rates in spite of {', '.join(finite)}")
                    if finite
                    else Said(STOPPED, said="not-a-number or infinity comes through")
                )
                yield _row(f"rhs of {what} = {kind}, one by one", name, "rhs", said)


def _hides(model: ModuleType, what: str, value: float, y: Array, p: Array, at: int) -> bool:
    """Whether rates that depend on it are finite: where a rod is, they do not depend on."""
    if what == "y" and model.STATE[at] in ("x0", "y0"):
        return False
    y, p = y.copy(), p.copy()
    (y if what == "y" else p)[at] = value
    with np.errstate(all="ignore"):
        return bool(np.isfinite(model.rhs(0.0, y, p)).all())


def _denormal() -> Iterator[Measurement]:
    """Denormal states are as good as zeros; denormal parameters are refused or are zeros."""
    scene = rodgen.Scene.from_dict(loaded_rod())
    for name, route in ROUTES.items():
        model = rodgen.build(scene, *route)
        p, zero = model.parameters(**scene.parameters), np.zeros(len(model.STATE))
        off = np.abs(model.rhs(0.0, zero + TINY, p) - model.rhs(0.0, zero, p)).max()
        said = Said(RIGHT if off < 1e-9 else WRONG, digits(float(off)))
        yield _row("rhs of y = 5e-324", name, "rhs", said)
    for place in (*PLACES[:3], *PLACES[3:7]):
        for target in ("c", "numpy"):
            case = f"{'.'.join(place)} = 5e-324"
            yield _row(case, target, "auto", _tiny(_with(loaded_rod(), place, TINY), place, target))


def _tiny(tables: Tables, place: tuple[str, ...], target: str) -> Said:
    """A denormal load is none; of a rod without mass or length nothing can be said."""
    try:
        tiny = _end(tables, target)
    except InputError as error:
        return Said(REFUSED, said=str(error))
    except RunError as error:
        return Said(STOPPED, said=str(error))
    if place[-1] in ("mass", "length"):
        return Said(LOST if not np.isfinite(tiny).all() else WRONG, said="the run was finished")
    plain = _end(_with(loaded_rod(), place, 0.0), target)
    off = float(np.abs(tiny - plain).max() / np.abs(plain).max())
    return Said(RIGHT if off < 1e-6 else WRONG, digits(off), said="as with zero")


def _end(tables: Tables, target: str) -> Array:
    scene = rodgen.Scene.from_dict(tables)
    with np.errstate(all="ignore"):
        sol = rodgen.simulate(scene, target=target, rtol=1e-8, max_steps=20_000)
    return np.asarray(sol.y[-1])


INVALID = "invalid"
LIMIT = 300.0  # s for a group, on a busy machine
ALL = (*GROUPS, INVALID)
# In the short report most of the time goes into making modules: those that run at once at first
# have none in common.
EARLY = ("stiffness", "folded", "links", "damping")


def units(_: object, quick: bool, *__: object) -> list[Unit]:
    """A unit for each group; the cases of the page have no part in them."""
    function = f"{__name__}:measure"
    names = (*EARLY, *(group for group in ALL if group not in EARLY)) if quick else ALL
    return [
        Unit(
            "extremes", f"extremes-{name}", function, {"group": name, "quick": quick}, False, LIMIT
        )
        for name in names
    ]


def measure(group: str, quick: bool = False) -> list[Measurement]:
    """All rows of a group."""
    if group == INVALID:
        return invalid()
    found = (case for case in GROUPS[group]() if case.quick or not quick)
    return [made for case in found for made in judge(case, group, quick)]
