"""A scene made ready for analysis: its loads as numbers, its module, and its blocks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse import flight
from rodgen.integrate.stepper import Array
from rodgen.loading import build
from rodgen.scene import Scene, SceneError
from rodgen.scene.scene import check_scene
from rodgen.scene.tables import PLACES


@dataclass(frozen=True)
class System:
    """scene: its loads are numbers, those at the time t [s]; model: its generated module; speed:
    at which a free rod moves along its axis, nose first [m/s]; across: the part of its velocity
    that is left out, since no state that moves so is steady [m/s]."""

    scene: Scene
    model: ModuleType
    t: float
    speed: float = 0.0
    across: float = 0.0

    @classmethod
    def of(cls, scene: Scene, t: float | None = None, speed: float | None = None) -> System:
        """t: at which loads are taken, by default the end of the scene's span; speed: of a free rod
        along its axis [m/s], by default that of the scene's initial state. Raises SceneError.

        The module is that of the NumPy target: a few evaluations are not worth a compilation.
        """
        check_scene(scene)
        t = scene.integrate.span[1] if t is None else t
        if not np.isfinite(t):
            raise SceneError("t", t, "a finite time")
        speed = flight.checked(scene, speed)
        scene = frozen(scene, t)
        system = cls(scene, build(scene, "numpy"), t)
        along, across = system._motion() if speed is None else (speed, 0.0)
        return replace(system, speed=along, across=across)

    def _motion(self) -> tuple[float, float]:
        """Velocity of a free rod along and across its axis at the start [m/s]."""
        if not self.base:
            return 0.0, 0.0
        moving = flight.velocity(self.model, self.scene.initial_state(), self.parameters())
        return flight.along_and_across(moving, float(self.straight[0]))

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

    def flying(self, phi: Array, across: float = 0.0) -> Array:
        """The same of a rod that moves along its straight axis with its speed, and across [m/s]."""
        y = self.at_rest(phi)
        if self.base:
            c, s = np.cos(self.straight[0]), np.sin(self.straight[0])
            y[len(y) // 2 :][:2] = -self.speed * c - across * s, -self.speed * s + across * c
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
