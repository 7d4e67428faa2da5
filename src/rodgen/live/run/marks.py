"""What was done to a run, and when: for its record, and as marks on its time line."""

from __future__ import annotations

from typing import NamedTuple

MOST = 200


class Mark(NamedTuple):
    """A change or a kick, in words, and when it acted [s]."""

    t: float
    what: str

    def __str__(self) -> str:
        return f"{self.what} at t = {self.t:.6g} s"


class Marks:
    """The changes and kicks since the start, in their order: the first ones, and the last."""

    def __init__(self) -> None:
        self.every: tuple[Mark, ...] = ()

    def note(self, t: float, what: str) -> None:
        """Note a change ("name = value") or a kick; of a slider that is dragged, the last value."""
        name, is_change, _ = what.partition(" = ")
        kept = self.every
        if is_change and kept and kept[-1].what.startswith(f"{name} = "):
            kept = kept[:-1]
        self.every = (*kept[: MOST - 1], Mark(t, what))

    def back_to(self, mark: Mark) -> None:
        """Forget a mark, and those after it."""
        kept = self.every[: self.every.index(mark)] if mark in self.every else self.every
        self.every = tuple(one for one in kept if one.t <= mark.t)
