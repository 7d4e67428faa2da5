"""Bending moments, forces on the joints and kicks of generated modules, by routes of their own:
laws written out link by link, differences of energies and positions, balances of momentum."""

from __future__ import annotations

import re
from dataclasses import dataclass
from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import root

from rodgen.loading import build
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import THESIS_TERMS
from rodgen.scene.structure import Structure
from tests.palette import can_move, cases

VALUES = {
    "mass": 3.0,
    "length": 2.0,
    "bending_stiffness": 30.0,
    "follower_force": 20.0,
    "follower_angle": 0.2,
    "internal_damping": 0.1,
    "material_damping_time": 0.02,
    "external_damping": 0.5,
    "clamp_angle": 0.3,
    "tip_force_x": 6.0,
    "tip_force_y": -4.0,
}
CHAINS = cases("boundary, links, inertia", BOUNDARIES, (1, 2, 5), INERTIAS, where=can_move)
FORCES = (*THESIS_TERMS, "tip_load")
# Rounding of some hundred operations.
ROUNDING = 1e-12


@dataclass
class _Rod:
    """A module at one set of parameters and one state, and its rod joint by joint."""

    module: ModuleType
    seed: int = 1

    def __post_init__(self) -> None:
        draw, rod = np.random.default_rng(self.seed), self.module
        names = {name for name in rod.PARAMETERS if not name.startswith("fin_factor")}
        self.fins = draw.uniform(0.5, 5.0, rod.N + 1)
        fins = {"fin_factor": self.fins} if "fin_factor_0" in rod.PARAMETERS else {}
        self.p = rod.parameters(**{k: v for k, v in VALUES.items() if k in names}, **fins)
        self.y = draw.normal(size=len(rod.STATE))
        self.half = len(self.y) // 2
        self.base = 2 * (rod.BOUNDARY == "free")
        self.first = int(rod.BOUNDARY == "cantilever")
        self.n, self.l, self.m = rod.N, VALUES["length"] / rod.N, VALUES["mass"] / rod.N

    def angles(self, y: np.ndarray) -> list[float]:
        """Of all links, the held one too."""
        return [VALUES["clamp_angle"]] * self.first + list(y[self.base : self.half])

    def velocities(self, y: np.ndarray) -> np.ndarray:
        """Of the joints (n+1, 2): link by link, each turns about its start."""
        out = [np.array(y[self.half : self.half + 2] if self.base else [0.0, 0.0])]
        rates = [0.0] * self.first + list(y[self.half + self.base :])
        for angle, rate in zip(self.angles(y), rates, strict=True):
            out.append(out[-1] + self.l * rate * np.array([-np.sin(angle), np.cos(angle)]))
        return np.array(out)


