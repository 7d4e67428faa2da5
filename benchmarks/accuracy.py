"""Largest relative errors of the accelerations against 50-digit arithmetic."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import exact
import numpy as np
from problem import LOADS, Vector, built, packed, state
from report import Report

Right = Callable[[ModuleType, Vector, Vector], Vector]


def one(module: ModuleType, y: Vector, p: Vector) -> Vector:
    """A call."""
    dy: Vector = module.rhs(0.0, y, p)
    return dy


def several(module: ModuleType, y: Vector, p: Vector) -> Vector:
    """One state of a batch."""
    dy: Vector = module.rhs_batch(0.0, np.array([y, y]), p)[1]
    return dy


# The dense form first: the others are held against it.
WAYS: tuple[tuple[str, dict[str, str], Right], ...] = (
    ("dense NumPy", {"form": "dense"}, one),
    ("NumPy", {}, one),
    ("C", {"target": "c"}, one),
    ("C, rhs_batch", {"target": "c"}, several),
)


def accuracy(report: Report, links: int = 200) -> None:
    """Straight, bent and coiled rods."""
    verified = exact.verified()
    report.note("50-digit O(n) against 50-digit dense form, n=20", f"{verified:.0e}")
    if not verified < 1e-40:
        raise ArithmeticError("the 50-digit reference is wrong")
    states = [
        state(links, spread, speed, seed)
        for spread, speed in ((1e-3, 1e-2), (0.1, 0.1), (3.0, 3.0))
        for seed in (1, 2, 3)
    ]
    for terms, loads in LOADS:
        truth = [exact.exact_rhs(links, terms, y) for y in states]
        dense = 0.0
        for name, how, right in WAYS:
            what = f"{name}, {loads}, n={links}"
            module = report.module(what, built, links, terms, **how)
            if module is None:
                continue
            off = _worst(module, right, states, truth)
            if not dense:
                dense = off
                report.note(what, f"{off:.1e}")
            else:
                asked = f"at most dense's {dense:.1e} and 1e-11"
                report.row(what, off, min(dense, 1e-11), f"{off:.1e}", asked)


def _worst(module: ModuleType, right: Right, states: list[Vector], truth: list[list[Any]]) -> float:
    p = packed(module)
    pairs = zip(states, truth, strict=True)
    return max(exact.error(right(module, y, p), dy) for y, dy in pairs)
