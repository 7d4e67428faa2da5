"""Pictures of an analysis, made for print: mode shapes, an equilibrium, a critical force."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rodgen.analyse.critical import Critical
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.family import Complex, Family
from rodgen.analyse.modes import Modes
from rodgen.analyse.statics import Equilibrium
from rodgen.analyse.system import System
from rodgen.integrate.stepper import Array
from rodgen.view.pictures import DOTS_PER_INCH, LINE

PANELS = 6  # modes drawn
AMPLITUDE = 0.1  # of the length
PHASES = 8  # of a mode whose joints do not move in step
SMALL, SEEN = 0.05, 0.2  # of the length: displacements drawn larger, and up to where
ARROW = 0.14  # of the length
ASIDE = 0.06  # of the length, by which arrows of gravity stand beside a rod that hangs
WEIGHTS = 9  # arrows of gravity along the rod
FORCES = 400  # in the curves of a critical force
BEYOND = 0.3  # of the critical force, that the curves go on
NEAR = 0.1  # of the critical force, up to where growth fills the picture


def save_picture(figure: Figure, folder: Path, name: str) -> Path:
    """Write a picture as PNG into a folder that exists, whole or not at all."""
    with tempfile.TemporaryDirectory(dir=folder, prefix=".pictures") as making:
        made = Path(making) / f"{name}.png"
        figure.savefig(made, dpi=DOTS_PER_INCH, bbox_inches="tight")
        return made.replace(folder / made.name)


def mode_shapes(modes: Modes, name: str) -> Figure:
    """The shapes of up to six modes, at both ends of their motion, on the steady state."""
    count = min(PANELS, len(modes.frequencies))
    size = AMPLITUDE * np.linalg.norm(np.diff(modes.joints, axis=0), axis=1).sum()
    moved = size * modes.displacements[:count]
    low = (modes.joints - np.abs(moved)).min(axis=(0, 1)) - size / 3
    high = (modes.joints + np.abs(moved)).max(axis=(0, 1)) + size / 3
    width, height = high - low
    columns = min(count, 2 + (height > 0.7 * width) + 3 * (height > 2 * width))
    rows = -(-count // columns)
    across = 6.3 / columns - 0.3
    figure = _canvas(7.0, rows * (min(across * height / width, 5.0) + 0.55) + 0.8)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for at, axes in enumerate(panels.flat):
        if at < count:
            _mode(axes, modes.joints, moved[at])
            axes.set_title(_label(modes, at), fontsize="small")
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
            axes.tick_params(labelsize="x-small")
        else:
            axes.set_visible(False)
    figure.suptitle(f"{name}: modes about the state: {modes.state}", fontsize="medium")
    figure.supxlabel("x [m]", fontsize="small")
    figure.supylabel("y [m]", fontsize="small")
    return figure


def _mode(axes: Axes, joints: Array, moved: Complex | Array) -> None:
    """One mode: the first phase in full colour, the others behind it."""
    phases = 2 if np.isrealobj(moved) else PHASES
    axes.plot(*joints.T, "--", color="grey", linewidth=0.8)
    for at in range(1, phases):
        shape = joints + (moved * np.exp(2j * np.pi * at / phases)).real
        axes.plot(*shape.T, "-", color="tab:blue", alpha=0.3, linewidth=0.8)
    shape = joints + moved.real
    axes.plot(*shape.T, "-", color="tab:blue", linewidth=LINE)
    axes.plot(*shape[0], "o", color="tab:blue", markersize=3)
    axes.grid(alpha=0.3)


def _label(modes: Modes, at: int) -> str:
    frequency, growth = modes.frequencies[at], modes.growth[at]
    text = f"{at + 1}: {frequency:.5g} Hz" if frequency else f"{at + 1}: no oscillation"
    return f"{text}\ngrows" if growth > 0 else text


def equilibrium_shape(rest: Equilibrium, system: System) -> Figure:
    """The deflected rod beside the straight one, with its loads; small displacements enlarged.
    A rod that turns freely is straight in more than one direction: that of its start is shown."""
    length, name = system.scene.rod.length, system.scene.name
    straight = system.model.joints(system.at_rest(system.straight), system.parameters())
    moved = rest.joints - straight
    largest = float(np.linalg.norm(moved, axis=1).max()) / length
    times = 1.0
    if 1e-12 < largest < SMALL:
        times = float(10.0 ** np.floor(np.log10(SEEN / largest)))
    joints = straight + times * moved
    figure = _canvas(6.0, 5.5)
    axes = figure.add_subplot()
    axes.grid(alpha=0.3)
    straight_as = "straight" if system.clamped else "straight, as at the start"
    axes.plot(*straight.T, "--", color="grey", label=straight_as, linewidth=LINE)
    dots = "o-" if len(joints) <= 60 else "-"
    scale = f" (displacements x {times:g})" if times > 1 else ""
    axes.plot(*joints.T, dots, color="tab:blue", markersize=2.5, label=f"equilibrium{scale}")
    axes.plot(*joints[0], "ks" if system.clamped else "ko", markersize=6)
    side = -1.0 if straight[-1, 0] > joints[-1, 0] else 1.0  # where the straight rod is not
    drawn = _loads(axes, system, joints, rest.phi[-1], side)
    points = np.concatenate((straight, joints, *drawn))
    low, high = points.min(axis=0), points.max(axis=0)
    half = np.maximum((high - low) / 2, 0.2 * length) + 0.06 * length
    middle = (low + high) / 2
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    axes.set_aspect("equal")
    figure.set_figheight(min(5.2 * half[1] / half[0] + 1.5, 6.5))
    state = ", unstable" if rest.stable is False else ""
    axes.set(xlabel="x [m]", ylabel="y [m]", title=f"{name}: static equilibrium{state}")
    handles = [*axes.get_legend_handles_labels()[0], *_keys(system)]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize="small")
    return figure


COLOURS = {"follower force": "tab:red", "tip load": "tab:orange", "gravity": "tab:green"}


def _amounts(system: System) -> dict[str, str]:
    """Loads that are not zero, with their values."""
    given = system.given
    tip = np.hypot(given.get("tip_force_x", 0.0), given.get("tip_force_y", 0.0))
    amounts = {
        "follower force": (given.get("follower_force", 0.0), "N"),
        "tip load": (float(tip), "N"),
        "gravity": (given.get("gravity", 0.0), "m/s²"),
    }
    return {load: f"{value:.4g} {unit}" for load, (value, unit) in amounts.items() if value}


def _keys(system: System) -> list[Line2D]:
    return [
        Line2D([], [], color=COLOURS[load], marker=">", markersize=4, label=f"{load} {amount}")
        for load, amount in _amounts(system).items()
    ]


def _loads(axes: Axes, system: System, joints: Array, angle: float, side: float) -> list[Array]:
    """Arrows of the loads; their ends, pairs of points (2, 2). side: +1 or -1, to the right or the
    left, where gravity stands beside a rod that hangs."""
    given, loads = system.given, _amounts(system)
    size = ARROW * system.scene.rod.length
    tip, ends = joints[-1], []
    if "follower force" in loads:
        at = angle + given.get("follower_angle", 0.0)
        out = size * np.array([np.cos(at), np.sin(at)])
        push = np.array([tip + out, tip])
        ends.append((push if given["follower_force"] > 0 else push[::-1], "follower force"))
    if "tip load" in loads:
        pull = np.array([given["tip_force_x"], given["tip_force_y"]])
        ends.append((np.array([tip, tip + size * pull / np.hypot(*pull)]), "tip load"))
    if "gravity" in loads:
        down = np.array([0.0, -0.5 * size * np.sign(given["gravity"])])
        width, height = np.ptp(joints, axis=0)
        aside = side * ASIDE * system.scene.rod.length * (height > 2 * width)
        at = joints + np.array([aside, 0.0])
        for k in np.unique(np.linspace(0, len(joints) - 1, WEIGHTS).round().astype(int)):
            ends.append((np.array([at[k], at[k] + down]), "gravity"))
    for (start, end), load in ends:
        style = {"arrowstyle": "-|>", "color": COLOURS[load], "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", end, start, arrowprops=style)
    return [pair for pair, _ in ends]


LABELS = {
    "follower": "follower force [N]",
    "tip": "dead force at the tail [N]",
    "gravity": "gravity [m/s²]",
    "all": "factor of all loads",
}


def stability_curves(found: Critical, family: Family) -> Figure:
    """Frequencies of the lowest modes and below them growth, against the load that is scaled."""
    start = min(0.0, found.searched[0])
    beyond = found.force + BEYOND * max(abs(found.force), family.unit * (not found.force))
    forces, s = _rates(family, start, beyond, found)
    # Without damping one eigenvalue of each pair is here, with damping both: the upper half.
    kept = slice(s.shape[1] // 2 if family.damped else 0, None)
    frequency = np.sort(np.where(np.isnan(s), -np.inf, s.imag), axis=1)[:, kept] / (2 * np.pi)
    growth = np.sort(s.real, axis=1)
    shown = np.isfinite(frequency) & (frequency >= 0)
    frequency = np.where(shown, frequency, np.nan)
    first = int(np.argmax(frequency[0] > family.rigid / (2 * np.pi)))  # overdamped motions apart
    last = min(first + max(*found.modes, 2), frequency.shape[1] - 1)
    figure = _canvas(6.4, 5.6)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    upper.plot(forces, frequency[:, : last + 1], ".", markersize=1.5, color="tab:blue")
    upper.set_ylim(0, 1.08 * max(float(np.nanmax(frequency[:, : last + 1])), 1e-300))
    upper.plot(found.force, found.frequency, "o", color="tab:red", clip_on=False, markersize=5)
    lower.plot(forces, growth, ".", markersize=1.5, color="tab:blue")
    lower.set_ylim(_limits(forces, growth, found.force, family))
    lower.plot(found.force, 0.0, "o", color="tab:red", markersize=5)
    for axes in (upper, lower):
        axes.axvline(found.force, color="tab:red", linestyle="--", linewidth=0.8)
        axes.grid(alpha=0.3)
    at = f" at {found.frequency:.5g} Hz" if found.frequency else ""
    name = family.system.scene.name
    upper.set(
        ylabel="frequency [Hz]",
        title=f"{name}: {found.kind} from {found.force:.6g} {found.unit}{at}",
    )
    lower.set(xlabel=LABELS[found.load], ylabel="growth [1/s]", xlim=(forces[0], forces[-1]))
    return figure


def _limits(forces: Array, growth: Array, force: float, family: Family) -> tuple[float, float]:
    """Of the growth [1/s]: up to what there is a little beyond the critical force, not to what
    comes much later, and down to the least damped motion wherever it dies away fastest."""
    most = np.nan_to_num(growth, nan=-np.inf).max(axis=1)
    near = forces <= force + NEAR * abs(force)
    high = max(float(most[near].max()), 1e-6 * family.lowest)
    low = float(most.min()) if family.damped else -high  # flutter dies away as it grows
    return 1.1 * min(low, -high / 4), 1.1 * max(high, -low / 4)


def _rates(family: Family, low: float, high: float, found: Critical) -> tuple[Array, Complex]:
    """Forces and eigenvalues at them, what is left out of the search as nan; only up to the
    critical force where no steady state lies beyond."""
    for end in (high, found.force * (1 - 1e-6)):
        forces = np.linspace(low, end, FORCES)
        try:
            return forces, family.motions(forces, elastic=found.elastic).s
        except AnalysisError as error:
            last = error
    raise last


def _canvas(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure
