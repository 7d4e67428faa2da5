"""How Datasets of branches, boundaries, nonlinear modes and studies look, by `rodgen.display`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from numpy.typing import NDArray

from rodgen.analyse.branches import boundary
from rodgen.analyse.branches import branch_data as branches
from rodgen.analyse.curves.datasets import scene_of
from rodgen.analyse.cycles import branch_data as cycle_branches
from rodgen.analyse.cycles import nonlinear_modes
from rodgen.dataset_result import PREFIX, known_or_none
from rodgen.errors import InputError
from rodgen.integrate.endings import NO_RESULT
from rodgen.result import ResultTable, Row, text_of
from rodgen.scene import Scene
from rodgen.show.appearance import drawn, page
from rodgen.show.branch_pictures import bifurcation_diagram, boundary_curve
from rodgen.show.cycle_pictures import amplitudes, family
from rodgen.show.study_pictures import pictures_of
from rodgen.show.study_results import Results

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Curve:
    """name: of its picture; title: of the Dataset, from its attributes and the name of its scene;
    rows: what it has."""

    name: str
    title: str
    draw: Callable[[Any, Scene], Figure]
    rows: tuple[Row, ...]


# By the attribute `format` of the Dataset.
CURVES = {
    branches.FORMAT: Curve(
        "branch",
        "Branch of {name} along {key}",
        lambda data, scene: bifurcation_diagram([data], scene),
        branches.ROWS,
    ),
    boundary.FORMAT: Curve(
        "boundary",
        "Boundary of stability of {name} over {a}, {b}",
        boundary_curve,
        boundary.ROWS,
    ),
    cycle_branches.FORMAT: Curve(
        "cycles", "Cycles of {name} along {key}", amplitudes, cycle_branches.ROWS
    ),
    nonlinear_modes.FORMAT: Curve(
        "mode", "Nonlinear mode {mode} of {name}", family, nonlinear_modes.ROWS
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
    kinds = Counter(map(_named, data["special_kind"].values))
    special = ", ".join(f"{kind} ({count})" for kind, count in kinds.items())
    return f"<{title}: {data.sizes['point']} points" + f"; special: {special}" * bool(special) + ">"


def html(data: xarray.Dataset) -> str:
    """Its first picture, its table, and below them the Dataset as xarray shows it, to be opened."""
    inside: str = data._repr_html_()
    if not known(data):
        return inside
    folded = f"<details><summary>xarray.Dataset</summary>{inside}</details>"
    draw = next(iter(_pictures(data).values()), None)
    return page(line(data), draw, tables(data), data.rodgen.notes) + folded


def tables(data: xarray.Dataset) -> list[ResultTable]:
    """Return its numbers in words: of a curve what changes along it and its special points, of a
    study what was varied and what was kept."""
    if not known(data):
        return []
    if _is_study(data):
        return [_of_study(data)]
    rows = CURVES[data.attrs["format"]].rows
    values = {"points": str(data.sizes["point"])}
    for row in rows:
        values |= _of_curve(data, row)
    special = enumerate(_special(data, rows), 1)
    values |= {f"special {number}": words for number, words in special}
    return [ResultTable.of_values(values)]


def _of_curve(data: xarray.Dataset, row: Row) -> Iterator[tuple[str, str]]:
    """A line on an attribute, or on a number of every point: its ends."""
    if not row.along and row.name in data.attrs:
        value = data.attrs[row.name]
        value = bool(value) if isinstance(value, int | np.integer) else value
        yield row.words, text_of(value, row.format, row.unit)
    elif row.name in data and data[row.name].dims == ("point",):
        values = known_or_none(data[row.name].variable)
        ends = (text_of(values[at], row.format, row.unit) for at in (0, -1))
        words = data[row.name].attrs.get("long_name", row.words)
        yield words, " at its start, ".join(ends) + " at its end"
        if row.name == "unstable":
            yield "stable", f"{values.count(0)} of {len(values)} points"


def _special(data: xarray.Dataset, rows: tuple[Row, ...]) -> Iterator[str]:
    """The special points in words."""
    shown = [
        row
        for row in rows
        if row.name in data
        and data[row.name].dims == ("special",)
        and row.name not in (f"{PREFIX}kind", f"{PREFIX}after")
    ]
    for at, kind in enumerate(data[f"{PREFIX}kind"].values.tolist()):
        values = [(row, data[row.name].values.tolist()[at]) for row in shown]
        said = [text_of(value, ".11g", row.unit) for row, value in values if value not in (0, "")]
        yield f"{_named(kind)} at {', '.join(said) or 0}"


def _named(kind: str) -> str:
    """A kind of special point in words."""
    points = {"hopf": "Hopf point", "branch": "branch point"}
    return points.get(str(kind), str(kind))


def _of_study(data: xarray.Dataset) -> ResultTable:
    """What was varied and what was kept, each with its ends, and the points that failed."""
    of = Results.thinned(data)
    rows = [(name, "varied", *_ends(*of.along(name))) for name in of.axes]
    rows += [(of.label(name), "kept", *_ends(*of.numbers(name))) for name in of.kept]
    failed = np.count_nonzero(np.isin(of.status, NO_RESULT))
    rows += [("points that failed", "", str(failed), "")] * bool(failed)
    return ResultTable.of_rows(("", "", "least", "largest"), rows)


def _ends(values: NDArray[np.float64], classes: list[str]) -> tuple[str, str]:
    """The least and the largest of numbers; of what is text or yes and no, all that is met."""
    if classes:
        return ", ".join(classes), ""
    fine = values[np.isfinite(values)]
    return (f"{fine.min():.6g}", f"{fine.max():.6g}") if fine.size else ("-", "-")
