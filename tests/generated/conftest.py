"""Generated modules, each written and built once, and exact Jacobians to hold them against."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
import pytest

from rodgen.emit import module_files
from rodgen.emit.by_hand import ByHand
from rodgen.emit.check import DIGITS, _parameters
from rodgen.loading import load_files
from rodgen.scene.expression import Expression
from rodgen.scene.structure import Structure


@pytest.fixture(scope="session")
def written() -> Callable[..., dict[str, str]]:
    """Texts of a structure in a target and form, by file name."""

    @cache
    def write(structure: Structure, target: str = "numpy", form: str = "chain") -> dict[str, str]:
        return module_files(structure, target, form)

    return write


@pytest.fixture(scope="session")
def built(written: Callable[..., dict[str, str]]) -> Callable[..., ModuleType]:
    """The module of a structure in a target and form: a second spent on C is spent once."""

    @cache
    def build(structure: Structure, target: str = "numpy", form: str = "chain") -> ModuleType:
        return load_files(written(structure, target, form))

    return build


class Point:
    """A module at random parameters, a time, and a state whose numbers are multiples of 2^-20."""

    def __init__(self, module: ModuleType, seed: int = 1):
        draw = np.random.default_rng(seed)
        self.module, self.t = module, 0.375
        self.values = _parameters(module, draw)
        self.p = module.parameters(**self.values)
        self.y = np.round(2.0 * draw.standard_normal(len(module.STATE)) * 2**20) / 2**20
        texts = getattr(module, "EXPRESSIONS", {})
        self._timed = {name: float(Expression(text, "t")(self.t)) for name, text in texts.items()}

    def exact_rhs(self, y: np.ndarray) -> list[Any]:
        """Rates by the closed form in 50 digits."""
        with mpmath.workdps(DIGITS):
            return ByHand(self.module, self.values | self._timed, y).rhs()

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
