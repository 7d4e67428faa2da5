"""Scenes made in Python: arrays, tuples and NumPy's numbers, and what is no scene."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.scene import Scene, SceneError
from rodgen.scene.integration import Integrate, Settings
from tests.scene.tables import ROD

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


@pytest.mark.parametrize(("given", "due"), SAME)
def test_values_of_numpy_are_those_of_a_file(given: dict[str, Any], due: dict[str, Any]) -> None:
    scene = Scene.from_dict({"name": "test", "rod": ROD, **given})
    assert scene == Scene.from_dict({"name": "test", "rod": ROD, **due})
    # Nothing of NumPy is left: repr tells np.float64(2.0) from 2.0.
    assert "np." not in repr(scene)
    scene.model_dump_json()


REFUSED = [
    ({"rod": {**ROD, "mass": np.True_}}, "rod.mass", "a number"),
    ({"rod": {**ROD, "mass": np.array([1.0])}}, "rod.mass", "a number"),
    ({"rod": {**ROD, "links": np.float64(5)}}, "rod.links", "a whole number"),
    ({"initial": {"phi": np.array([True] * 5)}}, "initial.phi.0", "a number"),
    ({"initial": {"phi": np.array(["a"] * 5)}}, "initial.phi", "real numbers"),
    ({"initial": {"phi": np.array([None] * 5)}}, "initial.phi", "array of object"),
    ({"initial": {"phi": np.ones(5) * 1j}}, "initial.phi", "array of complex128"),
    ({"initial": {"phi": np.zeros((5, 1))}}, "initial.phi.0", "a number"),
    ({"initial": {"phi": np.ma.masked_less(np.array(PHI), 0.05)}}, "initial.phi.0", "a number"),
    ({"initial": {"phi": np.array([np.nan] * 5)}}, "initial.phi.0", "a finite number"),
    ({"events": [{"quantity": "tip_x", "value": np.array("a", "O")}]}, "events[0].value", "real"),
    ({1: 2}, "1", "not a known key"),
    ({"self": 2}, "self", "not a known key"),
]


@pytest.mark.parametrize(("change", "field", "allowed"), REFUSED)
def test_other_arrays_are_refused(change: dict[Any, Any], field: str, allowed: str) -> None:
    with pytest.raises(SceneError, match=allowed) as caught:
        Scene.from_dict({"name": "test", "rod": ROD, **change})
    assert caught.value.field == field
    assert len(str(caught.value).splitlines()) == 1


def test_settings_and_structures_take_them_too() -> None:
    scene = Scene.from_dict({"name": "test", "rod": ROD})
    changed = scene.with_integrate(span=np.array([0, 5]), rtol=np.float32(0.5))
    assert changed == scene.with_integrate(span=[0.0, 5.0], rtol=0.5)
    with pytest.raises(SceneError, match=r"integrate\.span"):
        scene.with_integrate(span=np.array(["a", "b"]))
    one, other = rodgen.Structure(np.int64(4)), rodgen.Structure(4)  # type: ignore[arg-type]
    assert (one, one.hash) == (other, other.hash)


def test_scene_by_keywords_is_checked_in_the_same_words() -> None:
    scene = Scene(name="test", rod=ROD, integrate={"span": (0, 1)})
    assert scene == Scene.from_dict({"name": "test", "rod": ROD, "integrate": {"span": [0, 1]}})
    with pytest.raises(SceneError, match=r"rod\.mass = -1: must be greater than 0"):
        Scene(name="test", rod={**ROD, "mass": -1})
    with pytest.raises(SceneError, match=r"rod = \(missing\): must be given"):
        Scene(name="test")
    for table in ("chain.toml", 5, None, [ROD]):
        with pytest.raises(SceneError, match="must be a table"):
            Scene.from_dict(table)  # type: ignore[arg-type]


def test_scene_is_copied_and_read_back() -> None:
    scene = Scene(name="test", rod=ROD, events=[{"quantity": "tip_x", "value": 2}])
    assert copy.deepcopy(scene) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert Scene.model_validate_json(scene.model_dump_json(exclude_none=True)) == scene
    assert Scene(**dict(scene)) == scene  # of tables that are checked already


@pytest.mark.parametrize(
    "function",
    [
        rodgen.build,
        rodgen.simulate,
        rodgen.natural_modes,
        rodgen.static_equilibrium,
        rodgen.static_equilibria,
        rodgen.find_cycle,
        rodgen.lyapunov_exponents,
        rodgen.floquet,
        rodgen.critical_force,
        rodgen.simulated_critical_force,
    ],
    ids=lambda function: function.__name__,
)
def test_what_is_no_scene(function: Callable[..., Any]) -> None:
    with pytest.raises(TypeError, match=r"^scene must be a Scene .*Scene.from_toml\), not str$"):
        function("chain.toml")


def test_what_is_no_solution() -> None:
    scene = Scene.from_dict({"name": "test", "rod": ROD})
    with pytest.raises(TypeError, match=r"^solution must be a Solution .*, not Scene$"):
        rodgen.spectrum(scene)  # type: ignore[arg-type]


def test_every_key_of_integrate_is_a_typed_keyword() -> None:
    assert set(Settings.__annotations__) == set(Integrate.model_fields)
