"""Animations, decoded again: marks are where the angles say, and nothing is left of a failure."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.quiver import QuiverKey
from PIL import Image, ImageSequence

from rodgen.errors import InputError
from rodgen.integrate import Solution
from rodgen.integrate.files.file_layout import NO_STATS
from rodgen.model.palette import LIGHT, colours_of
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.show.animation.film import FrameRenderer, animate
from rodgen.show.animation.film_files import find_ffmpeg
from rodgen.show.animation.frame_times import FilmSettings, nearest_samples, plan_frames
from rodgen.show.animation.motion import sample_motion
from rodgen.system import System
from tests.palette import cases
from tests.told import refused
from tests.view.marks import turned

Make = Callable[..., Solution]
Pixels = np.ndarray
SMALL: dict[str, Any] = {"width": 640, "height": 480, "fps": 10, "speed": 1}
AXES = np.s_[40:430, 60:500]  # pixels of such a film that are inside the axes, without the clock
LARGE = np.s_[90:650, 90:1070]  # the same of 1280 x 720
TAIL, BODY = (tuple(bytes.fromhex(str(LIGHT[of])[1:])) for of in ("tail", "body"))  # of their marks
needs_ffmpeg = pytest.mark.skipif(
    find_ffmpeg() is None, reason="MP4 needs ffmpeg, which is not here"
)


@pytest.fixture
def moved(make_scene: Callable[..., Scene]) -> Make:
    """A solution with the given states over time; no integration is needed for a picture."""

    def make(t: Any, y: Any, **rod: Any) -> Solution:
        return Solution(
            System(make_scene(**rod)), np.array(t, float), np.array(y, float), {}, NO_STATS
        )

    return make


@pytest.fixture
def pendulum(moved: Make) -> Solution:
    """One link, from 0 to 180 degrees in 13 samples."""
    phi = np.pi * np.arange(13) / 12
    return moved(phi * 0 + np.arange(13) / 10, np.c_[phi, phi], links=1, boundary="pinned")


def frames(path: Path) -> Iterator[Pixels]:
    """Frames of a GIF, (height, width, 3)."""
    with Image.open(path) as film:
        for frame in ImageSequence.Iterator(film):
            yield np.asarray(frame.convert("RGB"))


def tail(frame: Pixels, tolerance: int = 12, inside: Any = AXES, colour: Any = TAIL) -> Pixels:
    """Middle of the tail's mark, or of one of another colour [pixels], x and y to the right and
    up."""
    rows, columns = np.nonzero(np.abs(frame[inside].astype(int) - colour).max(axis=-1) <= tolerance)
    assert len(rows) > 5, "no mark of the tail"
    return np.array([columns.mean(), -rows.mean()])


def on_a_circle(places: Pixels, phi: Pixels, tolerance: float) -> None:
    """Places of the tail are on a circle, at angles phi from 0 to pi."""
    middle, across = (places[0] + places[-1]) / 2, (places[0] - places[-1]) / 2
    radius = np.hypot(*across)
    assert radius > 100  # pixels: the rod fills the picture
    assert np.abs(places - middle - radius * np.c_[np.cos(phi), np.sin(phi)]).max() < tolerance


def test_gif_shows_the_tail_where_the_angle_says(pendulum: Solution, tmp_path: Path) -> None:
    """With a trail behind it: half way along the arc there is one at the end, none at the start.
    Frames of 1/30 s take hundredths, 3, 3 and 4 of them, so that the whole is right."""
    told: list[float] = []
    path = tmp_path / "film.gif"
    film = animate(pendulum, path, progress=told.append, **SMALL | {"fps": 30, "speed": 3})
    assert (film.frames, film.view) == (13, "fixed")
    assert film.seconds == pytest.approx(13 / 30)
    shown = list(frames(path))
    assert len(shown) == 13
    assert {frame.shape for frame in shown} == {(480, 640, 3)}
    # Half a pixel of rounding in each of the mark and the two that the circle is made of.
    on_a_circle(np.array([tail(frame) for frame in shown]), pendulum.phi[:, 0], 1.5)
    assert told == pytest.approx(pendulum.t)
    with Image.open(path) as opened:
        assert opened.info["loop"] == 0  # without an end
        assert tuple(np.asarray(opened.convert("RGB"))[2, 2]) == (255, 255, 255)
        durations = [frame.info["duration"] for frame in ImageSequence.Iterator(opened)]
    assert sum(durations) == pytest.approx(1000 * 13 / 30, abs=5)  # half a hundredth
    assert set(durations) == {30, 40}
    column, row = np.round(tail(shown[3]) * [1, -1]).astype(int)
    around = np.s_[row - 3 : row + 4, column - 3 : column + 4]
    first, last = (np.abs(shown[k][AXES][around].astype(int) - TAIL).sum(-1) for k in (0, -1))
    assert last.min() < 150 < first.min()  # it is transparent, by a quarter, and thin
    assert [found.name for found in tmp_path.iterdir()] == ["film.gif"]


@pytest.mark.slow
@needs_ffmpeg
def test_mp4_shows_the_same(pendulum: Solution, tmp_path: Path) -> None:
    path = tmp_path / "film.MP4"
    film = animate(pendulum, path, fps=10, speed=1)
    form = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-")
    command = [str(find_ffmpeg()), "-hide_banner", "-i", str(path), *form]
    done = subprocess.run(command, capture_output=True, check=True, timeout=600)
    (stream,) = re.findall(r"Video: h264.*", done.stderr.decode())
    assert all(word in stream for word in ("yuv420p", "1280x720", "10 fps"))
    shown = np.frombuffer(done.stdout, np.uint8).reshape(-1, 720, 1280, 3)
    assert len(shown) == film.frames == 13
    # Colour has half of the pixels, and is compressed: its mark is less sharp.
    on_a_circle(np.array([tail(frame, 40, LARGE) for frame in shown]), pendulum.phi[:, 0], 2.5)


@pytest.mark.parametrize(
    "view", ["fixed", *(pytest.param(v, marks=pytest.mark.slow) for v in ("centre", "axes"))]
)
def test_views_of_a_turning_rod(moved: Make, tmp_path: Path, view: str) -> None:
    """A rod that turns about its middle while that flies away, 5 m/s: the tail's mark stays where
    it is if the view turns with the rod, turns if it only moves along, and else flies. At 1e12 m
    doubles are 1.2e-4 m apart, less than a pixel of a rod of 2 m."""
    t = np.arange(5) / 5
    phi = 2.0 * t
    nose = np.c_[1e12 + 5 * t, 0 * t - 3e11] - np.c_[np.cos(phi), np.sin(phi)]
    sol = moved(t, np.c_[nose, phi, np.zeros((5, 3))], links=1)
    path = tmp_path / "film.gif"
    animate(sol, path, view=view, **SMALL | {"fps": 5})
    places = np.array([tail(frame) for frame in frames(path)])
    away = np.hypot(*(places - places[0]).T)
    if view == "fixed":
        ahead = np.c_[5 * t + np.cos(phi), np.sin(phi)]
        scale = away[-1] / np.hypot(*(ahead[-1] - ahead[0]))
        assert np.abs(places - places[0] - scale * (ahead - ahead[0])).max() < 1.5
    elif view == "centre":  # two ends of a chord of a circle about the middle of the rod
        assert away[-1] / away[2] == pytest.approx(np.sin(0.8) / np.sin(0.4), abs=0.02)  # of 100
    else:
        assert away.max() < 1.5


@pytest.mark.slow
def test_a_body_is_drawn_beside_its_link(moved: Make, tmp_path: Path) -> None:
    """Half-way along a rod of 2 m, and 0.6 m to its left, whichever way the rod points."""
    sol = moved([0.0, 0.1], [[0, 0], [np.pi, 0]], links=1, boundary="pinned")
    body = {"name": "tank", "at": 0.5, "mass": 6.0, "offset": [0.0, 0.6]}
    scene = Scene.from_dict(sol.scene.model_dump(exclude_none=True) | {"bodies": [body]})
    path = tmp_path / "film.gif"
    animate(replace(sol, system=System(scene), model=None), path, **SMALL)
    shown = list(frames(path))
    ends, bodies = (np.array([tail(f, 4, colour=c) for f in shown]) for c in (TAIL, BODY))
    middle, half = ends.mean(axis=0), (ends[0] - ends[1]) / 2
    beside = 0.3 * np.array([0, half[0]])  # 0.6 m of 2 m, upwards
    np.testing.assert_allclose(bodies[0], middle + half / 2 + beside, atol=1.5)
    np.testing.assert_allclose(bodies[1], middle - half / 2 - beside, atol=1.5)


@pytest.mark.slow
def test_colour_tells_the_sign_of_the_bending(moved: Make, tmp_path: Path) -> None:
    """One way in a frame, the other way in the next."""
    bent = [[0, 0, 0, angle, 0, 0, 0, 0] for angle in (0.5, -0.5)]
    path = tmp_path / "film.gif"
    animate(moved([0.0, 0.1], bent, links=2), path, **SMALL)
    blue, *_, red = (list(bytes.fromhex(end[1:])) for end in colours_of("moments"))
    for frame, (due, other) in zip(frames(path), ((red, blue), (blue, red)), strict=True):
        shown = frame[AXES].astype(int)
        counts = [np.count_nonzero(np.abs(shown - end).max(axis=-1) < 12) for end in (due, other)]
        assert counts[0] > 50 > counts[1]  # pixels: some of the rod


@pytest.mark.nightly
def test_run_that_blew_up_is_drawn_up_to_there(pendulum: Solution, tmp_path: Path) -> None:
    path = tmp_path / "film.gif"
    for bad in (np.nan, np.inf, -1e16):
        pendulum.y[7:] = bad
        film = animate(pendulum, path, **SMALL)
        assert film.frames == len(list(frames(path))) == 7
        assert "t = 0.7 s" in film.notes[0]
    pendulum.y[0] = np.nan
    path.unlink()
    with pytest.raises(InputError):
        animate(pendulum, path, **SMALL)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "ending", ["gif", pytest.param("mp4", marks=[needs_ffmpeg, pytest.mark.slow])]
)
def test_nothing_is_left_of_what_was_stopped(
    pendulum: Solution, tmp_path: Path, ending: str
) -> None:
    before = tmp_path / f"film.{ending}"
    before.write_text("an older film")

    def stop(t: float) -> None:
        if t > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        animate(pendulum, before, progress=stop, **SMALL)
    assert [path.name for path in tmp_path.iterdir()] == [before.name]
    assert before.read_text() == "an older film"


REFUSED: dict[str, list[tuple[str, dict[str, Any]]]] = {
    "--out": [("film.avi", {}), ("film", {}), ("nowhere/film.gif", {})],
    "fps": [("film.gif", {"fps": rate}) for rate in (60, 0, float("nan"))],
    "speed": [("film.gif", {"speed": speed}) for speed in (0.0, float("inf"), 1e-9)],
    "view": [("film.gif", {"view": "sideways"})],
    "width": [("film.gif", {"width": 641})],
    "height": [("film.gif", {"height": 100_000})],
    "bounds": [
        *(("film.gif", {"bounds": bounds}) for bounds in ((-1.0, None), (None, float("nan")))),
        ("film.gif", {"bounds": (0.5, 0.4)}),
    ],
}


def test_bad_input_is_refused(pendulum: Solution, tmp_path: Path) -> None:
    for field, given in REFUSED.items():
        for file, change in given:
            assert refused(animate, pendulum, tmp_path / file, **SMALL | change).field == field
    assert not list(tmp_path.iterdir())


def test_ffmpeg_that_is_missing_or_fails_is_told_of(
    pendulum: Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """How it is installed; and what it says itself."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(InputError, match=r"pip install"):
        animate(pendulum, tmp_path / "film.mp4", **SMALL)
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\necho 'Unknown encoder libx264' >&2\nexit 1\n")
    program.chmod(0o755)
    with pytest.raises(InputError, match="Unknown encoder libx264"):
        animate(pendulum, tmp_path / "film.mp4", **SMALL)
    assert list(tmp_path.iterdir()) == [program]


