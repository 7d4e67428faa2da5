"""Open-ended runs that are asked for frame by frame."""

from __future__ import annotations

import numpy as np

import rodgen
from rodgen.scene import Scene
from rodgen_live.open_run import Live, Samples

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
