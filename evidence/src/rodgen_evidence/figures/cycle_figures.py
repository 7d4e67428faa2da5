"""Picture of docs/tip-mass.md: cycles on both sides of a Hopf point, and what turns it.

python -m rodgen_evidence.figures.cycle_figures SCENES FOLDER
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import rodgen
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.hopf import first_hopf
from rodgen.system import ParameterRange, System
from rodgen_evidence.figures.model_figures import STYLE
from rodgen_evidence.figures.model_parts import FORCE, GUIDE
from rodgen_evidence.figures.rocket_figures import sheet
from rodgen_evidence.galerkin import Array, FlutterOnset, GalerkinColumn, bare, polynomials

KEY, DAMPING = "loads.follower.force", "foundation.damping"
MASS = 0.3
LINKS = 20  # of the rods whose normal form is drawn
LITTLE, MUCH = 20.0, 70.0  # external damping of the two branches; the second is the scene's
FEW = "c = 1, in 2 shapes"
EXTERNAL = np.geomspace(0.1, 100.0, 49)
INERTIA = np.geomspace(0.003, 2.0, 41)
SHARES = (-0.6, 0.8)
Numbers = tuple[float, float, float, float]


def rod(scene: rodgen.Scene, links: int, column: GalerkinColumn) -> rodgen.Scene:
    """The rod of the scene with so many links and the numbers of a column."""
    table: dict[str, Any] = scene.model_dump(exclude_none=True)
    stiffness = [*[1.0] * (links - 1), 2 / 3, 1.0]
    table["rod"] |= {"links": links, "bending_stiffness": stiffness}
    table["bodies"][0] |= {"mass": column.mass, "inertia": column.inertia}
    table["foundation"] |= {"damping": column.external}
    table["loads"]["material_damping"]["time"] = column.internal
    return rodgen.Scene.from_dict(table)


def onset(scene: rodgen.Scene, ends: tuple[float, float] = (0.5, 60.0)) -> FlutterOnset:
    """The first Hopf point of a scene along its thrust, by rodgen's normal form."""
    search = CycleSearch.of(System(scene))
    hopf, _ = first_hopf(search, ParameterRange(search.system, KEY, ends))
    turn = -hopf.coefficient.real / hopf.slope.real
    return FlutterOnset(hopf.value, hopf.frequency, turn)


def tip_mass(scenes: Path) -> Figure:
    """Branches of cycles, and the share of the force that they need beyond flutter, against
    external damping and against the moment of inertia."""
    scene = rodgen.Scene.from_toml(scenes / "tip_mass.toml")
    figure, (cycles, damped, turning) = sheet(8.4, 3)
    for damping, ends, colour in ((LITTLE, (8.0, 20.0), GUIDE), (MUCH, (30.0, 45.0), FORCE)):
        branch = rodgen.continue_cycles(scene.replace({DAMPING: damping}), KEY, ends)
        _branch(cycles, branch, f"c = {damping:g}", colour)
    cycles.set(xlabel="thrust $P L^2/EI$", ylabel="amplitude of the angles [rad]")
    cycles.legend()
    for c, tau, colour in ((1.0, 0.001, GUIDE), (MUCH, 0.01, FORCE)):
        of_inertia = partial(_numbers, external=c, internal=tau)
        _turns(turning, scene, INERTIA, of_inertia, colour, f"c = {c:g}")
    _turns(damped, scene, EXTERNAL, lambda c: (MASS, 0.1, c, 0.01), FORCE, "")
    few = [GalerkinColumn(bare(2), *_numbers(b, 1.0, 0.001)).onset() for b in INERTIA]
    turning.plot(INERTIA, [*map(_share, few)], "--", color=GUIDE, label=FEW)
    damped.set(xlabel=r"external damping $c L^2/\sqrt{mEI}$", ylabel="turn / critical force")
    turning.set(xlabel=r"moment of inertia $J/mL^3$")
    for axes in (damped, turning):
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.set(xscale="log", ylim=SHARES)
    turning.legend(loc="lower left")
    return figure


def _numbers(inertia: float, external: float, internal: float) -> Numbers:
    return MASS, inertia, external, internal


def _branch(axes: Axes, data: xarray.Dataset, label: str, colour: str) -> None:
    force, height = data["value"].values, data["amplitude"].values
    stable = data["unstable"].values == 0
    for one, two in pairwise(range(len(force))):
        line = "-" if stable[one] and stable[two] else "--"
        part = slice(one, two + 1)
        axes.plot(force[part], height[part], line, color=colour)
    axes.plot(data["special_value"].values[0], 0.0, "o", color=colour, markersize=4, label=label)


def _turns(
    axes: Axes,
    scene: rodgen.Scene,
    values: Array,
    numbers: Callable[[float], Numbers],
    colour: str,
    label: str,
) -> None:
    """The turn of the column (a line) and of rods (dots) along one number."""
    columns = [GalerkinColumn(polynomials(8), *numbers(value)) for value in values]
    axes.plot(values, [_share(one.onset()) for one in columns], color=colour, label=label)
    some = slice(None, None, 4)
    dots = [_share(onset(rod(scene, LINKS, one))) for one in columns[some]]
    axes.plot(values[some], dots, "o", color=colour, markersize=3.5)


def _share(found: FlutterOnset) -> float:
    """The turn as a share of the force; none where another oscillation is first, which turns far
    more."""
    share = found.turn / found.force
    return share if share < SHARES[1] else np.nan


FIGURES = {"tip_mass": tip_mass}


if __name__ == "__main__":
    scenes, folder = Path(sys.argv[1]), Path(sys.argv[2])
    for name, draw in FIGURES.items():
        with matplotlib.rc_context(STYLE):
            figure = draw(scenes)
            file = folder / f"{name}.svg"
            figure.savefig(file, metadata={"Date": None, "Creator": None})
            print(file)
