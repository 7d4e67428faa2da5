"""Picture of a scene: the rod at the start, its supports, and its loads."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from rodgen.analyse.steady_rod import SteadyRod
from rodgen.scene import Scene
from rodgen.show.analysis_pictures import draw_loads, load_legend
from rodgen.show.canvas import LINE, ROD, make_figure, set_limits
from rodgen.show.rod_marks import describe_marks, draw_marks


def scene_at_start(scene: Scene) -> Figure:
    """Rod in its initial state with its bodies, supports and loads at the start of the span; its
    module is built where it has not been."""
    rod, y = SteadyRod.of(scene, scene.integrate.span[0]), scene.initial_state()
    joints = rod.model.joints(y, rod.system.p)
    figure = make_figure(6.0, 5.0)
    axes = figure.add_subplot()
    axes.grid(alpha=0.3)
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


PICTURES_OF = {Scene: {"start": scene_at_start}}
