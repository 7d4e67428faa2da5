"""What xarray's Datasets of branches, boundaries and studies have as `data.rodgen`: the pictures,
notes and plain data that other results have."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from rodgen.display import dataset_appearance
from rodgen.result import NOTES, REMARK, Note, Result, ResultTable, Row, notes_from, plain_data

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

POINT, SPECIAL = "point", "special"  # dimensions of a curve
PREFIX = f"{SPECIAL}_"  # of variables along the second
DOUBTS, DIGEST = "doubts", "digest"  # a variable and an attribute of a study
LONG_NAME, UNITS, UNKNOWN = "long_name", "units", "unknown"  # attributes of a variable


class DatasetResult(Result):
    """What xarray's Datasets of branches, boundaries and studies have as `data.rodgen`.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("euler_column")
    >>> branch = rodgen.continue_equilibria(scene, "loads.tip.y", bounds=(0, -30))
    >>> [one["kind"] for one in branch.rodgen.to_dict()["special"]], branch.rodgen.notes
    (['branch'], ())
    """

    def __init__(self, data: xarray.Dataset):
        self._data = data

    @property
    def notes(self) -> tuple[Note, ...]:  # type: ignore[override]  # a field of other results
        """What to know about its numbers."""
        if NOTES in self._data.attrs:
            return notes_from(self._data.attrs)
        if DOUBTS not in self._data or DIGEST not in self._data.attrs:
            return ()
        counts = self._data[DOUBTS].values
        return doubtful_points(int((counts > 0).sum()), int((counts >= 0).sum()))

    def to_dict(self) -> dict[str, Any]:
        """Its variables, attributes and notes, as plain data for JSON. A curve has a list of its
        points and one of its special points; others have a list for every variable."""
        data = self._data
        values = {str(name): known_or_none(one) for name, one in data.variables.items()}
        made = _records(data, values) if {POINT, SPECIAL} <= set(data.dims) else values
        said = {
            str(name): bool(one) if name in FLAGS else plain_data(one)
            for name, one in data.attrs.items()
            if name not in OWN
        }
        return made | said | {NOTES: [note.to_dict() for note in self.notes]}

    def plot(self, picture: str | None = None, *, figure: Figure | SubFigure | None = None) -> Axes:
        """Draw it with matplotlib. Returns the axes, the first of them if there are several.

        picture: name of the picture, by default the first; the pictures of a study have the names
        of what it has kept; figure: the figure in which it is drawn, by default a new one of
        pyplot.

        InputError lists the names if there is no such picture, and refuses other Datasets.
        """
        axes: Axes = dataset_appearance().plot(self._data, picture, figure)
        return axes

    def __repr__(self) -> str:
        """What the Dataset is, in a line."""
        line: str = dataset_appearance().line(self._data)
        return line

    def tables(self) -> list[ResultTable]:
        """Its numbers in words."""
        found: list[ResultTable] = dataset_appearance().tables(self._data)
        return found

    def _repr_html_(self) -> str:
        return _dataset_html(self._data)


def doubtful_points(count: int, of: int) -> tuple[Note, ...]:
    """Return the remark on a study of whose points so many have doubts."""
    if not count:
        return ()
    return (Note(REMARK, f"{count} of {of} points have doubts: see {DOUBTS}", {"points": count}),)


# Attributes that are not among the plain data: how a file is read, and what stands there already.
OWN = {
    *("format", "rodgen", "scene", NOTES, "variables", "vary", "sample", "options", "time_limit"),
    *("token", DIGEST, "sources", "coordinates", "keep"),
}
FLAGS = {"complete", "moving", "damped", "supercritical"}  # which NetCDF has as numbers


def variables(
    rows: Iterable[Row],
    values: Mapping[str, Any],
    dims: Mapping[str, tuple[str, ...]],
    **names: str,
) -> dict[str, tuple[Any, Any, dict[str, Any]]]:
    """Return the variables of a Dataset, with what rows say of them as attributes.

    values: arrays by the names of rows; dims: of a row, beside the one along which it is; names:
    what the words of rows call by name.
    """
    return {
        row.name: (
            (row.along, *dims.get(row.name, ())),
            values[row.name],
            _attributes(row, names),
        )
        for row in rows
        if row.name in values
    }


def _attributes(row: Row, names: Mapping[str, str]) -> dict[str, Any]:
    found = {LONG_NAME: row.words.format(**names), UNITS: row.unit, UNKNOWN: row.unknown}
    return {name: value for name, value in found.items() if value not in ("", None)}


def known_or_none(variable: xarray.Variable) -> Any:
    """Return the values of a variable as plain data; None for those that are not known."""
    unknown = variable.attrs.get(UNKNOWN)
    if unknown is None:
        return plain_data(variable.values)
    values = variable.values.astype(object)
    values[variable.values == unknown] = None
    return plain_data(values)


def _records(data: xarray.Dataset, values: Mapping[str, Any]) -> dict[str, Any]:
    """The points of a curve and its special points, each with all that is known of it."""
    made: dict[str, Any] = {}
    for along, key, start in ((POINT, "points", ""), (SPECIAL, SPECIAL, PREFIX)):
        names = [name for name, one in data.variables.items() if one.dims[:1] == (along,)]
        columns = {str(name).removeprefix(start): values[str(name)] for name in names}
        rows = zip(*columns.values(), strict=True)
        made[key] = [dict(zip(columns, row, strict=True)) for row in rows]
    return made


def _dataset_html(data: xarray.Dataset) -> str:
    """A picture with a table; of a Dataset that rodgen did not make, what xarray shows."""
    html: str = dataset_appearance().html(data)
    return html


@cache
def show_datasets() -> None:
    """Have xarray's Datasets the accessor `rodgen`, and those of rodgen show themselves in
    notebooks; what makes or reads them calls it."""
    import xarray  # only where it is there already: it takes long to import

    register: Any = xarray.register_dataset_accessor  # which has no types
    register("rodgen")(DatasetResult)
    show_in_notebook(xarray.Dataset)


def show_in_notebook(dataset: type) -> None:
    """Where this is a notebook, have it show Datasets with picture and table."""
    notebook = sys.modules.get("IPython")
    shell: Any = notebook and notebook.get_ipython()
    if shell:
        shell.display_formatter.formatters["text/html"].for_type(dataset, _dataset_html)
