"""One and the same rod with several numbers of links."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen.analyse.extrapolation import find_unlike_damping
from rodgen.model.rod import BOUNDARIES
from rodgen.scene import Scene
from rodgen.scene.mesh import mesh_notes
from rodgen.scene.rod_mesh import RodMesh
from tests.told import numbers, refused

ROD = {"links": 4, "length": 2.0, "bending_stiffness": 3.0, "mass": 5.0}
INSIDE = {"internal_damping": {"coefficient": 0.5}}
FINS = {"external_damping": {"coefficient": 2.0, "fin_factor": {"nose": 3.0, "tail": 9.0}}}


def _scene(loads: dict[str, Any], boundary: str = "free", **tables: Any) -> Scene:
    rod = ROD | {"boundary": boundary}
    return Scene.from_dict({"name": "rod", "rod": rod, "loads": loads} | tables)


@pytest.mark.parametrize("links", [2, 7, 40])
def test_internal_damping_keeps_its_ratio_to_the_springs(links: int) -> None:
    """Kelvin and Voigt: c_int m = eta k with one eta for all; m = M/n, k = EI n/L."""
    for boundary in BOUNDARIES:
        one = _scene(INSIDE, boundary)
        other = one.with_links(links)
        eta = [
            s.parameters["internal_damping"]
            * (s.rod.mass / s.rod.links)
            / (s.rod.bending_stiffness * s.rod.links / s.rod.length)
            for s in (one, other)
        ]
        assert eta[0] == pytest.approx(eta[1], rel=1e-14)
        assert other.rod.links == links
        assert other.rod.model_dump(exclude={"links"}) == one.rod.model_dump(exclude={"links"})


@pytest.mark.parametrize("links", [2, 7, 40])
def test_fins_keep_their_force_and_moment(links: int) -> None:
    """Of a rod that moves across itself: sums over the joints, half a link's mass at both ends."""
    one = _scene(FINS)
    sums = []
    for scene in (one, one.with_links(links)):
        n = scene.rod.links
        masses = scene.rod.mass / n * np.array([0.5, *[1.0] * (n - 1), 0.5])
        forces = np.array(scene.parameters["fin_factor"]) * masses
        sums.append([forces.sum(), forces @ np.arange(n + 1) / n])
    np.testing.assert_allclose(sums[0], sums[1], rtol=1e-14)


def test_the_rest_of_a_scene_stays() -> None:
    """A fin of no more than the body is one of its joints; undamped there is nothing to convert."""
    loads = {"external_damping": {"coefficient": 2.0, "fin_factor": {"tail": 0.5}}}
    one = _scene(loads, initial={"phi": "0.1*s"}, integrate={"span": [0.0, 3.0]})
    other = one.with_links(9).model_dump()
    other["rod"]["links"] = 4
    assert other == one.model_dump()
    assert mesh_notes(one) == ()
    still = _scene({"external_damping": FINS["external_damping"] | {"coefficient": 0.0}})
    assert mesh_notes(still) == mesh_notes(_scene({"internal_damping": {"coefficient": 0}})) == ()


def test_notes_name_every_number_and_its_equivalent() -> None:
    """With four links and with eight, whose joints at the ends stand for half as much."""
    due = (
        ("loads.internal_damping.coefficient", 0.5, 2.0),
        ("fin_factor.nose", 3.0, 5.0),
        ("fin_factor.tail", 9.0, 17.0),
    )
    for note, (name, here, there) in zip(mesh_notes(_scene(INSIDE | FINS)), due, strict=True):
        assert name in note
        assert numbers(note)[:4] == [here, 4, there, 8]
    # The nose of a held rod does not move.
    assert len(mesh_notes(_scene(FINS, "pinned"))) == 1


