"""Which of a kind of quantities: numbers in a text."""

from __future__ import annotations

import pytest

from rodgen.live.page.names import which
from rodgen.scene import SceneError


@pytest.mark.parametrize(
    ("text", "numbers"),
    [("all", []), ("3", [3]), (" 0, 5-7 ", [0, 5, 6, 7]), ("2,2,1", [2, 1]), ("19-19", [19])],
)
def test_numbers_and_stretches(text: str, numbers: list[int]) -> None:
    assert which(text, list(range(20)), several=True) == numbers


@pytest.mark.parametrize(
    "text", ["", "-1", "20", "9-5", "0-99999999", "1e3", "all, 3", "0-20", "²"]
)
def test_others_are_refused(text: str) -> None:
    with pytest.raises(SceneError, match="of 0 to 19: such as 0, 5-9, or all"):
        which(text, list(range(20)), several=True)


def test_one_is_asked_for_where_one_is_shown() -> None:
    assert which("4", list(range(20)), several=False) == [4]
    for text in ("all", "1, 2"):
        with pytest.raises(SceneError, match="one of 0 to 19"):
            which(text, list(range(20)), several=False)
