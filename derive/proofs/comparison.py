"""What a proof is made of: comparisons that hold, and the error where one does not."""

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
    """What was compared: the symbol of the matrix or load, how, and how many entries."""

    name: str
    how: str
    entries: int
