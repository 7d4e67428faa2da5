"""rodgen animate: films from results."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

import rodgen as package
from rodgen.scene import Scene
from tests.cli.conftest import Run
from tests.told import numbers

SIZE = ("--width", 480, "--height", 320)


@pytest.fixture
def result(make_scene: Callable[..., Scene], tmp_path: Path) -> Path:
    """A result of 201 samples, in a folder of its own."""
    scene = make_scene(3, "clamped", terms=("follower", "gravity"), span=[0.0, 2.0], rtol=1e-6)
    path = tmp_path / "from" / "run.nc"
    path.parent.mkdir()
    package.simulate(scene, target="numpy").save(path)
    return path


def test_gif_of_a_part(works: Run, result: Path, work: Path) -> None:
    """Ten frames a second of a second that is slowed down to two, and the last. Then thirteen
    frames, 8 ms apart, that show eleven samples: a sixth repeats the one before."""
    film = work / "film.gif"
    times = ("--bounds", "0.5,1.5", "--fps", 10)
    chosen = ("--speed", 0.5, "--view", "axes")
    done = works("animate", result, "--out", film, *times, *SIZE, *chosen)
    assert {21, 480, 320, 2.1, 0.5} <= {*numbers(done.stdout)}
    assert "axes" in done.stdout
    assert done.stderr == ""
    with Image.open(film) as opened:
        assert (opened.n_frames, opened.size) == (21, (480, 320))
    assert list(work.iterdir()) == [film]
    part = ("--bounds", ",0.1", "--speed", 0.4, "--fps", 50)
    done = works("animate", result, "--out", film, *SIZE, *part)
    assert 17 in numbers(done.stderr)  # per cent


def test_damaged_result_is_drawn_only_if_asked_for(
    works: Run, refused: Run, result: Path, work: Path
) -> None:
    damaged = bytearray(result.read_bytes())
    damaged[-20] ^= 1  # in the last sample
    result.write_bytes(damaged)
    film = work / "film.gif"
    command = ("animate", result, "--out", film, "--fps", 2, *SIZE)
    refused(*command)
    assert not film.exists()
    done = works(*command, "--damaged")
    assert done.stderr.startswith("rodgen: warning: ")
    assert film.exists()
