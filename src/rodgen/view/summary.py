"""What came out of a run, in plain words."""

from __future__ import annotations

import numpy as np

from rodgen.integrate import Solution

SHOWN = 10  # events


def summary(solution: Solution) -> str:
    """Some lines of text: the scene, the run, the motion, and how well energy balances."""
    lines = [_scene(solution), _run(solution)]
    if solution.events:
        lines.append(_events(solution))
    if len(solution.t) > 1:
        lines += [*_motion(solution), *_energy(solution)]
    return "\n".join(lines) + "\n"


def _scene(solution: Solution) -> str:
    scene = solution.scene
    links = f"{scene.rod.links} link{'s' * (scene.rod.links > 1)}"
    terms = ", ".join(term.replace("_", " ") for term in scene.structure.terms) or "no loads"
    return (
        f"{scene.name}: {scene.rod.boundary} rod of {links}, "
        f"{scene.rod.length:g} m, {scene.rod.mass:g} kg, "
        f"EI = {scene.rod.bending_stiffness:g} N m^2; {terms}."
    )


def _run(solution: Solution) -> str:
    stats, settings = solution.stats, solution.scene.integrate
    how = solution.message[:1].upper() + solution.message[1:] or "Finished"
    rejected = "" if stats.rejected is None else f" ({stats.rejected} rejected)"
    tolerances = f"rtol {settings.rtol:g}, atol {settings.atol:g}"
    accuracy = f"step {settings.step:g} s" if settings.fixed else tolerances
    return (
        f"{how}: {solution.t[-1] - solution.t[0]:g} s of motion by {settings.method} ({accuracy}) "
        f"in {stats.wall_seconds:.2f} s, {stats.steps} steps{rejected}, {stats.rhs} evaluations."
    )


def _events(solution: Solution) -> str:
    shown = [f"{event.name} at t = {event.t:.9g} s" for event in solution.events[:SHOWN]]
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
    total = solution.energy.total
    lines = [f"Energy went from {total[0]:.6g} J to {total[-1]:.6g} J."]
    if solution.work:
        parts = ", ".join(f"{t.replace('_', ' ')} {w[-1]:.6g} J" for t, w in solution.work.items())
        lines.append(f"Work done on the rod: {parts}.")
    error = solution.energy_error
    moved = [np.ptp(part) for part in solution.energy] + [np.ptp(w) for w in solution.work.values()]
    scale = float(max(moved))
    share = f", {error / scale:.1e} of the largest exchange" if scale > 0 else ""
    lines.append(f"Energy and work balance to {error:.2e} J{share}.")
    return lines
