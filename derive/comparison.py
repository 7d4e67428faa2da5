"""Comparisons, of which proofs consist, and the error where one does not hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

EXPLICIT = "explicit n"
ANY_N = "any n"
POINTS = "rational points"
JOINTS = "joint forces"


class DisagreementError(ArithmeticError):
    """Two derivations differ in an entry."""

    def __init__(self, how: str, entry: str, derived: object, closed: object):
        self.how, self.entry, self.derived, self.closed = how, entry, derived, closed
        super().__init__(f"{entry} ({how}): derived {derived}, closed form {closed}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.how, self.entry, self.derived, self.closed)


@dataclass(frozen=True)
class Comparison:
    """A comparison that held: symbol of the matrix or load, how, and number of entries."""

    name: str
    how: str
    entries: int
