"""Rates at samples by the default method: within some tolerances, where fast motions die out in
steps at the limit of stability, and where many steps add up."""

from __future__ import annotations

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from tests.sets import sets

MOST = 3.0  # tolerances: of 300 random scenes 95 of 100 are off by less than 12 at their worst


def _rod(span: float, time: float) -> Scene:
    """A bent rod of four links that is let go; span, and time of its material damping [s]."""
    table = {
        "name": "bent",
        "rod": {"links": 4, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}
        | {"boundary": "clamped"},
        "loads": {"material_damping": {"time": time}},
        "initial": {"phi": "0.3*s"},
        "integrate": {"span": [0.0, span], "output_every": span / 100, "method": "dop853"},
    }
    return Scene.from_dict(table)


DAMPED = _rod(1.0, 0.05)


def _off(sol: rodgen.Solution, exact: rodgen.Solution, rtol: float) -> list[float]:
    """Largest errors of angles and rates over the tolerance of the largest of them."""
    pairs = (sol.phi, exact.phi), (sol.omega, exact.omega)
    return [float(np.abs(a - b).max() / (rtol * np.abs(b).max() + rtol / 100)) for a, b in pairs]


@pytest.mark.compiler
@pytest.mark.parametrize(
    ("target", "rtol"), sets([("c", 1e-6), ("c", 1e-10), ("numpy", 1e-8)], slow=[("c", 1e-4)])
)
def test_rates_of_a_damped_rod(target: str, rtol: float) -> None:
    """Rates by dense output alone are off by up to 1500 tolerances there."""
    tight = {"method": "radau", "target": "c", "rtol": 1e-12, "atol": 1e-14}
    exact = rodgen.simulate(DAMPED, **tight)
    sol = rodgen.simulate(DAMPED, target=target, rtol=rtol, atol=rtol / 100)
    assert sol.stats.nsteps > 50
    assert max(_off(sol, exact, rtol)) < MOST


@pytest.mark.compiler
def test_rates_of_damped_rods_side_by_side() -> None:
    model = rodgen.build(DAMPED, "c")
    p = np.tile(model.parameters(**DAMPED.parameters), (9, 1))
    times = np.linspace(0.01, 0.06, 9)
    p[:, model.PARAMETERS.index("material_damping_time")] = times
    given = {"span": [0.0, 1.0], "output_every": 0.01, "rtol": 1e-8, "atol": 1e-10}
    # The least rate of this link comes when those beside it have died out.
    made = rodgen.simulate_many(
        model, p, DAMPED.initial_state(), keep=["min(omega_2)", "rms(omega_3)"], **given
    )
    for at, time in enumerate(times):
        scene = DAMPED.replace({"loads.material_damping.time": float(time)})
        exact = rodgen.simulate(scene, method="radau", target="c", rtol=1e-12, atol=1e-14)
        most = MOST * 1e-8 * np.abs(exact.omega).max()
        assert made["min(omega_2)"][at] == pytest.approx(exact.omega[:, 2].min(), abs=most)
        rms = np.sqrt(np.mean(exact.omega[:, 3] ** 2))
        assert made["rms(omega_3)"][at] == pytest.approx(rms, abs=most)


@pytest.mark.compiler
def test_errors_of_many_steps_do_not_add_up() -> None:
    """A thousand steps of a rod that nothing damps: if each may be off by the tolerance, rates are
    by some 20. Gauss's method in equal steps is right to 1e-9 of the rates there."""
    scene = _rod(20.0, 0.0)
    exact = rodgen.simulate(scene, method="gauss", target="c", step=1e-3)
    for rtol in (1e-4, 1e-6):
        sol = rodgen.simulate(scene, target="c", rtol=rtol, atol=rtol / 100)
        assert sol.stats.nsteps > 1000
        assert max(_off(sol, exact, rtol)) < MOST
