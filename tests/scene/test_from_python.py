"""Scenes made in Python: arrays, tuples and NumPy's numbers, and what is no scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.errors import Missing
from rodgen.scene import Scene
from tests.scene.tables import ROD, scene_of
from tests.told import refused

PHI = [0.0, 0.1, 0.2, 0.3, 0.4]
# As Python has them, and as a file has them.
SAME: list[tuple[dict[str, Any], dict[str, Any]]] = [
    ({"rod": {**ROD, "links": np.int64(5)}}, {}),
    ({"rod": {**ROD, "mass": np.float32(1), "length": np.array(1)}}, {}),
    ({"rod": {**ROD, "boundary": np.str_("pinned")}}, {"rod": {**ROD, "boundary": "pinned"}}),
    ({"initial": {"phi": np.array(PHI)}}, {"initial": {"phi": PHI}}),
    ({"initial": {"phi": tuple(PHI)}}, {"initial": {"phi": PHI}}),
    ({"initial": {"phi": [np.float64(value) for value in PHI]}}, {"initial": {"phi": PHI}}),
    ({"initial": {"phi": np.arange(5, dtype="i2")}}, {"initial": {"phi": [0, 1, 2, 3, 4]}}),
    ({"initial": {"omega": np.longdouble(0.5)}}, {"initial": {"omega": 0.5}}),
    ({"initial": {"position": np.array([0, 1.0])}}, {"initial": {"position": [0.0, 1.0]}}),
    ({"integrate": {"span": (0, 1)}}, {"integrate": {"span": [0.0, 1.0]}}),
    ({"integrate": {"max_steps": np.uint8(9)}}, {"integrate": {"max_steps": 9}}),
    (
        {"loads": {"external_damping": {"coefficient": 1, "fin_factor": np.ones(6)}}},
        {"loads": {"external_damping": {"coefficient": 1, "fin_factor": [1.0] * 6}}},
    ),
    (
        {"events": ({"quantity": "tip_x", "value": np.float64(2)},)},
        {"events": [{"quantity": "tip_x", "value": 2.0}]},
    ),
]


def test_values_of_numpy_are_those_of_a_file() -> None:
    for given, due in SAME:
        scene = scene_of(**given)
        assert scene == scene_of(**due)
        # Nothing of NumPy is left: repr tells np.float64(2.0) from 2.0.
        assert "np." not in repr(scene)
        assert Scene.model_validate_json(scene.model_dump_json(exclude_none=True)) == scene
        assert scene.time_laws.expressions == ()
        assert not scene.unused_names
        assert Scene(**dict(scene)) == scene  # of tables that are checked already


REFUSED: list[tuple[str, Any, str]] = [
    ("rod.mass", np.True_, ""),
    ("rod.mass", np.array([1.0]), ""),
    ("rod.links", np.float64(5), ""),
    ("initial.phi", np.array([True] * 5), ".0"),
    ("initial.phi", np.array(["a"] * 5), ""),
    ("initial.phi", np.array([None] * 5), ""),
    ("initial.phi", np.ones(5) * 1j, ""),
    ("initial.phi", np.zeros((5, 1)), ".0"),
    ("initial.phi", np.ma.masked_less(np.array(PHI), 0.05), ".0"),
    ("initial.phi", np.array([np.nan] * 5), ".0"),
]


def test_other_arrays_are_refused() -> None:
    """At the array, or where it has what is no number."""
    for field, value, at in REFUSED:
        table, _, key = field.partition(".")
        assert refused(scene_of, **{table: {key: value}}).field == field + at
    events = [{"quantity": "tip_x", "value": np.array("a", "O")}]
    assert refused(scene_of, events=events).field == "events[0].value"
    for key in (1, "self"):
        assert refused(Scene.from_dict, {"name": "test", "rod": ROD, key: 2})[:2] == (str(key), 2)


def test_settings_and_structures_take_them_too() -> None:
    scene = scene_of()
    changed = scene.with_integrate(span=np.array([0, 5]), rtol=np.float32(0.5))
    assert changed == scene.with_integrate(span=[0.0, 5.0], rtol=0.5)
    assert refused(scene.with_integrate, span=np.array(["a", "b"])).field == "integrate.span"
    one, other = rodgen.Structure(np.int64(4)), rodgen.Structure(4)
    assert (one, one.hash) == (other, other.hash)


def test_scene_by_keywords_is_checked_alike() -> None:
    given = Scene(name="test", rod=ROD, integrate={"span": (0, 1)})
    assert given == scene_of(integrate={"span": [0, 1]})
    assert refused(Scene, name="test", rod={**ROD, "mass": -1})[:2] == ("rod.mass", -1)
    assert refused(Scene, name="test")[:2] == ("rod", Missing)
    for table in ("chain.toml", 5, None, [ROD]):
        assert refused(Scene.from_dict, table)[:2] == ("scene", table)


def test_what_is_no_scene_or_solution() -> None:
    functions: list[Callable[..., Any]] = [
        *(rodgen.build, rodgen.simulate, rodgen.natural_modes, rodgen.static_equilibrium),
        *(rodgen.static_equilibria, rodgen.find_cycle, rodgen.lyapunov_exponents),
        *(rodgen.floquet, rodgen.critical_load, rodgen.simulated_critical_load),
    ]
    for function in functions:
        with pytest.raises(TypeError, match=r"^(scene|system) .*Scene.from_toml.* str$"):
            function("chain.toml")
    with pytest.raises(TypeError, match=r"^solution .* Scene$"):
        rodgen.spectrum(scene_of())
