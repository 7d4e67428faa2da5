"""Pictures of branches and of boundaries of stability, made for print."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rodgen.integrate.stepper import Array
from rodgen.scene import Scene
from rodgen.show.pictures import LINE, canvas

if TYPE_CHECKING:
    import xarray

Style = Literal["-", "--", ":"]
NAMES = {"branch": "branch point", "fold": "fold", "hopf": "Hopf point"}
MARKS = {"branch": "s", "fold": "D", "hopf": "o"}
FLAT = 1e-9  # of the length: what moves less does not
STYLES: dict[int, Style] = {1: "--", 0: "-", -1: ":"}  # unstable, stable, not known


def bifurcation_diagram(branches: list[xarray.Dataset], scene: Scene) -> Figure:
    """How far the tail is moved across the straight rod against the number that is varied: stable
    states solid, unstable ones dashed, special points marked and named."""
    figure = canvas(6.4, 4.6)
    axes = figure.add_subplot()
    kinds: dict[str, None] = {}
    for data in branches:
        across = _across(data, "", scene)
        values = data["value"].values
        for where, rows in _runs(data["unstable"].values):
            line = Line2D(values[rows], across[rows], linestyle=STYLES[where], linewidth=LINE)
            axes.add_line(line)
        if data.sizes["special"]:
            kind_of, value_of = data["special_kind"].values, data["special_value"].values
            points = zip(kind_of, value_of, _across(data, "special_", scene), strict=True)
            for kind, value, y in points:
                axes.plot(value, y, MARKS.get(kind, "x"), color="tab:red", markersize=5)
                kinds[str(kind)] = None
    axes.autoscale_view()
    _named(axes, branches, scene)
    moved = [np.ptp(_across(data, "", scene)) for data in branches]
    if max(moved) < FLAT * scene.rod.length:
        axes.set_ylim(-0.05, 0.05)
    axes.grid(alpha=0.3)
    axes.set(
        xlabel=branches[0].attrs["key"],
        ylabel=_ordinate(scene),
        title=f"{scene.name}: {branches[0].attrs['key']} is varied",
    )
    known = {int(number) for data in branches for number in np.sign(data["unstable"].values)}
    words = {0: "stable", 1: "unstable", -1: "stability not known"}
    handles = [
        Line2D([], [], linestyle=STYLES[at], color="tab:blue", label=words[at])
        for at in (0, 1, -1)
        if at in known
    ]
    handles += [
        Line2D(
            [], [], linestyle="", marker=MARKS.get(k, "x"), color="tab:red", label=NAMES.get(k, k)
        )
        for k in kinds
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, fontsize="small")
    return figure


def _ordinate(scene: Scene) -> str:
    if scene.hold.translates and not scene.anchors.ties:
        return "angle of the tail against the nose [rad]"
    return "tail across the straight rod [m]" if scene.hold.clamped else "y of the tail [m]"


def _across(data: xarray.Dataset, prefix: str, scene: Scene) -> Array:
    """What is drawn of the states (points,) upwards."""
    phi, tip = data[f"{prefix}phi"].values, data[f"{prefix}tip"].values
    if scene.hold.translates and not scene.anchors.ties:
        return np.asarray(phi[:, -1] - phi[:, 0])
    angle = (scene.rod.clamp_angle or 0.0) if scene.hold.clamped else 0.0
    return np.asarray(tip @ [-np.sin(angle), np.cos(angle)])


def _runs(unstable: Array) -> list[tuple[int, slice]]:
    """Stretches of stable, unstable and unknown points; each goes on to the first of the next."""
    signs = np.sign(unstable)
    ends = [0, *(np.flatnonzero(np.diff(signs)) + 1).tolist(), len(signs)]
    return [(int(signs[a]), slice(a, b + 1)) for a, b in pairwise(ends)]


def _named(axes: Axes, branches: list[xarray.Dataset], scene: Scene) -> None:
    """Values beside the special points."""
    for data in branches:
        if not data.sizes["special"]:
            continue
        moved = _across(data, "special_", scene)
        for value, y in zip(data["special_value"].values, moved, strict=True):
            axes.annotate(
                f"{value:.6g}", (value, y), (4, 5), textcoords="offset points", fontsize="x-small"
            )
