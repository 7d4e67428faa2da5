"""rodgen show: what a scene's module will hold, and what it leaves out."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from rich.table import Table

from rodgen.cli.console import finite_or_none, out, print_json, print_notes, warn, working
from rodgen.cli.options import AsJson
from rodgen.integrate import choose
from rodgen.integrate.diagnosis import drift_warning
from rodgen.integrate.methods.choose import Choice, described, fastest_motion
from rodgen.integrate.stability import Dominant, limit
from rodgen.loading import build_fastest
from rodgen.model.methods import FIXED_STEP
from rodgen.scene import Scene
from rodgen.scene.contents import contents
from rodgen.scene.doubts import doubts
from rodgen.scene.mesh import mesh_notes

MOST_LISTED = 10  # break points


def show(scene: Scene, as_json: AsJson = False) -> None:
    """Show what the module of SCENE will hold, and what is left out and why."""
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
    out.print(f"parameters p: {', '.join(structure.parameters)}")
    breaks = _listed(scene.breaks())
    choice, fastest, limits = _integrated(scene)
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


def _integrated(scene: Scene) -> tuple[Choice, Dominant | None, dict[str, float]]:
    """By which method, and why; the fastest motion at the start, where its rate is finite, and the
    largest steps [s] of methods that have fixed ones."""
    with working("generating"):
        model = build_fastest(scene)
        choice = choose(scene, model)
    with suppress(ArithmeticError):  # the run will say so
        fastest = fastest_motion(scene, model)
        limits = {name: limit(name, fastest.value, fastest.partner) for name in FIXED_STEP}
        return choice, fastest, limits
    return choice, None, {}


def _object(scene: Scene) -> dict[str, Any]:
    structure, (choice, fastest, limits) = scene.structure, _integrated(scene)
    events = [one.model_dump() for one in scene.events]
    return {
        "module": structure.stem,
        "structure": structure.hash,
        "contents": [
            {"piece": row.piece, "present": row.present, "reason": row.reason}
            for row in contents(scene)
        ],
        "notes": [*mesh_notes(scene), *doubts(scene)],
        "states": len(scene.initial_state()),
        "parameters": scene.parameters,
        "method": choice.method,
        "reason": choice.reason,
        "warning": drift_warning(scene) or None,
        "fastest_motion": None if fastest is None else described(fastest),
        "largest_stable_steps": {name: finite_or_none(step) for name, step in limits.items()},
        "span": list(scene.integrate.span),
        "breaks": scene.breaks(),
        "events": events,
    }


def _listed(times: list[float]) -> str:
    """The first of them, and how many there are."""
    first = ", ".join(f"{t:g}" for t in times[:MOST_LISTED]) or "none"
    unit, rest = " s" * bool(times), f" ... ({len(times)} in all)"
    return first + unit + rest * (len(times) > MOST_LISTED)
