"""The choice of cases leaves no pair of values out."""

from __future__ import annotations

from itertools import combinations, product

from tests.palette import ALL, covering


def test_every_pair_of_values_is_covered() -> None:
    rows = [*product(range(4), "ab", [(), ALL], range(3))]
    values = covering(rows, 1)
    assert {row[2] for row in values} == {(), ALL}
    assert len(values) == 4
    chosen = covering(rows, 2, values)
    pairs = {pair for row in rows for pair in combinations(enumerate(row), 2)}
    assert {pair for row in chosen for pair in combinations(enumerate(row), 2)} == pairs
    assert values < chosen
    assert len(chosen) < len(rows) / 2
