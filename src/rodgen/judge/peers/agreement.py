"""Whether a peer's formulation is that of the scene: its accelerations against rodgen's."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import rodgen
from rodgen.judge.peers.stretches import stretches
from rodgen.judge.precision.contestant import Array
from rodgen.judge.precision.job import Job

AGREED = 1e-6  # relative: coordinates from link to link lose digits with n^4, 6e-10 at 50 links
STATES = 3  # that are looked at in every stretch
BEND, SPEED = 0.1, 0.5  # rad from link to link, rad/s (and m/s)

Accelerations = Callable[[float, Array], Array]  # t [s] and state -> second half of the rates


def random_states(scene: rodgen.Scene, count: int = STATES, seed: int = 1) -> Array:
    """States (count, states) of a rod bent at random, and moving."""
    draw, half = np.random.default_rng(seed), len(scene.initial_state()) // 2
    base = 2 if scene.hold.translates else 0
    bends = draw.normal(scale=BEND, size=(count, half))
    bends[:, base:] = np.cumsum(bends[:, base:], axis=1) + (scene.rod.clamp_angle or 0.0)
    return np.concatenate([bends, SPEED * draw.normal(size=(count, half))], axis=1)


def difference(theirs: Array, ours: Array) -> float:
    """The largest, over the largest of ours; infinite for what is not of one size, or no number."""
    if theirs.shape != ours.shape:
        return np.inf
    off = float(np.abs(theirs - ours).max() / np.abs(ours).max())
    return off if np.isfinite(off) else np.inf


def agreed(job: Job, theirs: Accelerations, limit: float = AGREED) -> float:
    """The largest relative difference, in every stretch of the loads.

    Raises ArithmeticError where it is beyond the limit.
    """
    half, worst = len(job.start) // 2, 0.0
    for stretch in stretches(job):
        for y in random_states(job.scene):
            ours = np.asarray(job.model.rhs(stretch.middle, y, job.p))[half:]
            worst = max(worst, difference(np.asarray(theirs(stretch.middle, y)), ours))
    if not worst <= limit:
        raise ArithmeticError(f"the accelerations differ from rodgen's by {worst:.1e}, relative")
    return worst
