"""Generated modules, each written and built once, and exact rates and Jacobians."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterable
from functools import cache
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
import pytest

from rodgen.check.module_check import DIGITS, _draw_parameters, assemble
from rodgen.loading import build, companions, sources
from rodgen.scene.structure import Structure
from tests.palette import covering, short

Built = Callable[..., ModuleType]
Written = Callable[..., dict[str, str]]
Whole = Callable[[Structure], dict[str, str]]


@pytest.fixture(scope="session")
def written() -> Written:
    """Texts of a structure in a target and form, by file name."""
    return cache(sources)


@pytest.fixture(scope="session")
def whole() -> Whole:
    """Texts of a C module in all parts that are C, and of the step loops beside it."""

    @cache
    def texts(structure: Structure) -> dict[str, str]:
        parts = ("rhs", "batch", "jac")
        return sources(structure, "c", parts=parts, steps=True) | companions("c", steps=True)

    return texts


@pytest.fixture(scope="session")
def built() -> Built:
    """The module of a structure in a target and form; its parts are made as they are asked for."""
    return build


def write(files: dict[str, str], folder: Path) -> str:
    """The stem of the files, written into a folder."""
    for name, text in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return Path(next(iter(files))).stem


def ran(*command: str | Path, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run a command to its end."""
    return subprocess.run(
        command, capture_output=True, text=True, timeout=600, check=False, **options
    )


def rarely(
    names: str, *factors: Iterable[Any], where: Callable[..., bool] = lambda *_: True
) -> pytest.MarkDecorator:
    """As `cases` of the palette where a case is dear: every value in `make test`, all else at
    night."""
    rows = [row for row in product(*map(tuple, factors)) if where(*row)]
    values, pairs = (covering(rows, strength) for strength in (1, 2))
    params = [
        pytest.param(
            *row, marks=() if row in values else pytest.mark.nightly, id="-".join(map(short, row))
        )
        for row in rows
        if row in values | pairs
    ]
    return pytest.mark.parametrize(names.split(", "), params)


class Point:
    """A module at random parameters, a time, and a state whose numbers are multiples of 2^-20."""

    def __init__(self, module: ModuleType, seed: int = 1):
        self.draw = np.random.default_rng(seed)
        self.module, self.t = module, 0.375
        self.values = _draw_parameters(module, self.t, self.draw)
        self.p = module.parameters(**self.values)
        self.y = np.round(2.0 * self.draw.standard_normal(len(module.STATE)) * 2**20) / 2**20

    def exact_rhs(self, y: np.ndarray) -> list[Any]:
        """Rates by the closed form in 50 digits."""
        with mpmath.workdps(DIGITS):
            return assemble(self.module, self.values, self.t, y).rhs()

    def exact_change(self, v: np.ndarray) -> np.ndarray:
        """Derivative of the rates along v, of whole numbers: central differences in 50 digits; with
        h = 2^-26 states stay exact doubles, and the error is h^2/6 = 4e-17 of the third
        derivatives."""
        h = 2.0**-26
        pairs = zip(self.exact_rhs(self.y + h * v), self.exact_rhs(self.y - h * v), strict=True)
        return np.array([float((a - b) / (2 * h)) for a, b in pairs])

    def exact_jacobian(self) -> np.ndarray:
        return np.array([self.exact_change(each) for each in np.eye(len(self.y))]).T

    def assert_jacobian(self, jac: Callable[..., np.ndarray]) -> None:
        """A Jacobian is that of the closed form: along two directions with all signs, in every row
        to 1e-9 of its largest entry."""
        J = jac(self.t, self.y, self.p)
        assert J.shape == 2 * self.y.shape
        largest = np.abs(J).max(axis=1)
        # Rows of zeros (nothing turns one free link) hold the rounding of terms that cancel.
        scale = np.maximum(largest, 1e-5 * largest.max())
        for _ in range(2):
            v = self.draw.choice([-1.0, 1.0], len(self.y))
            assert (np.abs(J @ v - self.exact_change(v)) < 1e-9 * scale).all()


@pytest.fixture
def point() -> type[Point]:
    return Point
