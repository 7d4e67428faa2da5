"""Floating-point and 50-digit numbers under one set of names."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from mpmath import mp, mpf

DIGITS = 80  # of sums and differences: a step of 1e-30 leaves 50 digits
Vector = list[Any]


@dataclass(frozen=True)
class NumberKind:
    """of: a number of this kind from a float; the functions that a rod needs of it."""

    of: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    sin: Callable[[Any], Any]
    sqrt: Callable[[Any], Any]


FLOAT = NumberKind(float, math.cos, math.sin, math.sqrt)
FIFTY = NumberKind(mpf, mp.cos, mp.sin, mp.sqrt)


def solve(A: Sequence[Sequence[Any]], b: Sequence[Any]) -> Vector:
    """Solve A x = b by elimination with row pivots. Raises ZeroDivisionError."""
    rows = [[*row, value] for row, value in zip(A, b, strict=True)]
    size = len(rows)
    for k in range(size):
        best = max(range(k, size), key=lambda i: abs(rows[i][k]))
        rows[k], rows[best] = rows[best], rows[k]
        head = rows[k]
        for i in range(k + 1, size):
            if rows[i][k]:
                share = rows[i][k] / head[k]
                rows[i] = [0] * (k + 1) + [
                    a - share * c for a, c in zip(rows[i][k + 1 :], head[k + 1 :], strict=True)
                ]
    x: Vector = [0] * size
    for k in reversed(range(size)):
        rest = sum(rows[k][j] * x[j] for j in range(k + 1, size))
        x[k] = (rows[k][size] - rest) / rows[k][k]
    return x
