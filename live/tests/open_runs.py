"""Open-ended runs that are asked for frame by frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import rodgen
from rodgen.arrays import Array
from rodgen.scene import Scene
from rodgen_live.open_run import Live
from rodgen_live.sample_store import Chunk

FRAME = 0.0137  # seconds between two times asked for, which are no samples


def live_of(scene: Scene, target: str = "c", every: float = 0.01) -> Live:
    """A run of the scene, with a sample every so many seconds."""
    return Live(scene, rodgen.build(scene, target), every)


def parts(chunk: Chunk) -> tuple[Array, Array, Array]:
    """Times, states and works of samples."""
    return chunk.t, chunk.y, chunk.work


def gone_on(live: Live, to: float, frame: float = FRAME) -> Chunk:
    """All samples up to a time, asked for frame by frame."""
    found, at = [], live.here().t[0]
    while at < to:
        at = min(at + frame, to)
        found.append(live.advance(at, 60.0))
    t, y, work = map(np.concatenate, zip(*map(parts, found), strict=True))
    return replace(found[-1], t=t, y=y, work=work)