def test_what_is_given_link_by_link_is_refused() -> None:
    angles = [0.1, 0.2, 0.3, 0.4]
    for tables, field, value in (
        ({"initial": {"phi": angles}}, "initial.phi", angles),
        ({"initial": {"omega": angles}}, "initial.omega", angles),
        ({"events": [{"quantity": "phi_2", "value": 0.1}]}, "events[0].quantity", "phi_2"),
    ):
        assert refused(_scene({}, **tables).with_links, 8)[:2] == (field, value)
    fins = _scene({"external_damping": {"coefficient": 1.0, "fin_factor": [1.0] * 5}})
    assert refused(fins.with_links, 8)[:2] == ("loads.external_damping.fin_factor", [1.0] * 5)
    for links in (0, -3, 2.5, True, 10**7, "8"):
        assert refused(_scene(INSIDE).with_links, links)[:2] == ("links", links)


@pytest.mark.parametrize("links", [8, 12])
def test_links_of_a_list_are_cut_into_equal_parts(links: int) -> None:
    """Masses and lengths of the parts add up to those of the link."""
    joints = [0.0, 0.1, 0.3, 0.7, 1.0]
    one = Scene.from_dict({"name": "rod", "rod": ROD | {"joints": joints}})
    other, parts = one.with_links(links), links // 4
    for name in ("link_length", "link_mass"):
        here, there = (np.array(scene.parameters[name]) for scene in (one, other))
        np.testing.assert_allclose(there, np.repeat(here / parts, parts), rtol=1e-12)
    assert refused(one.with_links, links + 1)[:2] == ("rod.joints", joints)


def test_an_expression_places_any_number_of_joints() -> None:
    one = Scene.from_dict(
        {"name": "rod", "rod": ROD | {"joints": "(i/n)**power"}, "parameters": {"power": 2}}
    )
    for links in (3, 8):
        places = one.with_links(links).mesh.places
        np.testing.assert_allclose(places, (np.arange(links + 1) / links) ** 2, atol=1e-15)


@pytest.mark.parametrize(
    "joints",
    [
        [0.0, 0.5, 1.0],  # as many as of two links
        [0.0, 0.5, 0.25, 0.75, 1.0],
        [0.0, 0.25, 0.25, 0.75, 1.0],
        [0.1, 0.25, 0.5, 0.75, 1.0],
        [0.0, 0.25, 0.5, 0.75, 1.1],
        "i/n + 0.1",
        "1 - i/n",
        "(i/n)**20",
        "log(i/n)",
        "i/m",
        "s",
    ],
)
def test_joints_that_no_rod_has_are_refused(joints: Any) -> None:
    table = {"name": "rod", "rod": ROD | {"joints": joints}}
    assert refused(Scene.from_dict, table)[:2] == ("rod.joints", joints)


def test_numbers_called_as_those_of_joints_are_refused() -> None:
    table = {"name": "rod", "rod": ROD | {"joints": "(i/n)**2"}, "parameters": {"n": 3.0}}
    assert refused(Scene.from_dict, table)[:2] == ("parameters.n", 3.0)


@pytest.mark.parametrize("loads", [INSIDE, FINS])
def test_damping_of_equal_links_is_refused_for_others(loads: dict[str, Any]) -> None:
    (name,) = loads
    table = {"name": "rod", "rod": ROD | {"joints": "(i/n)**2"}, "loads": loads}
    assert refused(Scene.from_dict, table).field == f"loads.{name}.coefficient"


def test_points_lie_on_links_by_their_places() -> None:
    mesh = RodMesh(4, (0.0, 0.1, 0.3, 0.7, 1.0))
    for s, place in ((0.0, "0"), (0.05, "0+1/2"), (0.1, "1"), (0.6, "2+3/4"), (1.0, "")):
        assert mesh.place_text(s) == place
    np.testing.assert_allclose(mesh.middles, [0.05, 0.2, 0.5, 0.85])
    np.testing.assert_allclose(mesh.lengths_at_joints(2.0), [0.1, 0.3, 0.6, 0.7, 0.3])


def test_damping_that_was_not_converted_is_found() -> None:
    one = _scene(INSIDE | FINS)
    assert find_unlike_damping([one, *(one.with_links(n) for n in (3, 8, 20))]) == []
    tables = one.model_dump(exclude_none=True)
    tables["rod"]["links"] = 8
    assert find_unlike_damping([one, Scene.from_dict(tables)]) == [
        "loads.internal_damping.coefficient",
        "loads.external_damping.fin_factor.nose",
        "loads.external_damping.fin_factor.tail",
    ]
