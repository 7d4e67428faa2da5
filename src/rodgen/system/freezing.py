"""Freezing of loads and masses that change with time."""

from __future__ import annotations

from typing import Any

import numpy as np

from rodgen.errors import InputError, Missing
from rodgen.model.terms import PARAMETERS
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
    start of the span. Raises InputError for a load that is not finite then.
    """
    changes: dict[str, Any] = {
        scene.key_of(name): float(e(t)) for name, e in scene.time_dependent_loads.items()
    }
    for field, value in changes.items():
        if not np.isfinite(value):
            raise InputError(field, value, f"finite at t = {t:g} s")
    changes |= {scene.key_of(name): values for name, values in scene.link_values_at(t).items()}
    changes |= masses_at(scene, t)
    return with_values(scene, changes) if changes else scene


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
