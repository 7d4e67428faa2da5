"""Freezing of loads, masses and a base that change with time."""

from __future__ import annotations

from typing import Any

import numpy as np

from rodgen.errors import InputError, Missing
from rodgen.model.terms import MOVING_BASE, PARAMETERS
from rodgen.scene import Scene
from rodgen.scene.plain_tables import is_number, to_plain
from rodgen.scene.scene import with_values


def load_time(scene: Scene, t: float | None = None) -> float:
    """Time at which loads are taken [s]: t, by default the start of the scene's span.

    Raises InputError for a time outside the span, where the scene says nothing of its loads, and
    where none is given of a scene whose masses change: no state of it lasts.
    """
    start, end = scene.integrate.span
    changing = scene.distribution.changing_masses
    if t is None and changing:
        fields = " and ".join(e.field for *_, e in changing)
        verb = "changes" if len(changing) == 1 else "change"
        allowed = f"given, the time whose masses are taken: {fields} {verb} with it"
        raise InputError("t", Missing(), allowed)
    t = start if t is None else to_plain(t, "t")
    if not (is_number(t) and start <= t <= end):
        raise InputError("t", t, f"a time in the span of the scene, {start:g} to {end:g} s")
    return float(t)


def freeze(scene: Scene, t: float) -> Scene:
    """Copy of a scene with all loads and masses constant, as they are at t [s].

    Damping in proportion to the mass of the links, such as the thesis's, keeps the mass at the
    start of the span. A base stays where it is then, and its acceleration is that of a frame: less
    of it falls freely. Raises InputError for a load that is not finite then.
    """
    changes: dict[str, Any] = {
        scene.key_of(name): float(e(t)) for name, e in scene.time_dependent_loads.items()
    }
    for field, value in changes.items():
        if not np.isfinite(value):
            raise InputError(field, value, f"finite at t = {t:g} s")
    changes |= {scene.key_of(name): values for name, values in scene.link_values_at(t).items()}
    changes |= masses_at(scene, t) | _base_at(scene, t)
    return with_values(scene, changes) if changes else scene


def _base_at(scene: Scene, t: float) -> dict[str, Any]:
    """Gravity in the frame of a base at a time [s], and what stays on the ground where it was, by
    keys in a scene."""
    if scene.base is None:
        return {}
    held = (("supports", scene.supports), ("stops", scene.stops))
    changes: dict[str, Any] = {
        f"{key}.{at}.to": [*scene.anchors.fixed_point(one)]
        for key, tables in held
        for at, one in enumerate(tables)
    }
    if (through := scene.anchors.through) is not None:
        changes["foundation.through"] = [*map(float, through)]
    acceleration = base_acceleration(scene, t)
    if any(acceleration):
        falling = _free_fall(scene, t)
        changes["loads.gravity"] = {
            "acceleration": [g - a for g, a in zip(falling, acceleration, strict=True)]
        }
    return changes


def base_acceleration(scene: Scene, t: float) -> tuple[float, float]:
    """Acceleration of joint 0 at a time [m/s^2]; t: the time [s]."""
    if scene.base is None:
        return 0.0, 0.0
    growth = {"x": 0.0, "y": 0.0}
    for key in growth.keys() & {*scene.base.keys}:
        e = scene.expression(f"{MOVING_BASE}_{key}")
        growth[key] = 0.0 if e is None else float(e.derivative(t, {}, 2))
        if not np.isfinite(growth[key]):
            allowed = f"of a finite acceleration at t = {t:g} s"
            raise InputError(f"base.{key}", getattr(scene.base, key), allowed)
    return growth["x"], growth["y"]


def _free_fall(scene: Scene, t: float) -> tuple[float, float]:
    """Acceleration of free fall in a scene at a time [m/s^2]."""
    gravity = scene.loads.gravity
    if gravity is None:
        return 0.0, 0.0

    def value(name: str) -> float:
        e = scene.expression(name)
        if e is not None and e.signals:
            allowed = "a number or an expression in t, where the base accelerates"
            raise InputError(scene.key_of(name), e.text, allowed)
        return float(scene.loads.value(name) if e is None else e(t))

    if gravity.acceleration is None:
        return 0.0, -value("gravity")
    return value("gravity_x"), value("gravity_y")


def masses_at(scene: Scene, t: float) -> dict[str, Any]:
    """Masses at a time [s], and the damping in proportion to them, by their keys in a scene."""
    changing = {name: e for name, _, e in scene.distribution.changing_masses}
    if not changing:
        return {}
    there, changes = scene.distribution_at(t), dict[str, Any]()
    if "" in changing:
        changes["rod.mass_per_length"] = changing[""].at_value(t)
        ratio = scene.distribution.total_link_mass / there.total_link_mass
        for name in filter(lambda name: PARAMETERS[name].by_mass, scene.loads.parameters):
            changes[scene.key_of(name)] = ratio * scene.loads.value(name)
    for body, mass in zip(scene.bodies, there.body_masses, strict=True):
        if body.name in changing:
            changes[f"bodies.{body.name}.mass"] = mass
    return changes
