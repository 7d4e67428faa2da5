"""Freezing of loads and masses that change with time."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError, Missing
from rodgen.model.terms import PARAMETERS
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.scene.plain_tables import is_number, to_plain
from rodgen.scene.scene import with_values

TIMES = 1001  # of the span, beside what lies between break points


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
        scene.key_of(name): float(e(t)) for name, e in scene.time_laws.items()
    }
    for field, value in changes.items():
        if not np.isfinite(value):
            raise InputError(field, value, f"finite at t = {t:g} s")
    changes |= {scene.key_of(name): values for name, values in scene.link_values_at(t).items()}
    changes |= _masses_at(scene, t)
    return with_values(scene, changes) if changes else scene


def freeze_masses(scene: Scene, t: float) -> Scene:
    """Copy of a scene with its masses alone constant, as they are at a time [s]."""
    changes = _masses_at(scene, t)
    return with_values(scene, changes) if changes else scene


def _masses_at(scene: Scene, t: float) -> dict[str, Any]:
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


def inactive_loads(scene: Scene, t: float, scaled: Collection[str] = ()) -> tuple[str, ...]:
    """Dotted names, such as loads.follower.force, of the loads that are zero at t [s] and act at
    another time of the span; scaled: parameters to leave out."""
    times = _sample_times(scene)
    return tuple(
        scene.key_of(name)
        for name, e in scene.time_laws.items()
        if name not in scaled and float(e(t)) == 0 and _is_ever_nonzero(e, times)
    )


def describe_instant(scene: Scene, t: float, scaled: Collection[str] = ()) -> str:
    """Describe the time at which loads are taken, and the loads that are zero then."""
    masses = " and masses" * bool(scene.distribution.changing_masses)
    words = f"loads{masses} as at t = {t:g} s"
    if t == scene.integrate.span[0]:
        words += ", the start of the span"
    quiet = inactive_loads(scene, t, scaled)
    if not quiet:
        return words
    verb = "is" if len(quiet) == 1 else "are"
    return f"{words}, where {' and '.join(quiet)} {verb} 0, but not at all times"


def _sample_times(scene: Scene) -> Array:
    """Times of the span [s], dense enough that no load acts between two of them alone."""
    start, end = scene.integrate.span
    ends = np.array([start, *scene.breaks(), end])
    peaks = [peak for _, peak, _ in scene.time_functions.pulses()]
    return np.concatenate((np.linspace(start, end, TIMES), (ends[1:] + ends[:-1]) / 2, peaks))


def _is_ever_nonzero(e: Expression, times: Array) -> bool:
    return bool((np.asarray(e(times)) != 0).any())
