"""Films of a run, in a file or in memory: its rod over time, frame by frame, as MP4 or GIF."""

from __future__ import annotations

import base64
import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from rodgen.arrays import Array, even_indices
from rodgen.errors import InputError
from rodgen.integrate import Solution
from rodgen.integrate.files import atomic_write
from rodgen.progress import show_run
from rodgen.scene import Scene
from rodgen.show.animation.film_files import check_file, find_ffmpeg, open_writer
from rodgen.show.animation.frame_times import FilmSettings, FramePlan, plan_frames
from rodgen.show.animation.load_arrows import CoupleArrows, LoadArrows
from rodgen.show.animation.motion import MotionSamples, choose_camera, ground_grid, sample_motion
from rodgen.show.animation.stage import GRID_STYLE, Stage
from rodgen.show.canvas import (
    BED,
    BODY,
    CENTRE,
    EDGE,
    FIXED,
    INK,
    MOMENTS,
    PAPER,
    TAIL,
    moment_norm,
)
from rodgen.show.marks import moves_root, start_name, turned_mark

LARGEST_FILMED = 1e15  # of any state: beyond, a double has no digits left for the shape
PALETTE = 8  # frames from which a GIF has its colours
Progress = Callable[[float], None]
TRAIL_SECONDS = 5.0  # seconds of film
ROD_WIDTH, EDGES_WIDTH = 3.6, 1.4  # points: widths of the rod, and of both its edges
LARGEST_BODY = 26.0  # points across: of a body that is the whole mass
LEAST_LINK = 8.0  # points: the joints of shorter links would hide the rod
SUPPORTS = {"none": ("o", 6.5), "pin": ("^", 11.0), "wall": ("s", 10.0)}  # marks, their sizes


@dataclass(frozen=True)
class Film:
    """A film that was written. frames: how many; seconds: its length [s]; speed: simulated seconds
    in a second of film; view: one of VIEWS; notes: on what could not be drawn as asked."""

    frames: int
    seconds: float
    speed: float
    view: str
    notes: tuple[str, ...]


@dataclass(frozen=True, repr=False)
class Video:
    """A film in memory: data as in a file; ending: of such a file, ".mp4" or ".gif"; about: its
    frames, and notes; width [pixels]."""

    data: bytes = field(repr=False)
    ending: str
    about: Film
    width: int

    def __repr__(self) -> str:
        frames = f"{self.about.frames} frames, {self.about.seconds:.4g} s"
        return f"<Video {self.ending}: {frames}, {len(self.data) / 1e6:.3g} MB>"

    def _repr_html_(self) -> str:
        """HTML that plays it again and again in notebooks."""
        coded, width = base64.b64encode(self.data).decode(), f'width="{self.width}"'
        if self.ending == ".gif":
            words = f'alt="a film of {self.about.seconds:.4g} s"'
            return f'<img {width} {words} src="data:image/gif;base64,{coded}">'
        source = f'src="data:video/mp4;base64,{coded}"'
        return f"<video {width} controls autoplay loop muted playsinline {source}></video>"

    def save(self, path: str | Path) -> None:
        """Write it to a file with its ending. Raises InputError for another ending."""
        path = Path(path)
        if path.suffix.lower() != self.ending:
            raise InputError("path", str(path), f"a file that ends in {self.ending}")
        path.write_bytes(self.data)


def animate(
    solution: Solution, path: Path, progress: Progress | None = None, **settings: Any
) -> Film:
    """Write an animation of a solution, .mp4 or .gif, whole or not at all; settings: those of
    FilmSettings.

    progress is told the simulated time [s] of every frame; what it raises ends the work. Can be
    called in any thread. Raises InputError for what cannot be used.
    """
    how = FilmSettings(**settings)
    planned = plan_frames(solution.t, how)
    return write_film(solution.isel(planned.kept), planned, path, how, progress)


def write_film(
    solution: Solution,
    planned: FramePlan,
    path: Path,
    settings: FilmSettings,
    progress: Progress | None = None,
) -> Film:
    """Write an animation of a run from those of its samples that the plan keeps."""
    path = Path(path)
    check_file(path, settings)
    frames, notes = _drawable_frames(solution, planned)
    moved = sample_motion(solution.head(int(frames[-1]) + 1))
    picture = FrameRenderer(moved, solution.scene, settings, planned.speed)
    with (
        atomic_write(path, "--out") as part,
        open_writer(
            part, path.suffix.lower(), settings, lambda: _palette_frames(picture, frames)
        ) as add,
    ):
        for k, when in zip(frames, planned.times, strict=False):
            add(picture.render(int(k), float(when)))
            if progress:
                progress(float(when))
    count = len(frames)
    return Film(count, count / settings.fps, planned.speed, picture.camera.view, tuple(notes))


