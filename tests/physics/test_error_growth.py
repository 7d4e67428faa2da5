"""How fast small errors grow: beside runs that differ, and where the rate is known."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import rodgen
from rodgen.errors import InputError
from rodgen.integrate.dense_output import error_growth
from rodgen.integrate.trajectory import Changes
from rodgen.scene import Scene
from rodgen.system import System
from tests.sets import sets

G = 11.94  # m/s^2


def _scene(links: int, span: float, *, phi: str | float, **tables: object) -> Scene:
    rod = {"length": 1.0, "mass": 1.0, "bending_stiffness": 1.0, "boundary": "pinned"}
    return Scene.from_dict(
        {
            "name": "neighbours",
            "rod": {**rod, "links": links},
            "loads": {"gravity": {"g": G}},
            "initial": {"phi": phi},
            "integrate": {"span": [0.0, span], "rtol": 1e-6},
            **tables,
        }
    )


@pytest.mark.slow
@pytest.mark.compiler
def test_chaos_is_told_and_true() -> None:
    """Beside two runs from states that differ by 1e-9 rad, over a span in which the difference
    stays small: of another direction, it grows as much to an order of magnitude."""
    scene = _scene(10, 8.0, phi="0.05*cos(8*pi*s)+0.3*s")
    run = rodgen.simulate(scene, target="c", error_growth=True)
    off = np.zeros(20)
    off[:10] = np.random.default_rng(7).standard_normal(10)
    off *= 1e-9 / np.linalg.norm(off)
    y0 = scene.initial_state()
    tight = {"target": "c", "rtol": 1e-12, "atol": 1e-14}
    one, other = (rodgen.simulate(System(scene).at(y0=y), **tight) for y in (y0, y0 + off))
    apart = np.linalg.norm(one.phi - other.phi, axis=1)
    truth = apart.max() / 1e-9
    assert truth / 10 < run.error_growth < truth * 10
    # An error at the tolerance is seen when this difference has grown a thousandfold.
    seen = one.t[np.argmax(apart > 1e-6)]
    assert 0 < 0.5 * seen < run.errors.visible < 2 * seen
    assert run.error_growth > 1e4


def test_regular_motion_is_not_told() -> None:
    """A pendulum at 1 rad: its period depends on how far it swings, so that errors grow with
    the number of swings, some seven here, and no faster. Events change nothing."""
    scene = _scene(1, 10.0, phi=-0.5, events=[{"quantity": "tip_x", "value": 0.0}])
    run = rodgen.simulate(scene, target="numpy", error_growth=True)
    assert 1 <= run.error_growth < 100
    assert run.errors.visible == math.inf


@pytest.mark.parametrize(
    ("method", "step"), sets([("dop853", None)], slow=[("rk4", 5e-3)], nightly=[("radau", None)])
)
def test_falling_pendulum_grows_at_its_rate(method: str, step: float | None) -> None:
    """About the upright state an error in the angle alone grows as cosh(rate t)."""
    up = _scene(1, 2.0, phi=math.pi / 2)
    rate = math.sqrt(1.5 * G)  # a bar of 1 m about its end
    overrides = {"method": method, "span": [0.0, 12 / rate], "step": step}
    run = rodgen.simulate(
        up, target="numpy", error_growth=True, **{k: v for k, v in overrides.items() if v}
    )
    # Brought back from 0.01 rad, where the sine is off by 2e-5 of itself.
    assert run.error_growth == pytest.approx(math.cosh(12.0), rel=0.01)
    decades = math.log10(run.error_growth)
    assert run.errors.tenfold == pytest.approx(12 / rate / decades)


@pytest.mark.nightly
def test_errors_that_come_later_count() -> None:
    """A load that holds a pendulum up, and is taken away: what had died out grows anew."""
    held = {
        "gravity": {},
        "tip": {"y": "60 if t < 2 else 0"},
        "external_damping": {"coefficient": 4.0},
    }
    scene = _scene(1, 4.0, phi=math.pi / 2, loads=held)
    run = rodgen.simulate(scene, target="numpy", error_growth=True)
    short = rodgen.simulate(scene, target="numpy", error_growth=True, span=[0.0, 1.9])
    assert short.error_growth < 2
    assert run.error_growth > 5


def test_where_it_is_kept_and_where_it_cannot_be_had(tmp_path: Path) -> None:
    scene = _scene(1, 1.0, phi=0.3)
    file = tmp_path / "run.nc"
    run = rodgen.simulate(scene, target="numpy", error_growth=True, out=file, t_eval=[0.5, 1.0])
    whole = rodgen.simulate(scene, target="numpy", error_growth=True)
    assert run.errors == whole.errors
    with pytest.raises(InputError, match="error_growth"):
        _ = rodgen.load(file).error_growth
    changed = Changes(np.tile(whole.system.p, (len(whole.t), 1)), np.zeros(len(whole.t)))
    whole.changes = changed
    with pytest.raises(InputError):
        error_growth(whole)
