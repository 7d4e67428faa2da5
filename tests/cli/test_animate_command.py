"""rodgen animate: films from results."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import rodgen as package
from rodgen.integrate.files.storage import Excerpt
from rodgen.scene import Scene
from rodgen.show.animation.files import ffmpeg

Run = Callable[..., subprocess.CompletedProcess[str]]
SIZE = ("--width", 480, "--height", 320)


@pytest.fixture
def result(make_scene: Callable[..., Scene], tmp_path: Path) -> Path:
    """A result of 201 samples, in a folder of its own."""
    scene = make_scene(3, "clamped", terms=("follower", "gravity"), span=[0.0, 2.0], rtol=1e-6)
    path = tmp_path / "from" / "run.nc"
    path.parent.mkdir()
    package.simulate(scene, target="numpy").save(path)
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where films go."""
    path = tmp_path / "to"
    path.mkdir()
    return path


def test_gif_of_a_part(rodgen: Run, result: Path, folder: Path) -> None:
    film = folder / "film.gif"
    times = ("--from", 0.5, "--to", 1.5, "--fps", 10)
    done = rodgen("animate", result, "--out", film, *times, *SIZE, "--speed", 0.5)
    assert done.returncode == 0, done.stderr
    assert "21 frames of 480 x 320, 2.1 s, speed 0.5, view" in done.stdout
    with Image.open(film) as opened:
        assert (opened.n_frames, opened.size) == (21, (480, 320))
    assert list(folder.iterdir()) == [film]


@pytest.mark.skipif(ffmpeg() is None, reason="no ffmpeg is installed, which MP4 needs")
def test_mp4_with_what_is_chosen(rodgen: Run, result: Path, folder: Path) -> None:
    film = folder / "film.mp4"
    done = rodgen("animate", result, "--out", film, *SIZE, "--view", "axes")
    assert done.returncode == 0, done.stderr
    # 2 s are slowed down to 3 s of film: 0.67 with two digits; 2/0.67*30 = 89.6.
    assert "90 frames of 480 x 320, 3 s, speed 0.67 (chosen), view axes." in done.stdout
    assert film.read_bytes()[4:8] == b"ftyp"


def test_coarse_samples_are_told_of(rodgen: Run, result: Path, folder: Path) -> None:
    """At a speed of 0.05 and 50 frames a second, ten frames show each sample."""
    film = folder / "film.gif"
    part = ("--to", 0.1, "--speed", 0.05, "--fps", 50)
    done = rodgen("animate", result, "--out", film, *SIZE, *part)
    assert done.returncode == 0, done.stderr
    assert "90% of them repeat the one before" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("run.nc", "--out", "film.mov"), "a file that ends in .mp4 or .gif"),
        (("run.nc", "--out", "none/film.gif"), "in a folder that exists"),
        (("run.nc", "--out", "/proc/film.gif"), "--out = '/proc': must be a folder to write into"),
        (("run.nc", "--out", "film.gif", "--from", "5"), "a time of the run, from 0 to 2 s"),
        (("run.nc", "--out", "film.gif", "--fps", "-1"), "from 1 to 120"),
    ],
)
def test_bad_input_ends_in_one_line(
    rodgen: Run, result: Path, arguments: tuple[str, ...], said: str
) -> None:
    before = sorted(result.parent.iterdir())
    done = rodgen("animate", *arguments, cwd=result.parent)
    assert done.returncode == 2
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
    assert sorted(result.parent.iterdir()) == before


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("ending", "sent"),
    list(product(("gif", "mp4"), (signal.SIGINT, signal.SIGTERM))),
)
def test_stopped_film_leaves_nothing(
    result: Path, folder: Path, ending: str, sent: signal.Signals
) -> None:
    if ending == "mp4" and ffmpeg() is None:
        pytest.skip("no ffmpeg is installed, which MP4 needs")
    program = "from rodgen.cli import main; main()"
    film = folder / f"film.{ending}"
    slow = ["--speed", "0.002", "--fps", "30"]  # 30,000 frames
    command = [sys.executable, "-c", program, "animate", str(result), "--out", str(film), *slow]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    # As it is in the background of a script, where a kill is to end it all the same.
    before = signal.signal(signal.SIGINT, signal.SIG_IGN) if sent == signal.SIGTERM else None
    process = subprocess.Popen(command, **pipes)
    if before is not None:
        signal.signal(signal.SIGINT, before)
    try:
        deadline = time.monotonic() + 60
        while not list(folder.iterdir()) and time.monotonic() < deadline:
            time.sleep(0.02)
        assert [path.name.startswith(".film.") for path in folder.iterdir()] == [True]
        time.sleep(0.3)
        process.send_signal(sent)
        _, said = process.communicate(timeout=30)
    finally:
        process.kill()  # a fault would have it draw on for half an hour
    assert process.returncode == 130
    assert said.decode().strip() == "rodgen: interrupted"
    assert not list(folder.iterdir())


def test_only_the_samples_that_are_shown_are_read(result: Path) -> None:
    stored = Excerpt(result)
    whole = package.load(result)
    assert np.array_equal(stored.t, whole.t)
    kept = np.array([0, 3, 4, 200])
    some = stored.at(kept)
    assert np.array_equal(some.y, whole.y[kept])
    assert np.array_equal(some.t, whole.t[kept])
    assert (some.status, some.scene, some.stats) == (whole.status, whole.scene, whole.stats)


def test_damaged_result_is_drawn_only_if_asked_for(
    rodgen: Run, result: Path, folder: Path, tmp_path: Path
) -> None:
    damaged = bytearray(result.read_bytes())
    damaged[-20] ^= 1  # in the last sample
    path = tmp_path / "damaged.nc"
    path.write_bytes(damaged)
    film = folder / "film.gif"
    command = ("animate", path, "--out", film, "--fps", 2, *SIZE)
    done = rodgen(*command)
    assert done.returncode == 2
    assert "1 sample after t = " in done.stderr
    assert not film.exists()
    done = rodgen(*command, "--damaged")
    assert done.returncode == 0, done.stderr
    assert "warning" in done.stderr
    assert "1 sample after t = " in done.stderr
    assert film.exists()
