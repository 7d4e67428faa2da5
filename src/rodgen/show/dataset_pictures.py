"""Pictures and tables of Datasets: branches, boundaries, nonlinear modes, studies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from numpy.typing import NDArray

from rodgen.analyse.branches import equilibrium_data as branches
from rodgen.analyse.branches import stability_boundary
from rodgen.analyse.curves.curve_datasets import CurveFormat, scene_of
from rodgen.analyse.cycles import cycle_data as cycle_branches
from rodgen.analyse.cycles import nonlinear_modes
from rodgen.dataset_result import PREFIX, known_or_none
from rodgen.errors import InputError
from rodgen.result import ResultTable, Row, format_value
from rodgen.scene import Scene
from rodgen.show.appearance import compose_html, draw_picture
from rodgen.show.branch_pictures import bifurcation_diagram, boundary_curve
from rodgen.show.cycle_pictures import cycle_branch_diagram, frequency_energy_plot
from rodgen.show.marks import mark_of
from rodgen.show.study_pictures import pictures_of
from rodgen.show.study_results import StudyResults

if TYPE_CHECKING:
    import xarray


class CurveDisplay(NamedTuple):
    """Presentation of the Dataset of a curve. name: of its picture; title: format of the Dataset's
    attributes and the name of its scene; draw: makes the picture."""

    format: CurveFormat
    name: str
    title: str
    draw: Callable[[Any, Scene], Figure]


DISPLAYS = (
    CurveDisplay(
        branches.FORMAT,
        "branch",
        "Branch of {name} along {key}",
        lambda data, scene: bifurcation_diagram([data], scene),
    ),
    CurveDisplay(
        stability_boundary.FORMAT,
        "boundary",
        "Boundary of stability of {name} over {a}, {b}",
        boundary_curve,
    ),
    CurveDisplay(
        cycle_branches.FORMAT, "cycles", "Cycles of {name} along {key}", cycle_branch_diagram
    ),
    CurveDisplay(
        nonlinear_modes.FORMAT, "mode", "Nonlinear mode {mode} of {name}", frequency_energy_plot
    ),
)
DISPLAY_OF = {one.format.name: one for one in DISPLAYS}  # by the attribute `format` of the Dataset


def is_known(data: xarray.Dataset) -> bool:
    """Whether a Dataset was made by rodgen, and is whole."""
    if data.attrs.get("format") in DISPLAY_OF:
        return {"point", "special"} <= set(data.dims) and "special_kind" in data
    return _is_study(data)


def _is_study(data: xarray.Dataset) -> bool:
    return "status" in data and "digest" in data.attrs


def plot(data: xarray.Dataset, picture: str | None, figure: Figure | SubFigure | None) -> Axes:
    """Draw a picture of a Dataset; returns the first axes. Raises InputError for a picture that it
    does not have, and for other Datasets."""
    return draw_picture(_pictures(data), picture, figure)


def _pictures(data: xarray.Dataset) -> Mapping[str, Callable[[], Figure]]:
    if _is_study(data):
        return pictures_of(data)
    form = data.attrs.get("format")
    if form not in DISPLAY_OF:
        raise InputError("data", form, f"a Dataset of one of the formats {', '.join(DISPLAY_OF)}")
    curve = DISPLAY_OF[form]
    return {curve.name: partial(curve.draw, data, scene_of(data))}


def figure_of(data: xarray.Dataset) -> Figure:
    """Draw the first picture of a Dataset into a figure of its own."""
    return next(iter(_pictures(data).values()))()


def describe(data: xarray.Dataset) -> str:
    """Describe the Dataset in a line."""
    if not is_known(data):
        return "<Dataset without pictures of rodgen>"
    if _is_study(data):
        of = StudyResults.subsample(data)
        failed = of.failures.sum()
        points = f"{data['status'].size} points of {', '.join(of.axes)}"
        seen = f"; seen: {of.share}" * bool(of.share)
        return f"<Results of {of.title}: {points}{seen}" + f"; {failed} failed" * bool(failed) + ">"
    title = DISPLAY_OF[data.attrs["format"]].title.format(name=scene_of(data).name, **data.attrs)
    kinds = Counter(mark_of(kind)[1] for kind in data["special_kind"].values)
    special = ", ".join(f"{kind} ({count})" for kind, count in kinds.items())
    return f"<{title}: {data.sizes['point']} points" + f"; special: {special}" * bool(special) + ">"


def html(data: xarray.Dataset) -> str:
    """Return HTML: its first picture, its table and, folded, the Dataset as xarray shows it."""
    inside: str = data._repr_html_()
    if not is_known(data):
        return inside
    folded = f"<details><summary>xarray.Dataset</summary>{inside}</details>"
    draw = next(iter(_pictures(data).values()), None)
    return compose_html(describe(data), draw, tables(data), data.rodgen.notes) + folded


def tables(data: xarray.Dataset) -> list[ResultTable]:
    """Return its table: of a curve, what changes along it and its special points; of a study, what
    was varied and what was kept."""
    if not is_known(data):
        return []
    if _is_study(data):
        return [_study_table(data)]
    rows = DISPLAY_OF[data.attrs["format"]].format.rows
    values = {"points": str(data.sizes["point"])}
    for row in rows:
        values |= _curve_rows(data, row)
    special = enumerate(_describe_special(data, rows), 1)
    values |= {f"special {number}": words for number, words in special}
    return [ResultTable.of_values(values)]


def _curve_rows(data: xarray.Dataset, row: Row) -> Iterator[tuple[str, str]]:
    """Yield the line of an attribute, or of a variable of the points: its value at both ends."""
    if not row.along and row.name in data.attrs:
        value = data.attrs[row.name]
        value = bool(value) if isinstance(value, int | np.integer) else value
        yield row.words, format_value(value, row.format, row.unit)
    elif row.name in data and data[row.name].dims == ("point",):
        values = known_or_none(data[row.name].variable)
        ends = (format_value(values[at], row.format, row.unit) for at in (0, -1))
        words = data[row.name].attrs.get("long_name", row.words)
        yield words, " at its start, ".join(ends) + " at its end"
        if row.name == "unstable":
            yield "stable", f"{values.count(0)} of {len(values)} points"


def _describe_special(data: xarray.Dataset, rows: tuple[Row, ...]) -> Iterator[str]:
    """Yield the special points in words."""
    shown = [
        row
        for row in rows
        if row.name in data
        and data[row.name].dims == ("special",)
        and row.name not in (f"{PREFIX}kind", f"{PREFIX}after")
    ]
    for at, kind in enumerate(data[f"{PREFIX}kind"].values.tolist()):
        values = [(row, data[row.name].values.tolist()[at]) for row in shown]
        said = [
            format_value(value, ".11g", row.unit) for row, value in values if value not in (0, "")
        ]
        yield f"{mark_of(kind)[1]} at {', '.join(said) or 0}"


def _study_table(data: xarray.Dataset) -> ResultTable:
    """Return a table of what was varied and kept, with bounds, and of the points that failed."""
    of = StudyResults.subsample(data)
    rows = [(name, "varied", *_bounds_text(*of.axis_values(name))) for name in of.axes]
    rows += [(of.label(name), "kept", *_bounds_text(*of.values_of(name))) for name in of.kept]
    failed = of.failures.sum()
    rows += [("points seen", "", of.share, "")] * bool(of.share)
    rows += [("points that failed", "", str(failed), "")] * bool(failed)
    return ResultTable.of_rows(("", "", "least", "largest"), rows)


def _bounds_text(values: NDArray[np.float64], classes: list[str]) -> tuple[str, str]:
    """Return the least and the largest of numbers as text; of classes, all that occur."""
    if classes:
        return ", ".join(classes), ""
    fine = values[np.isfinite(values)]
    return (f"{fine.min():.6g}", f"{fine.max():.6g}") if fine.size else ("-", "-")
