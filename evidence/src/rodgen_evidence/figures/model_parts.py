"""Parts of the pictures of the model, and its loads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch
from matplotlib.path import Path

from rodgen.loading import build
from rodgen.scene.structure import Structure

SCALE = 1.5  # inches per unit
FONT = 11.0  # points
INK, PALE = "black", "0.82"
SPRING, FORCE, VELOCITY, GUIDE = "#8a4b08", "#b2182b", "#1f5fa8", "0.45"

Point = np.ndarray


def along(angle: float, length: float = 1.0) -> Point:
    """The vector of this length in the direction of an angle."""
    return length * np.array([np.cos(angle), np.sin(angle)])


def by(x: float, y: float) -> Point:
    """A vector by its components."""
    return np.array([x, y])


def across(angle: float, length: float = 1.0) -> Point:
    """The vector of this length a quarter turn ahead of an angle."""
    return along(angle + np.pi / 2, length)


def joints(boundary: str, angles: list[float], start: Point, length: float = 1.0) -> np.ndarray:
    """Joints of a rod with these angles by the generated module, joint 0 at ``start``."""
    module = build(Structure(len(angles), boundary, terms=()))
    values = {"clamp_angle": angles[0]} if "clamp_angle" in module.PARAMETERS else {}
    state = {f"phi_{i}": a for i, a in enumerate(angles)} | {"x0": start[0], "y0": start[1]}
    p = module.parameters(mass=1.0, length=length * len(angles), bending_stiffness=1.0, **values)
    at = np.asarray(module.joints(np.array([state.get(name, 0.0) for name in module.STATE]), p))
    return at if boundary == "free" else at + start


def sheet(width: float, height: float, scale: float = SCALE) -> tuple[Figure, Axes]:
    """A white sheet of this many units, its lower left corner at (0, 0)."""
    figure = Figure(figsize=(width * scale, height * scale), facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0, width), ylim=(0, height), aspect="equal")
    axes.set_axis_off()
    return figure, axes


def text(axes: Axes, at: Point, words: str, colour: str = INK, **options: Any) -> None:
    """Words about a point."""
    how: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": FONT, **options}
    axes.text(float(at[0]), float(at[1]), words, color=colour, **how)


def rod(axes: Axes, joints: np.ndarray) -> None:
    """Links between these joints, and the joints."""
    ends: Any = {"solid_joinstyle": "round", "solid_capstyle": "round"}
    axes.plot(*joints.T, color=INK, linewidth=9.0, zorder=2, gid="rod", **ends)
    axes.plot(*joints.T, color=PALE, linewidth=7.0, zorder=3, **ends)
    axes.plot(*joints.T, "o", markersize=6, markerfacecolor="white", color=INK, zorder=5)


def spring(axes: Axes, centre: Point, start: float, radius: float = 0.17) -> None:
    """A rotary spring: a spiral about a joint that begins at an angle."""
    turns = np.linspace(0.0, 2.0, 120)
    points = [centre + along(start + 2 * np.pi * t, radius * (0.45 + 0.275 * t)) for t in turns]
    axes.plot(*np.transpose(points), color=SPRING, linewidth=1.4, zorder=4)


def guide(axes: Axes, start: Point, end: Point, style: str = "--") -> None:
    """A thin line that shows a direction."""
    axes.plot(*np.transpose([start, end]), style, color=GUIDE, linewidth=0.9, zorder=1)


def arrow(axes: Axes, points: Sequence[Point], colour: str = INK, width: float = 1.8) -> None:
    """An arrow along these points."""
    patch = FancyArrowPatch(
        path=Path(np.array(points)),
        arrowstyle="-|>",
        mutation_scale=6 + 4 * width,
        color=colour,
        linewidth=width,
        fill=False,
        zorder=6,
    )
    patch.set_joinstyle("miter")
    patch.set_facecolor(colour)
    axes.add_patch(patch)


def turn(
    axes: Axes, centre: Point, radius: float, angles: tuple[float, float], colour: str = INK
) -> None:
    """An arrow about a centre, from one angle to another: a moment or a rate."""
    steps = np.linspace(*angles, 30)
    arrow(axes, [centre + along(a, radius) for a in steps], colour, 1.5)


def angle(
    axes: Axes, corner: Point, radius: float, angles: tuple[float, float], words: str
) -> None:
    """An angle, from its first leg to its second, with its name beyond the arc."""
    steps = np.linspace(*angles, 30)
    arrow(axes, [corner + along(a, radius) for a in steps], INK, 0.9)
    text(axes, corner + along(float(np.mean(angles)), radius + 0.17), words)


def dimension(axes: Axes, start: Point, end: Point, aside: Point, words: str) -> None:
    """A length between two points, drawn aside from them."""
    a, b = start + aside, end + aside
    for point, foot in ((start, a), (end, b)):
        guide(axes, point, foot + 0.2 * aside, "-")
    for tip in (a, b):
        arrow(axes, [(a + b) / 2, tip], INK, 0.8)
    mark = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    text(axes, (a + b) / 2, words, bbox=mark, zorder=7)


def wall(axes: Axes, start: Point, end: Point, into: Point) -> None:
    """Ground behind a line, hatched towards ``into``."""
    axes.plot(*np.transpose([start, end]), color=INK, linewidth=1.6, zorder=1)
    side = (end - start) / np.linalg.norm(end - start) * np.linalg.norm(into)
    for share in np.linspace(0.0, 1.0, 8):
        foot = start + share * (end - start)
        axes.plot(*np.transpose([foot, foot + into - side]), color=INK, linewidth=0.8, zorder=1)


def damping() -> Figure:
    """Draw how external and internal damping and the spring act at a joint."""
    figure, axes = sheet(5.4, 2.2, 1.33)
    phi = [0.5, -0.05]
    mean = sum(phi) / 2
    r = joints("free", phi, by(0.25, 0.3))
    text(axes, by(1.3, 2.08), "external damping")
    rod(axes, r)
    guide(axes, r[1] - along(mean, 0.75), r[1] + along(mean, 0.9))
    text(axes, r[1] + along(mean, 1.02), r"$\bar\varphi_s$")
    velocity = along(mean + 0.9, 1.1)
    part = across(mean) * (velocity @ across(mean))
    arrow(axes, [r[1], r[1] + velocity], VELOCITY)
    arrow(axes, [r[1], r[1] + part], VELOCITY, 1.0)
    guide(axes, r[1] + part, r[1] + velocity, ":")
    text(axes, r[1] + velocity + by(0.15, 0.04), "$v_s$", VELOCITY)
    text(axes, r[1] + part + by(-0.17, -0.1), r"$v_{s\perp}$", VELOCITY)
    arrow(axes, [r[1], r[1] - 0.6 * velocity], FORCE, 2.2)
    text(axes, r[1] - 0.6 * velocity + by(0.16, 0.02), "$F_s$", FORCE)
    text(axes, by(4.0, 2.08), "moments across a joint")
    before, after = r + by(2.4, 0.35), r + by(3.1, 0.35)
    rod(axes, before[:2])
    rod(axes, after[1:])
    _name(axes, before[:2], 0.3, "s-1")
    _name(axes, after[1:], 0.68, "s")
    _moments(axes, before[1], after[1], phi, r"$\tau_s$")
    return figure


def _name(axes: Axes, ends: np.ndarray, share: float, index: str) -> None:
    """The name of a link below it, at a share of its length."""
    step = ends[1] - ends[0]
    turned = float(np.arctan2(step[1], step[0]))
    at = ends[0] + share * step + across(turned, -0.2)
    text(axes, at, f"link ${index}$", rotation=np.degrees(turned))


def _moments(axes: Axes, end: Point, start: Point, phi: list[float], name: str) -> None:
    """A moment on the link that starts here, and its opposite on the link that ends there."""
    turn(axes, end, 0.3, (phi[0] + np.pi + 1.0, phi[0] + np.pi - 1.0), SPRING)
    turn(axes, start, 0.3, (phi[1] - 1.0, phi[1] + 1.0), SPRING)
    text(axes, end + along(phi[0] + np.pi - 1.0, 0.44), name, SPRING)
    text(axes, start + along(phi[1] + 1.0, 0.44), name, SPRING)


def cut() -> Figure:
    """A link cut free: the forces and moments in the joints at its ends."""
    figure, axes = sheet(6.4, 2.2, 1.12)
    phi = [0.45, 0.2, -0.05]
    r = joints("free", phi, by(-0.68, 0.02), 2.0)
    gap = by(0.95, 0.0)
    stubs = (r[1] - along(phi[0], 0.95), r[2] + along(phi[2], 0.95))
    parts = (np.array([stubs[0], r[1]]), r[1:3] + gap, np.array([r[2], stubs[1]]) + 2 * gap)
    for part, share, name in zip(parts, (0.27, 0.7, 0.73), ("s-1", "s", "s+1"), strict=True):
        rod(axes, part)
        _name(axes, part, share, name)
    forces = (along(0.95, 0.65), along(0.75, 0.65))
    for at, (force, name) in enumerate(zip(forces, ("s", "s+1"), strict=True)):
        end, start = parts[at][1], parts[at + 1][0]
        arrow(axes, [end, end + force], FORCE)
        arrow(axes, [start, start - force], FORCE)
        text(axes, end + force + by(0.05, 0.13), rf"$m\lambda_{{{name}}}$", FORCE)
        text(axes, start - force + by(0.0, -0.13), rf"$-m\lambda_{{{name}}}$", FORCE)
        _moments(axes, end, start, phi[at : at + 2], rf"$\tau_{{{name}}}$")
    middle = parts[1].mean(axis=0)
    arrow(axes, [middle, middle - by(0.0, 0.75)], FORCE)
    text(axes, middle + by(0.18, -0.62), "$mg$", FORCE)
    return figure
