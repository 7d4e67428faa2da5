"""The time at which loads and masses are taken, where they change with time."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError, Missing
from rodgen.model.terms import PARAMETERS
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.scene.plain import is_number, plain
from rodgen.scene.scene import with_values

TIMES = 1001  # of the span, beside what lies between break points


def instant(scene: Scene, t: float | None = None) -> float:
    """The time whose loads are taken [s]: t, by default the start of the scene's span.

    Raises InputError for a time outside the span, where the scene says nothing of its loads, and
    where none is given of a scene whose masses change: no state of it lasts.
    """
    start, end = scene.integrate.span
    changing = scene.distribution.changing
    if t is None and changing:
        fields = " and ".join(e.field for *_, e in changing)
        verb = "changes" if len(changing) == 1 else "change"
        allowed = f"given, the time whose masses are taken: {fields} {verb} with it"
        raise InputError("t", Missing(), allowed)
    t = start if t is None else plain(t, "t")
    if not (is_number(t) and start <= t <= end):
        raise InputError("t", t, f"a time in the span of the scene, {start:g} to {end:g} s")
    return float(t)


def freeze(scene: Scene, t: float) -> Scene:
    """The scene with every load and mass that is a function of time as it is at t [s].

    What goes by the mass of the links, such as the thesis's damping, still does so by that at the
    start of the span. Raises InputError for a load that is not finite then.
    """
    changes: dict[str, Any] = {scene.field(name): float(e(t)) for name, e in scene.timed.items()}
    for field, value in changes.items():
        if not np.isfinite(value):
            raise InputError(field, value, f"finite at t = {t:g} s")
    changes |= {scene.field(name): values for name, values in scene.along_at(t).items()}
    changes |= _masses_at(scene, t)
    return with_values(scene, changes) if changes else scene


def freeze_masses(scene: Scene, t: float) -> Scene:
    """The scene whose masses alone stay what they are at a time [s]."""
    changes = _masses_at(scene, t)
    return with_values(scene, changes) if changes else scene


def _masses_at(scene: Scene, t: float) -> dict[str, Any]:
    """Masses at a time [s], and the damping that goes by them, by their keys in a scene."""
    changing = {name: e for name, _, e in scene.distribution.changing}
    if not changing:
        return {}
    there, changes = scene.distribution_at(t), dict[str, Any]()
    if "" in changing:
        changes["rod.mass_per_length"] = changing[""].held(t)
        ratio = scene.distribution.links_mass / there.links_mass
        for name in filter(lambda name: PARAMETERS[name].by_mass, scene.loads.parameters):
            changes[scene.field(name)] = ratio * scene.loads.value(name)
    for body, mass in zip(scene.bodies, there.body_mass, strict=True):
        if body.name in changing:
            changes[f"bodies.{body.name}.mass"] = mass
    return changes


def inactive_loads(scene: Scene, t: float, scaled: Collection[str] = ()) -> tuple[str, ...]:
    """Places, such as loads.follower.force, of the loads that are zero at t [s] and act at another
    time of the span; scaled: parameters that are not asked for."""
    times = _times(scene)
    return tuple(
        scene.field(name)
        for name, e in scene.timed.items()
        if name not in scaled and float(e(t)) == 0 and _acts(e, times)
    )


def describe_instant(scene: Scene, t: float, scaled: Collection[str] = ()) -> str:
    """Describe the time at which loads are taken, and the loads that are zero then."""
    masses = " and masses" * bool(scene.distribution.changing)
    words = f"loads{masses} as at t = {t:g} s"
    if t == scene.integrate.span[0]:
        words += ", the start of the span"
    quiet = inactive_loads(scene, t, scaled)
    if not quiet:
        return words
    verb = "is" if len(quiet) == 1 else "are"
    return f"{words}, where {' and '.join(quiet)} {verb} 0, but not at all times"


def _times(scene: Scene) -> Array:
    """Times of the span [s] at which no load can hide between two others."""
    start, end = scene.integrate.span
    ends = np.array([start, *scene.breaks(), end])
    peaks = [peak for _, peak, _ in scene.course.pulses()]
    return np.concatenate((np.linspace(start, end, TIMES), (ends[1:] + ends[:-1]) / 2, peaks))


def _acts(e: Expression, times: Array) -> bool:
    return bool((np.asarray(e(times)) != 0).any())