def test_speed_is_chosen() -> None:
    for span, samples, speed in (
        (120.0, 10_000, 2.0),  # a minute of film
        (10.0, 10_000, 1.0),
        (2.92, 293, 1.0),  # not slowed 1.02 times
        (64.0, 10_000, 1.0),
        (0.3, 10_000, 0.1),  # three seconds of film
        (0.3, 46, 0.2),  # 45 intervals, shown at 30 a second: 1.5 s
        (1e-6, 10_000, 3.4e-7),  # a third, with two digits, rounded up
    ):
        planned = plan_frames(np.linspace(0, span, samples), FilmSettings())
        assert planned.speed == pytest.approx(speed)
        assert len(planned.frames) == int(span / speed * 30 + 1e-9) + 1


def test_nearest_samples_are_taken() -> None:
    random = np.random.default_rng(7)
    t = np.sort(random.uniform(0, 1, 50))
    times = random.uniform(-0.1, 1.1, 400)
    assert (nearest_samples(t, times) == np.abs(t[:, None] - times).argmin(axis=0)).all()
    assert (nearest_samples(t[:1], times) == 0).all()
    planned = plan_frames(t, FilmSettings(bounds=(float(t[10]), float(t[30]))))
    assert np.abs(t[planned.kept[planned.frames]] - planned.times).max() == pytest.approx(
        np.abs(t[:, None] - planned.times).min(axis=0).max()
    )


