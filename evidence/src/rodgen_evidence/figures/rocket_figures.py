"""Pictures of docs/rocket.md: modes in flight, the place of the gyro, the gust.

python -m rodgen_evidence.figures.rocket_figures SCENE FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import rodgen
from rodgen_evidence.figures.model_figures import STYLE
from rodgen_evidence.figures.model_parts import FORCE, GUIDE, VELOCITY

TIMES = (0.2, 1.0, 2.0, 3.0, 4.0, 4.6, 4.9)  # s: under thrust, without the gust
SLOW = 3.0  # Hz
PLACES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)  # s of the gyro


def sheet(width: float, panels: int) -> tuple[Figure, list[Axes]]:
    """A white figure with panels side by side."""
    figure = Figure(figsize=(width, 3.0), facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    return figure, list(figure.subplots(1, panels, squeeze=False)[0])


def with_gyros(scene: rodgen.Scene) -> dict[str, Any]:
    """The tables of a scene with a gyro at every place, each with a weight, so that one module
    serves them all."""
    table = scene.model_dump(exclude_none=True, by_alias=True)
    weights = {f"weight_of_gyro{k}x": 0.0 for k in range(len(PLACES))}
    table["parameters"] |= weights
    command = " + ".join(
        f"{weight}*(gain*(phi({at}) - upright) + rate_gain*omega({at}))"
        for weight, at in zip(weights, PLACES, strict=True)
    )
    table["states"]["gimbal"]["rate"] = f"({command} - gimbal)/lag"
    return table


def bending(found: rodgen.Modes) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and growth [1/s] of the modes that bend the rod, which the steering is far
    too slow for."""
    fast = np.asarray(found.frequencies) > SLOW
    return np.asarray(found.frequencies)[fast], np.asarray(found.growth)[fast]


def modes(scene: rodgen.Scene) -> Figure:
    """Frequencies of the first bending modes while the tank empties, and how the first one grows
    or decays by where the gyro sits."""
    figure, (left, right) = sheet(7.4, 2)
    found = [bending(rodgen.natural_modes(scene, count=4, t=t))[0] for t in TIMES]
    for mode in (0, 1):
        left.plot(TIMES, [f[mode] for f in found], "o-", color=VELOCITY, markersize=3)
    left.set(xlabel="time [s]", ylabel="frequency [Hz]", ylim=(0, None), title="bending modes")
    table = with_gyros(scene)
    for t, style in ((0.2, "-"), (4.6, "--")):
        growth = []
        for k in range(len(PLACES)):
            weights = {f"weight_of_gyro{j}x": float(j == k) for j in range(len(PLACES))}
            one = rodgen.Scene.from_dict(table | {"parameters": table["parameters"] | weights})
            growth.append(bending(rodgen.natural_modes(one, count=4, t=t))[1][0])
        right.plot(PLACES, growth, style, color=FORCE, label=f"t = {t} s")
    right.axhline(0.0, color=GUIDE, linewidth=0.9)
    right.set(xlabel="place s of the gyro", ylabel="growth [1/s]", title="first bending mode")
    right.legend()
    return figure


def gust(scene: rodgen.Scene) -> Figure:
    """Angle of the gyro, angle of the gimbal, and the bending moment in the middle."""
    sol = rodgen.simulate(scene)
    figure, panels = sheet(7.4, 3)
    data = sol.to_xarray()
    gyro = int(0.3 * scene.rod.links)
    lines = {
        "gyro [deg]": np.degrees(np.asarray(data.phi)[:, gyro] - scene.numbers["upright"]),
        "gimbal [deg]": np.degrees(data.y.sel(state="gimbal").to_numpy()),
        "moment in the middle [N m]": sol.bending_moments[:, scene.rod.links // 2],
    }
    for axes, (name, values) in zip(panels, lines.items(), strict=True):
        axes.plot(sol.t, values, color=VELOCITY, linewidth=1.2)
        axes.axvspan(2.0, 2.8, color=GUIDE, alpha=0.25, linewidth=0)
        axes.set(xlabel="time [s]", title=name)
    return figure


if __name__ == "__main__":
    scene, folder = rodgen.Scene.from_toml(sys.argv[1]), Path(sys.argv[2])
    with matplotlib.rc_context(STYLE):
        for name, draw in {"rocket_modes": modes, "rocket_gust": gust}.items():
            draw(scene).savefig(folder / f"{name}.svg", metadata={"Date": None, "Creator": None})
            print(folder / f"{name}.svg")
