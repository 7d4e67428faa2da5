"""Runs whose loads and rates switch by the motion: steps end there, on either side."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.endings import RunError
from rodgen.integrate.files import checkpoint
from rodgen.integrate.files.saver import Saver
from rodgen.scene import Scene
from tests.palette import cases

# A rod that turns evenly, phi = t, and integrals of what has corners and jumps, known exactly.
STATES: dict[str, Any] = {
    "clock": {"rate": 1.0},
    "bounded": {"rate": "max(0, 1 - clock)"},
    "bent": {"rate": "abs(phi(0.5) - 0.5)"},
    "jumps": {"rate": "1 if clock < 0.3 else 3*clock if clock < 1.7 else -1"},
    "saturated": {"rate": "min(0.7, clock, 1.9 - clock)"},
    "tabled": {"rate": "interp(phi(1), [0.2, 0.9], [1, 8])"},
}
ENDS = [2.0, 0.5, 1.25, 0.3 + 1.5 * (1.7**2 - 0.3**2) - 0.3, 0.835, 0.2 + 3.15 + 8 * 1.1]
ROD = {"links": 2, "length": 2.0, "mass": 3.0, "bending_stiffness": 30.0}


def _scene(states: dict[str, Any] = STATES, **integrate: Any) -> Scene:
    table = {"name": "switching", "rod": ROD, "states": states, "initial": {"omega": 1.0}}
    return Scene.from_dict(table | {"integrate": {"span": [0.0, 2.0], "rtol": 1e-4} | integrate})


@pytest.mark.compiler
@cases("method, target", ["dop853", "gauss", "radau"], ["numpy", "c"])
def test_switches_cost_no_digits(method: str, target: str) -> None:
    """Between them all rates are polynomials, that every method has exactly."""
    sol = rodgen.simulate(_scene(method=method, output_every=0.5), target=target)
    # A jump is met a billionth of a step early.
    np.testing.assert_allclose(sol.y[-1, -len(ENDS) :], ENDS, rtol=0, atol=1e-9)
    assert sol.stats.steps < 120
    assert sol(1.0)[-5] == pytest.approx(0.5, abs=1e-12)


def test_a_load_that_switches_keeps_the_balance() -> None:
    """A thrust that is turned off when the rod has come to an angle: corners cost no energy."""
    table = {
        "name": "relay",
        "rod": ROD | {"links": 2},
        "loads": {"follower": {"force": "30 if phi(0) < 0.8 else 0", "angle": -0.1}},
        "initial": {"omega": 1.0},
        "integrate": {"span": [0.0, 2.0], "rtol": 1e-10, "atol": 1e-12, "method": "dop853"},
    }
    sol = rodgen.simulate(Scene.from_dict(table), target="numpy")
    off = sol.phi[:, 0] > 0.8
    assert off.any()
    assert not off.all()
    assert sol.energy_error < 1e-8  # of some 30 J, and quadrature of the power


@pytest.mark.nightly
def test_what_chatters_is_not_cut_for_ever() -> None:
    # Its steps are long where the error that they make is tolerated.
    relay = {"a": {"rate": "-1 if a > 0.5 else 1"}}
    try:
        sol = rodgen.simulate(_scene(relay, method="dop853", max_steps=20_000), target="numpy")
    except RunError as stopped:  # an honest end, too
        sol = stopped.solution
    assert np.abs(sol.y[sol.t > 0.6, -1] - 0.5).max(initial=0.0) < 1e-2


@pytest.mark.slow
@pytest.mark.compiler
def test_a_run_that_is_put_down_anywhere_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    """Before a switch, on the way onto it, and behind it."""
    scene = _scene(method="dop853", output_every=0.1)
    whole = rodgen.simulate(scene, target="c")
    out, taken, stops = tmp_path / "run.nc", [], iter(range(3, 40, 4))

    for stop in stops:
        out.unlink(missing_ok=True)
        seen = 0

        def tick(saver: Saver, now: float, stop: int = stop) -> None:
            nonlocal seen
            seen += 1
            if seen == stop:
                saver._checkpoint()
                raise KeyboardInterrupt

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Saver, "tick", tick)
            patch.setattr("rodgen.integrate.methods.compiled.FIRST", 1)
            patch.setattr("rodgen.integrate.methods.compiled.MOST", 1)
            try:
                rodgen.simulate(scene, target="c", out=out, checkpoint=1e9)
            except rodgen.Interrupted:
                taken.append(stop)
            else:
                break
        assert checkpoint.beside(out).exists()
        assert (rodgen.resume(out).y == whole.y).all()
    assert len(taken) > 3
