"""The page of quantities, from their rows in the vocabulary."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rodgen.model.quantities import (
    ADDED,
    CONTACTS,
    DATASET,
    FILE,
    FORCES,
    IN_AIR,
    JOINT_CONTACTS,
    LOADS,
    POWERS,
    QUANTITIES,
    SHOWN,
    WORKS,
    Quantity,
)

if TYPE_CHECKING:
    from sphinx.application import Sphinx

PAGE, MARK = "reference/quantities", "<!-- quantities -->"
SIZES = {"link": "n", "supported": "n", "joint": "n + 1", "axis": "2", "principal": "2"}
SIZES |= {"spring": "springs", "section": "sections"}
ONE_FOR_EACH = {
    WORKS: "load without potential",
    POWERS: "load without potential",
    FORCES: "load on joints",
    LOADS: "load that changes with time, by its parameter",
    ADDED: "state that the scene adds",
    CONTACTS: "stop and wall",
    JOINT_CONTACTS: "stop in a joint",
    IN_AIR: "point that the air pushes",
}
OF_RODS = {"translates": "free rods", "is_held": "rods that are held", "is_clamped": "clamped rods"}
KEPT = {FILE: "file, dataset", DATASET: "dataset", SHOWN: ""}


def _words(quantity: Quantity) -> str:
    unit = f" [{quantity.unit}]" if quantity.unit else ""
    if quantity.name == "{}":
        return f"one for each {ONE_FOR_EACH[quantity.each]}{unit}"
    words = quantity.words.format("a load") + unit
    each = f"; one for each {ONE_FOR_EACH[quantity.each]}" if quantity.each else ""
    only = f"; of {OF_RODS[quantity.only]}" if quantity.only else ""
    return words + each + only


def _row(quantity: Quantity) -> str:
    of = "NAME" if quantity.name == "{}" else "LOAD"
    name = quantity.name.format(of)
    sizes = [SIZES[one] for one in quantity.dimensions]
    shape = ", ".join(["T", *sizes]) if sizes else "T,"
    each = "NUMBER" if not quantity.each else of
    numbers = ", ".join(f"`{one.format(each)}`" for one in quantity.numbers)
    cells = f"`{name}`", _words(quantity), f"({shape})", numbers, KEPT[quantity.kept]
    return f"| {' | '.join(cells)} |"


def _table() -> Iterator[str]:
    yield "| `sol.values(...)` | what it is | shape | numbers | kept in |"
    yield "|---|---|---|---|---|"
    yield from map(_row, QUANTITIES)


def _fill(_: Sphinx, page: str, source: list[str]) -> None:
    """Write the table where the page has its mark."""
    if page == PAGE:
        source[0] = source[0].replace(MARK, "\n".join(_table()))


def setup(site: Sphinx) -> dict[str, bool]:
    site.connect("source-read", _fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
