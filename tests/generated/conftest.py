"""Generated modules, each written and built once, and exact Jacobians to hold them against."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
import pytest

from rodgen.check.module import DIGITS, _parameters, assembled
from rodgen.loading import build, companions, sources
from rodgen.scene.structure import Structure


@pytest.fixture(scope="session")
def written() -> Callable[..., dict[str, str]]:
    """Texts of a structure in a target and form, by file name."""
    return cache(sources)


@pytest.fixture(scope="session")
def whole() -> Callable[[Structure], dict[str, str]]:
    """Texts of a C module in all parts that are C, and of the step loops beside it."""

    @cache
    def texts(structure: Structure) -> dict[str, str]:
        parts = ("rhs", "batch", "jac")
        return sources(structure, "c", parts=parts, steps=True) | companions("c", steps=True)

    return texts


@pytest.fixture(scope="session")
def built() -> Callable[..., ModuleType]:
    """The module of a structure in a target and form; its parts are made as they are asked for."""
    return build


class Point:
    """A module at random parameters, a time, and a state whose numbers are multiples of 2^-20."""

    def __init__(self, module: ModuleType, seed: int = 1):
        draw = np.random.default_rng(seed)
        self.module, self.t = module, 0.375
        self.values = _parameters(module, self.t, draw)
        self.p = module.parameters(**self.values)
        self.y = np.round(2.0 * draw.standard_normal(len(module.STATE)) * 2**20) / 2**20

    def exact_rhs(self, y: np.ndarray) -> list[Any]:
        """Rates by the closed form in 50 digits."""
        with mpmath.workdps(DIGITS):
            return assembled(self.module, self.values, self.t, y).rhs()

    def exact_jacobian(self) -> np.ndarray:
        """Central differences in 50 digits; with h = 2^-26 states stay exact doubles, and the
        error is h^2/6 = 4e-17 of the third derivatives."""
        size, h = len(self.y), 2.0**-26
        columns = np.empty((size, size))
        for at in range(size):
            step = np.zeros(size)
            step[at] = h
            pairs = zip(self.exact_rhs(self.y + step), self.exact_rhs(self.y - step), strict=True)
            columns[:, at] = [float((a - b) / (2 * h)) for a, b in pairs]
        return columns


@pytest.fixture
def point() -> type[Point]:
    return Point
