"""Pictures of a cycle, made for print: a film strip of its shapes, and its multipliers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rodgen.analyse.cycles.cycle_result import Cycle
from rodgen.analyse.cycles.floquet import Floquet
from rodgen.model.terms import axis_label
from rodgen.scene import Scene
from rodgen.show.canvas import (
    CURVE,
    FAINT,
    INK,
    LINE,
    ROD,
    SPECIAL,
    add_legend,
    add_remark,
    label_ordinate,
    label_strip,
    make_axes,
    make_strip,
    set_title,
)
from rodgen.show.marks import (
    describe_marks,
    draw_by_stability,
    draw_marks,
    mark_of,
    stability_legend,
)

if TYPE_CHECKING:
    import xarray

FRAMES = 8  # of a film strip
TRAIL_SHAPES = 4  # earlier shapes behind each
STRIP_MARGIN = 0.06  # of the largest side, around the shapes
INSIDE = 1.25  # what is drawn of the plane, at least


def film_strip(cycle: Cycle) -> Figure:
    """The rod at eight times of a period, with the shapes just before each behind it."""
    scene, joints = cycle.scene, cycle.motion.joints
    is_free = scene.boundary_condition.translates and not scene.anchors.terms
    if is_free:
        joints = joints - cycle.motion.centre_of_gravity[:, None]
    low, high = joints.min(axis=(0, 1)), joints.max(axis=(0, 1))
    room = STRIP_MARGIN * max(high - low)
    low, high = low - room, high + room
    width, height = high - low
    columns = FRAMES if height > 1.5 * width else FRAMES // 2
    figure, panels = make_strip(7.8, FRAMES, columns, height / width)
    step = (len(joints) - 1) // FRAMES
    for frame, axes in enumerate(panels):
        at = frame * step
        for back in range(TRAIL_SHAPES, 0, -1):
            before = (at - back * step // TRAIL_SHAPES) % (len(joints) - 1)
            axes.plot(*joints[before].T, "-", color=ROD, alpha=0.7 - 0.14 * back, linewidth=0.8)
        axes.plot(*joints[at].T, "-", color=ROD, linewidth=LINE)
        draw_marks(axes, scene, joints[at], ROD, t=cycle.motion.t[at])
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.set_title(f"{frame}/{FRAMES} T")
    kind = "stable" if cycle.stable else "unstable"
    seen = ", seen from its centre of gravity" if is_free else ""
    words = f"{kind} cycle, T = {cycle.period:.6g} s{seen}; pale: just before"
    set_title(figure, f"{scene.name}: cycle")
    label_strip(figure, "x [m]", "y [m]", f"{words}; {describe_marks(scene)}")
    return figure


def unit_circle(cycle: Cycle) -> Figure:
    """Floquet multipliers of a cycle with the unit circle; a ring for those that are 1 by
    symmetry."""
    return multiplier_plane(cycle.nontrivial, cycle.scene.name, cycle.trivial)


def multiplier_plane(multipliers: NDArray[np.complex128], name: str, trivial: int = 0) -> Figure:
    """Floquet multipliers with the unit circle; trivial: how many more are 1 by symmetry."""
    figure, (axes,) = make_axes(4.6, 4.6)
    turn = np.linspace(0, 2 * np.pi, 361)
    axes.plot(np.cos(turn), np.sin(turn), "-", color=FAINT, linewidth=LINE)
    mu = multipliers[np.isfinite(multipliers)]
    grows = np.abs(mu) > 1 + 1e-7
    axes.plot(mu[~grows].real, mu[~grows].imag, "o", color=CURVE, markersize=4)
    axes.plot(mu[grows].real, mu[grows].imag, "X", color=SPECIAL, markersize=7)
    if trivial:
        axes.plot([1.0], [0.0], "o", markersize=9, fillstyle="none", color=INK)
    side = max(INSIDE, 1.1 * float(np.abs(mu).max(initial=0.0)))
    axes.set(xlim=(-side, side), ylim=(-side, side), aspect="equal")
    axes.set(xlabel="real part", ylabel="imaginary part")
    said = f"{grows.sum()} outside" if grows.any() else "none outside"
    rings = f"; ring: {trivial} at 1 by symmetry" if trivial else ""
    add_remark(axes, f"multipliers: {said}{rings}")
    set_title(figure, f"{name}: multipliers")
    return figure


def cycle_branch_diagram(data: xarray.Dataset, scene: Scene) -> Figure:
    """Amplitude and period along a branch of cycles: stable ones solid, unstable ones dashed,
    special points marked and named."""
    value = data["value"].values
    stable = data["unstable"].values == 0
    kinds = np.where(stable[:-1] & stable[1:], 0, 1)
    figure, (top, low) = make_axes(6.5, 5.6, 2, sharex=True)
    for axes, name, words in (
        (top, "amplitude", "amplitude of the angles [rad]"),
        (low, "period", "period [s]"),
    ):
        height = data[name].values
        draw_by_stability(axes, value, height, kinds)
        for kind in dict.fromkeys(data["special_kind"].values.tolist()):
            here = np.flatnonzero(data["special_kind"].values == kind)
            x = data["special_value"].values[here]
            y = [_ordinate(data, name, int(one)) for one in here]
            mark, label = mark_of(kind)
            axes.plot(x, y, mark, color=SPECIAL, markersize=5, label=label)
        label_ordinate(axes, words, 2)
    low.set_xlabel(axis_label(data.attrs["key"]))
    set_title(figure, f"{scene.name}: cycles")
    add_legend(figure, [*stability_legend(kinds, CURVE), *top.get_legend_handles_labels()[0]])
    return figure


def _ordinate(data: xarray.Dataset, name: str, special: int) -> float:
    """Return the ordinate of a special point, interpolated along the branch."""
    if name == "period":
        return float(data["special_period"][special])
    after = int(data["special_after"][special])
    if after < 0:
        return 0.0
    ends, around = (data[one].values[after : after + 2] for one in (name, "value"))
    if len(ends) < 2:
        return float(ends[0])
    (a, b), x = around, float(data["special_value"][special])
    share = float(np.clip((x - a) / (b - a), 0, 1)) if a != b else 0.5
    return float(ends[0] * (1 - share) + ends[1] * share)


def frequency_energy_plot(data: xarray.Dataset, scene: Scene) -> Figure:
    """Frequency against energy of a nonlinear mode: stable motions solid, unstable ones dashed."""
    figure, (axes,) = make_axes(6.0, 4.2)
    stable = data["unstable"].values == 0
    kinds = np.where(stable[:-1] & stable[1:], 0, 1)
    energy, frequency = data["energy"].values, data["frequency"].values
    draw_by_stability(axes, energy, frequency, kinds)
    axes.plot(
        [0.0], [data.attrs["linear_frequency"]], "o", color=INK, markersize=4, label="linear mode"
    )
    axes.set(xlabel="energy above rest [J]", ylabel="frequency [Hz]")
    set_title(figure, f"{scene.name}: nonlinear mode {data.attrs['mode']}")
    axes.legend()
    return figure


PICTURES_OF = {
    Cycle: {"film": film_strip, "multipliers": unit_circle},
    Floquet: {"multipliers": lambda found: multiplier_plane(found.multipliers, "periodic motion")},
}