def _cross(a: np.ndarray, b: np.ndarray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


# Bending moments ----------------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", ["cantilever", "clamped"])
def test_moments_carry_the_tip_load_at_rest(boundary: str) -> None:
    """What is behind a joint is in balance: its spring holds the moment of the force at the tail,
    positive where that turns to the left."""
    rod = _Rod(build(Structure(5, boundary, "uniform", ("tip_load",))))
    rest = np.zeros(rod.half)

    def acceleration(angles: np.ndarray) -> np.ndarray:
        return rod.module.rhs(0.0, np.concatenate((angles, rest)), rod.p)[rod.half :]

    found = root(acceleration, rest + VALUES["clamp_angle"], tol=1e-13)
    y = np.concatenate((found.x, rest))
    joints = rod.module.joints(y, rod.p)
    force = np.array([VALUES["tip_force_x"], VALUES["tip_force_y"]])
    expected = [_cross(joints[-1] - at, force) for at in joints]
    if boundary == "cantilever":
        expected[0] = 0.0  # the support holds link 0, no spring
    assert np.ptp(expected) > 1.0
    # The accelerations at rest are some 1e-11 of those at the start, 1e3.
    np.testing.assert_allclose(rod.module.bending_moments(y, rod.p), expected, atol=1e-8)


# Forces -------------------------------------------------------------------------------------------


def _drag(rod: _Rod, velocities: np.ndarray) -> np.ndarray:
    """External damping as it is defined: by the angles of velocity and rod."""
    angles, out = rod.angles(rod.y), np.zeros((rod.n + 1, 2))
    for joint in range(rod.n + 1):
        v, meet = velocities[joint], angles[max(joint - 1, 0) : joint + 1]
        if np.any(v != 0):
            across = abs(np.sin(np.arctan2(v[1], v[0]) - np.mean(meet)))
            mass = rod.m * len(meet) / 2
            out[joint] = -VALUES["external_damping"] * rod.fins[joint] * across * mass * v
    return out


@CHAINS
def test_forces_are_those_of_the_laws_and_give_the_power(
    boundary: str, links: int, inertia: str
) -> None:
    rod = _Rod(build(Structure(links, boundary, inertia, FORCES)))
    velocities = rod.velocities(rod.y)
    thrust = rod.angles(rod.y)[-1] + VALUES["follower_angle"]
    at_tail = np.zeros((2, links + 1, 2))
    at_tail[0, -1] = -VALUES["follower_force"] * np.array([np.cos(thrust), np.sin(thrust)])
    at_tail[1, -1] = VALUES["tip_force_x"], VALUES["tip_force_y"]
    expected = {"follower": at_tail[0], "tip_load": at_tail[1]}
    expected["external_damping"] = _drag(rod, velocities)
    forces, power = (f(0.0, rod.y, rod.p) for f in (rod.module.forces, rod.module.power))
    assert set(forces) == set(expected)
    for term, by_hand in expected.items():
        limit = ROUNDING * np.abs(by_hand).max()
        np.testing.assert_allclose(forces[term], by_hand, rtol=0, atol=limit)
        each = np.sum(forces[term] * velocities, axis=1)
        assert power[term] == pytest.approx(each.sum(), abs=ROUNDING * np.abs(each).max())
        assert power[term] != 0


@pytest.mark.parametrize("terms", [(), ("gravity", "internal_damping")])
def test_loads_that_are_no_forces_on_joints_are_none(terms: tuple[str, ...]) -> None:
    rod = _Rod(build(Structure(5, "free", "uniform", terms)))
    assert rod.module.forces(0.0, rod.y, rod.p) == {}


def test_many_states_and_times_at_once() -> None:
    timed = (("tip_force_x", "sin(3*t)"), ("follower_force", "20*t"))
    module = build(Structure(5, "cantilever", "uniform", FORCES, timed))
    p = _Rod(module).p
    y = np.random.default_rng(3).normal(size=(4, 3, len(module.STATE)))
    t = np.linspace(0.1, 2.0, 12).reshape(4, 3)
    together = module.forces(t, y, p)
    assert list(together) == ["follower", "external_damping", "tip_load"]
    for at in np.ndindex(4, 3):
        one = module.forces(t[at], y[at], p)
        for term, values in together.items():
            # To rounding: long arrays may take other instructions.
            np.testing.assert_allclose(values[at], one[term], rtol=ROUNDING, atol=ROUNDING)
        assert one["tip_load"][-1] == pytest.approx([np.sin(3 * t[at]), -4.0])
        np.testing.assert_allclose(
            module.bending_moments(y, p)[at], module.bending_moments(y[at], p), rtol=ROUNDING
        )


# Generalised forces -------------------------------------------------------------------------------

KICK = np.array([0.7, -1.9])


@pytest.mark.parametrize(
    ("link", "share", "force", "words"),
    [
        (-1, 0.5, KICK, "link = -1: must be a whole number from 0 to 4"),
        (5, 0.5, KICK, "link = 5: must be"),
        (1.0, 0.5, KICK, "link = 1.0: must be"),
        (True, 0.5, KICK, "link = True: must be"),
        ("1", 0.5, KICK, "link = '1': must be"),
        (0, -0.01, KICK, "share = -0.01: must be a finite number, from 0 to 1"),
        (0, 1.01, KICK, "share = 1.01: must be"),
        (0, float("nan"), KICK, "share = nan: must be"),
        (0, "half", KICK, "share = 'half': must be"),
        (0, 0.5, 3.0, "force = 3.0: must be 2 values"),
        (0, 0.5, [1.0, 2.0, 3.0], "force has 3 values: must be 2"),
        (0, 0.5, [1.0, float("inf")], "force[1] = inf: must be a finite number"),
        (0, 0.5, "xy", "force[0] = 'x': must be a finite number"),
    ],
)
def test_points_and_forces_that_are_none_are_refused(
    link: object, share: object, force: object, words: str
) -> None:
    rod = _Rod(build(Structure(5, "free", "uniform", FORCES)))
    with pytest.raises(ValueError, match=re.escape(words)):
        rod.module.generalised_force(rod.y, rod.p, link, share, force)
