"""What is taken away of a live run after changes and a kick: the film and the file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import rodgen
from rodgen.integrate import Solution
from rodgen.integrate.files.storage import Excerpt
from rodgen.live.run.live_run import LiveRun
from rodgen.live.run.scenes import Place, edit
from rodgen.scene import Scene
from rodgen.show.animation.film import animate
from rodgen.show.animation.motion import motion
from rodgen.show.animation.times import Settings, plan
from tests.live.conftest import ROD
from tests.live.view import until

SCENE = {
    **ROD,
    "loads": {
        **ROD["loads"],
        "internal_damping": {"coefficient": 0.05},
        "external_damping": {"coefficient": 0.2},
    },
    "integrate": {**ROD["integrate"], "output_every": 0.001},
}
CHANGES: list[tuple[Place, float]] = [
    (("loads", "gravity", "g"), 1.0),
    (("rod", "mass"), 4.0),
    (("rod", "bending_stiffness"), 8.0),
    (("loads", "follower", "force"), 6.0),
]


class Taken(NamedTuple):
    """What was taken away, and after which times the change [s] and the kick were made."""

    solution: Solution
    change: float
    kick: float


@pytest.fixture(scope="module")
def taken() -> Iterator[Taken]:
    scene = Scene.from_dict(SCENE)
    run = LiveRun(scene)
    try:
        run.do(lambda: run.set_speed(np.inf)).result()
        change = _on(run, 0.4)
        run.do(lambda: run.change(edit(scene, CHANGES), "change")).result()
        kick = _on(run, change + 0.3)
        run.do(lambda: run.kick(1, 0.25, (0.5, 2.0))).result()
        _on(run, kick + 0.3)
        yield Taken(run.do(run.solution).result(), change, kick)
    finally:
        run.close()


def _on(run: LiveRun, to: float) -> float:
    """Run on to a time [s], and hold; the time of the last sample [s]."""
    run.do(run.go).result()
    until(lambda: run.shown.t[-1], lambda t: t >= to, "the run does not go on")
    run.do(run.pause).result()
    return float(run.shown.t[-1])


def _gravity_energy(taken: Taken, t: np.ndarray, y: np.ndarray) -> np.ndarray:
    """M g times the height of the middle of masses, from the angles [J]."""
    half = 2.0 / 5 * np.sin(y[:, 2:7]) / 2
    height = y[:, 1] + np.mean(np.cumsum(2 * half, axis=1) - half, axis=1)
    return np.where(t <= taken.change, 3.0 * 9.81, 4.0 * 1.0) * height


def test_saved_run_holds_what_held(taken: Taken, tmp_path: Path) -> None:
    sol = taken.solution
    sol.save(tmp_path / "run.nc")
    back = rodgen.load(tmp_path / "run.nc")
    assert back.changes is not None
    assert "change at t = " in back.message
    assert back.scene.integrate.method == "dop853"
    began = np.searchsorted(back.t, [taken.change, taken.kick], side="right")
    given = np.split(back.changes.given, began)
    assert [np.ptp(part) for part in given] == [0.0, 0.0, 0.0]
    jumps = np.diff([part[0] for part in given])
    assert np.abs(jumps).min() > 1.0  # J: neither the change nor the kick is small
    # rtol 1e-8 of some 100 J; the balance starts at the first sample.
    assert sol.energy_error < 1e-6
    assert back.energy_error < 1e-6
    assert np.abs(back.energy_balance).max() < 1e-6
    due = _gravity_energy(taken, back.t, back.y)
    assert np.allclose(back.energy.gravity, due, atol=1e-9)
    assert np.allclose(sol.energy.gravity, due, atol=1e-9)
    kept = np.arange(0, len(back.t), 7)
    some = Excerpt(tmp_path / "run.nc").at(kept)
    assert np.allclose(some.energy.gravity, due[kept], atol=1e-9)


def test_film_shows_every_sample_with_what_held(taken: Taken, tmp_path: Path) -> None:
    sol, settings = taken.solution, Settings(fps=10, speed=1, width=640, height=480)
    kept = plan(sol.t, settings).kept
    assert len(kept) < len(sol.t) / 10  # else this is no test of what is left out
    drawn, t, y = motion(sol.taken(kept)), sol.t[kept], sol.y[kept]
    before = t <= taken.change
    links = 0.4 * np.stack((np.cos(y[:, 2:7]), np.sin(y[:, 2:7])), -1)
    assert np.allclose(np.diff(drawn.joints, axis=1), links, atol=1e-9)
    assert np.allclose(drawn.joints[:, 0], y[:, :2], atol=1e-12)
    weight = drawn.loads["gravity"].force[:, 1]
    assert np.allclose(weight, np.where(before, -3 * 9.81, -4.0), atol=1e-12)
    thrust = np.linalg.norm(drawn.loads["follower"].force, axis=1)
    assert np.allclose(thrust, np.where(before, 2.0, 6.0), atol=1e-12)
    moments = np.where(before, 5.0, 8.0)[:, None] / 0.4 * np.diff(y[:, 2:7], axis=1)
    assert np.allclose(np.abs(drawn.bending[:, 1:-1]), np.abs(moments), atol=1e-9)
    film = animate(sol, tmp_path / "film.gif", fps=10, speed=1, width=640, height=480)
    assert film.frames == int(10 * float(np.ptp(sol.t)) * (1 + 1e-12)) + 1