def make_video(solution: Solution, width: int, **settings: Any) -> Video:
    """Make a film of a run in memory, MP4 where that can be made, else GIF; behind a bar. settings:
    those of FilmSettings. Raises InputError for what cannot be used."""
    ending = ".gif" if find_ffmpeg() is None else ".mp4"
    first, last = (float(solution.t[at]) for at in (0, -1)) if len(solution.t) else (0.0, 0.0)
    with tempfile.TemporaryDirectory() as folder, show_run("drawing", first, last) as update:
        path = Path(folder) / f"film{ending}"
        made = animate(solution, path, update, width=width, **settings)
        return Video(path.read_bytes(), ending, made, width)


def _drawable_frames(solution: Solution, planned: FramePlan) -> tuple[NDArray[np.intp], list[str]]:
    """Return the frames before a run blows up, by number of their sample, and notes on them."""
    notes = []
    good = np.all(np.abs(solution.y) <= LARGEST_FILMED, axis=1)
    bad = len(good) if good.all() else int(good.argmin())
    frames = planned.frames[planned.frames < bad]
    if not len(frames):
        raise InputError(
            "result", "not finite or beyond 1e15", "a run that can be drawn at its start"
        )
    if len(frames) < len(planned.frames):
        notes.append(f"from t = {solution.t[bad]:.9g} s on nothing can be drawn: it blew up")
    if planned.repeated:
        share = planned.repeated / max(len(planned.frames) - 1, 1)
        notes.append(f"samples are coarser than frames: {share:.0%} of them repeat the one before")
    return frames, notes


def _palette_frames(picture: FrameRenderer, frames: NDArray[np.intp]) -> NDArray[np.uint8]:
    """Draw some frames of a film, one above the other."""
    some = frames[even_indices(0, len(frames) - 1, PALETTE)]
    return np.concatenate([picture.render(int(k), 0.0) for k in some])


