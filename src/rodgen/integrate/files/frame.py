"""Solutions as pandas' tables, one row a sample."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rodgen.integrate.solution import Solution
from rodgen.model.quantities import FORCES, QUANTITIES, SHOWN, Index, Quantity, numbers

if TYPE_CHECKING:
    import pandas


def to_pandas(solution: Solution) -> pandas.DataFrame:
    """All that a Dataset holds and added states, a column a number, with units as an attribute."""
    import pandas  # only where it is needed: it takes long to import

    columns, units = {}, {}
    for quantity in QUANTITIES:
        if quantity.kept == SHOWN:
            continue
        for name, _ in solution.names(quantity):
            values = solution.values(name)
            for number, at in _numbers(solution, quantity, name):
                columns[number] = values[(slice(None), *at)]
                units[number] = quantity.unit
    for back, name in enumerate(reversed(solution.added), start=1):
        columns[name] = solution.y[:, -back]
        units[name] = ""
    frame = pandas.DataFrame(columns, pandas.Index(solution.t, name="t"))
    frame.attrs["units"] = {"t": "s", **units}
    return frame


def _numbers(solution: Solution, quantity: Quantity, name: str) -> Iterator[tuple[str, Index]]:
    """Single numbers of a quantity, by their names and where they are beside the time."""
    links = solution.scene.rod.links
    if quantity.each == FORCES:
        for joint in range(links + 1):
            yield from ((f"{name}_{joint}_{axis}", (joint, k)) for k, axis in enumerate("xy"))
    elif quantity.each:
        yield name, ()
    else:
        yield from ((one.name, one.at) for one in numbers(quantity, solution.hold, links))
