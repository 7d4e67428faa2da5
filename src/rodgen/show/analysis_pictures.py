"""Pictures of mode shapes, of an equilibrium, and of a scene at its start."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rodgen.analyse.eigenvalues import Complex
from rodgen.analyse.modes import Modes
from rodgen.analyse.statics import Equilibrium
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.arrays import Array, even_indices
from rodgen.display import Plottable
from rodgen.errors import EmptyPictureError
from rodgen.integrate.couples import point_at
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.weights import falls_of
from rodgen.model.term import COUPLE, FORCE, SPREAD, WEIGHT
from rodgen.model.terms import TERMS, load_places
from rodgen.scene import Scene
from rodgen.show.canvas import (
    FAINT,
    LINE,
    ROD,
    add_legend,
    add_remark,
    label_strip,
    make_axes,
    make_strip,
    set_limits,
    set_title,
)
from rodgen.show.marks import curved_arrow, describe_marks, draw_marks

PANELS = 6  # modes drawn
AMPLITUDE = 0.1  # of the length
PHASES = 8  # of a mode whose joints do not move in step
SMALL_BEND, SEEN_BEND = 0.05, 0.2  # of the length: displacements drawn larger, and up to where
ARROW = 0.14  # of the length
ASIDE = 0.06  # of the length, by which arrows of gravity stand beside a rod that hangs
WEIGHTS = 9  # arrows of what acts along the rod


def scene_at_start(scene: Scene) -> Figure:
    """Rod in its initial state with its bodies, supports and loads at the start of the span; its
    module is built where it has not been."""
    rod, y = SteadyRod.of(scene, scene.integrate.span[0]), scene.initial_state()
    joints = rod.model.joints(y, rod.system.p)
    figure, (axes,) = make_axes(6.0, 5.0)
    axes.plot(*joints.T, "-", color=ROD, linewidth=LINE)
    draw_marks(axes, scene, joints, ROD)
    drawn = draw_loads(axes, rod, joints, y, 1.0, np.ones(2))
    fixed = [(tie.x, tie.y) for tie in scene.anchors.support_points]
    axes.set(xlabel="x [m]", ylabel="y [m]")
    add_remark(axes, describe_marks(scene))
    set_title(figure, f"{scene.name} at the start")
    set_limits(axes, np.concatenate((joints, *drawn, np.reshape(fixed, (-1, 2)))))
    if keys := load_legend(rod, y):
        add_legend(figure, keys)
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
    figure, panels = make_strip(7.0, count, columns, height / width)
    for at, axes in enumerate(panels):
        _draw_mode(axes, modes.joints, moved[at])
        draw_marks(axes, scene, modes.joints + moved[at].real, ROD)
        axes.set_title(_mode_label(modes, at), fontsize=rcParams["xtick.labelsize"])
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    every = len(modes.frequencies)
    which = "modes" if count == every else f"the first {count} of {every} modes"
    set_title(figure, f"{scene.name}: {which} about the state: {modes.state}")
    pale = "the other end of the motion" if np.isrealobj(moved) else "other phases of the motion"
    words = f"dashed: the state; pale: {pale}; {describe_marks(scene)}; motions of arbitrary size"
    label_strip(figure, "x [m]", "y [m]", words)
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


def _mode_label(modes: Modes, at: int) -> str:
    frequency, growth = modes.frequencies[at], modes.growth[at]
    text = f"{at + 1}: {frequency:.5g} Hz" if frequency else f"{at + 1}: no oscillation"
    return f"{text}\ngrows" if growth > 0 else text


def equilibrium_shape(rest: Equilibrium) -> Figure:
    """Deflected rod beside the one without load, with its loads; small displacements enlarged. A
    rod that turns freely lies in more than one direction then: that of its start is shown."""
    rod = SteadyRod.of(rest.scene, rest.t)
    unloaded = rod.model.joints(
        rod.state_at_rest(rod.start_unknowns(rod.unloaded_angles)), rod.system.p
    )
    joints, stretch = rest.joints, _choose_stretch(unloaded, rest.joints)
    figure, (axes,) = make_axes(6.0, 5.0)
    shape = "straight" if rod.is_straight else "without load"
    label = shape if rod.is_clamped else f"{shape}, as at the start"
    axes.plot(*unloaded.T, "--", color=FAINT, label=label, linewidth=LINE)
    dots = "o-" if len(joints) <= 60 else "-"
    state = ", unstable" if rest.stable is False else ""
    axes.plot(*joints.T, dots, color=ROD, markersize=2.5, label=f"equilibrium{state}")
    draw_marks(axes, rod.scene, joints, ROD)
    side = -1.0 if unloaded[-1, 0] > joints[-1, 0] else 1.0  # where the dashed line is not
    drawn = draw_loads(axes, rod, joints, rest.y, side, stretch)
    axes.set(xlabel="x [m]", ylabel="y [m]")
    add_remark(axes, describe_marks(rod.scene))
    if (times := stretch.max()) > 1:
        large = int(stretch.argmax())
        add_remark(axes, f"{'xy'[large]} drawn {times:g} times as large as {'yx'[large]}")
    set_limits(axes, np.concatenate((unloaded, joints, *drawn)), stretch)
    set_title(figure, f"{rod.scene.name}: static equilibrium")
    handles = [*axes.get_legend_handles_labels()[0], *load_legend(rod, rest.y)]
    add_legend(figure, handles)
    return figure


def _choose_stretch(unloaded: Array, joints: Array) -> Array:
    """Choose how many times as large as along it a rod is drawn across (2,), where it bends too
    little to be seen, and lies along an axis of the picture."""
    along = np.abs(unloaded[-1] - unloaded[0])
    bent = float(np.linalg.norm(joints - unloaded, axis=1).max() / along.max())
    stretch = np.ones(2)
    if along.min() < 1e-9 * along.max() and 1e-12 < bent < SMALL_BEND:
        stretch[along.argmin()] = 10.0 ** np.floor(np.log10(SEEN_BEND / bent))
    return stretch


def _load_magnitudes(rod: SteadyRod, y: Array) -> dict[str, float]:
    """Return the magnitudes of forces, couples and weights that are not zero, by their terms: the
    largest where they differ from link to link; those in a state y (states,) where they depend on
    it."""
    found, p = {}, rod.system.p
    given = rod.system.parameters
    if rod.has_feedback:
        given |= rod.model.signals(rod.t, y, p)
    for name in rod.system.load_terms:
        row = rod.system.structure.load_rows[name]
        if row.kind in (FORCE, COUPLE, SPREAD, WEIGHT):
            parts = [max(np.atleast_1d(given[e.name]), key=abs) for e in row.size_parameters]
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


def draw_loads(
    axes: Axes, rod: SteadyRod, joints: Array, y: Array, side: float, stretch: Array
) -> list[Array]:
    """Draw arrows of the loads in a state y (states,); returns points of each (k, 2). side: +1 or
    -1, to the right or the left, where gravity stands beside a rod that hangs; stretch (2,): times
    as large as the other that each coordinate is drawn."""
    size = ARROW * rod.scene.rod.length
    forces = rod.model.forces(rod.t, y, rod.system.p)
    here = MotionSlice(rod.model, rod.system.p, y, np.asarray(rod.t))
    falls = falls_of(here, rod.system.structure.terms)
    ends, curves = [], []
    for name, amount in _load_magnitudes(rod, y).items():
        term = TERMS[name]
        if term.kind == FORCE:
            shares = np.hypot(*forces[name].T)
            at, point = int(shares.argmax()), shares @ joints / shares.sum()
            pull = _shorten(size * forces[name].sum(axis=0) / shares.sum(), stretch)
            # What pushes ends at the rod, lest it hide it.
            pushes = pull @ (joints[at] - joints[at - 1 if at else 1]) < 0
            start = point - pull if pushes else point
            ends.append((np.array([start, start + pull]), term))
        elif term.kind == COUPLE:
            point = point_at(load_places(rod.system.structure.terms)[name], joints)
            curves.append(point + curved_arrow(0.5 * size, np.sign(amount)) / stretch)
            axes.plot(*curves[-1].T, color=term.colours[0])
        elif term.kind == SPREAD:
            largest = np.hypot(*forces[name].T).max()
            for at in even_indices(0, len(joints) - 1, WEIGHTS):
                pull = _shorten(0.5 * size * forces[name][at] / largest, stretch)
                ends.append((np.array([joints[at] - pull, joints[at]]), term))
        else:
            fall = falls[name] / np.linalg.norm(falls[name])
            down = _shorten(0.5 * size * fall, stretch)
            width, height = np.ptp(joints, axis=0)
            aside = side * ASIDE * rod.scene.rod.length * (height > 2 * width) / stretch[0]
            for start in joints[even_indices(0, len(joints) - 1, WEIGHTS)] + [aside, 0.0]:
                ends.append((np.array([start, start + down]), term))
    for (start, end), term in ends:
        style = {"arrowstyle": "-|>", "color": term.colours[0], "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", end, start, arrowprops=style)
    return [pair for pair, _ in ends] + curves


def _shorten(vector: Array, stretch: Array) -> Array:
    """Give a vector (2,) the length in a stretched picture that it has in another."""
    longer = float(np.linalg.norm(vector * stretch))
    return vector * (float(np.linalg.norm(vector)) / longer if longer else 1.0)


PICTURES_OF: dict[type[Plottable] | type[Scene], Mapping[str, Callable[[Any], Figure]]] = {
    Scene: {"start": scene_at_start},
    Modes: {"shapes": mode_shapes},
    Equilibrium: {"shape": equilibrium_shape},
}
