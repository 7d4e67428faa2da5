"""Pictures of branches and of boundaries of stability, made for print."""

from __future__ import annotations

from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from rodgen.analyse.critical import critical_load
from rodgen.analyse.statics import Equilibrium
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.model.terms import TERMS, axis_label
from rodgen.scene import Scene
from rodgen.show.canvas import (
    CURVE,
    INK,
    LINE,
    LOG_RATIO,
    SERIES,
    SPECIAL,
    add_legend,
    add_remark,
    make_axes,
    set_title,
)
from rodgen.show.marks import (
    STABILITY,
    base_at,
    describe_marks,
    draw_by_stability,
    draw_marks,
    mark_of,
    stability_legend,
)

if TYPE_CHECKING:
    import xarray

STEEP = 5.0  # largest over least load, from which on their axis is logarithmic
WIDEST = 1e4  # largest over least damping of an axis
FLAT = 1e-9  # of the length: what moves less does not


def bifurcation_diagram(branches: list[xarray.Dataset], scene: Scene) -> Figure:
    """Bifurcation diagram: deflection of the tail over the varied number; stable states solid,
    unstable ones dashed, special points marked, named, and with their values beside them."""
    figure, (axes,) = make_axes(6.4, 4.6)
    known, named, furthest = set[int](), dict[str, str](), 0.0
    for data in branches:
        label, across = _deflection(data, "", scene)
        kinds = np.sign(data["unstable"].values)
        draw_by_stability(axes, data["value"].values, across, kinds[:-1])
        known |= set(kinds.tolist())
        furthest = max(furthest, float(np.ptp(across)))
        if not data.sizes["special"]:
            continue
        points = (data["special_value"].values, _deflection(data, "special_", scene)[1])
        for kind, value, y in zip(data["special_kind"].values, *points, strict=True):
            mark, name = mark_of(kind)
            named[name] = mark
            axes.plot(value, y, mark, color=SPECIAL, markersize=5)
            beside: dict[str, Any] = {
                "textcoords": "offset points",
            }
            axes.annotate(f"{value:.6g}", (value, y), (4, 5), **beside)
    if furthest < FLAT * scene.rod.length:
        axes.set_ylim(-0.05, 0.05)
    axes.set(xlabel=axis_label(branches[0].attrs["key"]), ylabel=label)
    set_title(figure, f"{scene.name}: equilibria")
    handles = stability_legend(known, CURVE)
    for name, mark in named.items():
        handles.append(Line2D([], [], linestyle="", marker=mark, color=SPECIAL, label=name))
    add_legend(figure, handles)
    return figure


def _deflection(data: xarray.Dataset, prefix: str, scene: Scene) -> tuple[str, Array]:
    """Return the ordinate of the states of a branch: its label, and its values (points,)."""
    phi, tip = data[f"{prefix}phi"].values, data[f"{prefix}tip"].values
    if scene.boundary_condition.translates and not scene.anchors.support_points:
        return "angle of the tail against the nose [rad]", phi[:, -1] - phi[:, 0]
    if not scene.boundary_condition.is_clamped:
        return "y of the tail [m]", tip[:, 1]
    start, angle = base_at(scene, data.attrs["t"])
    across = (tip - start) @ [-np.sin(angle), np.cos(angle)]
    return "tail across the line of the clamp [m]", across


def equilibrium_shapes(found: list[Equilibrium], scene: Scene) -> Figure:
    """Rod in all equilibria that were found: stable ones solid, unstable ones dashed."""
    figure, (axes,) = make_axes(5.6, 5.2)
    kinds = [-1 if one.stable is None else int(not one.stable) for one in found]
    for one, kind, colour in zip(found, kinds, cycle(SERIES), strict=False):
        style = STABILITY[kind][0]
        axes.plot(*one.joints.T, color=colour, linestyle=style, linewidth=LINE)
        draw_marks(axes, scene, one.joints, colour, t=one.t)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    add_remark(axes, describe_marks(scene))
    set_title(figure, f"{scene.name}: {len(found)} equilibria")
    handles = stability_legend(kinds, INK)
    add_legend(figure, handles)
    return figure


