"""Drag against a medium with a wind: terminal speed, and work that is energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen.analyse.modes import natural_modes
from rodgen.analyse.statics import static_equilibrium
from rodgen.integrate import simulate
from rodgen.scene import Scene, SceneError

M, L, G, NORMAL = 3.0, 2.0, 9.81, 0.4
TERMINAL = np.sqrt(M * G / (NORMAL * L))


def _rod(drag: dict[str, Any], boundary: str = "free", **tables: Any) -> Scene:
    rod = {"links": 4, "length": L, "mass": M, "bending_stiffness": 20.0, "boundary": boundary}
    loads = {"drag": drag} | tables.pop("loads", {})
    return Scene.from_dict({"name": "rod", "rod": rod, "loads": loads} | tables)


def test_a_level_rod_falls_to_its_terminal_speed() -> None:
    """M dv/dt = -M g + c_n L (v - w)^2 across it, M dv/dt = c_t L (v - w)^2 along it, v < w; the
    drag of a link lies as its weight does, so that nothing bends it."""
    c_t, wind = 0.1, (3.0, -2.0)
    scene = _rod(
        {"normal": NORMAL, "tangential": c_t, "wind": list(wind)},
        loads={"gravity": {"g": G}},
        initial={"velocity": [0.0, wind[1]]},
        integrate={"span": [0.0, 3.0], "rtol": 1e-11, "atol": 1e-13},
    )
    sol = simulate(scene)
    across = wind[1] - TERMINAL * np.tanh(G * sol.t / TERMINAL)
    along = wind[0] - 1 / (1 / wind[0] + c_t * L / M * sol.t)
    v = sol.y[:, sol.y.shape[1] // 2 :][:, :2]
    np.testing.assert_allclose(v, np.stack((along, across), -1), rtol=0, atol=1e-9)
    assert np.abs(sol.phi).max() < 1e-9
    assert abs(v[-1, 1] - wind[1] + TERMINAL) < 0.01 * TERMINAL
    assert sol.energy_error < 1e-8


@pytest.mark.nightly
def test_wind_bends_and_damps_a_clamped_rod() -> None:
    """At rest without wind it has no part in small motions; in a wind along the rod's side it damps
    them with 2 c_n |w|, and bends the rod as a load c_n w^2 across it does."""
    still = natural_modes(_rod({"normal": 0.5}, "clamped"))
    bare = natural_modes(_rod({"normal": 0.0}, "clamped"))
    np.testing.assert_allclose(still.frequencies, bare.frequencies, rtol=1e-10)
    speed = 0.1
    bent = static_equilibrium(_rod({"normal": 0.5, "wind": [0.0, speed]}, "clamped"))
    # Of the discrete rod: moments of the forces behind each joint, over the springs.
    l, k = L / 4, 20.0 / (L / 4)
    forces = 0.5 * speed**2 * l * np.array([1.0, 1.0, 1.0, 0.5])  # at joints 1 to 4
    moments = [
        sum(f * l * (j + 1 - s) for j, f in enumerate(forces) if j + 1 > s) for s in range(4)
    ]
    angles = np.cumsum(np.array(moments) / [2 * k, k, k, k])
    np.testing.assert_allclose(bent.phi, angles, rtol=1e-5)  # small: they are below 1e-3


def test_what_is_no_drag_is_refused() -> None:
    for drag, field in (
        ({"normal": -1.0}, "normal"),
        ({"wind": [1.0]}, "wind"),
        ({"wind": [1.0, "x*t"]}, "wind.1"),
        ({"wind": [1.0, float("nan")]}, "wind.1"),
        ({"wind": 3.0}, "wind"),
    ):
        with pytest.raises(SceneError) as refused:
            _rod(drag)
        assert refused.value.field == f"loads.drag.{field}"
