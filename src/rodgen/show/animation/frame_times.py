"""Samples that an animation shows, and their times."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError

VIEWS = ("fixed", "centre", "axes")
LONGEST_FILM, SHORTEST_FILM = 60.0, 3.0  # seconds of film at a speed that is not given
REAL = 0.1  # share by which a speed that is chosen may miss real time, to be real time
MOST_FRAMES = 36_000  # twenty minutes at 30 a second
LEAST_PIXELS, MOST_PIXELS = 320, 4096  # of width and height; H.264's common levels end there
FINER = 4  # samples of the trails in the time of a frame


@dataclass(frozen=True)
class FilmSettings:
    """Settings of a film. fps: frames a second; speed: simulated seconds in a second of film, and
    view: one of VIEWS, both chosen if None; width and height [pixels]; bounds: simulated times (a,
    b) [s], those of the run if None. Raises InputError for what cannot be used."""

    fps: float = 30.0
    speed: float | None = None
    view: str | None = None
    width: int = 1280
    height: int = 720
    bounds: tuple[float | None, float | None] = (None, None)

    def __post_init__(self) -> None:
        if not 1 <= self.fps <= 120:
            raise InputError("fps", self.fps, "from 1 to 120 frames a second")
        if self.speed is not None and not 0 < self.speed < math.inf:
            raise InputError("speed", self.speed, "a positive number")
        if self.view is not None and self.view not in VIEWS:
            raise InputError("view", self.view, f"one of {', '.join(VIEWS)}")
        for name in ("width", "height"):
            pixels = getattr(self, name)
            if not LEAST_PIXELS <= pixels <= MOST_PIXELS or pixels % 2:
                allowed = f"an even number from {LEAST_PIXELS} to {MOST_PIXELS}"
                raise InputError(name, pixels, allowed)


@dataclass(frozen=True)
class FramePlan:
    """Samples of a film. kept: numbers of those that are read, ascending, (S,); frames: which of
    them every frame shows, (F,); times: simulated time of every frame [s], (F,); speed: simulated
    seconds a second; repeated: frames that show the same sample as the one before."""

    kept: NDArray[np.intp]
    frames: NDArray[np.intp]
    times: Array
    speed: float
    repeated: int


def plan_frames(t: Array, settings: FilmSettings) -> FramePlan:
    """Choose the samples of a film: those of times t (T,) nearest to its frames, and some between
    for the trails; raises InputError for a span that the run does not have."""
    if not len(t):
        raise InputError("result", "no samples", "a run with at least one sample")
    start, end = _span(t, settings)
    samples = max(int(np.count_nonzero((t >= start) & (t <= end))), 2)
    speed = settings.speed or _speed(end - start, settings.fps / (samples - 1))
    frames = math.floor((end - start) / speed * settings.fps * (1 + 1e-12)) + 1
    if frames > MOST_FRAMES:
        least = (end - start) * settings.fps / (MOST_FRAMES - 1)
        raise InputError("speed", speed, f"at least {least:.3g}: {MOST_FRAMES} frames at most")
    step = speed / settings.fps
    fine: Array = start + step / FINER * np.arange((frames - 1) * FINER + 1.0)
    shown = nearest_samples(t, fine[::FINER])
    kept = np.unique(nearest_samples(t, fine))
    repeated = int(np.count_nonzero(np.diff(shown) == 0))
    return FramePlan(kept, np.searchsorted(kept, shown), fine[::FINER], speed, repeated)


def _span(t: Array, settings: FilmSettings) -> tuple[float, float]:
    first, last = float(t[0]), float(t[-1])
    low, high = settings.bounds
    start, end = first if low is None else low, last if high is None else high
    # What a user copies from a summary is rounded.
    slack = 1e-6 * (last - first)
    if not all(first - slack <= value <= last + slack for value in (start, end)):
        allowed = f"times of the run, from {first:.9g} to {last:.9g} s"
        raise InputError("bounds", settings.bounds, allowed)
    if start > end or (start == end and first < last):
        raise InputError("bounds", settings.bounds, f"(a, b) with b later than {start:.9g} s")
    return max(start, first), min(end, last)


def _speed(span: float, least: float) -> float:
    """Choose the speed: real time where the film is then neither very long nor short; two digits.

    least: share of the span in a second at which every frame has a sample of its own.
    """
    wanted = max(span / LONGEST_FILM, min(max(1 / SHORTEST_FILM, least) * span, 1.0))
    if not wanted or abs(wanted - 1) < REAL:
        return 1.0
    unit = 10.0 ** (math.floor(math.log10(wanted)) - 1)
    return unit * math.ceil(wanted / unit * (1 - 1e-9))


def nearest_samples(t: Array, times: Array) -> NDArray[np.intp]:
    """Return the numbers of the samples at t (T,), ascending, nearest to each of the times."""
    after = np.clip(np.searchsorted(t, times), 1, max(len(t) - 1, 1))
    before = after - 1
    after = np.minimum(after, len(t) - 1)
    late: NDArray[np.bool_] = t[after] - times < times - t[before]
    return np.where(late, after, before)
