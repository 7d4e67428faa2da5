"""Pictures of an analysis, made for print (mode shapes, an equilibrium, a critical force), and of a
scene: the rod at the start, its supports and its loads.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rodgen.analyse.critical import Critical
from rodgen.analyse.eigenvalues import Complex
from rodgen.analyse.load_family import LoadFamily, load_family
from rodgen.analyse.modes import Modes
from rodgen.analyse.scaled_load import GROUPS, label_of
from rodgen.analyse.statics import Equilibrium
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.arrays import Array, even_indices
from rodgen.display import Plottable
from rodgen.errors import AnalysisError, EmptyPictureError
from rodgen.model.term import FORCE, SPREAD, WEIGHT, typeset
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.show.canvas import (
    CURVE,
    FAINT,
    LINE,
    ROD,
    SPECIAL,
    describe_marks,
    draw_marks,
    make_axes,
    make_figure,
    set_height,
    set_limits,
)

PANELS = 6  # modes drawn
AMPLITUDE = 0.1  # of the length
PHASES = 8  # of a mode whose joints do not move in step
SMALL, SEEN = 0.05, 0.2  # of the length: displacements drawn larger, and up to where
ARROW = 0.14  # of the length
ASIDE = 0.06  # of the length, by which arrows of gravity stand beside a rod that hangs
WEIGHTS = 9  # arrows of what acts along the rod
FORCES = 400  # in the curves of a critical force
BEYOND = 0.3  # of the critical force, that the curves go on
NEAR = 0.1  # of the critical force, up to where growth fills the picture


def scene_at_start(scene: Scene) -> Figure:
    """Rod in its initial state with its bodies, supports and loads at the start of the span; its
    module is built where it has not been."""
    rod, y = SteadyRod.of(scene, scene.integrate.span[0]), scene.initial_state()
    joints = rod.model.joints(y, rod.system.p)
    figure, (axes,) = make_axes(6.0, 5.0)
    axes.plot(*joints.T, "-", color=ROD, linewidth=LINE)
    draw_marks(axes, scene, joints, ROD)
    drawn = draw_loads(axes, rod, joints, y, 1.0)
    fixed = [(tie.x, tie.y) for tie in scene.anchors.support_points]
    axes.set(xlabel=f"x [m]\n{describe_marks(scene)}", ylabel="y [m]")
    axes.set_title(f"{scene.name} at the start")
    set_limits(axes, np.concatenate((joints, *drawn, np.reshape(fixed, (-1, 2)))))
    if keys := load_legend(rod, y):
        figure.legend(handles=keys, loc="outside lower center", ncols=2, fontsize="small")
    return figure


def mode_shapes(modes: Modes) -> Figure:
    """Shapes of up to six modes, at both ends of their motion, on the steady state."""
    scene, count = modes.scene, min(PANELS, len(modes.frequencies))
    if not count:
        raise EmptyPictureError("modes", modes, "at least one")
    size = AMPLITUDE * np.linalg.norm(np.diff(modes.joints, axis=0), axis=1).sum()
    moved = size * modes.displacements[:count]
    low = (modes.joints - np.abs(moved)).min(axis=(0, 1)) - size / 3
    high = (modes.joints + np.abs(moved)).max(axis=(0, 1)) + size / 3
    width, height = high - low
    columns = min(count, 2 + (height > 0.7 * width) + 3 * (height > 2 * width))
    rows = -(-count // columns)
    across = 6.3 / columns - 0.3
    figure = make_figure(7.0, rows * (min(across * height / width, 5.0) + 0.55) + 0.8)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for at, axes in enumerate(panels.flat):
        if at < count:
            _draw_mode(axes, modes.joints, moved[at])
            draw_marks(axes, scene, modes.joints + moved[at].real, ROD)
            axes.set_title(_mode_label(modes, at), fontsize="small")
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
            axes.tick_params(labelsize="x-small")
        else:
            axes.set_visible(False)
    every = len(modes.frequencies)
    which = "modes" if count == every else f"the first {count} of {every} modes"
    figure.suptitle(f"{scene.name}: {which} about the state: {modes.state}", fontsize="medium")
    pale = "the other end of the motion" if np.isrealobj(moved) else "other phases of the motion"
    words = f"dashed: the state; pale: {pale}; {describe_marks(scene)}"
    figure.supxlabel(f"x [m]\n{words}", fontsize="small")
    figure.supylabel("y [m], motions of arbitrary size", fontsize="small")
    return figure


def _draw_mode(axes: Axes, joints: Array, moved: Complex | Array) -> None:
    """Draw a mode: the first phase in full colour, the others behind it."""
    phases = 2 if np.isrealobj(moved) else PHASES
    axes.plot(*joints.T, "--", color=FAINT, linewidth=0.8)
    for at in range(1, phases):
        shape = joints + (moved * np.exp(2j * np.pi * at / phases)).real
        axes.plot(*shape.T, "-", color=ROD, alpha=0.3, linewidth=0.8)
    shape = joints + moved.real
    axes.plot(*shape.T, "-", color=ROD, linewidth=LINE)
    axes.grid(alpha=0.3)


def _mode_label(modes: Modes, at: int) -> str:
    frequency, growth = modes.frequencies[at], modes.growth[at]
    text = f"{at + 1}: {frequency:.5g} Hz" if frequency else f"{at + 1}: no oscillation"
    return f"{text}\ngrows" if growth > 0 else text


def equilibrium_shape(rest: Equilibrium) -> Figure:
    """Deflected rod beside the straight one, with its loads; small displacements enlarged. A rod
    that turns freely is straight in more than one direction: that of its start is shown."""
    rod = SteadyRod.of(rest.scene, rest.t)
    length, name = rod.scene.rod.length, rod.scene.name
    straight = rod.model.joints(
        rod.state_at_rest(rod.start_unknowns(rod.straight_angles)), rod.system.p
    )
    moved = rest.joints - straight
    largest = float(np.linalg.norm(moved, axis=1).max()) / length
    times = 1.0
    if 1e-12 < largest < SMALL:
        times = float(10.0 ** np.floor(np.log10(SEEN / largest)))
    joints = straight + times * moved
    figure, (axes,) = make_axes(6.0, 5.5)
    straight_as = "straight" if rod.is_clamped else "straight, as at the start"
    axes.plot(*straight.T, "--", color=FAINT, label=straight_as, linewidth=LINE)
    dots = "o-" if len(joints) <= 60 else "-"
    scale = f" (displacements x {times:g})" if times > 1 else ""
    axes.plot(*joints.T, dots, color=ROD, markersize=2.5, label=f"equilibrium{scale}")
    draw_marks(axes, rod.scene, joints, ROD)
    side = -1.0 if straight[-1, 0] > joints[-1, 0] else 1.0  # where the straight rod is not
    drawn = draw_loads(axes, rod, joints, rest.y, side)
    points = np.concatenate((straight, joints, *drawn))
    low, high = points.min(axis=0), points.max(axis=0)
    half = np.maximum((high - low) / 2, 0.2 * length) + 0.06 * length
    middle = (low + high) / 2
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    axes.set_aspect("equal")
    set_height(figure, min(5.2 * half[1] / half[0] + 1.5, 6.5))
    state = ", unstable" if rest.stable is False else ""
    unit = "m" if times == 1 else f"m, but displacements x {times:g}"
    axes.set(xlabel=f"x [{unit}]\n{describe_marks(rod.scene)}", ylabel=f"y [{unit}]")
    axes.set_title(f"{name}: static equilibrium{state}")
    handles = [*axes.get_legend_handles_labels()[0], *load_legend(rod, rest.y)]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize="small")
    return figure


def _load_magnitudes(rod: SteadyRod, y: Array) -> dict[str, float]:
    """Return the magnitudes of forces and weights that are not zero, by their terms: the largest
    where they differ from link to link; those in a state y (states,) where they depend on it."""
    found, p = {}, rod.system.p
    given = rod.system.parameters
    if rod.has_feedback:
        given |= rod.model.signals(rod.t, y, p)
    for name in rod.system.load_terms:
        if TERMS[name].kind in (FORCE, SPREAD, WEIGHT):
            parts = [
                max(np.atleast_1d(given[e.name]), key=abs) for e in TERMS[name].size_parameters
            ]
            found[name] = float(parts[0] if len(parts) == 1 else np.hypot(*parts))
    return {name: size for name, size in found.items() if size}


def load_legend(rod: SteadyRod, y: Array) -> list[Line2D]:
    """Return entries of a legend for the loads in a state y (states,)."""
    rows = [(TERMS[name], size) for name, size in _load_magnitudes(rod, y).items()]
    labels = [
        f"{term.label} {size:.4g} {term.size_parameters[0].display_unit}" for term, size in rows
    ]
    return [
        Line2D([], [], color=term.colours[0], marker=">", markersize=4, label=label)
        for (term, _), label in zip(rows, labels, strict=True)
    ]


def draw_loads(axes: Axes, rod: SteadyRod, joints: Array, y: Array, side: float) -> list[Array]:
    """Draw arrows of the loads in a state y (states,); returns their ends, pairs of points (2, 2).
    side: +1 or -1, to the right or the left, where gravity stands beside a rod that hangs."""
    size = ARROW * rod.scene.rod.length
    forces = rod.model.forces(rod.t, y, rod.system.p)
    ends = []
    for name, amount in _load_magnitudes(rod, y).items():
        term = TERMS[name]
        if term.kind == FORCE:
            shares = np.hypot(*forces[name].T)
            at, point = int(shares.argmax()), shares @ joints / shares.sum()
            pull = size * forces[name].sum(axis=0) / shares.sum()
            # What pushes ends at the rod, lest it hide it.
            pushes = pull @ (joints[at] - joints[at - 1 if at else 1]) < 0
            start = point - pull if pushes else point
            ends.append((np.array([start, start + pull]), term))
        elif term.kind == SPREAD:
            largest = np.hypot(*forces[name].T).max()
            for at in even_indices(0, len(joints) - 1, WEIGHTS):
                pull = 0.5 * size * forces[name][at] / largest
                ends.append((np.array([joints[at] - pull, joints[at]]), term))
        else:
            down = np.array([0.0, -0.5 * size * np.sign(amount)])
            width, height = np.ptp(joints, axis=0)
            aside = side * ASIDE * rod.scene.rod.length * (height > 2 * width)
            for start in joints[even_indices(0, len(joints) - 1, WEIGHTS)] + [aside, 0.0]:
                ends.append((np.array([start, start + down]), term))
    for (start, end), term in ends:
        style = {"arrowstyle": "-|>", "color": term.colours[0], "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", end, start, arrowprops=style)
    return [pair for pair, _ in ends]


def stability_curves(found: Critical) -> Figure:
    """Frequencies of the lowest modes, and growth rates below, over the load that is scaled."""
    scene = found.scene
    speed = found.speed if scene.boundary_condition.translates else None
    family = load_family(scene, found.t, speed, load=found.load)
    start = min(0.0, found.searched[0])
    beyond = found.value + BEYOND * max(abs(found.value), family.unit * (not found.value))
    forces, s = _eigenvalue_curves(family, start, beyond, found)
    # Without damping one eigenvalue of each pair is here, with damping both: the upper half.
    kept = slice(s.shape[1] // 2 if family.is_damped else 0, None)
    frequency = np.sort(np.where(np.isnan(s), -np.inf, s.imag), axis=1)[:, kept] / (2 * np.pi)
    growth = np.sort(s.real, axis=1)
    shown = np.isfinite(frequency) & (frequency >= 0)
    frequency = np.where(shown, frequency, np.nan)
    # Overdamped motions apart.
    first = int(np.argmax(frequency[0] > family.zero_tolerance / (2 * np.pi)))
    last = min(first + max(*found.modes, 2), frequency.shape[1] - 1)
    figure, (upper, lower) = make_axes(6.4, 5.6, 2, sharex=True, height_ratios=(3, 2))
    upper.plot(forces, frequency[:, : last + 1], ".", markersize=1.5, color=CURVE)
    upper.set_ylim(0, 1.08 * max(float(np.nanmax(frequency[:, : last + 1])), 1e-300))
    upper.plot(found.value, found.frequency, "o", color=SPECIAL, clip_on=False, markersize=5)
    lower.plot(forces, growth, ".", markersize=1.5, color=CURVE)
    lower.set_ylim(_growth_limits(forces, growth, found.value, family))
    lower.plot(found.value, 0.0, "o", color=SPECIAL, markersize=5)
    for axes in (upper, lower):
        axes.axvline(found.value, color=SPECIAL, linestyle="--", linewidth=0.8)
    at = f" at {found.frequency:.5g} Hz" if found.frequency else ""
    upper.set(
        ylabel="frequency [Hz]",
        title=f"{scene.name}: {found.kind} from {found.value:.6g} {found.unit}{at}",
    )
    label = label_of(found.load) + f" [{typeset(found.unit)}]" * (found.load not in GROUPS)
    lower.set(xlabel=label, ylabel="growth [1/s]", xlim=(forces[0], forces[-1]))
    return figure


def _growth_limits(
    forces: Array, growth: Array, force: float, family: LoadFamily
) -> tuple[float, float]:
    """Return limits for the growth [1/s]: up to its largest a little beyond the critical force, not
    to what comes much later, and down to the least damped motion wherever it dies away fastest."""
    most = np.nan_to_num(growth, nan=-np.inf).max(axis=1)
    near = forces <= force + NEAR * abs(force)
    high = max(float(most[near].max()), 1e-6 * family.lowest_frequency)
    low = float(most.min()) if family.is_damped else -high  # flutter dies away as it grows
    return 1.1 * min(low, -high / 4), 1.1 * max(high, -low / 4)


def _eigenvalue_curves(
    family: LoadFamily, low: float, high: float, found: Critical
) -> tuple[Array, Complex]:
    """Return forces and eigenvalues at them, those left out of the search as nan; only up to the
    critical force where there is no steady state beyond."""
    for end in (high, found.value * (1 - 1e-6)):
        forces = np.linspace(low, end, FORCES)
        try:
            return forces, family.motions(forces, elastic=found.elastic).s
        except AnalysisError as error:
            last = error
    raise last


PICTURES_OF: dict[type[Plottable] | type[Scene], Mapping[str, Callable[[Any], Figure]]] = {
    Scene: {"start": scene_at_start},
    Modes: {"shapes": mode_shapes},
    Equilibrium: {"shape": equilibrium_shape},
    Critical: {"curves": stability_curves},
}
