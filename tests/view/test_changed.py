"""Films of runs that were changed while they went on: what is drawn is what held then."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rodgen.integrate import Solution
from rodgen.integrate.files.file_layout import NO_STATS
from rodgen.integrate.files.reader import solution_of
from rodgen.integrate.files.result_file import ResultFile
from rodgen.integrate.trajectory import Changes
from rodgen.scene import Scene
from rodgen.show.animation.film import animate, write_film
from rodgen.show.animation.frame_times import FilmSettings, plan_frames
from rodgen.show.animation.motion import sample_motion
from rodgen.system import System
from tests.view.test_animation import SMALL

SAMPLES, CHANGE = 1001, 400


@pytest.fixture
def swinging(make_scene: Callable[..., Scene]) -> Solution:
    """A rod of 2 m that bends as it swings about its start, a sample a millisecond."""
    scene = make_scene(3, "pinned", ("follower", "gravity"))
    t = np.arange(SAMPLES) / 1000
    y = np.c_[np.outer(t, [1.0, 1.3, 1.5]), np.ones((SAMPLES, 3))]
    return Solution(System(scene), t, y, {}, NO_STATS)


@pytest.fixture
def changed(swinging: Solution) -> Solution:
    """The swinging rod, of which g, mass, stiffness and thrust were others in the first 0.4 s."""
    p = np.tile(swinging.system.p, (SAMPLES, 1))
    names = swinging.scene.structure.parameters
    before = {"gravity": 2.0, "mass": 5.0, "bending_stiffness": 60.0, "follower_force": 10.0}
    for name, value in before.items():
        p[:CHANGE, names.index(name)] = value
    swinging.changes = Changes(p, np.zeros(SAMPLES))
    return swinging


def test_frames_are_samples_with_what_held(changed: Solution) -> None:
    planned = plan_frames(changed.t, FilmSettings(**SMALL))
    assert len(planned.kept) < SAMPLES / 10  # else this is no test of what is left out
    drawn = sample_motion(changed.isel(planned.kept))
    t, before = changed.t[planned.kept], planned.kept < CHANGE
    phi = np.outer(t, [1.0, 1.3, 1.5])
    links = 2 / 3 * np.stack((np.cos(phi), np.sin(phi)), -1)
    assert np.allclose(drawn.joints[:, 1:], np.cumsum(links, axis=1), atol=1e-12)
    weight = -np.where(before, 2.0 * 5.0, 9.81 * 3.0)
    assert np.allclose(drawn.loads["gravity"].force, np.c_[0 * weight, weight], atol=1e-12)
    thrust = np.linalg.norm(drawn.loads["follower"].force, axis=1)
    assert np.allclose(thrust, np.where(before, 10.0, 40.0), atol=1e-12)
    spring = np.where(before, 60.0, 30.0) / (2 / 3)  # EI over the length of a link
    due = spring[:, None] * np.diff(phi, axis=1)
    assert np.allclose(np.abs(drawn.bending[:, 1:-1]), due, atol=1e-12)


def test_rod_that_gets_longer_and_had_no_stiffness(swinging: Solution) -> None:
    p = np.tile(swinging.system.p, (SAMPLES, 1))
    names = swinging.scene.structure.parameters
    p[:, names.index("bending_stiffness")] = 0.0
    p[CHANGE:, names.index("length")] = 4.0
    swinging.changes = Changes(p, np.zeros(SAMPLES))
    kept = np.array([0, 399, 400, 1000])
    drawn = sample_motion(swinging.isel(kept))
    assert drawn.label.endswith("[1/m]")
    per_metre = np.array([1.5, 1.5, 0.75, 0.75])
    due = per_metre * swinging.t[kept] * 0.2  # of the last two links: 1.5 - 1.3
    assert np.allclose(drawn.bending[:, 2], due, atol=1e-12)
    span = np.linalg.norm(np.diff(drawn.joints, axis=1), axis=-1)
    assert np.allclose(span, 1 / per_metre[:, None], atol=1e-12)


@pytest.mark.slow
def test_film_of_the_file_is_that_of_the_run(changed: Solution, tmp_path: Path) -> None:
    animate(changed, tmp_path / "run.gif", **SMALL)
    changed.save(tmp_path / "run.nc")
    settings = FilmSettings(**SMALL)
    planned = plan_frames(changed.t, settings)
    with ResultFile(tmp_path / "run.nc") as file:
        some = solution_of(file, file.samples()[0], planned.kept)
    write_film(some, planned, tmp_path / "file.gif", settings)
    content = (tmp_path / "run.gif").read_bytes()
    assert (tmp_path / "file.gif").read_bytes() == content
    changed.changes = None
    animate(changed, tmp_path / "plain.gif", **SMALL)
    assert (tmp_path / "plain.gif").read_bytes() != content
