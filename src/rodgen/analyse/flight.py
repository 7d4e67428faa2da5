"""How a free rod flies: its speed along its axis, from a scene or from a run of it."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from rodgen.analyse.errors import AnalysisError
from rodgen.integrate.outcome import RunError
from rodgen.integrate.simulate import simulate
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError
from rodgen.scene.overrides import with_state
from rodgen.scene.plain import plain

ROUNDING = 1e-9  # of the speed, below which a part of it is none
APART = 1e-5  # s, between the two positions from which a velocity follows


def velocity(model: ModuleType, y: Array, p: Array) -> Array:
    """Velocity (2,) of the centre of gravity in a state [m/s]."""
    # With joint 0 at the origin no digits are lost, and the rod turns little in so short a time.
    q, rates = np.split(y, 2)
    start, here = rates[:2], np.concatenate((np.zeros(2), q[2:]))
    largest = max(1.0, float(np.abs(rates[2:]).max(initial=0.0)))
    step = APART / largest * np.concatenate((np.zeros(2), rates[2:]))
    after, before = (
        np.asarray(model.centre_of_gravity(np.concatenate((here + sign * step, rates)), p))
        for sign in (1, -1)
    )
    turning: Array = (after - before) * largest / (2 * APART)
    return start + turning


def along_and_across(velocity: Array, angle: float) -> tuple[float, float]:
    """Its part along a rod of this angle, nose first, and its part across, to the left [m/s]."""
    c, s = np.cos(angle), np.sin(angle)
    parts = -float(velocity @ [c, s]), -float(velocity @ [-s, c])
    least = ROUNDING * float(np.linalg.norm(velocity))
    along, across = (part if abs(part) > least else 0.0 for part in parts)
    return along, across


def checked(scene: Scene, speed: float | None) -> float | None:
    """A speed that was asked for. Raises SceneError."""
    if speed is None:
        return None
    speed = plain(speed, "speed")
    if not (_is_number(speed) and np.isfinite(speed)):
        raise SceneError("speed", speed, "a finite number")
    if not scene.hold.translates:
        raise SceneError("speed", speed, f"absent: a {scene.rod.boundary} rod does not fly")
    return float(speed)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def flown(
    scene: Scene, t: float | None, speed: float | None, after: float | None
) -> tuple[Scene, float | None]:
    """The scene that starts in the state that its run has reached after so many seconds, and that
    time; where no time is asked for, the scene itself and t. Raises SceneError, AnalysisError."""
    if after is None:
        return scene, t
    start, end = scene.integrate.span
    after = plain(after, "after")
    if not (_is_number(after) and start <= after <= end):
        raise SceneError("after", after, f"a time in the span, {start:g} to {end:g} s")
    for name, value in (("t", t), ("speed", speed)):
        if value is not None:
            raise SceneError(name, value, "absent: that of the run is taken (after)")
    if after == start:
        return scene, float(after)
    table = scene.model_dump(exclude_none=True)
    given = {k: value for k, value in table["integrate"].items() if k != "t_eval"}
    given |= {"span": [start, float(after)], "output_every": float(after) - start}
    try:
        run = simulate(Scene.from_dict(table | {"integrate": given}))
    except RunError as error:
        raise AnalysisError(f"the run up to {after:g} s cannot be finished: {error}") from error
    if run.t[-1] < after:
        raise SceneError("after", after, f"before the run ends, at {run.t[-1]:g} s")
    return with_state(scene, run.y[-1]), float(after)
