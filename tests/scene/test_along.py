"""What differs along a rod: how it is discretised, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen import Scene, SceneError
from rodgen.scene.overrides import with_parameters

ROD: dict[str, Any] = {"links": 5, "length": 2.0, "mass": 3.0, "bending_stiffness": 100.0}


def _scene(**rod: Any) -> Scene:
    return Scene(name="along", rod=ROD | rod)


@pytest.mark.parametrize("boundary", ["free", "cantilever", "clamped", "pinned"])
@pytest.mark.parametrize("form", ["100 + 0*s", [100.0] * 6])
def test_an_even_law_gives_the_springs_of_an_even_rod(boundary: str, form: Any) -> None:
    scene = _scene(boundary=boundary, bending_stiffness=form)
    inner = 100.0 * 5 / 2.0
    root = [2 * inner] if boundary == "clamped" else []
    assert scene.structure.uneven == ("stiffness",)
    wanted = [*root, *[inner] * 4]
    np.testing.assert_allclose(scene.parameters["joint_stiffness"], wanted, rtol=4e-16)
    assert "bending_stiffness" not in scene.parameters


def test_text_without_s_is_a_number() -> None:
    scene = _scene(bending_stiffness="50*2")
    assert scene.structure == _scene().structure
    assert scene.parameters == _scene().parameters


def test_a_spring_bends_as_much_as_its_cell() -> None:
    """1/EI = 1 + 9 s^2, whose integral is s + 3 s^3: a polynomial, which Gauss has exactly."""
    scene = _scene(boundary="clamped", bending_stiffness="1/(1 + 9*s**2)")
    ends = np.array([0.0, 0.1, 0.3, 0.5, 0.7, 0.9])
    bends = 2.0 * np.diff(ends + 3 * ends**3)
    np.testing.assert_allclose(scene.parameters["joint_stiffness"], 1 / bends, rtol=1e-14)


def test_values_stand_for_their_joints() -> None:
    values = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0]
    scene = _scene(boundary="clamped", bending_stiffness=values)
    wanted = [6.0 / 0.4, 1.0 / 0.4, 4.0 / 0.4, 1.0 / 0.4, 5.0 / 0.4]
    np.testing.assert_allclose(scene.parameters["joint_stiffness"], wanted, rtol=4e-16)


def test_another_number_of_links_keeps_the_expression() -> None:
    scene = _scene(bending_stiffness="100*(1 - s/2)")
    assert scene.with_links(9).rod.bending_stiffness == "100*(1 - s/2)"
    with pytest.raises(SceneError, match=r"rod\.bending_stiffness"):
        _scene(bending_stiffness=[1.0] * 6).with_links(9)


def test_numbers_by_name_are_those_of_the_scene() -> None:
    """Another value is another scene of the same module."""
    rod = {key: value for key, value in ROD.items() if key != "mass"}
    rod |= {"bending_stiffness": "EI0*(1 - s/2)", "mass_per_length": "mu + s"}
    tables = {"name": "along", "rod": rod, "parameters": {"EI0": 100.0, "mu": 1.0}}
    scene = Scene.from_dict(tables)
    assert scene.mass == pytest.approx(2.0 * 1.5)
    other = with_parameters(scene, {"EI0": 200.0, "mu": 2.0})
    assert other.structure == scene.structure
    twice = np.array(other.parameters["joint_stiffness"]) / scene.parameters["joint_stiffness"]
    np.testing.assert_allclose(twice, 2.0, rtol=1e-14)
    assert other.mass == pytest.approx(2.0 * 2.5)
    with pytest.raises(SceneError) as caught:
        with_parameters(scene, {"mu": -0.5})
    assert caught.value.field == "rod.mass_per_length"


@pytest.mark.parametrize(
    ("value", "field", "said"),
    [
        ("EI0*s", "rod.bending_stiffness", "EI0"),
        ("100*(1 - 2*s)", "rod.bending_stiffness", "s = 0.50"),
        ("1/(s - 0.25)**2", "rod.bending_stiffness", "s = 0.25"),
        ("100*t", "rod.bending_stiffness", "s"),
        ([1.0] * 5, "rod.bending_stiffness", "6 values"),
        ([1.0, -1.0, 1.0, 1.0, 1.0, 1.0], "rod.bending_stiffness.1", "at least 0"),
        (-1.0, "rod.bending_stiffness", "at least 0"),
    ],
)
def test_what_no_rod_has_is_refused(value: Any, field: str, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        _scene(bending_stiffness=value)
    assert caught.value.field == field
    assert said in str(caught.value)


PAYLOAD: dict[str, Any] = {"name": "payload", "at": 0.0, "mass": 2.0}


def _carrying(*bodies: dict[str, Any], **rod: Any) -> Scene:
    return Scene(name="along", rod=ROD | rod, bodies=list(bodies))


@pytest.mark.parametrize("form", [1.5, "1.5", "1.5 + 0*s", [1.5] * 5])
def test_mass_per_length_is_mass(form: Any) -> None:
    rod = {key: value for key, value in ROD.items() if key != "mass"}
    scene = Scene(name="along", rod=rod | {"mass_per_length": form})
    assert scene.mass == pytest.approx(3.0, rel=4e-16)
    np.testing.assert_allclose(scene.parameters.get("link_mass", 0.6), 0.6, rtol=4e-16)


def test_links_weigh_what_lies_on_them() -> None:
    """A polynomial of degree 9, whose total five Gauss points have exactly."""
    rod = {key: value for key, value in ROD.items() if key != "mass"}
    scene = Scene(name="along", rod=rod | {"mass_per_length": "1 + 10*s**9"})
    ends = np.arange(6) / 5
    np.testing.assert_allclose(
        scene.parameters["link_mass"], 2.0 * np.diff(ends + ends**10), rtol=1e-14
    )


def test_a_body_moves_the_centre_of_its_link() -> None:
    body = PAYLOAD | {"at": 0.3, "mass": 0.6, "inertia": 0.012, "offset": [0.1, 0.2]}
    scene = _carrying(body)
    p = {name: values[1] for name, values in scene.parameters.items() if name.startswith("link")}
    # Link 1 of 0.4 m and 0.6 kg; the body's place on it is 0.5, and 0.1/0.4 and 0.2/0.4 from there.
    assert p["link_mass"] == pytest.approx(1.2)
    assert p["link_centre_along"] == pytest.approx((0.5 + 0.75) / 2)
    assert p["link_centre_across"] == pytest.approx(0.5 / 2)
    own = 0.012 / (2 * 0.6 * 0.4**2)
    assert p["link_spread_along"] == pytest.approx((1 / 12 + own) / 2 + 0.125**2)
    assert p["link_spread_across"] == pytest.approx(own / 2 + 0.25**2)
    assert p["link_spread_mixed"] == pytest.approx(0.125 * 0.25)


@pytest.mark.parametrize(("at", "link"), [(0.0, 0), (0.2, 1), (0.6, 3), (0.7, 3), (1.0, 4)])
def test_a_body_at_a_joint_is_fixed_to_the_link_behind(at: float, link: int) -> None:
    masses = np.array(_carrying(PAYLOAD | {"at": at}).parameters["link_mass"])
    assert int(np.argmax(masses)) == link
    assert masses.sum() == pytest.approx(5.0)


def test_one_module_serves_all_bodies() -> None:
    many = _carrying(PAYLOAD, PAYLOAD | {"name": "engine", "at": 0.9, "inertia": 1.0})
    assert many.structure == _carrying(PAYLOAD).structure != _scene().structure


@pytest.mark.parametrize(
    ("bodies", "rod", "field"),
    [
        ([PAYLOAD | {"at": 1.5}], {}, "bodies[0].at"),
        ([PAYLOAD | {"mass": 0.0}], {}, "bodies[0].mass"),
        ([PAYLOAD | {"inertia": -1.0}], {}, "bodies[0].inertia"),
        ([PAYLOAD | {"name": "a b"}], {}, "bodies[0].name"),
        ([PAYLOAD, PAYLOAD], {}, "bodies[1].name"),
        ([PAYLOAD | {"offset": [1.0]}], {}, "bodies[0].offset"),
        ([PAYLOAD | {"inertia": 1.0}], {"inertia": "lumped"}, "bodies[0].inertia"),
        ([PAYLOAD | {"offset": [1.0, 0.0]}], {"inertia": "lumped"}, "bodies[0].offset"),
        ([PAYLOAD | {"at": 0.5}], {"inertia": "lumped"}, "bodies[0].at"),
        ([], {"mass_per_length": 1.0}, "rod.mass"),
        ([], {"mass": None}, "rod.mass"),
        ([], {"mass": None, "mass_per_length": "1 - 2*s"}, "rod.mass_per_length"),
        ([], {"mass": None, "mass_per_length": [1.0] * 6}, "rod.mass_per_length"),
        ([], {"mass": None, "mass_per_length": 0.0}, "rod.mass_per_length"),
        ({}, {}, "bodies"),
    ],
)
def test_what_no_rod_carries_is_refused(bodies: Any, rod: dict[str, Any], field: str) -> None:
    table = {key: value for key, value in (ROD | rod).items() if value is not None}
    with pytest.raises(SceneError) as caught:
        Scene(name="along", rod=table, bodies=bodies)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("law", "said"),
    [
        ("0.1/(s - 0.53)", "s = 0.53)"),  # between the points at which links sum it up
        ("t + 0.1/(s - 0.53)**2", "s = 0.53 and t = 0)"),
        ("0.1/((s - 0.53)*(t - 1))", "s = 0.53"),
        ("0.01/(s + 0.4 - t)", "s = 0 and t = 0.4)"),  # comes onto the rod
        ("tan(pi*s)", "s = 0.5)"),
        ("1/s", "s = 0)"),
        ("0.1/(s - 1.01)", ""),
        ("0.1/(s + t + 0.1)", ""),
        ("0.1/(t - 1)", ""),  # at its pole the run ends, which tells of it
        ("abs(s - 0.5)", ""),
    ],
)
def test_a_pole_inside_the_rod_is_refused_with_its_place(law: str, said: str) -> None:
    table = {
        "name": "poles",
        "rod": {"links": 5, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0},
        "loads": {"distributed_follower": {"force_per_length": law}},
        "integrate": {"span": [0.0, 2.0]},
    }
    if not said:
        assert Scene.from_dict(table).loads.terms == ("distributed_follower",)
        return
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(table)
    assert caught.value.field == "loads.distributed_follower.force_per_length"
    assert said in caught.value.allowed