def test_the_arrow_of_the_key_is_as_long_as_its_force(make_scene: Callable[..., Scene]) -> None:
    """It was lost where the load began to act at the origin of the picture."""
    changes = {"loads.follower.force": 7.0, "loads.follower.at": 0.0}
    scene = make_scene(1, "free", ("follower",)).replace(changes)
    states = np.array([[0.0] * 6, [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]])
    sol = Solution(System(scene), np.array([0.0, 1.0]), states, {}, NO_STATS)
    stage = FrameRenderer(
        sample_motion(sol), scene, FilmSettings(view="fixed", width=640, height=480), 1.0
    )._stage
    stage.canvas.draw()
    key = next(one for one in stage.axes.get_children() if isinstance(one, QuiverKey))
    longest = 0.2 * min(stage.size) / 2  # pixels of the largest force
    drawn = np.ptp(key.vector.get_paths()[0].vertices[:, 0])
    assert drawn == pytest.approx(key.U / 7.0 * longest, abs=0.01)  # of a pixel


def test_a_couple_is_as_long_an_arc_as_it_is_large(make_scene: Callable[..., Scene]) -> None:
    """About its point, in the picture's view; one below a fiftieth of the largest is not drawn."""
    scene = make_scene(1, "pinned").replace({"loads.moment": {"moment": "4*cos(t)", "at": 0.5}})
    t = np.array([0.0, np.pi / 2, 2 * np.pi / 3])
    sol = Solution(System(scene), t, np.zeros((3, 2)), {}, NO_STATS)
    settings = FilmSettings(view="fixed", width=640, height=480)
    film = FrameRenderer(sample_motion(sol), scene, settings, 1.0)
    assert film._couples.names == ("moment",)
    ((_, _, line),) = film._couples._drawn
    found = []
    for k in (0, 2):
        film.render(k, t[k])
        arc = np.transpose(line.get_data())[:-3] - [1.0, 0.0]
        found.append(np.ptp(np.unwrap(np.arctan2(arc[:, 1], arc[:, 0]))))
        assert np.ptp(np.linalg.norm(arc, axis=1)) < 1e-12
    assert found[1] == pytest.approx(found[0] / 2)
    assert found[0] == pytest.approx(2 * np.pi * 3 / 4)
    assert "3/4 of a circle: 4 N m" in [text.get_text() for text in film._stage.figure.texts]
    pictures = [film.render(k, 0.0).copy() for k in (0, 1)]
    blue = tuple(bytes.fromhex(TERMS["moment"].colours[0][1:]))
    seen = [int((picture[AXES][..., :3] == blue).all(axis=-1).sum()) for picture in pictures]
    assert seen[0] > 20
    assert seen[1] == 0


