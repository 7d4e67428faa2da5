"""Units of tables that are not SI, and masses at stations."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

from rodgen.errors import InputError
from rodgen.model.rod import BODY, FOUNDATION, ROD, SUPPORT
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.scene.units import _powers, _table_of, _units_of
from tests.told import refused

PLAIN: dict[str, Any] = {
    "name": "plain",
    "rod": {
        "links": 4,
        "length": 2.4,
        "mass": 3.0,
        "bending_stiffness": 500.0,
        "boundary": "clamped",
        "clamp_angle": 0.5235987755982988,
    },
    "bodies": [{"name": "head", "at": 0.3, "mass": 0.25, "offset": [0.0, 0.0127]}],
    "supports": [{"at": 0.5, "to": [1.0, 2.0], "stiffness": [2000.0, 3000.0]}],
    "loads": {"follower": {"force": 3000.0}, "drag": {"normal": 0.7, "wind": [3.0, "2*t"]}},
    "initial": {"phi": 0.1},
}
OTHER: dict[str, Any] = {
    "name": "plain",
    "units": {"length": "mm", "angle": "deg"},
    "rod": {
        "links": 4,
        "length": 2400,
        "mass": 3.0,
        "bending_stiffness": 5e8,
        "boundary": "clamped",
        "clamp_angle": 30,
    },
    "bodies": [
        {
            "units": {"mass": "g", "length": "in"},
            "name": "head",
            "at": 0.3,
            "mass": 250,
            "offset": [0.0, 0.5],
        }
    ],
    "supports": [{"at": 0.5, "to": [1000, "1000*2"], "stiffness": [2.0, 3.0]}],
    "loads": {
        "units": {"force": "kN"},
        "follower": {"force": 3},
        "drag": {"normal": 0.7, "wind": [3.0, "2*t"]},
    },
    "initial": {"phi": "18/pi"},
}


def test_a_scene_in_other_units_is_the_scene_in_si() -> None:
    """Those of a table hold within it, and add to those outside."""
    one, two = Scene.from_dict(PLAIN), Scene.from_dict(OTHER)
    assert one.structure == two.structure
    for name, value in one.parameters.items():
        np.testing.assert_allclose(two.parameters[name], value, rtol=3e-16, err_msg=name)
    np.testing.assert_allclose(one.initial_state(), two.initial_state(), rtol=3e-16)
    assert Scene.from_dict(two.to_dict()) == two
    assert "units" not in two.to_toml()


def test_a_decimal_number_is_the_nearest_double_of_what_it_means() -> None:
    for length in (0.1, 2.4, 1.7, 1e3, 123456.789):
        text = {**OTHER, "rod": {**OTHER["rod"], "length": length * 1000}}
        exact = float(f"{length * 1000!r}e-3")
        assert Scene.from_dict(text).rod.length == exact


def test_an_expression_is_converted_by_its_value() -> None:
    made = Scene.from_dict(
        {**OTHER, "loads": {"units": {"force": "kN"}, "follower": {"force": "3*t"}}}
    )
    assert made.expression("follower_force")(2.0) == 6000.0


def test_numbers_of_an_expression_keep_their_places() -> None:
    loads = {"units": {"force": "kN"}, "follower": {"force": "300*min(t/0.5, 1)"}}
    scene = Scene.from_dict(PLAIN | {"loads": loads})
    changed = scene.replace({"loads.follower.force.0": 5.0})
    assert changed.expression("follower_force")(1.0) == 5000.0


def test_a_state_or_a_table_may_be_called_units() -> None:
    states = {"units": {"rate": "1 - units"}}
    assert [*Scene.from_dict(PLAIN | {"states": states}).states] == ["units"]


def test_units_that_are_not_known_are_refused_with_their_place() -> None:
    def with_units(units: object) -> dict[str, Any]:
        return {**PLAIN, "rod": {**PLAIN["rod"], "units": units}}

    for units, field in (
        ({"lenght": "mm"}, "rod.units.lenght"),
        ({"length": "furlong"}, "rod.units.length"),
        ({"length": 3}, "rod.units.length"),
        ("mm", "rod.units"),
    ):
        with pytest.raises(InputError) as told:
            Scene.from_dict(with_units(units))
        assert told.value.field == field
    twice = {**OTHER, "initial": {"phi": "deg(30)"}}
    assert refused(Scene.from_dict, twice)[:2] == ("initial.phi", "deg(30)")
    stop = {"at": 1.0, "direction": 0.0, "gap": 1, "stiffness": 1.0, "exponent": 1.5}
    assert refused(Scene.from_dict, {**OTHER, "stops": [stop]}).field == "stops[0].exponent"


def _keys(model: type[BaseModel], place: str = "") -> Iterator[tuple[type[BaseModel], str, str]]:
    for key, field in model.model_fields.items():
        if (inner := _table_of(field)) is not None:
            yield from _keys(inner, f"{place}{key}.")
        else:
            yield model, key, place


def test_every_unit_of_the_vocabulary_is_read() -> None:
    """Of rows and of descriptions: a unit that is not would leave its numbers as they are."""
    rows = (*ROD, *BODY, *SUPPORT, *FOUNDATION, *(p for t in TERMS.values() for p in t.parameters))
    assert not [one.name for one in rows if one.unit and _powers(one.unit) is None]
    # Units in brackets, but for [x, y], [see below], and lists of tables.
    unit = re.compile(r"\[(?:1/)?(?:kg|rad|m|N|s)\b[^\]`]*\]")
    for model, key, place in _keys(Scene):
        shown = unit.findall(str(model.model_fields[key].description))
        if not hasattr(model, "term"):
            assert len(shown) == len(_units_of(model, key)), f"{place}{key}"


STATIONS = "station [mm]; mass [g]\n0; 500\n400; 1250\n1000; 250\n1150; 2000\n"


def test_stations_keep_their_total_and_are_spread_to_the_middles_between_them(
    tmp_path: Path,
) -> None:
    """From a file in its own units: 0 to 0.2 m, to 0.7 m, to 1.075 m, and to the end."""
    (tmp_path / "stations.csv").write_text(STATIONS)
    (tmp_path / "rocket.toml").write_text(
        'name = "rocket"\n[rod]\nunits = {length = "mm", mass = "g"}\nlinks = 4\nlength = 1200\n'
        'bending_stiffness = 1e8\nmass = "stations.csv"\n'
    )
    scene = Scene.from_toml(tmp_path / "rocket.toml")
    assert scene.mass == 4.0
    assert scene.rod.bending_stiffness == 100.0
    per_length = [0.5 / 0.2, 1.25 / 0.5, 0.25 / 0.375, 2.0 / 0.125]
    edges, masses = np.array([0, 0.2, 0.7, 1.075, 1.2]), np.zeros(4)
    for link, (low, high) in enumerate(zip((0, 0.3, 0.6, 0.9), (0.3, 0.6, 0.9, 1.2), strict=True)):
        shared = np.minimum(high, edges[1:]) - np.maximum(low, edges[:-1])
        masses[link] = np.maximum(shared, 0) @ per_length
    np.testing.assert_allclose(scene.parameters["link_mass"], masses, rtol=1e-14)
    assert scene.replace({"rod.links": 7}).mass == 4.0
    assert Scene.from_dict(scene.to_dict()) == scene


def test_stations_that_are_not_on_the_rod_are_refused(tmp_path: Path) -> None:
    rod = {key: value for key, value in PLAIN["rod"].items() if key != "mass"}
    for stations, field in (
        ([[0.1, 1.0], [0.1, 1.0]], "rod.stations[1]"),
        ([[0.1, 1.0], [2.5, 1.0]], "rod.stations[1]"),
        ([[0.1, -1.0]], "rod.stations.0.1"),
        ([[0.1]], "rod.stations.0"),
    ):
        scene = {**PLAIN, "rod": {**rod, "stations": stations}}
        assert refused(Scene.from_dict, scene).field == field
    both = {**PLAIN, "rod": {**PLAIN["rod"], "stations": [[0.1, 1.0]]}}
    assert refused(Scene.from_dict, both).field == "rod.mass"
    (tmp_path / "a.toml").write_text(
        'name = "a"\n[rod]\nlinks = 4\nlength = 1\nbending_stiffness = 1\nmass = "../x.csv"\n'
    )
    assert refused(Scene.from_toml, tmp_path / "a.toml").field == "rod.mass"


def test_links_weigh_exactly_what_lies_on_them_where_a_law_has_corners() -> None:
    """Between the points at which links sum it up: a step, and a table."""
    rod = {key: value for key, value in PLAIN["rod"].items() if key != "mass"}
    for law, share in (
        ("4 if s < 0.37 else 9", 4 * 0.37 + 9 * 0.63),
        ("interp(s, [0.11, 0.52, 0.53], [1, 7, 2])", 0.11 + 0.41 * 4 + 0.01 * 4.5 + 0.47 * 2),
        ("max(1, 8*s)", 1 / 8 + 4 * (1 - 1 / 64)),
    ):
        made = {**PLAIN, "bodies": [], "rod": {**rod, "mass_per_length": law}}
        assert Scene.from_dict(made).mass == pytest.approx(2.4 * share, rel=1e-14)
