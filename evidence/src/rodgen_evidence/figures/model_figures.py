"""Pictures of docs/derivation.md: the model, its loads, its frequencies."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rodgen.loading import build
from rodgen.scene.structure import Structure
from rodgen.show.style import style
from rodgen_evidence.figures.model_parts import (
    FONT,
    FORCE,
    GUIDE,
    INK,
    SPRING,
    VELOCITY,
    Point,
    across,
    along,
    angle,
    arrow,
    by,
    cut,
    damping,
    dimension,
    guide,
    joints,
    rod,
    sheet,
    spring,
    text,
    turn,
    wall,
)


@dataclass(frozen=True)
class CompressedRod:
    """A straight rod under a compressive force that grows: how it is built, the force (of EI/L^2)
    up to which it is drawn, and its eigenvalues at zero, by which it moves as a rigid body."""

    structure: Structure
    force: str
    sign: float
    most: float
    rigid: int

    def eigenvalues(self, force: float) -> np.ndarray:
        """The four of least modulus by which the rod bends, in units of (EI/(M L^3))^(1/2)."""
        module = build(self.structure)
        loads = dict.fromkeys(module.PARAMETERS[3:], 0.0) | {self.force: self.sign * force}
        p = module.parameters(mass=1.0, length=1.0, bending_stiffness=1.0, **loads)
        values = np.linalg.eigvals(module.jac(0.0, np.zeros(len(module.STATE)), p))
        return values[np.argsort(np.abs(values))][self.rigid : self.rigid + 4]

    def critical(self) -> float:
        """The force from which on something grows."""
        low, high = 0.0, self.most
        while high - low > 1e-6 * self.most:
            middle = (low + high) / 2
            grows = self.eigenvalues(middle).real.max() > 1e-3
            low, high = (low, middle) if grows else (middle, high)
        return low


FLUTTER = CompressedRod(Structure(10, "free", terms=("follower",)), "follower_force", 1.0, 120.0, 6)
DIVERGENCE = CompressedRod(
    Structure(10, "clamped", terms=("tip_load",)), "tip_force_x", -1.0, 3.2, 0
)


def frequencies() -> Figure:
    """Frequencies against force: two meet, or one reaches zero."""
    figure = Figure(figsize=(7.2, 3.3), facecolor="white")
    FigureCanvasAgg(figure)
    cases = {
        "free, follower force": (FLUTTER, "$P L^2/EI$", 70.0),
        "clamped, dead force": (DIVERGENCE, "$F L^2/EI$", 4.0),
    }
    for at, (title, (loading, force, top)) in enumerate(cases.items()):
        axes = figure.add_axes((0.085 + 0.505 * at, 0.16, 0.395, 0.74))
        _curves(axes, loading, np.linspace(0.0, 1.0, 60), count=2 - at)
        axes.set(xlim=(0, loading.most), ylim=(0, top), xlabel=force, title=title)
        axes.set_ylabel(r"in units of $\sqrt{EI/(ML^3)}$")
        axes.legend(loc="upper right", fontsize=9.5)
        axes.title.set_fontsize(FONT)
    return figure


def _curves(axes: Axes, loading: CompressedRod, share: np.ndarray, count: int) -> None:
    """The ``count`` lowest frequencies, and how fast motion grows, below and above the critical
    force; points are dense beside it, where the curves are steep."""
    critical = loading.critical()
    below, above = 1 - (1 - share) ** 2, share**2
    forces = np.concatenate((critical * below, critical + (loading.most - critical) * above))
    values = np.array([loading.eigenvalues(force) for force in forces])
    shown = np.sort(np.abs(values.imag), axis=1)[:, : 2 * count : 2]
    axes.plot(forces, shown, color=VELOCITY, linewidth=1.8)
    axes.plot([], [], color=VELOCITY, linewidth=1.8, label="frequency")
    grown = forces >= critical
    growth = values.real.max(axis=1)[grown]
    axes.plot(forces[grown], growth, "--", color=FORCE, linewidth=1.8, label="growth rate")
    axes.axvline(critical, color=GUIDE, linewidth=0.9, linestyle=":")


STYLE: Any = style | {
    "figure.constrained_layout.use": False,  # drawings have places of their own
    "font.family": "DejaVu Sans",
    "mathtext.fontset": "dejavuserif",
    "svg.fonttype": "path",  # looks alike without our fonts
    "svg.hashsalt": "rodgen",
}


def model() -> Figure:
    """The rod, its coordinates, springs and loads."""
    figure, axes = sheet(4.95, 2.85)
    phi, nu = [0.95, 0.6, 0.35, -0.3], 0.5
    r = joints("free", phi, by(0.62, 0.62))
    _axes_of_the_plane(axes, by(0.3, 0.28))
    x, y = r[0]
    for foot in (np.array([x, 0.28]), np.array([0.3, y])):
        guide(axes, r[0], foot, ":")
    text(axes, np.array([x, 0.12]), "$x_0$")
    text(axes, np.array([0.13, y]), "$y_0$")
    rod(axes, r)
    for s, (joint, turned) in enumerate(zip(r, phi, strict=False)):
        guide(axes, joint, joint + by(0.75, 0.0))
        angle(axes, joint, 0.5, (0.0, turned), f"$\\varphi_{s}$")
        side = across(turned, 0.17 if s < 3 else -0.17)
        text(axes, joint + along(turned, 0.55) + side, f"link {s}", rotation=np.degrees(turned))
        if s:
            spring(axes, joint, phi[s - 1] - 2.0)
            text(axes, joint + by(-0.08, 0.28), f"{s}")
    text(axes, r[0] + by(-0.13, 0.14), "0")
    text(axes, r[-1] + by(-0.02, -0.19), "4")
    text(axes, r[1] + by(-0.45, 0.02), "spring $k$", SPRING)
    guide(axes, r[-1], r[-1] + along(phi[-1], 0.85))
    arrow(axes, [r[-1] + along(phi[-1] + nu, 0.9), r[-1] + along(phi[-1] + nu, 0.07)], FORCE, 2.4)
    text(axes, r[-1] + along(phi[-1] + nu, 0.75) + by(-0.05, 0.16), "$P$", FORCE)
    angle(axes, r[-1], 0.55, (phi[-1], phi[-1] + nu), r"$\nu$")
    arrow(axes, [by(0.55, 2.6), by(0.55, 2.05)], FORCE)
    text(axes, by(0.7, 2.33), "$g$", FORCE)
    return figure


def _axes_of_the_plane(axes: Axes, origin: Point) -> None:
    for step, name in ((by(0.85, 0.0), "$x$"), (by(0.0, 0.85), "$y$")):
        arrow(axes, [origin, origin + step], INK, 1.0)
        text(axes, origin + 1.12 * step, name)


def link() -> Figure:
    """The velocity of a point of a link: that of its start and that of turning."""
    figure, axes = sheet(4.3, 2.3)
    turned, share = 0.35, 0.55
    r = joints("free", [turned], by(0.55, 0.6), 2.9)
    point = r[0] + share * (r[1] - r[0])
    rod(axes, r)
    guide(axes, r[0], r[0] + by(1.25, 0.0))
    angle(axes, r[0], 1.0, (0.0, turned), r"$\varphi_s$")
    velocity, rate = by(0.68, -0.12), across(turned, 0.75)
    for foot in (r[0], point):
        arrow(axes, [foot, foot + velocity], VELOCITY)
    arrow(axes, [point + velocity, point + velocity + rate], VELOCITY)
    arrow(axes, [point, point + velocity + rate], INK, 2.4)
    axes.plot(*point, "o", markersize=5, color=INK, zorder=7)
    text(axes, r[0] + velocity + by(-0.08, -0.13), "$v_s$", VELOCITY)
    text(axes, point + velocity + by(-0.08, -0.13), "$v_s$", VELOCITY)
    text(axes, point + velocity + 0.97 * rate + by(0.36, 0.02), r"$\xi l\,\omega_s n_s$", VELOCITY)
    text(axes, point + (velocity + rate) / 2 + by(-0.1, 0.12), "$v$")
    dimension(axes, r[0], point, across(turned, 0.33), r"$\xi l$")
    dimension(axes, r[0], r[1], across(turned, -0.52), "$l$")
    turn(axes, r[0], 0.3, (turned + 2.0, turned + 4.0), VELOCITY)
    text(axes, r[0] + by(-0.4, 0.1), r"$\omega_s$", VELOCITY)
    text(axes, r[0] + by(-0.1, -0.42), "joint $s$")
    for direction, name in ((along(turned), "$e_s$"), (across(turned), "$n_s$")):
        arrow(axes, [r[1], r[1] + 0.45 * direction], INK, 1.2)
        text(axes, r[1] + 0.58 * direction, name)
    return figure


def boundaries() -> Figure:
    """The four ways to hold the start of the rod."""
    figure, axes = sheet(6.6, 1.75, 1.1)
    phi = [0.0, 0.18, 0.36, 0.5]
    words = {
        "free": "joint 0 moves",
        "cantilever": "link 0 is held",
        "clamped": "spring $2k$ in joint 0",
        "pinned": "joint 0 is held",
    }
    for at, (boundary, what) in enumerate(words.items()):
        start = np.array([0.26 + 1.66 * at, 0.75])
        held = boundary == "cantilever"
        r = joints(boundary, phi if held else [a + 0.12 for a in phi], start, 0.32)
        _support(axes, boundary, r)
        rod(axes, r)
        for joint in r[1:-1]:
            spring(axes, joint, 2.0, 0.105)
        text(axes, start + by(0.52, 0.85), boundary)
        text(axes, start + by(0.52, -0.58), what, fontsize=FONT - 1.5)
    return figure


def _support(axes: Axes, boundary: str, r: np.ndarray) -> None:
    start = r[0]
    if boundary == "cantilever":
        for side in (0.09, -0.09):
            edge = np.array([0.0, side])
            wall(axes, start + edge, r[1] + edge, np.array([0.0, 0.8 * side]))
    if boundary == "clamped":
        wall(axes, start + by(-0.13, -0.3), start + by(-0.13, 0.3), by(-0.08, 0.0))
        spring(axes, start, np.pi, 0.13)
    if boundary == "pinned":
        corners = np.array([start, start + by(-0.13, -0.22), start + by(0.13, -0.22), start])
        axes.plot(*corners.T, color=INK, linewidth=1.2, zorder=1)
        wall(axes, start + by(-0.22, -0.22), start + by(0.22, -0.22), by(0.0, -0.08))


FIGURES: dict[str, Callable[[], Figure]] = {
    "model_rod": model,
    "model_link": link,
    "model_damping": damping,
    "model_boundaries": boundaries,
    "model_cut": cut,
    "model_frequencies": frequencies,
}


def save_figures(folder: Path, suffix: str = "svg") -> list[Path]:
    """Draw every figure into a folder that exists; returns the files."""
    files = []
    with matplotlib.rc_context(STYLE):
        for name, draw in FIGURES.items():
            files.append(folder / f"{name}.{suffix}")
            nothing = {"Date": None, "Creator": None} if suffix == "svg" else None
            draw().savefig(files[-1], dpi=120, metadata=nothing)
    return files


if __name__ == "__main__":
    print(*save_figures(Path(sys.argv[1])), sep="\n")
