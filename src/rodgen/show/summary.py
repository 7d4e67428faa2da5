"""Summary of a run in plain words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rodgen.integrate import Solution
from rodgen.integrate.dense_output import visible_error
from rodgen.integrate.trajectory import ErrorGrowth
from rodgen.model.terms import BASE_ROWS, describe
from rodgen.result import DOUBT, ResultTable
from rodgen.scene import Scene
from rodgen.scene.law import Along
from rodgen.scene.model_contents import describe_along, describe_loads

MOST_EVENTS = 10  # events
ROUNDING = 1e-9  # of the largest energy: what changes by less has not changed


def summary(solution: Solution, without_c: str = "") -> str:
    """Return some lines of text: the scene, the run, the motion, and how well energy balances.

    without_c: why the C module could not be used, if that is so.
    """
    lines = [_scene(solution), _run(solution)]
    if without_c:
        lines.append(f"The C module, which is faster, cannot be built: {without_c}.")
    if solution.events:
        lines.append(_events(solution))
    if len(solution.t) > 1:
        lines += [*_motion(solution), *_energy(solution)]
    if solution.errors is not None:
        lines.append(_errors(solution, solution.errors))
    lines += (f"Doubt: {note}." for note in solution.notes if note.kind == DOUBT)
    return "\n".join(lines) + "\n"


def scene_table(scene: Scene) -> ResultTable:
    """Return a table of the rod, what acts on it, and how it is integrated."""
    rod, settings = scene.rod, scene.integrate
    rows = {
        "rod": f"{rod.boundary}, {rod.links} links, {rod.inertia} inertia",
        "length": f"{rod.length:g} m",
        "mass": f"{scene.mass:g} kg",
        "EI": f"{describe_along(rod.bending_stiffness)} N m^2",
        "curvature at rest": _rest_curvature(rod.rest_curvature),
        "bodies": ", ".join(body.name for body in scene.bodies),
        "loads": ", ".join(describe_loads(scene)),
        "base": ", ".join(_base(scene)),
        "span": f"{settings.span[0]:g} to {settings.span[1]:g} s, by {settings.method}",
        "events": ", ".join(event.name for event in scene.events),
    }
    return ResultTable.of_values({name: text for name, text in rows.items() if text})


def _base(scene: Scene) -> Iterator[str]:
    """Yield what moves the start of the rod, by key."""
    for one in BASE_ROWS if scene.base is not None else ():
        if (value := getattr(scene.base, one.key)) is not None:
            yield f"{one.key} {describe_along(value)} {one.unit}"


def _scene(solution: Solution) -> str:
    scene = solution.scene
    links = f"{scene.rod.links} link{'s' * (scene.rod.links > 1)}"
    masses = zip(scene.bodies, scene.distribution.body_masses, strict=True)
    named = ", ".join(f"{body.name} {mass:g} kg" for body, mass in masses)
    bodies = f" ({named})" if named else ""
    law = f", springs of the moment {describe_along(scene.rod.spring)}" if scene.spring_law else ""
    if curvature := _rest_curvature(scene.rod.rest_curvature):
        law += f", {curvature} at rest"
    terms = ", ".join(describe_loads(scene)) or "no loads"
    return (
        f"{scene.name}: {scene.rod.boundary} rod of {links}, "
        f"{scene.rod.length:g} m, {scene.mass:g} kg{bodies}, "
        f"EI = {describe_along(scene.rod.bending_stiffness)} N m^2{law}; {terms}."
    )


def _rest_curvature(value: Along | None) -> str:
    return "" if value is None else f"curvature {describe_along(value)} 1/m"


def _run(solution: Solution) -> str:
    stats, settings = solution.stats, solution.scene.integrate
    how = solution.message[:1].upper() + solution.message[1:] or "Finished"
    rejected = "" if stats.rejected is None else f" ({stats.rejected} rejected)"
    tolerances = f"rtol {settings.rtol:g}, atol {settings.atol:g}"
    accuracy = f"step {settings.step:g} s" if settings.has_fixed_step else tolerances
    target = f", target {stats.target}," if stats.target else ""
    seconds = np.diff(solution.t).sum()  # there may be no samples, where t_eval begins late
    return (
        f"{how}: {seconds:g} s of motion by {settings.method} ({accuracy})"
        f"{target} in {stats.wall_seconds:.2f} s, {stats.nsteps} steps{rejected}, "
        f"{stats.nfev} evaluations."
    )


def _events(solution: Solution) -> str:
    shown = [f"{event.name} at t = {event.t:.9g} s" for event in solution.events[:MOST_EVENTS]]
    rest = len(solution.events) - len(shown)
    return f"Events: {'; '.join(shown)}{f'; and {rest} more' * bool(rest)}."


def _motion(solution: Solution) -> list[str]:
    start, end = solution.centre_of_gravity[[0, -1]]
    tip_start, tip_end = solution.tip[[0, -1]]
    lines = [
        f"The centre of gravity went from {_point(start)} to {_point(end)}, "
        f"the tail from {_point(tip_start)} to {_point(tip_end)}."
    ]
    if solution.scene.rod.links > 1:
        bend = solution.phi.max(axis=1) - solution.phi.min(axis=1)
        at = int(np.argmax(bend))
        lines.append(
            f"The links differed by at most {np.degrees(bend[at]):.3g} degrees in angle "
            f"(at t = {solution.t[at]:g} s), by {np.degrees(bend[-1]):.3g} at the end."
        )
    return lines


def _point(p: np.ndarray) -> str:
    x, y = (0.0 if abs(c) < 1e-12 * max(1.0, np.abs(p).max()) else c for c in p)
    return f"({x:.5g}, {y:.5g}) m"


def _energy(solution: Solution) -> list[str]:
    total, error = solution.energy.total, solution.energy_error
    largest = float(max(np.abs(part).max() for part in solution.energy))
    rounding = ROUNDING * largest
    lines = [_energy_change(total, rounding)]
    if solution.work:
        parts = ", ".join(f"{describe(t)} {w[-1]:.6g} J" for t, w in solution.work.items())
        lines.append(f"Work done on the rod: {parts}.")
    moved = [np.ptp(part) for part in solution.energy] + [np.ptp(w) for w in solution.work.values()]
    scale, what = float(max(moved)), "exchange"
    if scale < rounding:
        scale, what = largest, "energy, as next to none was exchanged"
    share = f", {error / scale:.1e} of the largest {what}" if scale > 0 else ""
    lines.append(f"Energy and work balance to {error:.2e} J{share}.")
    return lines


def _errors(solution: Solution, errors: ErrorGrowth) -> str:
    """Describe how much small errors grow, and from when on those at the tolerance may be seen."""
    if np.isnan(errors.factor):
        return "How fast errors grow is not known: a motion beside that of the run failed."
    times = f"{errors.factor:.1e}" if errors.factor < np.inf else "more than 1e308"
    words = f"A small error in the angles grows to at most {times} times its size"
    tolerance = solution.scene.integrate.rtol
    rtol = f"one at the tolerance (rtol {tolerance:g})"
    if errors.visible < np.inf:
        return (
            f"{words}, tenfold in {errors.tenfold:.2g} s on average: {rtol} may be visible "
            f"({visible_error(tolerance):g} rad) from t = {errors.visible:.3g} s on. Angles after "
            "that are not to be trusted; energies and means may be."
        )
    return (
        f"{words}." if solution.scene.integrate.has_fixed_step else f"{words}: {rtol} stays small."
    )


def _energy_change(total: np.ndarray, rounding: float) -> str:
    """Describe the change of the energy [J], (T,); rounding: a smaller change is none [J]."""
    start, end = total[[0, -1]]
    change = np.ptp(total)
    if change == 0 or change < rounding:
        return f"Energy stayed at {start:.6g} J, to within {change:.1e} J."
    digits = next((d for d in (6, 9, 12, 17) if f"{start:.{d}g}" != f"{end:.{d}g}"), 6)
    return f"Energy went from {start:.{digits}g} J to {end:.{digits}g} J."
