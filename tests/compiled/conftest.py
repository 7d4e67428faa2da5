"""Scenes for the compiled methods: one smooth, one with everything that a scene can have. What
differs from test to test are their numbers, so that each is compiled once."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import pytest

import rodgen
from rodgen import Scene

SMOOTH: dict[str, Any] = {
    "name": "smooth",
    "parameters": {"A": 1.0},
    "rod": {"links": 3, "length": 1.0, "bending_stiffness": 1.0, "mass": 2.0, "boundary": "pinned"},
    "loads": {
        "gravity": {"g": 9.81},
        "internal_damping": {"coefficient": 0.02},
        "tip": {"x": "A*sin(3*t)"},
    },
    "initial": {"phi": "0.8-0.5*s", "omega": "1-s"},
    "integrate": {"span": [0.0, 1.0], "output_every": 0.1},
}
# A ramp up to P; a root that ends, growth without end and a jump, which are zero if not told
# otherwise.
FORCE = "P*min(t/ramp, 1) + root*sqrt(end - t) + grown*exp(rate*t) + (old if t <= jump else new)"
NUMBERS = dict.fromkeys(("root", "grown", "rate", "old", "new"), 0.0)
NUMBERS |= {"P": 300.0, "ramp": 0.3, "end": 1e9, "jump": 0.3}
MISSILE: dict[str, Any] = {
    "name": "missile",
    "parameters": NUMBERS,
    "rod": {"links": 3, "length": 5.0, "bending_stiffness": 3000.0, "mass": 50.0},
    "loads": {
        "follower": {"force": FORCE, "angle": 0.01},
        "gravity": {"g": 9.81},
        "internal_damping": {"coefficient": 0.01},
        "external_damping": {"coefficient": 0.5},
    },
    "initial": {"phi": "1.4+0.1*s", "velocity": [3.0, 5.0]},
    "integrate": {"span": [0.0, 1.0], "output_every": 0.05},
}


# Of SMOOTH, what takes or gives energy.
WITHOUT_LOADS = {"parameters.A": 0.0, "loads.gravity.g": 0.0}
WITHOUT_LOADS |= {"loads.internal_damping.coefficient": 0.0}
# Of MISSILE, all but gravity.
NO_LOADS = {
    **{f"loads.{kind}_damping.coefficient": 0.0 for kind in ("internal", "external")},
    "parameters.P": 0.0,
    "rod.bending_stiffness": 0.0,
}


@pytest.fixture(scope="session")
def model() -> ModuleType:
    """Of the smooth scene."""
    return rodgen.build(Scene.from_dict(SMOOTH), "c", parts=("jac", "flow", "newton"))


@pytest.fixture(scope="session")
def smooth() -> Scene:
    """Three links on a pin, under all that is smooth."""
    return Scene.from_dict(SMOOTH)


@pytest.fixture(scope="session")
def missile() -> Scene:
    """Three free links under a force that has a break point at 0.3 s."""
    return Scene.from_dict(MISSILE)
