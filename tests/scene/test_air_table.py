"""The air of a scene: what its tables allow, and how keys reach the module."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.errors import Missing
from rodgen.scene import Scene
from rodgen.system import System
from tests.told import refused

SCENE: dict[str, Any] = {
    "name": "arrow",
    "rod": {"links": 5, "length": 1.0, "mass": 1.0, "bending_stiffness": 9.0, "diameter": 0.02},
    "air": {"density": "rho0*exp(-y/8000)", "wind": [2.0, "3*t"]},
    "parameters": {"rho0": 1.2},
    "loads": {
        "fins": [{"at": 0.9, "normal_slope": 8.0}, {"at": 0.2, "normal_slope": 1.0, "area": 0.01}],
        "nose": {"at": 0.0},
    },
    "initial": {"velocity": [0.0, 20.0], "phi": "-pi/2"},
}
GEOMETRY = {"root": 0.1, "tip": 0.05, "span": 0.06, "sweep": 0.04, "number": 4, "body_radius": 0.02}


def arrow(changes: dict[str, Any] | None = None) -> Scene:
    return Scene.from_dict(SCENE).replace(changes or {})


def test_points_in_the_air_need_it_and_it_needs_no_points() -> None:
    lacking = {key: value for key, value in SCENE.items() if key != "air"}
    assert refused(Scene.from_dict, lacking)[:2] == ("air", Missing)
    assert not arrow({"loads.fins": None, "loads.nose": None}).structure.terms
    assert "air_wind_x" not in arrow({"air.wind": None}).structure.parameters


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("air.density", -1.0),
        ("air.density", "isothermal"),
        ("air.density", "1.2*x"),
        ("air.wind", [1.0]),
        ("air.stall_angle", 0.0),
        ("air.height", 100.0),
        ("air.speed_of_sound", 0.0),
        ("loads.fins.0.area", -1.0),
        ("rod.diameter", 0.0),
    ],
)
def test_a_value_that_no_air_has_is_refused(key: str, value: object) -> None:
    told = refused(arrow, {key: value})
    assert told.field.replace("[", ".").replace("]", "").startswith(key)


def test_fins_have_a_slope_or_a_geometry_and_an_area_or_a_diameter() -> None:
    assert refused(arrow, {"loads.fins.0.normal_slope": None}).field == "loads.fins.0.normal_slope"
    assert refused(arrow, {"loads.fins.0.geometry": GEOMETRY}).field == "loads.fins.0.normal_slope"
    assert refused(arrow, {"rod.diameter": None}).field == "loads.fins.0.area"
    shaped = {"loads.fins.0": {"at": 0.9, "geometry": GEOMETRY}}
    assert refused(arrow, {"loads.fins.0": {"geometry": GEOMETRY | {"number": 5}}}).field == (
        "loads.fins.0.geometry.number"
    )
    found = arrow(shaped).parameters
    assert found["fins_area"] == pytest.approx(np.pi * 0.02**2)
    assert found["fins_2_area"] == 0.01
    assert found["nose_area"] == pytest.approx(np.pi / 4 * 0.02**2)


def test_numbers_of_the_air_are_one_for_all_points() -> None:
    """What follows the height is a law of each point, by the same numbers."""
    even = arrow({"air.density": 1.2}).structure
    assert even.parameters.count("air_density") == 1
    assert not {"fins_density", "nose_density"} & {*even.parameters}
    high = arrow().structure
    laws = {name for name, _ in high.expressions}
    assert laws == {"fins_density", "fins_2_density", "nose_density", "air_wind_y"}
    assert {"rho0", "air_density_1"} <= {*high.parameters}
    assert "air_density_2" not in high.parameters


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("air.density", 0.9),
        ("air.wind.0", -3.0),
        ("air.wind.1.0", 5.0),
        ("air.stall_angle", 0.1),
        ("parameters.rho0", 0.4),
        ("air.density.0", 7000.0),
        ("loads.fins.0.normal_slope", 3.0),
        ("rod.diameter", 0.1),
    ],
)
def test_a_system_with_another_number_is_that_of_the_scene_with_it(key: str, value: float) -> None:
    given = arrow({"air.density": 1.2}) if key == "air.density" else arrow()
    system = System(given)
    made, whole = system.at({key: value}), System(given.replace({key: value}))
    assert made.structure == whole.structure
    np.testing.assert_array_equal(made.p, whole.p)
    if key != "rod.diameter":
        assert made.structure is system.structure  # a copy of p


def test_the_standard_atmosphere_may_stand_in_an_expression() -> None:
    """Its numbers are not those of the text; and nothing else has its name."""
    hot = arrow({"air.density": "isa*0.9", "air.height": 500.0})
    model = rodgen.build(hot)
    p, y = model.parameters(**hot.parameters), hot.initial_state()
    y[1] = 1500.0
    found = model.signals(0.0, y, p)["nose_density"]
    assert found == pytest.approx(0.9 * 1.00655, rel=1e-5)  # of 2000 m, in the tables
    system = System(hot)
    made, whole = system.at({"air.density.0": 0.5}), System(hot.replace({"air.density.0": 0.5}))
    np.testing.assert_array_equal(made.p, whole.p)
    assert refused(arrow, {"parameters.isa": 2.0}).field == "parameters.isa"


def test_studies_keep_airspeeds_also_of_points_that_are_held() -> None:
    held = arrow({"rod.boundary": "clamped", "initial.velocity": None, "initial.phi": None})
    data = rodgen.study(
        held.replace({"integrate.span": [0.0, 0.01]}),
        vary={"air.wind.0": [3.0, 4.0]},
        keep=["max(airspeed_nose)", "last(attack_fins)"],
    )
    np.testing.assert_allclose(data["max(airspeed_nose)"], [3.0, 4.0], rtol=1e-4)


def test_a_run_stops_at_an_airspeed_and_doubts_stay_in_its_file(tmp_path: Path) -> None:
    event = {"quantity": "airspeed_nose", "value": 19.99, "action": "stop"}
    scene = arrow({"air.wind": None, "events": [event], "loads.gravity": {}})
    sol = rodgen.simulate(scene)
    assert sol.values("airspeed_nose")[-1] == pytest.approx(19.99, abs=1e-9)
    turned = arrow({"air.wind": None, "initial.phi": 0.0})
    with pytest.warns(rodgen.DoubtWarning):
        doubted = rodgen.simulate(turned, span=(0.0, 0.01), out=tmp_path / "run.nc")
    assert rodgen.load(tmp_path / "run.nc").notes == doubted.notes


def test_a_density_below_zero_is_doubted() -> None:
    scene = arrow({"air.density": "y + 0.0001", "air.wind": None, "initial.velocity": [0.0, -20.0]})
    with pytest.warns(rodgen.DoubtWarning):
        (note,) = (
            n for n in rodgen.simulate(scene, span=(0.0, 0.1)).notes if "density" in n.figures
        )
    assert note.figures["density"] < -1


def test_a_gust_may_be_a_state_of_the_scene() -> None:
    """Here one that comes to 4 m/s within 0.1 s."""
    states = {"gust": {"rate": "(4 - gust)/0.1"}}
    scene = Scene.from_dict(SCENE | {"states": states}).replace({"air.wind": ["gust", 0.0]})
    sol = rodgen.simulate(scene, span=(0.0, 0.3), output_every=0.3)
    across = sol.values("joints")[-1, :, 0] - sol.values("joints")[0, :, 0]
    assert across.mean() > 0  # it is blown along
    assert sol.values("air_wind_x")[-1] == pytest.approx(4 * (1 - np.exp(-3)), rel=1e-6)


def test_speeds_and_angles_that_the_forces_do_not_know_are_doubted() -> None:
    calm = rodgen.simulate(arrow({"air.wind": None}), span=(0.0, 0.01))
    assert not calm.notes
    turned = arrow({"initial.phi": "-pi/2 + 0.5", "air.wind": None})
    fast = turned.replace({"initial.velocity": [0.0, 280.0]})
    for scene, figures in ((turned, {"degrees"}), (fast, {"degrees", "mach"})):
        with pytest.warns(rodgen.DoubtWarning):
            notes = rodgen.simulate(scene, span=(0.0, 0.001)).notes
        assert {name for note in notes for name in note.figures} == figures | {"stall"}
    with pytest.warns(rodgen.DoubtWarning):
        rodgen.natural_modes(arrow({"initial.velocity": [0.0, 280.0], "air.wind": None}))
    slow = fast.replace({"air.speed_of_sound": 1000.0, "initial.phi": "-pi/2"})
    assert not rodgen.simulate(slow, span=(0.0, 0.001)).notes