@cases("view", ("fixed", "axes"))
def test_a_clamp_turns_in_the_film(make_scene: Callable[..., Scene], view: str) -> None:
    """With the base, and against a picture that turns with the rod."""
    scene = make_scene(2, "cantilever").replace({"base": {"angle": "0.5*t", "x": "t"}})
    y = np.zeros((3, 2))
    y[:, 0] = 0.5 * (t := np.array([0.0, 1.0, 2.0]))  # straight: all of it turns
    film = FrameRenderer(
        sample_motion(Solution(System(scene), t, y, {}, NO_STATS)),
        scene,
        FilmSettings(view=view, width=640, height=480),
        1.0,
    )
    found = []
    for k in range(3):
        film.render(k, t[k])
        found.append(turned(film._start))
    # An axis points from the tail to the nose: half a turn.
    assert np.diff(found) == pytest.approx([0.5 * (view == "fixed")] * 2, abs=1e-9)
    assert found[0] % np.pi == pytest.approx(0.0, abs=1e-9)
    assert len(film._trails[-1][0].get_xydata()) == 3  # of the root


def test_names_of_loads_are_within_the_film(make_scene: Callable[..., Scene]) -> None:
    """The longest as well."""
    scene = make_scene(2, terms=("distributed_follower",))
    sol = Solution(System(scene), np.array([0.0]), scene.initial_state()[None], {}, NO_STATS)
    stage = FrameRenderer(sample_motion(sol), scene, FilmSettings(view="fixed"), 1.0)._stage
    (legend,) = stage.figure.legends
    assert "distributed follower force" in [text.get_text() for text in legend.get_texts()]
    assert legend.get_window_extent().x1 <= stage.canvas.get_width_height()[0]


@cases("view, size", ("fixed", "centre", "axes"), ((1280, 720), (640, 480), (320, 640)))
def test_grid_is_square(moved: Make, view: str, size: tuple[int, int]) -> None:
    """One step along both axes, some centimetres of a screen; where the picture moves, the
    legend says it."""
    settings = FilmSettings(view=view, width=size[0], height=size[1])
    sol = moved([0.0, 1.0], [[0, 0, 1.2, 0, 0, 0], [3.0, 1, 0.3, 0, 0, 0]], links=1)
    stage = FrameRenderer(sample_motion(sol), sol.scene, settings, 1.0)._stage
    axes = (stage.axes.xaxis, stage.axes.yaxis)
    steps = np.concatenate([np.diff(axis.get_majorticklocs()) for axis in axes])
    assert steps == pytest.approx(np.full(len(steps), stage.grid_step))
    low, high = stage.axes.get_ylim()
    assert 50 < stage.grid_step / (high - low) * stage.size[1] / stage.zoom < 160  # pixels
    texts = [text.get_text() for text in stage.figure.legends[0].get_texts()]
    assert any(f"{stage.grid_step:g} m" in text for text in texts) is (view != "fixed")
