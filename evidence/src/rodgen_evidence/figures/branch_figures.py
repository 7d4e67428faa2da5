"""Pictures of docs/after-the-critical-load.md: Euler's column, Beck's with damping, an umbrella.

python -m rodgen_evidence.figures.branch_figures SCENES FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

import rodgen
from rodgen.model.terms import axis_label
from rodgen.show.branch_pictures import bifurcation_diagram, boundary_curve
from rodgen_evidence.figures.model_figures import STYLE
from rodgen_evidence.figures.rocket_figures import sheet

LOAD, FORCE, ACROSS = "loads.tip.y", "loads.follower.force", "loads.tip.x"
INTERNAL, EXTERNAL = "loads.internal_damping.coefficient", "loads.external_damping.coefficient"
FORCES = (15.0, 16.0, 17.0, 18.0, 18.5, 18.77, 19.5, 20.5)  # on Ziegler's pendulum [N]
IMPERFECTION = 0.3  # N


def column(scenes: Path) -> Figure:
    """Euler's column: the straight branch, and those that leave it in both of its branch points."""
    scene = rodgen.Scene.from_toml(scenes / "euler_column.toml")
    ends = (0.0, -30.0)
    every = [rodgen.continue_equilibria(scene, LOAD, ends, branch_point=at) for at in (None, 1, 2)]
    return bifurcation_diagram(every, scene)


def imperfect_column(scenes: Path) -> Figure:
    """The column with a small force across: its own branch, and the one that begins in a fold."""
    scene = rodgen.Scene.from_toml(scenes / "euler_column.toml")
    pushed = scene.replace({ACROSS: IMPERFECTION})
    own = rodgen.continue_equilibria(pushed, LOAD, (0.0, -10.0))
    other = rodgen.continue_equilibria(pushed, LOAD, (-10.0, 0.0), imperfection=1.0)
    return bifurcation_diagram([own, other], pushed)


def damped_column(scenes: Path) -> Figure:
    """Draw the boundary of flutter of Beck's column of 20 links with internal damping."""
    table = rodgen.Scene.from_toml(scenes / "beck_after_flutter.toml").model_dump(exclude_none=True)
    table["rod"]["links"] = 20
    del table["loads"]["material_damping"]
    table["loads"]["internal_damping"] = {"coefficient": 0.2}  # m^2/s
    scene = rodgen.Scene.from_dict(table)
    bounds = ((0.0, 60.0), None)
    return boundary_curve(rodgen.stability_boundary(scene, (FORCE, INTERNAL), bounds=bounds), scene)


def spring_column(scenes: Path) -> Figure:
    """Flutter and divergence of Beck's column with a spring across its tail."""
    table = rodgen.Scene.from_toml(scenes / "becks_column.toml").model_dump(exclude_none=True)
    ones = {"length": 1.0, "mass": 1.0, "bending_stiffness": 1.0}
    table["rod"] |= {"links": 8, "clamp_angle": 0.0} | ones
    table["loads"] = {"follower": {"force": 1.0}, "material_damping": {"time": 0.01}}
    table["supports"] = [{"at": 1.0, "stiffness": [0.0, 10.0]}]
    scene = rodgen.Scene.from_dict(table)
    keys, bounds = (FORCE, "supports.0.stiffness.1"), ((0.0, 60.0), (0.0, 100.0))
    return boundary_curve(rodgen.stability_boundary(scene, keys, bounds=bounds), scene)


def umbrella(scenes: Path) -> Figure:
    """Boundaries of Ziegler's pendulum in the plane of two dampings, for forces below and above
    that at which it flutters without any: sections of Whitney's umbrella."""
    table = rodgen.Scene.from_toml(scenes / "ziegler.toml").model_dump(exclude_none=True)
    table["rod"] |= {"length": 1.0, "mass": 1.0}
    table["loads"] |= {
        "internal_damping": {"coefficient": 0.0},
        "external_damping": {"coefficient": 0.0},
    }
    scene = rodgen.Scene.from_dict(table)
    figure, (axes,) = sheet(6.4, 1)
    figure.set_figheight(4.4)
    shares = (np.array(FORCES) - FORCES[0]) / (FORCES[-1] - FORCES[0])
    for force, colour in zip(FORCES, matplotlib.colormaps["viridis"](shares), strict=True):
        loaded = scene.replace({FORCE: force})
        found = rodgen.stability_boundary(loaded, (INTERNAL, EXTERNAL))
        a, b = (found[name].values for name in ("a", "b"))
        axes.plot(a, b, color=colour, label=f"{force:g} N", linewidth=1.2)
    onset = 9 * (3.5 - np.sqrt(2))
    axes.set(
        xlim=(0, 1.0),
        ylim=(0, 3.5),
        xlabel=axis_label(INTERNAL),
        ylabel=axis_label(EXTERNAL),
        title=f"without damping flutter begins at {onset:.2f} N",
    )
    axes.legend(ncols=2)
    return figure


FIGURES = {
    "branch_column": column,
    "branch_imperfect": imperfect_column,
    "branch_damping": damped_column,
    "branch_umbrella": umbrella,
    "branch_spring": spring_column,
}


if __name__ == "__main__":
    scenes, folder = Path(sys.argv[1]), Path(sys.argv[2])
    for name, draw in FIGURES.items():
        with matplotlib.rc_context(STYLE):
            figure = draw(scenes)
            file = folder / f"{name}.svg"
            figure.savefig(file, metadata={"Date": None, "Creator": None})
            print(file)
