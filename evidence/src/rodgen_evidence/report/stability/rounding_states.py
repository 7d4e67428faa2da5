"""States and parameters at which rounding errors are measured."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen_evidence.report import cases

Array = NDArray[np.float64]

ROD = {
    **cases.ROD,
    **dict.fromkeys(("follower_force", "follower_angle", "gravity"), 0.0),
    **dict.fromkeys(("internal_damping", "external_damping"), 0.0),
}
CRITICAL = 437.68  # N: critical thrust of this rod of 50 links
ALL = {"follower_force": 300.0, "gravity": 9.81, "internal_damping": 0.1, "external_damping": 0.5}
SLACK = {"bending_stiffness": 0.0}
DRAG = {"external_damping": 0.5}


@dataclass(frozen=True, eq=False)
class Shape:
    """Angles and rates of all links, with position and velocity of joint 0."""

    phi: Array
    omega: Array
    base: tuple[float, float] = (0.3, -0.2)
    velocity: tuple[float, float] = (0.7, 0.4)


@dataclass(frozen=True, eq=False)
class ExtremeState:
    """Shape with values that differ from those of ROD; few: among the few of many links."""

    group: str
    case: str
    shape: Shape
    values: dict[str, Any] = field(default_factory=dict)
    few: bool = False


def extremes(links: int) -> Iterator[ExtremeState]:
    """Yield all extreme states of a rod of so many links."""
    bent = _bent(links)
    yield ExtremeState("ordinary", "all loads", bent, ALL, few=True)
    yield ExtremeState("ordinary", "no loads", bent)
    yield from _sizes(bent)
    yield from _shapes(links)
    yield from _turning(links, bent)
    yield from _damped_states(links, bent)
    for times in (1000.0, -1000.0):
        thrust = {"follower_force": times * CRITICAL}
        yield ExtremeState("thrust", f"{times:g} times critical", bent, thrust, few=times > 0)


def _sizes(bent: Shape) -> Iterator[ExtremeState]:
    for stiffness in (0.0, 1e-12, 1e-8, 1e-4, 1.0, 1e4, 1e8, 1e12):
        values, few = {"bending_stiffness": stiffness}, stiffness in (0.0, 1e12)
        yield ExtremeState("stiffness", f"EI = {stiffness:g} N m^2", bent, values, few)
    for mass in (1e-12, 1e-6, 1.0, 1e6, 1e12):
        values = {**ALL, "mass": mass}
        yield ExtremeState("mass", f"{mass:g} kg, all loads", bent, values, mass == 1e-12)
    for length in (1e-6, 1e-3, 1.0, 1e3, 1e6):
        values = {**ALL, "length": length}
        yield ExtremeState("length", f"{length:g} m, all loads", bent, values, length == 1e6)


def _shapes(links: int) -> Iterator[ExtremeState]:
    at, draw = np.arange(links), np.random.default_rng(3)
    rates, little = 0.5 * draw.standard_normal(links), 1e-8 * draw.standard_normal(links)
    back = 0.3 + math.pi * (at % 2)
    shapes = {
        "straight": np.full(links, 0.4),
        "straight but for 1e-8 rad": 0.4 + little,
        "back by pi at every joint": back,
        "back by pi but for 1e-8 rad": 0.3
        + math.pi * (at % 2)
        + 1e-8 * draw.standard_normal(links),
        "straight but for 6 pi at every joint": 0.3 + 6 * math.pi * (at % 2),
        "turned on by 2 pi at every joint": 0.3 + 2 * math.pi * at,
        "right angles": 0.3 + math.pi / 2 * (at % 2),
        "coiled, 1 rad at every joint": 0.3 + at,
        "random angles": 3.0 * draw.standard_normal(links),
    }
    for name, phi in shapes.items():
        folded = "back" in name
        yield ExtremeState(
            "folded", name, Shape(phi, rates), ALL, few=name == "back by pi at every joint"
        )
        if folded or name == "right angles":
            yield ExtremeState("folded", f"{name}, no springs, no loads", Shape(phi, rates), SLACK)


def _turning(links: int, bent: Shape) -> Iterator[ExtremeState]:
    for turned in (1e3, 1e6, 1e9):
        shape = Shape(bent.phi + turned, bent.omega)
        yield ExtremeState("turns", f"phi about {turned:g} rad", shape, ALL, turned == 1e6)
    for speed in (1e3, 1e6):
        shape = Shape(bent.phi, np.full(links, speed))
        yield ExtremeState("spin", f"all links, omega = {speed:g} rad/s", shape, ALL, speed == 1e6)
        shape = Shape(bent.phi, speed * bent.omega)
        yield ExtremeState("spin", f"each by itself, about {speed:g} rad/s", shape, ALL)
    for far in (1e12,):
        shape = Shape(bent.phi, bent.omega, base=(far, far))
        yield ExtremeState("translation", f"x0 = {far:g} m", shape, ALL, few=True)


def _damped_states(links: int, bent: Shape) -> Iterator[ExtremeState]:
    still, none = np.zeros(links), (0.0, 0.0)
    at_rest = Shape(bent.phi, still, velocity=none)
    yield ExtremeState("drag", "velocities of zero", at_rest, DRAG, few=True)
    turning = Shape(bent.phi, bent.omega, velocity=none)
    yield ExtremeState("drag", "velocity of zero at joint 0 alone", turning, DRAG)
    for size in (1e-300, 1e-150, 1e-8, 1e8):
        slow = Shape(bent.phi, size * bent.omega, velocity=(size, 0.3 * size))
        yield ExtremeState("drag", f"velocities about {size:g} m/s", slow, DRAG)
    along = Shape(np.full(links, 0.4), still, velocity=(math.cos(0.4), math.sin(0.4)))
    yield ExtremeState("drag", "all joints move along the rod", along, DRAG)
    heavy = {"external_damping": 1e6 * _slowest()}
    yield ExtremeState("drag", "overdamped by 1e6, outside", bent, heavy)
    for ratio in (1.0, 1e3, 1e6):
        values = {"internal_damping": ratio * _critical_damping(links)}
        name = f"{ratio:g} times critical, inside"
        yield ExtremeState("damping", name, bent, values, few=ratio == 1e6)


def _bent(links: int) -> Shape:
    draw = np.random.default_rng(2)
    return Shape(0.4 + 0.3 * draw.standard_normal(links), 0.5 * draw.standard_normal(links))


def _frequency() -> float:
    return math.sqrt(ROD["bending_stiffness"] / (ROD["mass"] * ROD["length"] ** 3))


def _slowest() -> float:
    """Twice the frequency of the first bending mode [1/s]."""
    return 2 * 22.37 * _frequency()


def _critical_damping(links: int) -> float:
    """Internal damping [m^2/s] that is critical for the fastest mode of many links."""
    m, k = ROD["mass"] / links, ROD["bending_stiffness"] * links / ROD["length"]
    return 2 * k / (m * 4 * math.sqrt(3) * links**2 * _frequency())
