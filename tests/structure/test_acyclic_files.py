"""The contract that files import one another in no circle."""

from __future__ import annotations

import grimp
import pytest

from tests.structure.acyclic_files import AcyclicFiles, circles


@pytest.mark.parametrize(
    ("imports", "found"),
    [
        ("a>b b>c", []),
        ("a>b b>a", [["a", "b"]]),
        ("a>b b>c c>b c>d", [["b", "c"]]),
        ("a>b b>c c>a d>c d>e e>d", [["a", "b", "c"], ["d", "e"]]),
    ],
)
def test_every_knot_has_a_circle_that_is_found(imports: str, found: list[list[str]]) -> None:
    pairs = [pair.split(">") for pair in imports.split()]
    of = {name: {b for a, b in pairs if a == name} for pair in pairs for name in pair}
    assert list(circles(of)) == found


def test_a_circle_breaks_the_contract() -> None:
    graph = grimp.ImportGraph()
    contract = AcyclicFiles("", {}, {"type": "acyclic_files"})
    graph.add_import(importer="house.low", imported="house.room.high")
    assert contract.check(graph, verbose=False).kept
    graph.add_import(importer="house.room.high", imported="house.low")
    assert not contract.check(graph, verbose=False).kept
