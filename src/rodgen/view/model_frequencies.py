"""How the frequencies of a straight rod change with a force that compresses it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rodgen.loading import build
from rodgen.scene.structure import Structure
from rodgen.view.model_parts import FONT, FORCE, GUIDE, VELOCITY


@dataclass(frozen=True)
class Loading:
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


FLUTTER = Loading(Structure(10, "free", terms=("follower",)), "follower_force", 1.0, 120.0, 6)
DIVERGENCE = Loading(Structure(10, "clamped", terms=("tip_load",)), "tip_force_x", -1.0, 3.2, 0)


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


def _curves(axes: Axes, loading: Loading, share: np.ndarray, count: int) -> None:
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
