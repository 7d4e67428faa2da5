"""The page of results, from their rows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import rodgen
from rodgen.analyse.branches import equilibrium_data, stability_boundary
from rodgen.analyse.cycles import cycle_data as cycle_branches
from rodgen.analyse.cycles import nonlinear_modes
from rodgen.result import Row

if TYPE_CHECKING:
    from sphinx.application import Sphinx

PAGE, MARK = "reference/results", "<!-- results -->"
# What is in tables of its own, by the function that returns it.
CURVES = {
    "continue_equilibria": equilibrium_data.FORMAT.rows,
    "stability_boundary": stability_boundary.FORMAT.rows,
    "continue_cycles": cycle_branches.FORMAT.rows,
    "continue_mode": nonlinear_modes.FORMAT.rows,
}


def _unit(row: Row) -> str:
    return row.unit.format(unit="that of the load")


def _kept(row: Row) -> str:
    if row.kept is None:
        return ""
    name = f"`{row.name}(k)`" if row.kept.several else f"`{row.name}`"
    return f"**{name}**" if row.kept.usual else name


def _cells(row: Row) -> str:
    words = row.words.format("NAME", key="the number that is varied", a="first number", b="second")
    each = f"; one for each {row.along}" * bool(row.along)
    return f"| `{row.name}` | {words}{each} | {_unit(row)} | {_kept(row)} |"


def _table(rows: Sequence[Row]) -> Iterator[str]:
    yield from ("| name | what it is | unit | kept by studies |", "|---|---|---|---|")
    yield from map(_cells, rows)


def _page() -> Iterator[str]:
    results = [getattr(rodgen, name) for name in rodgen.__all__]
    kinds = [one for one in results if isinstance(one, type) and issubclass(one, rodgen.Result)]
    for kind in kinds:
        if kind.ROWS:
            yield from (f"## {kind.__name__}", "", *_table(kind.ROWS), "")
    for name, rows in CURVES.items():
        yield from (f"## Dataset of {name}", "", *_table(rows), "")


def _fill(_: Sphinx, page: str, source: list[str]) -> None:
    """Write the tables where the page has its mark."""
    if page == PAGE:
        source[0] = source[0].replace(MARK, "\n".join(_page()))


def setup(site: Sphinx) -> dict[str, bool]:
    site.connect("source-read", _fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
