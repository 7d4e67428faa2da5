"""rodgen show: what a scene's module will hold, and what it leaves out."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import groupby
from types import ModuleType
from typing import Any

import numpy as np
from rich.table import Table

from rodgen.analyse.sizes import SHOW, check_size
from rodgen.cli.console import finite_or_none, out, print_json, print_notes, warn, working
from rodgen.cli.options import AsJson
from rodgen.integrate import choose
from rodgen.integrate.catalogue import Piece
from rodgen.integrate.diagnosis import drift_warning
from rodgen.integrate.methods.choose import Choice, described, fastest_motion
from rodgen.integrate.stability import Dominant, limit
from rodgen.loading import build_fastest
from rodgen.model.methods import FIXED_STEP
from rodgen.progress import tell
from rodgen.scene import Scene
from rodgen.scene.contents import contents
from rodgen.scene.doubts import doubts
from rodgen.scene.mesh import mesh_notes
from rodgen.system import System

MOST_LISTED = 10  # break points
TABLED = re.compile(r"(_(?:knot|value))_\d+$")  # how the numbers of a table are called


def show(scene: Scene, as_json: AsJson = False) -> None:
    """Show what the module of SCENE will hold, and what is left out and why."""
    check_size(SHOW, System(scene))
    if as_json:
        print_json(_object(scene))
        return
    structure = scene.structure
    out.print(f"{scene.name}: module {structure.stem}, structure {structure.hash}")
    table = Table()
    for column in ("piece", "in the module", "because"):
        table.add_column(column)
    for row in contents(scene):
        table.add_row(row.piece, "yes" if row.present else "no", row.reason)
    out.print(table)
    print_notes((*mesh_notes(scene), *doubts(scene)))
    out.print(f"state y: {len(scene.initial_state())} values")
    out.print(f"parameters p: {', '.join(_in_tables(structure.parameters))}")
    breaks = _listed(scene.breaks())
    model, choice, fastest, limits = _integrated(scene)
    x, y = _centre(scene, model)
    x, y = (round(c, 12) + 0.0 for c in (x, y))  # without rounding, and without -0
    out.print(f"at the start: mass {scene.mass:.9g} kg, centre of gravity ({x:.9g}, {y:.9g}) m")
    out.print(f"integrated by {choice.method}: {choice.reason}")
    drifts = drift_warning(scene)
    if drifts:
        warn(drifts)
    if fastest is not None:
        out.print(f"fastest motion at the start: {described(fastest)}")
        shown = ", ".join(f"{name} {step:.3g} s" for name, step in limits.items())
        out.print(f"largest stable steps for it: {shown}")
    out.print(f"over {scene.integrate.span} s; break points: {breaks}")
    for event in scene.events:
        out.print(f"event {event.name!r}: {event.quantity} {event.direction}, {event.action}")


def _in_tables(names: Iterable[str]) -> Iterator[str]:
    """Names of parameters, those of the numbers of a table as one."""
    for stem, group in groupby(names, lambda name: TABLED.sub(r"\1", name)):
        found = [*group]
        yield found[0] if len(found) == 1 else f"{stem}_1 to {len(found)}"


def _centre(scene: Scene, model: ModuleType) -> tuple[float, float]:
    """The centre of gravity at the start [m]."""
    t, p = np.array(scene.integrate.span[0]), model.parameters(**scene.parameters)
    x, y = Piece(model, p, scene.initial_state(), t).values("centre_of_gravity")
    return float(x), float(y)


def _integrated(
    scene: Scene,
) -> tuple[ModuleType, Choice, Dominant | None, dict[str, float]]:
    """The module; by which method, and why; the fastest motion at the start, where its rate is
    finite, and the largest steps [s] of methods that have fixed ones."""
    with working("generating"):
        model = build_fastest(scene)
        choice = choose(scene, model)
        tell("looking for the fastest motion")
        with suppress(ArithmeticError):  # the run will say so
            fastest = fastest_motion(System.of(scene), model)
            limits = {name: limit(name, fastest.value, fastest.partner) for name in FIXED_STEP}
            return model, choice, fastest, limits
    return model, choice, None, {}


def _object(scene: Scene) -> dict[str, Any]:
    structure, (model, choice, fastest, limits) = scene.structure, _integrated(scene)
    events = [one.model_dump() for one in scene.events]
    return {
        "module": structure.stem,
        "structure": structure.hash,
        "contents": [
            {"piece": row.piece, "present": row.present, "reason": row.reason}
            for row in contents(scene)
        ],
        "notes": [*mesh_notes(scene), *doubts(scene)],
        "mass": scene.mass,
        "centre_of_gravity": [finite_or_none(c) for c in _centre(scene, model)],
        "states": len(scene.initial_state()),
        "parameters": dict(_numbers(scene)),
        "method": choice.method,
        "reason": choice.reason,
        "warning": drift_warning(scene) or None,
        "fastest_motion": None if fastest is None else described(fastest),
        "largest_stable_steps": {name: finite_or_none(step) for name, step in limits.items()},
        "span": list(scene.integrate.span),
        "breaks": scene.breaks(),
        "events": events,
    }


def _numbers(scene: Scene) -> Iterator[tuple[str, Any]]:
    """The parameters of its module, of tables how many rows these have."""
    rows = dict(scene.structure.tables)
    for name, value in scene.parameters.items():
        yield name, {"rows": rows[name]} if name in rows else value


def _listed(times: list[float]) -> str:
    """The first of them, and how many there are."""
    first = ", ".join(f"{t:g}" for t in times[:MOST_LISTED]) or "none"
    unit, rest = " s" * bool(times), f" ... ({len(times)} in all)"
    return first + unit + rest * (len(times) > MOST_LISTED)
