"""Gravity as a vector and in time: of a rod that is turned, of a pendulum whose pivot shakes, of
falls, rests and columns, and in the balance of energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rodgen
from rodgen.scene import Scene
from tests.told import refused

G = 9.81
TIGHT = {"method": "dop853", "rtol": 1e-12, "atol": 1e-13, "span": [0.0, 2.0]}


def _rod(gravity: dict[str, Any], boundary: str = "pinned", **tables: Any) -> Scene:
    rod = {"links": 3, "length": 1.5, "mass": 2.0, "bending_stiffness": 4.0, "boundary": boundary}
    table = {"name": "rod", "rod": rod, "loads": {"gravity": gravity}, "integrate": TIGHT}
    return Scene.from_dict(table | tables)


TURNED = 0.4  # rad


@pytest.mark.parametrize("boundary", ["free", "pinned", "clamped"])
def test_a_vector_downwards_is_g_and_a_slanting_one_turns_the_rod(boundary: str) -> None:
    """To the rounding of some 100 steps."""
    initial = {"phi": "0.3*s - 0.2", "omega": "2*s"}
    down, vector = (
        rodgen.simulate(_rod(gravity, boundary, initial=initial), target="numpy")
        for gravity in ({}, {"acceleration": [0.0, -G]})
    )
    np.testing.assert_allclose(vector.y, down.y, rtol=0, atol=1e-11)
    np.testing.assert_allclose(vector.energy.total, down.energy.total, rtol=0, atol=1e-10)
    assert not vector.work
    slanting = [G * np.sin(TURNED), -G * np.cos(TURNED)]
    scene = _rod(
        {"acceleration": slanting}, boundary, initial=initial | {"phi": f"0.3*s - 0.2 + {TURNED}"}
    )
    if boundary == "clamped":
        scene = scene.replace({"rod.clamp_angle": TURNED})
    turned = rodgen.simulate(scene, target="numpy")
    np.testing.assert_allclose(turned.phi - TURNED, down.phi, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "gravity",
    [
        {"g": "9.81*(1 + 0.3*sin(5*t))"},
        {"acceleration": [3.0, -8.0]},
        {"acceleration": ["3*sin(4*t)", -9.81]},
        {"acceleration": [0.5, "-9.81*exp(-t)"]},
    ],
    ids=["g in time", "vector", "x in time", "y in time"],
)
@pytest.mark.parametrize("boundary", ["free", "cantilever"])
def test_energy_balances(gravity: dict[str, Any], boundary: str) -> None:
    """Of numbers by a potential, of what changes by work, of which the whole vector does."""
    start = {"phi": "0.3*s" if boundary == "free" else "0.3*s - 0.1", "omega": "s"}
    sol = rodgen.simulate(_rod(gravity, boundary, initial=start), target="numpy")
    timed = any(isinstance(x, str) for x in (gravity.get("g"), *gravity.get("acceleration", ())))
    assert [*sol.work] == ["gravity"] * timed
    moved = np.ptp(sol.energy.kinetic)
    assert np.abs(sol.energy_balance).max() < 1e-9 * moved
    exchanged = sol.work["gravity"] if timed else sol.energy.gravity
    assert np.ptp(exchanged) > 0.1 * moved
    assert bool(sol.energy.gravity.any()) is not timed


def test_a_free_rod_falls_along_the_integral_of_the_vector() -> None:
    sol = rodgen.simulate(_rod({"acceleration": ["6*t", "-2*cos(3*t)"]}, "free"), target="numpy")
    fallen = np.stack((sol.t**3, 2 / 9 * (np.cos(3 * sol.t) - 1)), axis=-1)
    centre = sol.centre_of_gravity - sol.centre_of_gravity[0]
    np.testing.assert_allclose(centre, fallen, rtol=0, atol=1e-11)
    assert np.abs(sol.phi).max() < 1e-12  # nothing turns or bends it


def test_a_pendulum_whose_pivot_shakes() -> None:
    """In the frame of a pivot at x = A cos(w t)/w^2, y = B cos(v t)/v^2 gravity is (A cos(w t),
    -g + B cos(v t)); the angle of a link of length l from the x axis obeys
    2/3 l phi'' = a_y cos phi - a_x sin phi, which SciPy integrates here."""
    A, w, B, v, length = 4.0, 5.0, 7.0, 11.0, 0.8
    fall = ["A*cos(w*t)", "B*cos(v*t) - 9.81"]
    table: dict[str, Any] = {
        "name": "pendulum",
        "parameters": {"A": A, "w": w, "B": B, "v": v},
        "rod": {"links": 1, "length": length, "mass": 0.3, "bending_stiffness": 0.0}
        | {"boundary": "pinned"},
        "loads": {"gravity": {"acceleration": fall}},
        "initial": {"phi": -1.2, "omega": 0.5},
        "integrate": TIGHT,
    }
    sol = rodgen.simulate(Scene.from_dict(table), target="numpy")

    def rates(t: float, y: Any) -> list[float]:
        x_pull, y_pull = A * np.cos(w * t), B * np.cos(v * t) - G
        return [y[1], 1.5 / length * (y_pull * np.cos(y[0]) - x_pull * np.sin(y[0]))]

    other = solve_ivp(
        rates, (0, 2), [-1.2, 0.5], method="Radau", t_eval=sol.t, rtol=1e-10, atol=1e-12
    )
    np.testing.assert_allclose(sol.phi[:, 0], other.y[0], rtol=0, atol=1e-8)
    assert np.ptp(sol.phi) > 0.5


def test_it_hangs_and_buckles_along_the_vector() -> None:
    """A chain lies along the vector; a column that leans as its gravity does bears what an upright
    one does, whatever the size in the scene."""
    chain = _rod({"acceleration": [3.0, -4.0]}).replace({"rod.bending_stiffness": 0.0})
    rest = rodgen.static_equilibrium(chain)
    np.testing.assert_allclose(rest.joints[-1], [0.9, -1.2], rtol=0, atol=1e-12)
    upright = _rod({}, "clamped").replace({"rod.clamp_angle": np.pi / 2})
    leaning = _rod(
        {"acceleration": [0.02 * np.sin(TURNED), "-0.02*(1 + t)*cos(0.4)"]}, "clamped"
    ).replace({"rod.clamp_angle": np.pi / 2 + TURNED})
    one, two = (rodgen.critical_load(scene, load="gravity") for scene in (upright, leaning))
    assert (one.unit, two.unit) == ("m/s^2", "m/s^2")
    assert two.value == pytest.approx(one.value, rel=1e-8)
    assert two.load_parameter == pytest.approx(one.load_parameter, rel=1e-8)
    assert (one.applied, two.applied) == (G, pytest.approx(0.02, rel=1e-12))


def test_of_g_and_the_vector_a_scene_has_one() -> None:
    field = "loads.gravity.acceleration"
    for gravity, wrong in (
        ({"g": 9.81, "acceleration": [0.0, -9.81]}, "loads.gravity.g"),
        ({"acceleration": [0.0]}, field),
        ({"acceleration": [0.0, 1.0, 2.0]}, field),
        ({"acceleration": -9.81}, field),
        ({"acceleration": ["phii(0)", 0.0]}, f"{field}.0"),
        ({"acceleration": [0.0, None]}, f"{field}.1"),
        ({"g": None}, "loads.gravity.g"),
    ):
        assert refused(_rod, gravity).field == wrong
    down, vector = _rod({}), _rod({"acceleration": [1.0, 2.0]})
    assert (down.loads.gravity.g, vector.loads.gravity.g) == (9.81, None)
    assert set(down.parameters) ^ set(vector.parameters) == {"gravity", "gravity_x", "gravity_y"}
    assert Scene.from_dict(vector.to_dict()) == vector
    other = vector.replace({f"{field}.1": "-3*t"})
    assert other.loads.gravity.acceleration == [1.0, "-3*t"]
    assert vector.replace({field: None}) == down
    assert down.replace({"loads.gravity.g": None, field: [1.0, 2.0]}) == vector
