"""The rods that are timed: values of their parameters, and random states of them."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rodgen

Vector = NDArray[np.float64]

FOLLOWER = ("follower",)
ALL = ("follower", "gravity", "internal_damping", "external_damping")  # the thesis's
LOADS = ((FOLLOWER, "follower"), (ALL, "all loads"))

VALUES = {
    "mass": 50.0,
    "length": 5.0,
    "bending_stiffness": 100.0,
    "follower_force": 300.0,
    "follower_angle": 0.1,
    "gravity": 9.81,
    "internal_damping": 0.1,
    "external_damping": 0.5,
    "clamp_angle": 0.2,
}
# As the yardstick and the peers hold them.
P = np.array([VALUES[name] for name in list(VALUES)[:5]])


def built(
    links: int,
    terms: tuple[str, ...] = FOLLOWER,
    target: str = "numpy",
    form: str = "chain",
    kind: tuple[str, str] = ("free", "uniform"),
) -> ModuleType:
    """The module of a rod. Raises BuildError where there is none."""
    module: ModuleType = rodgen.build(rodgen.Structure(links, *kind, terms), target, form)
    return module


def packed(module: ModuleType, **other: Any) -> Vector:
    """The parameters that a module has."""
    values = {name: value for name, value in VALUES.items() if name in module.PARAMETERS}
    p: Vector = module.parameters(**(values | other))
    return p


def state(
    links: int, spread: float = 0.1, speed: float = 0.1, seed: int = 1, base: int = 2
) -> Vector:
    """A random state of a free rod, or with a base of 0 of one whose start does not move."""
    draw = np.random.default_rng(seed)
    half = links + base
    return np.concatenate([spread * draw.normal(size=half), speed * draw.normal(size=half)])


def disagreement(dy: Vector, reference: Vector) -> float:
    """Largest difference of the accelerations over their largest magnitude."""
    half = len(reference) // 2
    if len(dy) != len(reference) or not np.array_equal(dy[:half], reference[:half]):
        return np.inf  # the velocities are copied, so they agree exactly
    largest = np.abs(reference[half:]).max()
    return float(np.abs(dy[half:] - reference[half:]).max() / largest)
