"""The instant at which an analysis takes loads that change with time."""

from __future__ import annotations

import numpy as np

from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError
from rodgen.scene.expression import Expression
from rodgen.scene.plain import plain
from rodgen.scene.tables import PLACES

SAMPLES = 1001  # over the span, beside what lies between break points


def instant(scene: Scene, t: float | None = None) -> float:
    """The time whose loads are taken [s]: t, by default the start of the scene's span.

    Raises SceneError for a time outside the span, where the scene says nothing of its loads.
    """
    start, end = scene.integrate.span
    t = start if t is None else plain(t, "t")
    if isinstance(t, bool) or not isinstance(t, int | float) or not start <= t <= end:
        raise SceneError("t", t, f"a time in the span of the scene, {start:g} to {end:g} s")
    return float(t)


def silent(scene: Scene, t: float) -> tuple[str, ...]:
    """Places, such as loads.follower.force, of the loads that are zero at t [s] and act at another
    time of the span."""
    times = _times(scene)
    return tuple(
        f"loads.{'.'.join(PLACES[name])}"
        for name, e in scene.timed.items()
        if float(e(t)) == 0 and _acts(e, times)
    )


def in_words(scene: Scene, t: float) -> str:
    """What is to be said of the instant before any result: which one it is, and what it lacks."""
    words = f"loads as at t = {t:g} s"
    if t == scene.integrate.span[0]:
        words += ", the start of the span"
    quiet = silent(scene, t)
    if not quiet:
        return words
    verb = "is" if len(quiet) == 1 else "are"
    return f"{words}, where {' and '.join(quiet)} {verb} 0, but not at all times"


def _times(scene: Scene) -> Array:
    """Times of the span [s] at which no load can hide between two others."""
    start, end = scene.integrate.span
    ends = np.array([start, *scene.breaks(), end])
    peaks = [peak for _, peak, _ in scene.pulses()]
    return np.concatenate((np.linspace(start, end, SAMPLES), (ends[1:] + ends[:-1]) / 2, peaks))


def _acts(e: Expression, times: Array) -> bool:
    return bool((np.asarray(e(times)) != 0).any())
