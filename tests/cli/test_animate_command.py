"""rodgen animate: films from results."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from itertools import product
from pathlib import Path

import pytest
from PIL import Image

import rodgen as package
from rodgen.scene import Scene
from rodgen.show.animation.files import ffmpeg
from tests.cli.conftest import Run, numbers

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


def test_gif_of_a_part(works: Run, result: Path, folder: Path) -> None:
    """Ten frames a second of a second that is slowed down to two, and the last."""
    film = folder / "film.gif"
    times = ("--from", 0.5, "--to", 1.5, "--fps", 10)
    done = works("animate", result, "--out", film, *times, *SIZE, "--speed", 0.5)
    assert {21, 480, 320, 2.1, 0.5} <= {*numbers(done.stdout)}
    assert done.stderr == ""
    with Image.open(film) as opened:
        assert (opened.n_frames, opened.size) == (21, (480, 320))
    assert list(folder.iterdir()) == [film]


@pytest.mark.slow
@pytest.mark.skipif(ffmpeg() is None, reason="no ffmpeg is installed, which MP4 needs")
def test_mp4_with_what_is_chosen(works: Run, result: Path, folder: Path) -> None:
    """2 s are slowed down to 3 s of film: 0.67 with two digits, and 2/0.67*30 = 89.6."""
    film = folder / "film.mp4"
    done = works("animate", result, "--out", film, *SIZE, "--view", "axes")
    assert {90, 3, 0.67} <= {*numbers(done.stdout)}
    assert "axes" in done.stdout
    assert film.read_bytes()[4:8] == b"ftyp"


def test_coarse_samples_are_told_of(works: Run, result: Path, folder: Path) -> None:
    """Thirteen frames, 8 ms apart, show eleven samples: a sixth repeats the one before."""
    part = ("--to", 0.1, "--speed", 0.4, "--fps", 50)
    done = works("animate", result, "--out", folder / "film.gif", *SIZE, *part)
    assert 17 in numbers(done.stderr)  # per cent


def test_bad_input_ends_in_one_line(refused: Run, result: Path) -> None:
    """And leaves nothing behind."""
    before = sorted(result.parent.iterdir())
    for arguments, field in (
        (("--out", "film.mov"), "--out"),
        (("--out", "none/film.gif"), "--out"),
        (("--out", "/proc/film.gif"), "--out = '/proc'"),
        (("--out", "film.gif", "--from", "5"), "from"),
        (("--out", "film.gif", "--fps", "-1"), "fps"),
    ):
        refused("animate", "run.nc", *arguments, field=field, cwd=result.parent)
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
        deadline = time.monotonic() + 300
        while not list(folder.iterdir()) and time.monotonic() < deadline:
            time.sleep(0.02)
        assert [path.name.startswith(".film.") for path in folder.iterdir()] == [True]
        time.sleep(0.3)
        process.send_signal(sent)
        _, said = process.communicate(timeout=300)
    finally:
        process.kill()  # a fault would have it draw on for half an hour
    assert process.returncode == 130
    assert said.count(b"\n") == 1
    assert not list(folder.iterdir())


def test_damaged_result_is_drawn_only_if_asked_for(
    works: Run, refused: Run, result: Path, folder: Path
) -> None:
    damaged = bytearray(result.read_bytes())
    damaged[-20] ^= 1  # in the last sample
    result.write_bytes(damaged)
    film = folder / "film.gif"
    command = ("animate", result, "--out", film, "--fps", 2, *SIZE)
    refused(*command)
    assert not film.exists()
    done = works(*command, "--damaged")
    assert done.stderr.startswith("rodgen: warning: ")
    assert film.exists()
