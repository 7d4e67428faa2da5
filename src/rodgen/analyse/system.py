"""A scene made ready for analysis: its loads as numbers, its module, and its blocks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.instant import instant
from rodgen.integrate.stepper import Array
from rodgen.loading import build
from rodgen.scene import Scene, SceneError
from rodgen.scene.scene import check_scene
from rodgen.scene.tables import PLACES


@dataclass(frozen=True)
class System:
    """scene: its loads are numbers, those at the time t [s]; model: its generated module."""

    scene: Scene
    model: ModuleType
    t: float

    @classmethod
    def of(cls, scene: Scene, t: float | None = None) -> System:
        """t: at which loads are taken, see `instant`. Raises SceneError.

        The module is that of the NumPy target: a few evaluations are not worth a compilation.
        """
        check_scene(scene)
        t = instant(scene, t)
        scene = frozen(scene, t)
        return cls(scene, build(scene, "numpy"), t)

    @property
    def base(self) -> int:
        """Coordinates of joint 0, before the angles."""
        return 2 * self.scene.hold.translates

    @property
    def cells(self) -> int:
        """Links that move."""
        return self.scene.rod.links - self.scene.held

    @cached_property
    def given(self) -> dict[str, Any]:
        """Parameters of the scene by name."""
        return self.scene.parameters

    def parameters(self, **changes: float) -> Array:
        """p of the module, with other values for some parameters."""
        p: Array = self.model.parameters(**(self.given | changes))
        return p

    def at_rest(self, phi: Array) -> Array:
        """y (states,) with these angles of the moving links [rad], joint 0 at the origin."""
        y = np.zeros(2 * (self.base + self.cells))
        y[self.base : self.base + self.cells] = phi
        return y

    @property
    def clamped(self) -> bool:
        """Whether the start of the rod keeps its direction."""
        return bool(self.scene.held or self.scene.hold.root_spring)

    @cached_property
    def straight(self) -> Array:
        """Angles (cells,) of the straight rod: along the clamp, or at the mean initial angle."""
        rod, start = self.scene.rod, self.scene.initial_state()
        if self.clamped:
            return np.full(self.cells, rod.clamp_angle or 0.0)
        return np.full(self.cells, start[self.base : self.base + self.cells].mean())

    def all_links(self, phi: NDArray[Any]) -> NDArray[Any]:
        """Angles of all n links, held ones included, from those of the moving ones (..., cells)."""
        held = np.full((*phi.shape[:-1], self.scene.held), self.scene.rod.clamp_angle or 0.0)
        return np.concatenate((held, phi), axis=-1)

    def rates(self, y: Array, p: Array) -> Array:
        """Accelerations (base + cells,) of the coordinates."""
        rates: Array = self.model.rhs(0.0, y, p)[len(y) // 2 :]
        return rates


def frozen(scene: Scene, t: float) -> Scene:
    """The scene with every load that is a function of time as the number that it has at t [s].

    Raises SceneError for a load that is not finite then.
    """
    changed = {name: float(e(t)) for name, e in scene.timed.items()}
    if not changed:
        return scene
    table = scene.model_dump(exclude_none=True)
    for name, value in changed.items():
        at, key = PLACES[name]
        if not np.isfinite(value):
            raise SceneError(f"loads.{at}.{key}", value, f"finite at t = {t:g} s")
        table["loads"][at][key] = value
    return Scene.from_dict(table)


def without(scene: Scene, table: str) -> Scene:
    """The scene without one of its tables of loads."""
    given = scene.model_dump(exclude_none=True)
    given["loads"].pop(table, None)
    return Scene.from_dict(given)
