"""Animations of a run: its rod over time, as MP4 or GIF."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate import Solution
from rodgen.integrate.files.whole import replaced
from rodgen.integrate.stepper import Array
from rodgen.scene import SceneError
from rodgen.view.animation.files import check_file, writer
from rodgen.view.animation.motion import motion
from rodgen.view.animation.picture import Picture
from rodgen.view.animation.times import Plan, Settings, plan

LARGEST = 1e15  # of any state: beyond, a double has no digits left for the shape
PALETTE = 8  # frames from which a GIF has its colours
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Film:
    """What was written: frames, seconds of film, simulated seconds in one of them, the view, and
    what is to be said of it."""

    frames: int
    seconds: float
    speed: float
    view: str
    notes: tuple[str, ...]


def animate(
    solution: Solution,
    path: Path,
    *,
    fps: float = 30.0,
    speed: float | None = None,
    view: str | None = None,
    width: int = 1280,
    height: int = 720,
    start: float | None = None,
    end: float | None = None,
    progress: Progress | None = None,
) -> Film:
    """Write an animation of a solution, .mp4 or .gif, whole or not at all; see Settings.

    progress is told the simulated time [s] of every frame; what it raises ends the work. Can be
    called in any thread. Raises SceneError for what cannot be used.
    """
    settings = Settings(fps, speed, view, width, height, start, end)
    return film(solution.t, solution.taken, path, settings, progress)


def film(
    t: Array,
    at: Callable[[NDArray[np.intp]], Solution],
    path: Path,
    settings: Settings,
    progress: Progress | None = None,
) -> Film:
    """The same of a run with samples at times t [s], (T,), of which `at` gives those that are
    asked for by their numbers."""
    path = Path(path)
    check_file(path, settings)
    planned = plan(t, settings)
    solution = at(planned.kept)
    frames, notes = _drawable(solution, planned)
    moved = motion(solution.until(int(frames[-1]) + 1))
    picture = Picture(moved, solution.scene, settings, planned.speed)
    with (
        replaced(path, "--out") as part,
        writer(part, path.suffix.lower(), settings, lambda: _colours(picture, frames)) as add,
    ):
        for k, when in zip(frames, planned.times, strict=False):
            add(picture.pixels(int(k), float(when)))
            if progress:
                progress(float(when))
    count = len(frames)
    return Film(count, count / settings.fps, planned.speed, picture.camera.view, tuple(notes))


def _drawable(solution: Solution, planned: Plan) -> tuple[NDArray[np.intp], list[str]]:
    """Frames before a run blows up, by number of their sample, and what is to be said of them."""
    notes = []
    good = np.all(np.abs(solution.y) <= LARGEST, axis=1)
    bad = len(good) if good.all() else int(good.argmin())
    frames = planned.frames[planned.frames < bad]
    if not len(frames):
        raise SceneError(
            "result", "not finite or beyond 1e15", "a run that can be drawn at its start"
        )
    if len(frames) < len(planned.frames):
        notes.append(f"from t = {solution.t[bad]:.9g} s on nothing can be drawn: it blew up")
    if planned.repeated:
        share = planned.repeated / max(len(planned.frames) - 1, 1)
        notes.append(f"samples are coarser than frames: {share:.0%} of them repeat the one before")
    return frames, notes


def _colours(picture: Picture, frames: NDArray[np.intp]) -> NDArray[np.uint8]:
    """Some frames of a film, one above the other."""
    some = frames[np.unique(np.linspace(0, len(frames) - 1, PALETTE).round().astype(int))]
    return np.concatenate([picture.pixels(int(k), 0.0) for k in some])
