"""What differs along a rod: how it is discretised, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen import Scene
from rodgen.errors import Missing
from rodgen.model.rod import BOUNDARIES
from tests.scene.tables import table_of
from tests.told import refused

ROD: dict[str, Any] = {"links": 5, "length": 2.0, "mass": 3.0, "bending_stiffness": 100.0}
PAYLOAD: dict[str, Any] = {"name": "payload", "at": 0.0, "mass": 2.0}


def _scene(*bodies: Any, integrate: Any = None, **rod: Any) -> Scene:
    """The rod with other keys, without those that are None, and with bodies on it."""
    table = {key: value for key, value in (ROD | rod).items() if value is not None}
    return Scene(name="along", rod=table, bodies=list(bodies), integrate=integrate or {})


@pytest.mark.parametrize("form", ["100 + 0*s", [100.0] * 6])
def test_an_even_law_gives_the_springs_of_an_even_rod(form: Any) -> None:
    for boundary in BOUNDARIES:
        scene = _scene(boundary=boundary, bending_stiffness=form)
        inner = 100.0 * 5 / 2.0
        root = [2 * inner] if boundary == "clamped" else []
        assert scene.structure.nonuniform == ("stiffness",)
        wanted = [*root, *[inner] * 4]
        np.testing.assert_allclose(scene.parameters["joint_stiffness"], wanted, rtol=4e-16)
        assert "bending_stiffness" not in scene.parameters


def test_a_spring_bends_as_much_as_its_cell() -> None:
    """1/EI = 1 + 9 s^2, whose integral is s + 3 s^3: a polynomial, which Gauss has exactly."""
    scene = _scene(boundary="clamped", bending_stiffness="1/(1 + 9*s**2)")
    ends = np.array([0.0, 0.1, 0.3, 0.5, 0.7, 0.9])
    bends = 2.0 * np.diff(ends + 3 * ends**3)
    np.testing.assert_allclose(scene.parameters["joint_stiffness"], 1 / bends, rtol=1e-14)


def test_values_stand_for_their_joints() -> None:
    scene = _scene(boundary="clamped", bending_stiffness=[3.0, 1.0, 4.0, 1.0, 5.0, 9.0])
    wanted = [6.0 / 0.4, 1.0 / 0.4, 4.0 / 0.4, 1.0 / 0.4, 5.0 / 0.4]
    np.testing.assert_allclose(scene.parameters["joint_stiffness"], wanted, rtol=4e-16)


def test_another_number_of_links_keeps_the_expression() -> None:
    scene = _scene(bending_stiffness="100*(1 - s/2)")
    assert scene.with_links(9).rod.bending_stiffness == "100*(1 - s/2)"
    listed = _scene(bending_stiffness=[1.0] * 6)
    assert refused(listed.with_links, 9)[:2] == ("rod.bending_stiffness", [1.0] * 6)


def test_numbers_by_name_are_those_of_the_scene() -> None:
    """Another value is another scene of the same module."""
    laws = {"bending_stiffness": "EI0*(1 - s/2)", "mass_per_length": "mu + s"}
    rod = {key: value for key, value in ROD.items() if key != "mass"} | laws
    tables = {"name": "along", "rod": rod, "parameters": {"EI0": 100.0, "mu": 1.0}}
    scene = Scene.from_dict(tables)
    assert scene.mass == pytest.approx(2.0 * 1.5)
    other = scene.replace({"parameters.EI0": 200.0, "parameters.mu": 2.0})
    assert other.structure == scene.structure
    twice = np.array(other.parameters["joint_stiffness"]) / scene.parameters["joint_stiffness"]
    np.testing.assert_allclose(twice, 2.0, rtol=1e-14)
    assert other.mass == pytest.approx(2.0 * 2.5)
    assert refused(scene.replace, {"parameters.mu": -0.5})[:2] == ("rod.mass_per_length", "mu + s")


def test_a_stiffness_that_no_rod_has_is_refused() -> None:
    for value, number in (
        ("EI0*s", None),
        ("100*(1 - 2*s)", 0.5),  # from which on it is below 0
        ("1/(s - 0.25)**2", 0.25),
        ("100*t", None),
        ([1.0] * 5, 6),
    ):
        told = refused(_scene, bending_stiffness=value)
        assert told[:2] == ("rod.bending_stiffness", value)
        # The place is found to a thousandth of the rod.
        assert number is None or pytest.approx(number, abs=1e-2) in told.numbers
    values = [1.0, -1.0, 1.0, 1.0, 1.0, 1.0]
    assert refused(_scene, bending_stiffness=values)[:2] == ("rod.bending_stiffness.1", -1.0)
    assert refused(_scene, bending_stiffness=-1.0)[:2] == ("rod.bending_stiffness", -1.0)


def test_mass_per_length_is_mass() -> None:
    for form in (1.5, "1.5", "1.5 + 0*s", [1.5] * 5):
        scene = _scene(mass=None, mass_per_length=form)
        assert scene.mass == pytest.approx(3.0, rel=4e-16)
        np.testing.assert_allclose(scene.parameters.get("link_mass", 0.6), 0.6, rtol=4e-16)


def test_a_law_along_the_rod_may_change_in_time_alone() -> None:
    """Along it, it has neither poles nor breaks; one that has them at a time is refused."""
    scene = _scene(mass=None, mass_per_length="1 + t**2")
    assert scene.mass == pytest.approx(2.0, rel=4e-16)  # at the start
    load = {"distributed_follower": {"force_per_length": "1 + t**2"}}
    assert Scene(name="along", rod=ROD, loads=load).structure.terms == ("distributed_follower",)
    assert refused(_scene, mass=None, mass_per_length="1/(t - 0.5)").field == "rod.mass_per_length"


def test_links_weigh_what_lies_on_them() -> None:
    """A polynomial of degree 9, whose total five Gauss points have exactly."""
    found = _scene(mass=None, mass_per_length="1 + 10*s**9").parameters["link_mass"]
    ends = np.arange(6) / 5
    np.testing.assert_allclose(found, 2.0 * np.diff(ends + ends**10), rtol=1e-14)


def test_a_body_moves_the_centre_of_its_link() -> None:
    scene = _scene(PAYLOAD | {"at": 0.3, "mass": 0.6, "inertia": 0.012, "offset": [0.1, 0.2]})
    p = {name: values[1] for name, values in scene.parameters.items() if name.startswith("link")}
    # Link 1 of 0.4 m and 0.6 kg; the body's place on it is 0.5, and 0.1/0.4 and 0.2/0.4 from there.
    assert p["link_mass"] == pytest.approx(1.2)
    assert p["link_centre_along"] == pytest.approx((0.5 + 0.75) / 2)
    assert p["link_centre_across"] == pytest.approx(0.5 / 2)
    own = 0.012 / (2 * 0.6 * 0.4**2)
    assert p["link_spread_along"] == pytest.approx((1 / 12 + own) / 2 + 0.125**2)
    assert p["link_spread_across"] == pytest.approx(own / 2 + 0.25**2)
    assert p["link_spread_mixed"] == pytest.approx(0.125 * 0.25)


def test_a_body_at_a_joint_is_fixed_to_the_link_behind() -> None:
    for at, link in ((0.0, 0), (0.2, 1), (0.6, 3), (0.7, 3), (1.0, 4)):
        masses = np.array(_scene(PAYLOAD | {"at": at}).parameters["link_mass"])
        assert int(np.argmax(masses)) == link
        assert masses.sum() == pytest.approx(5.0)


def test_one_module_serves_all_bodies() -> None:
    many = _scene(PAYLOAD, PAYLOAD | {"name": "engine", "at": 0.9, "inertia": 1.0})
    assert many.structure == _scene(PAYLOAD).structure != _scene().structure


def test_a_body_that_no_rod_carries_is_refused() -> None:
    for inertia, key, value in (
        ("uniform", "at", 1.5),
        ("uniform", "mass", 0.0),
        ("uniform", "inertia", -1.0),
        ("uniform", "name", "a b"),
        ("uniform", "offset", [1.0]),
        ("lumped", "inertia", 1.0),
        ("lumped", "offset", [1.0, 0.0]),
        ("lumped", "at", 0.5),
    ):
        told = refused(_scene, PAYLOAD | {key: value}, inertia=inertia)
        assert told[:2] == (f"bodies[0].{key}", value)
    assert refused(_scene, PAYLOAD, PAYLOAD)[:2] == ("bodies[1].name", "payload")
    assert refused(Scene, name="along", rod=ROD, bodies={})[:2] == ("bodies", {})


def test_a_mass_that_no_rod_has_is_refused() -> None:
    assert refused(_scene, mass_per_length=1.0)[:2] == ("rod.mass", 3.0)
    assert refused(_scene, mass=None)[:2] == ("rod.mass", Missing)
    for law in ("1 - 2*s", [1.0] * 6, 0.0):
        assert refused(_scene, mass=None, mass_per_length=law)[:2] == ("rod.mass_per_length", law)


def test_a_pole_inside_the_rod_is_refused_with_its_place() -> None:
    """At a time in the span of two seconds; a pole of all the rod at a time ends the run there."""
    for law, *place in (
        ("0.1/(s - 0.53)", 0.53),  # between the points at which links sum it up
        ("t + 0.1/(s - 0.53)**2", 0.53, 0.0),
        ("0.1/((s - 0.53)*(t - 1))", 0.53),
        ("0.01/(s + 0.4 - t)", 0.0, 0.4),  # comes onto the rod
        ("tan(pi*s)", 0.5),
        ("1/s", 0.0),
        ("0.1/(s - 1.01)",),
        ("0.1/(s + t + 0.1)",),
        ("0.1/(t - 1)",),
        ("abs(s - 0.5)",),
    ):
        loads = {"distributed_follower": {"force_per_length": law}}
        table = table_of(loads=loads, integrate={"span": [0.0, 2.0]})
        if not place:
            assert Scene.from_dict(table).loads.terms == ("distributed_follower",)
            continue
        told = refused(Scene.from_dict, table)
        assert told[:2] == ("loads.distributed_follower.force_per_length", law)
        for number in place:  # as they are printed, to some digits
            assert pytest.approx(number, abs=1e-3) in told.numbers


# Between samples ---------------------------------------------------------------------------------

STIFFNESS, MASS, BODY = "rod.bending_stiffness", "rod.mass_per_length", "bodies[0].mass"


def _varying(field: str, law: str) -> Scene:
    """One that varies along the rod or in seven seconds."""
    bodies: list[Any] = []
    rod: dict[str, Any] = {field.removeprefix("rod."): law}
    if field == BODY:
        bodies, rod = [PAYLOAD | {"mass": law}], {}
    elif field == MASS:
        rod["mass"] = None
    return _scene(*bodies, integrate={"span": [0.0, 7.0]}, **rod)


def test_what_lies_between_samples_is_found() -> None:
    for field, law, where in (
        (STIFFNESS, "abs(s - 0.123456789) - 1e-6", 0.123456789),
        (STIFFNESS, "(s - 0.3141592)**2 - 1e-9", 0.3141592),
        (STIFFNESS, "interp(s, [0, 0.12345, 1], [1, -1e-6, 1])", 0.12345),
        (STIFFNESS, "1/abs(s - 0.31415926)", 0.31415926),
        (STIFFNESS, "2 if s < 0.2999999 else -1 if s < 0.3 else 2", 0.3),
        (MASS, "(s - 0.2)**2 + (t - 1.2345)**2 - 1e-7", 1.2345),
        (MASS, "abs(s - 0.2345) + abs(t - 3.21) - 1e-7", 3.21),
        (MASS, "2 if t < 1.2345 else -1 if t < 1.2346 else 2", 1.2345),
        (MASS, "1/(t - 3.2123)**2", 3.2123),
        (BODY, "1.0 - cos(t - 3.2123)", 3.2123),
        (BODY, "interp(t, [0, 3.3333, 7], [1, -1e-9, 1])", 3.3333),
    ):
        told = refused(_varying, field, law)
        assert told[:2] == (field, law)
        # To the six digits that are printed.
        assert pytest.approx(where, rel=1e-5) in told.numbers, told.allowed


def test_what_is_large_enough_is_taken() -> None:
    for field, law in (
        (STIFFNESS, "(s - 0.3141592)**2"),  # a stiffness may be zero
        (STIFFNESS, "1 - s"),
        (STIFFNESS, "abs(sin(20*s))"),
        (MASS, "1 + 0.999*sin(40*t + 3*s)"),
        (MASS, "2 if s > t/7 else 1e-3"),
        (BODY, "1.0001 - cos(t - 3.2123)"),
    ):
        _varying(field, law)
