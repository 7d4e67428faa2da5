"""Scenes for the compiled methods: one smooth, one with everything that a scene can have."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import pytest

import rodgen
from rodgen import Scene

SMOOTH: dict[str, Any] = {
    "name": "smooth",
    "rod": {
        "links": 3,
        "length": 1.0,
        "bending_stiffness": 1.0,
        "mass": 2.0,
        "boundary": "pinned",
    },
    "loads": {
        "gravity": {"g": 9.81},
        "internal_damping": {"coefficient": 0.02},
        "tip": {"x": "sin(3*t)"},
    },
    "initial": {"phi": "0.8-0.5*s", "omega": "1-s"},
    "integrate": {"span": [0.0, 1.0], "output_every": 0.1},
}
MISSILE: dict[str, Any] = {
    "name": "missile",
    "rod": {"links": 12, "length": 5.0, "bending_stiffness": 100.0, "mass": 50.0},
    "loads": {
        "follower": {"force": "300*min(t/0.3, 1)", "angle": 0.01},
        "gravity": {"g": 9.81},
        "internal_damping": {"coefficient": 0.01},
        "external_damping": {"coefficient": 0.5},
    },
    "initial": {"phi": "1.4+0.1*s", "velocity": [3.0, 5.0]},
    "integrate": {"span": [0.0, 1.0], "output_every": 0.05},
}


def changed(scene: Scene, **tables: Any) -> Scene:
    """A scene with other values in its tables."""
    table = scene.model_dump(exclude_none=True)
    for name, values in tables.items():
        table[name] = {**table.get(name, {}), **values} if isinstance(values, dict) else values
    return Scene.from_dict(table)


@pytest.fixture(scope="session")
def model() -> ModuleType:
    """Of the smooth scene, compiled as it is for users."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("RODGEN_CFLAGS", raising=False)
        return rodgen.build(Scene.from_dict(SMOOTH), "c", parts=("jac", "flow", "newton"))


@pytest.fixture
def smooth() -> Scene:
    """Three links on a pin, under all that is smooth."""
    return Scene.from_dict(SMOOTH)


@pytest.fixture
def missile() -> Scene:
    """A free rod with a force that has a break point at 0.3 s."""
    return Scene.from_dict(MISSILE)


@pytest.fixture
def short(missile: Scene) -> Scene:
    """Three free links under a force that does not change, for loads of other kinds: what
    each of them needs is compiled for itself."""
    return changed(missile, rod={"links": 3}, loads={"follower": {"force": 30.0}})
