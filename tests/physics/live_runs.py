"""A bar, and runs without an end that are asked for frame by frame."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import rodgen
from rodgen.live.open_run import Live, Samples
from rodgen.scene import Scene

# On a tail, within some 0.03 s at t = 7.3 s: an impulse of 0.05 N s.
PULSE = {"y": f"{0.05 / (0.01 * math.sqrt(math.pi))!r}*exp(-((t - 7.3)/0.01)**2)"}
FRAME = 0.0137  # seconds between two times asked for, which are no samples


def live_of(scene: Scene, target: str = "c", every: float = 0.01) -> Live:
    """A run of the scene, with a sample every so many seconds."""
    return Live(scene, rodgen.build(scene, target), every)


def gone_on(live: Live, to: float, frame: float = FRAME) -> Samples:
    """All samples up to a time, asked for frame by frame."""
    parts, at = [], live.here().t[0]
    while at < to:
        at = min(at + frame, to)
        parts.append(live.advance(at, 60.0))
    return Samples(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def bar(boundary: str = "free", **tables: Any) -> Scene:
    """One link of 2 m and 3 kg."""
    rod = {"links": 1, "length": 2.0, "bending_stiffness": 1.0, "mass": 3.0, "boundary": boundary}
    return Scene.from_dict({"name": "bar", "rod": rod, **tables})
