"""The picture of a scene: the rod as it starts, what holds it, and the loads on it."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from rodgen.analyse.steady_rod import SteadyRod
from rodgen.scene import Scene
from rodgen.show.analysis_pictures import draw_loads, load_keys
from rodgen.show.canvas import LINE, ROD, canvas, frame
from rodgen.show.rod_marks import draw_marks, marks_in_words


def at_start(scene: Scene) -> Figure:
    """The rod in its initial state with its bodies, supports and loads at the start of the span;
    its module is built where it has not been."""
    rod, y = SteadyRod.of(scene, scene.integrate.span[0]), scene.initial_state()
    joints = rod.model.joints(y, rod.system.p)
    figure = canvas(6.0, 5.0)
    axes = figure.add_subplot()
    axes.grid(alpha=0.3)
    axes.plot(*joints.T, "-", color=ROD, linewidth=LINE)
    draw_marks(axes, scene, joints, ROD)
    drawn = draw_loads(axes, rod, joints, y, 1.0)
    fixed = [(tie.x, tie.y) for tie in scene.anchors.ties]
    axes.set(xlabel=f"x [m]\n{marks_in_words(scene)}", ylabel="y [m]")
    axes.set_title(f"{scene.name} at the start")
    frame(axes, np.concatenate((joints, *drawn, np.reshape(fixed, (-1, 2)))))
    if keys := load_keys(rod, y):
        figure.legend(handles=keys, loc="outside lower center", ncols=2, fontsize="small")
    return figure
