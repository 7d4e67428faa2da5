"""How Datasets of branches, boundaries, nonlinear modes and studies look, by `rodgen.shown`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from rodgen.analyse.branches import boundary
from rodgen.analyse.branches import branch_data as branches
from rodgen.analyse.curves.datasets import scene_of
from rodgen.analyse.cycles import branch_data as cycle_branches
from rodgen.analyse.cycles import nonlinear_modes
from rodgen.errors import InputError
from rodgen.integrate.endings import NO_RESULT
from rodgen.scene import Scene
from rodgen.show import dataset_tables as tables
from rodgen.show.appearance import drawn, page
from rodgen.show.branch_pictures import bifurcation_diagram, boundary_curve
from rodgen.show.cycle_pictures import amplitudes, family
from rodgen.show.result_tables import ResultTable
from rodgen.show.study_pictures import pictures_of
from rodgen.show.study_results import Results

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Curve:
    """name: of its picture; title: of the Dataset, from its attributes and the name of its scene;
    table: its numbers in words."""

    name: str
    title: str
    draw: Callable[[Any, Scene], Figure]
    table: Callable[[Any], Mapping[str, str]]


# By the attribute `format` of the Dataset.
CURVES = {
    branches.FORMAT: Curve(
        "branch",
        "Branch of {name} along {key}",
        lambda data, scene: bifurcation_diagram([data], scene),
        tables.of_branch,
    ),
    boundary.FORMAT: Curve(
        "boundary",
        "Boundary of stability of {name} over {a}, {b}",
        boundary_curve,
        tables.of_boundary,
    ),
    cycle_branches.FORMAT: Curve(
        "cycles", "Cycles of {name} along {key}", amplitudes, tables.of_cycles
    ),
    nonlinear_modes.FORMAT: Curve(
        "mode", "Nonlinear mode {mode} of {name}", family, tables.of_mode
    ),
}


def known(data: xarray.Dataset) -> bool:
    """Whether it is one that rodgen made, and whole."""
    if data.attrs.get("format") in CURVES:
        return {"point", "special"} <= set(data.dims) and "special_kind" in data
    return _is_study(data)


def _is_study(data: xarray.Dataset) -> bool:
    return "status" in data and "digest" in data.attrs


def plot(data: xarray.Dataset, picture: str | None, figure: Figure | SubFigure | None) -> Axes:
    """Draw one of its pictures; returns the first axes. Raises InputError for one it has not, and
    for other Datasets."""
    return drawn(_pictures(data), picture, figure)


def _pictures(data: xarray.Dataset) -> Mapping[str, Callable[[], Figure]]:
    if _is_study(data):
        return pictures_of(data)
    form = data.attrs.get("format")
    if form not in CURVES:
        raise InputError("data", form, f"a Dataset of one of the formats {', '.join(CURVES)}")
    curve = CURVES[form]
    return {curve.name: partial(curve.draw, data, scene_of(data))}


def line(data: xarray.Dataset) -> str:
    """What it is, in a line."""
    if not known(data):
        return "<Dataset without pictures of rodgen>"
    if _is_study(data):
        of = Results.thinned(data)
        failed = sum((of.status == one).sum() for one in NO_RESULT)
        points = f"{data['status'].size} points of {', '.join(of.axes)}"
        return f"<Results of {of.title}: {points}" + f"; {failed} failed" * bool(failed) + ">"
    title = CURVES[data.attrs["format"]].title.format(name=scene_of(data).name, **data.attrs)
    kinds = Counter(map(tables.named, data["special_kind"].values))
    special = ", ".join(f"{kind} ({count})" for kind, count in kinds.items())
    return f"<{title}: {data.sizes['point']} points" + f"; special: {special}" * bool(special) + ">"


def html(data: xarray.Dataset) -> str:
    """Its first picture, its table, and below them the Dataset as xarray shows it, to be opened."""
    inside: str = data._repr_html_()
    if not known(data):
        return inside
    table: Mapping[str, str] | ResultTable
    table = (tables.of_study if _is_study(data) else CURVES[data.attrs["format"]].table)(data)
    folded = f"<details><summary>xarray.Dataset</summary>{inside}</details>"
    return page(line(data), next(iter(_pictures(data).values()), None), table) + folded
