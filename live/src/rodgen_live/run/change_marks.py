"""Marks of what was done to a run, and when: for its record, and on its time line."""

from __future__ import annotations

from typing import NamedTuple

MOST = 200


class ChangeMark(NamedTuple):
    """A change or a kick, in words, and when it acted [s]."""

    t: float
    what: str

    def __str__(self) -> str:
        return f"{self.what} at t = {self.t:.6g} s"


class ChangeMarks:
    """The changes and kicks since the start, in order; of too many, the first ones and the last."""

    def __init__(self) -> None:
        self.every: tuple[ChangeMark, ...] = ()

    def note(self, t: float, what: str) -> None:
        """Add a change ("name = value") or a kick; changes of one name in a row count as one."""
        name, is_change, _ = what.partition(" = ")
        kept = self.every
        if is_change and kept and kept[-1].what.startswith(f"{name} = "):
            kept = kept[:-1]
        self.every = (*kept[: MOST - 1], ChangeMark(t, what))

    def drop_from(self, mark: ChangeMark) -> None:
        """Drop a mark, and those after it."""
        kept = self.every[: self.every.index(mark)] if mark in self.every else self.every
        self.every = tuple(one for one in kept if one.t <= mark.t)
