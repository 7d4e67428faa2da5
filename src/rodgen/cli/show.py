"""rodgen show: what a scene's module will hold, and what it leaves out."""

from __future__ import annotations

from contextlib import suppress

from rich.table import Table

from rodgen.cli.console import out, print_notes, warn, working
from rodgen.cli.options import SceneFile
from rodgen.integrate import choose
from rodgen.integrate.diagnosis import drift_warning
from rodgen.integrate.methods.choose import described, fastest_motion
from rodgen.integrate.stability import limit
from rodgen.loading import build_fastest
from rodgen.model.methods import FIXED_STEP
from rodgen.scene import Scene
from rodgen.scene.contents import contents
from rodgen.scene.mesh import mesh_notes

MOST_LISTED = 10  # break points


def show(
    scene_file: SceneFile,
) -> None:
    """Show what will be in the module of SCENE, and what is left out and why."""
    scene = Scene.from_toml(scene_file)
    structure = scene.structure
    out.print(f"{scene.name}: module {structure.stem}, structure {structure.hash}")
    table = Table()
    for column in ("piece", "in the module", "because"):
        table.add_column(column)
    for row in contents(scene):
        table.add_row(row.piece, "yes" if row.present else "no", row.reason)
    out.print(table)
    print_notes(mesh_notes(scene))
    out.print(f"state y: {len(scene.initial_state())} values")
    out.print(f"parameters p: {', '.join(structure.parameters)}")
    settings = scene.integrate
    breaks = _listed(scene.breaks())
    with working("generating"):
        model = build_fastest(scene)
        choice = choose(scene, model)
    out.print(f"integrated by {choice.method}: {choice.reason}")
    drifts = drift_warning(scene)
    if drifts:
        warn(drifts)
    with suppress(ArithmeticError):  # rates that are not finite: the run will say so
        fastest = fastest_motion(scene, model)
        out.print(f"fastest motion at the start: {described(fastest)}")
        limits = {name: limit(name, fastest.value, fastest.partner) for name in FIXED_STEP}
        shown = ", ".join(f"{name} {step:.3g} s" for name, step in limits.items())
        out.print(f"largest stable steps for it: {shown}")
    out.print(f"over {settings.span} s; break points: {breaks}")
    for event in scene.events:
        out.print(f"event {event.name!r}: {event.quantity} {event.direction}, {event.action}")


def _listed(times: list[float]) -> str:
    """The first of them, and how many there are."""
    first = ", ".join(f"{t:g}" for t in times[:MOST_LISTED]) or "none"
    return first if len(times) <= MOST_LISTED else f"{first} ... ({len(times)} in all)"