def boundary_curve(data: xarray.Dataset, scene: Scene) -> Figure:
    """Boundary of stability, the first number over the second (a damping is the abscissa), and the
    frequency along it. Where damping vanishes, its limit is marked beside the undamped onset."""
    names = [data.attrs["a"], data.attrs["b"]]
    values = [data[name].values for name in ("a", "b")]
    up = 0 if not _is_damping(names[0]) else 1  # a load stands upright, damping lies
    y, x, frequency = values[up], values[1 - up], data["frequency"].values
    figure, (upper, lower) = make_axes(6.4, 5.2, 2, sharex=True, height_ratios=(2, 1))
    upper.plot(x, y, color=CURVE, linewidth=LINE)
    places = [data[f"special_{name}"].values for name in ("a", "b")]
    for kind, *place in zip(data["special_kind"].values, *places, strict=True):
        upper.plot(place[1 - up], place[up], "s", color=SPECIAL, markersize=5)
        inside = place[1 - up] > x.max() / 2  # of the right edge
        beside: dict[str, Any]
        beside = {"ha": "right", "xytext": (-8, 0)} if inside else {"xytext": (8, -8)}
        beside |= {"textcoords": "offset points", "va": "center"}
        upper.annotate(kind, (place[1 - up], place[up]), **beside)
    lower.plot(x, frequency, color=CURVE, linewidth=LINE)
    positive = x[x > 0]
    if _is_damping(names[1 - up]) and len(positive) and positive.max() > LOG_RATIO * positive.min():
        least = max(float(positive.min()), float(positive.max()) / WIDEST)
        upper.set_xscale("symlog", linthresh=least, linscale=0.6)
        powers = 10.0 ** np.arange(np.ceil(np.log10(least)), np.ceil(np.log10(positive.max())) + 1)
        upper.set_xticks([0.0, *powers], minor=False)
        upper.set_xticks([], minor=True)
        upper.set_xlim(-0.3 * least, 2 * float(positive.max()))
    if (x == 0).any() and _is_damping(names[1 - up]):
        at = int(np.argmax(x == 0))
        unit = axis_label(names[up]).partition("[")[2].rstrip("]")
        label = f"limit of no damping: {y[at]:.6g} {unit}"
        upper.plot(0.0, y[at], "o", markerfacecolor="white", color=SPECIAL, label=label)
        without = _undamped_onset(scene, names[up])
        if without is not None:
            label = f"without damping: {without:.6g} {unit}"
            upper.plot(0.0, without, "o", color=SPECIAL, label=label)
        upper.legend()
    if y.min() > 0:
        if y.max() > STEEP * y.min():  # or all but its end would lie along the lower edge
            upper.set_yscale("log")
            upper.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            upper.yaxis.set_major_formatter("{x:g}")
            upper.yaxis.set_minor_formatter(NullFormatter())
        else:
            upper.set_ylim(bottom=0.0)
    upper.set(ylabel=axis_label(names[up]))
    set_title(figure, f"{scene.name}: {data.attrs['kind']} begins at the boundary")
    lower.set(xlabel=axis_label(names[1 - up]), ylabel="frequency [Hz]")
    return figure


def _is_damping(key: str) -> bool:
    """Whether a key is that of a damping."""
    return any(
        term.is_damping and key.startswith(f"loads.{term.table}.") for term in TERMS.values()
    )


def _undamped_onset(scene: Scene, key: str) -> float | None:
    """Return the critical value of a load in the scene without its damping, if it has any."""
    damping = [TERMS[name].table for name in scene.loads.terms if TERMS[name].is_damping]
    if not damping:
        return None
    load = key.removeprefix("loads.").partition(".")[0]
    try:
        undamped = scene.replace({f"loads.{one}": None for one in damping})
        return critical_load(undamped, load=load).value
    except (AnalysisError, InputError):
        return None