class FrameRenderer:
    """Drawing of the frames of a film: pixels(k, t) is that of sample k at time t.

    Like all of matplotlib's figures it belongs to one thread; it shares nothing with others.
    """

    def __init__(self, motion: MotionSamples, scene: Scene, settings: FilmSettings, speed: float):
        self._stage = stage = Stage(settings)
        self.camera = choose_camera(motion, settings.view, stage.aspect, scene.rod.length)
        stage.set_limits(self.camera)
        self._step = stage.grid_step
        stage.set_title(scene, speed)
        stage.add_colours(motion.label, motion.bending_limit, float(np.abs(motion.bending).max()))
        self._motion, self._trail = motion, TRAIL_SECONDS * speed
        self._joints = self.camera.to_picture(motion.joints)
        self._centre = self.camera.to_picture(motion.centre)
        self._arrows = LoadArrows(motion, self.camera, stage)
        self._couples = CoupleArrows(motion, self.camera, stage)
        loads = (*self._arrows.names, *self._couples.names)
        self._hold = SUPPORTS[scene.boundary_condition.start_drawing]
        bodies = bool(scene.bodies)
        stage.add_legend((self._hold[0], start_name(scene)), bodies, loads, self.camera.view)
        self._digits = min(max(2, math.ceil(-math.log10(speed / settings.fps))), 12)
        self._add_moving(scene)
        self._still = stage.draw_background()

    def _add_moving(self, scene: Scene) -> None:
        """Add the artists that are drawn in every frame."""
        stage, n, limit = self._stage, scene.rod.links, self._motion.bending_limit
        self._ground = stage.add_line(**GRID_STYLE)
        motion = self._motion
        paths = [(TAIL, motion.joints[:, -1]), (CENTRE, motion.centre)]
        paths += [(INK, motion.joints[:, 0])] * moves_root(scene)
        self._trails = [
            (stage.add_line(color, linewidth=1.1, alpha=0.75), path) for color, path in paths
        ]
        # Behind a rod that is pale where it is not bent.
        self._edge = stage.add_line(EDGE, linewidth=ROD_WIDTH + EDGES_WIDTH, solid_capstyle="round")
        self._rod = stage.add_lines(
            linewidth=ROD_WIDTH, capstyle="round", cmap=MOMENTS, norm=moment_norm(limit)
        )
        self._rod.set_snap(False)  # to whole pixels, in which a bent rod has steps
        # Views of one array are drawn: new paths in every frame would take most of its time.
        self._halves = np.zeros((2 * n, 2, 2))
        self._rod.set_segments(list(self._halves))
        self._bodies = [
            (mark, stage.add_mark(("o", LARGEST_BODY * mark.size), BODY, INK))
            for mark in scene.distribution.body_outlines
        ]
        self._anchors = scene.anchors
        self._bed = stage.add_line(BED, linewidth=9.0)
        self._obstacles = [(line, stage.add_line(FIXED, linewidth=2.5)) for line in scene.obstacles]
        self._ties = [
            (
                tie,
                stage.add_line(INK, linewidth=1.2, linestyle=":"),
                stage.add_mark(("^", 8.0), FIXED, INK),
            )
            for tie in self._anchors.support_points
        ]
        self._inner = stage.add_mark(("o", 3.6), PAPER, INK)
        self._start = stage.add_mark(self._hold, INK, INK)
        self._tail = stage.add_mark(("o", 6.0), TAIL, INK)
        self._middle = stage.add_mark(("o", 6.5), PAPER, CENTRE, 2.2)
        self._clock = stage.add_clock()
        link = scene.rod.length / n * stage.pixels_per_metre(self.camera)
        self._dotted = link * 72 / stage.figure.dpi >= LEAST_LINK

    def render(self, k: int, t: float) -> NDArray[np.uint8]:
        """Draw the frame of sample k, with the time t [s] as text: (height, width, 4) of red,
        green, blue, alpha; overwritten by the next."""
        stage = self._stage
        stage.canvas.restore_region(self._still)
        if self.camera.view != "fixed":
            self._show_ground(k)
        self._show_trails(k)
        self._show_anchors(k)
        self._show_rod(k)
        self._arrows.draw(k)
        self._couples.draw(k)
        self._show(self._middle, self._centre[k, None])
        self._clock.set_text(f"t = {t:.{self._digits}f} s")
        stage.axes.draw_artist(self._clock)
        return np.asarray(stage.canvas.buffer_rgba())

    def _show(self, line: Line2D, points: Array) -> None:
        line.set_data(points[:, 0], points[:, 1])
        self._stage.axes.draw_artist(line)

    def _show_ground(self, k: int) -> None:
        seen = self.camera
        reach = float(np.hypot(*seen.half))
        self._show(self._ground, ground_grid(seen.origin[k], seen.angle_of(k), self._step, reach))

    def _show_trails(self, k: int) -> None:
        t = self._motion.t
        first = int(np.searchsorted(t, t[k] - self._trail))
        for line, path in self._trails:
            self._show(line, self.camera.to_picture_at(k, path[first : k + 1]))

    def _show_anchors(self, k: int) -> None:
        self._show(self._bed, self.camera.to_picture_at(k, self._anchors.foundation_line))
        for points, line in self._obstacles:
            self._show(line, self.camera.to_picture_at(k, points))
        for tie, spring, fixed in self._ties:
            way = self.camera.to_picture_at(k, tie.segment(self._motion.joints[k]))
            self._show(spring, way)
            self._show(fixed, way[1:])

    def _show_rod(self, k: int) -> None:
        joints, bending = self._joints[k], self._motion.bending[k]
        self._show(self._edge, joints)
        self._halves[:] = half_links(joints)
        # The bending of a joint colours the halves of the links that meet there.
        self._rod.set_array(np.repeat(bending, 2)[1:-1])
        self._stage.axes.draw_artist(self._rod)
        if self._dotted:
            self._show(self._inner, joints[1:-1])
        turned = self._motion.clamp[k] - self.camera.angle_of(k)
        self._start.set_marker(turned_mark(self._hold[0], turned))
        self._show(self._start, joints[:1])
        self._show(self._tail, joints[-1:])
        for mark, disc in self._bodies:
            self._show(disc, mark.positions(joints)[None])


def half_links(joints: Array) -> Array:
    """Split the links between joints (n+1, 2) into halves: (2n, 2, 2)."""
    points: Array = np.empty((2 * len(joints) - 1, 2))
    points[::2] = joints
    points[1::2] = (joints[:-1] + joints[1:]) / 2
    return np.stack((points[:-1], points[1:]), axis=1)
