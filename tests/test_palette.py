"""The choice of cases leaves no pair of values out."""

from __future__ import annotations

from itertools import combinations, product

from tests.palette import ALL, covering


def test_every_pair_of_values_is_covered() -> None:
    rows = [*product(range(4), "ab", [(), ALL], range(3))]
    chosen = covering(rows)
    pairs = {pair for row in rows for pair in combinations(enumerate(row), 2)}
    assert {pair for row in chosen for pair in combinations(enumerate(row), 2)} == pairs
    assert len(chosen) < len(rows) / 2
    assert {row[2] for row in covering(rows, strength=1)} == {(), ALL}
    assert len(covering(rows, strength=1)) == 4
