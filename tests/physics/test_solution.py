"""Quantities of a Solution by a second route, and its way through a file."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.model.rod import BOUNDARIES
from tests.palette import ENDS
from tests.sets import Make
from tests.told import refused

HELD = ("cantilever", "clamped")  # at a clamp_angle


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_angles_and_joints_of_all_links(make_scene: Make, boundary: str) -> None:
    """Those that are held too, at the angle of the clamp."""
    scene = make_scene(3, boundary, rod={"clamp_angle": 0.4} if boundary in HELD else {})
    sol = rodgen.simulate(scene, output_every=0.5, target="numpy", rtol=1e-3)
    assert sol.t.shape == (3,)
    assert sol.y.shape == (3, {"free": 10, "cantilever": 4}.get(boundary, 6))
    assert sol.phi.shape == sol.omega.shape == (3, 3)
    if boundary == "cantilever":
        assert np.all(sol.phi[:, 0] == 0.4)
        assert np.all(sol.omega[:, 0] == 0.0)
    l = 2.0 / 3
    e = np.stack((np.cos(sol.phi), np.sin(sol.phi)), axis=-1)
    start = sol.y[:, :2] if boundary == "free" else np.zeros((len(sol.t), 2))
    joints = np.concatenate((np.zeros((len(sol.t), 1, 2)), np.cumsum(l * e, axis=1)), axis=1)
    np.testing.assert_allclose(sol.joints, joints + start[:, None], atol=1e-14)
    np.testing.assert_array_equal(sol.tip, sol.joints[:, -1])


def test_principal_axes_of_a_straight_rod_run_along_it(make_scene: Make) -> None:
    for angle in (-1.5, -0.3, 0.0, 0.7, 1.5, np.pi / 2):
        initial = {"phi": angle, "omega": 0.0}
        sol = rodgen.simulate(make_scene(3, initial=initial), span=[0.0, 0.01])
        assert np.cos(2 * (sol.principal_axes.angle[0] - angle)) == pytest.approx(1.0)
        # A thin straight rod: nothing across it, M L^2/12 about its middle.
        np.testing.assert_allclose(sol.principal_axes.moments[0], [0.0, 3.0 * 4.0 / 12], atol=1e-14)


def test_overrides_without_use_are_refused(make_scene: Make) -> None:
    """They are checked like a scene, and must be of use to the method."""
    fixed = {"method": "rk4", "step": 0.01}
    overrides: dict[str, Any]
    for field, overrides in (
        ("integrate.method", {"method": "magic"}),
        ("integrate.colour", {"colour": 3}),
        ("target", {"target": "fortran"}),
        ("step", {"step": 0.1}),
        ("step", {"step": 0.1, "method": "radau"}),
        ("rtol", {"rtol": 1e-3, **fixed}),
        ("atol", {"atol": 1e-3, **fixed, "method": "euler"}),
    ):
        assert refused(rodgen.simulate, make_scene(), **overrides).field == field


def test_a_scene_may_hold_what_its_method_has_no_use_for(make_scene: Make) -> None:
    """So that the method alone can be changed; what is None is not given."""
    scene = make_scene(2, step=1e-3, span=[0.0, 0.01])
    for method, other in (("rk4", {"rtol": None}), ("dop853", {"step": None})):
        sol = rodgen.simulate(scene, method=method, target="numpy", **other)
        assert sol.scene.integrate.step == 1e-3
        assert sol.scene.integrate.rtol == 1e-10


def test_dataset_has_all_that_a_solution_has(make_scene: Make) -> None:
    scene = make_scene(3, "free", ENDS)
    sol = rodgen.simulate(scene, span=(0, 0.2), output_every=0.1, target="numpy")
    data = sol.to_xarray()
    for name, values, dimensions in (
        ("tip", sol.tip, ("time", "axis")),
        ("total_energy", sol.energy.total, ("time",)),
        ("principal_angle", sol.principal_axes.angle, ("time",)),
        ("principal_moments", sol.principal_axes.moments, ("time", "principal")),
    ):
        np.testing.assert_array_equal(data[name], values)
        assert data[name].dims == dimensions
        assert data[name].attrs["units"]
    assert data.attrs["energy_error"] == sol.energy_error
    assert data["centre_of_gravity"].attrs["long_name"] == "centre of gravity"
    units = dict(zip(data["state"].values, data["state_units"].values, strict=True))
    assert (units["x0"], units["vy0"]) == ("m", "m/s")
    assert (units["phi_2"], units["omega_0"]) == ("rad", "rad/s")
