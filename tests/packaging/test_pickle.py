"""Everything public goes through pickle, cloudpickle and copy, and through pools of processes."""

from __future__ import annotations

import copy
import inspect
import multiprocessing
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, is_dataclass
from functools import cache
from types import ModuleType
from typing import Any

import cloudpickle
import numpy as np
import pytest
import xarray

import rodgen
from rodgen.analyse.fourier import peaks_of
from rodgen.integrate.live_progress import LiveError
from rodgen.scene import Scene

TABLE: dict[str, Any] = {
    "name": "carried",
    "rod": {
        "links": 3,
        "length": 2.0,
        "bending_stiffness": 30.0,
        "mass": 3.0,
        "boundary": "clamped",
    },
    "loads": {"follower": {"force": 4.0}},
    "initial": {"phi": 0.1},
    "events": [{"quantity": "phi_2", "value": 0.0}],
    "integrate": {"span": [0.0, 0.5], "output_every": 0.1},
}
SCENE = Scene.from_dict(TABLE)


def _error(call: Callable[[], object]) -> BaseException:
    try:
        call()
    except BaseException as error:
        return error
    raise AssertionError("no error")


@cache
def _solution() -> rodgen.Solution:
    return rodgen.simulate(SCENE, target="numpy")


def _ensemble() -> rodgen.Ensemble:
    model = rodgen.build(SCENE)
    p, y = model.parameters(**SCENE.parameters), SCENE.initial_state()
    return rodgen.simulate_many(
        model, p, np.stack((y, 2 * y)), span=(0.0, 0.5), keep=["max(phi_2)"]
    )


def _critical() -> rodgen.SimulatedCritical:
    values = {field.name: 1.0 for field in fields(rodgen.SimulatedCritical)}
    return rodgen.SimulatedCritical(**values)  # type: ignore[arg-type]


def _exponents() -> rodgen.Exponents:
    several = [np.ones((1, 3)) for _ in range(2)]
    means = [np.arange(3.0), np.ones(3), np.ones(1)]
    rest = 0.5, 0.9, float("nan"), {"time": 1}, ("a note",)
    return rodgen.Exponents(*means, *several, *rest, scene=SCENE)


# How to come by one of every class that is public. What is missing here fails the test below.
EXAMPLES: dict[str, Callable[[], Any]] = {
    "AnalysisError": lambda: rodgen.AnalysisError("none found"),
    "BranchInterrupted": lambda: rodgen.BranchInterrupted(xarray.Dataset({"a": ("point", [1.0])})),
    "BuildError": lambda: rodgen.BuildError("no compiler"),
    "Critical": lambda: rodgen.critical_force(SCENE),
    "Cycle": lambda: rodgen.Cycle(
        *(
            SCENE,
            0.0,
            1.5,
            np.ones(2),
            np.ones(2) + 0j,
            1,
            1e-10,
            0.0,
            0.5,
            0.1,
            False,
            1e-12,
            4,
            "collocation",
        )
    ),
    "Ensemble": _ensemble,
    "Equilibrium": lambda: rodgen.static_equilibrium(SCENE),
    "Event": lambda: _solution().events[0],
    "Exponents": _exponents,
    "Extrapolation": lambda: rodgen.richardson([5, 10, 20], [1.04, 1.01, 1.0025]),
    "FileWarning": lambda: rodgen.FileWarning("damaged"),
    "Floquet": lambda: rodgen.Floquet(np.ones(2) + 0j, 3.0, np.ones(2), 1e-10, 0.0, (0, 1)),
    "Interrupted": lambda: rodgen.Interrupted(_solution()),
    "MeshWarning": lambda: rodgen.MeshWarning("damping was not converted"),
    "Modes": lambda: rodgen.natural_modes(SCENE),
    "RunError": lambda: rodgen.RunError("stopped at t = 1 s", _solution()),
    "Scene": lambda: SCENE,
    "SceneError": lambda: _error(lambda: Scene.from_dict(TABLE | {"name": 3})),
    "SimulatedCritical": _critical,
    "Solution": _solution,
    "Spectrum": lambda: peaks_of(np.arange(64.0), np.sin(np.arange(64.0))),
    "StepWarning": lambda: rodgen.StepWarning("the step is too long"),
    "Structure": lambda: SCENE.structure,
    "Study": lambda: rodgen.Study.of(SCENE, {"rod.mass": [1.0, 2.0]}, keep="max(phi_2)"),
    "StudyError": lambda: rodgen.StudyError("the scheduler does not answer any more"),
    "WorkPrecision": lambda: rodgen.WorkPrecision(
        SCENE,
        [{"method": "rk4", "error_phi": 1e-3}],
        {"order": 8},
        {"error_phi": 1e-9},
        {"rk4": 0.1},
    ),
}
WAYS: dict[str, Callable[[Any], Any]] = {
    **{
        f"protocol {n}": lambda it, n=n: pickle.loads(pickle.dumps(it, n))  # type: ignore[misc]
        for n in range(2, pickle.HIGHEST_PROTOCOL + 1)
    },
    "cloudpickle": lambda it: pickle.loads(cloudpickle.dumps(it)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


CLASSES = [name for name in rodgen.__all__ if inspect.isclass(getattr(rodgen, name))]
FUNCTIONS = [name for name in rodgen.__all__ if name not in CLASSES]


def _same(one: Any, other: Any) -> bool:
    """Whether two values are equal in all that they have."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return bool(np.array_equal(one, other, equal_nan=one.dtype.kind == "f"))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(one[k], other[k]) for k in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, ModuleType):
        # Operations are those of the parts that anybody has asked for so far.
        made = [{**module.PROVENANCE, "operations": None} for module in (one, other)]
        return one is other or made[0] == made[1]
    if isinstance(one, BaseException):
        return (
            str(one) == str(other) and _same(one.args, other.args) and _same(vars(one), vars(other))
        )
    if is_dataclass(one):
        names = [field.name for field in fields(one)]
        return all(_same(getattr(one, name), getattr(other, name)) for name in names)
    return bool(one == other) or bool(one != one and other != other)


@pytest.mark.parametrize("name", CLASSES)
def test_every_public_object_survives(name: str) -> None:
    value = EXAMPLES[name]()
    assert type(value) is getattr(rodgen, name)
    for way, through in WAYS.items():
        assert _same(value, through(value)), way


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_public_function_survives(name: str) -> None:
    function = getattr(rodgen, name)
    for way, through in WAYS.items():
        assert through(function) is function, way


def test_a_module_is_built_again_where_it_arrives() -> None:
    timed = copy.deepcopy(TABLE)
    timed["loads"]["follower"]["force"] = "4*cos(t)"
    model = rodgen.build(Scene.from_dict(timed))
    for way, through in WAYS.items():
        back = through(model)
        assert (back.PROVENANCE, back.EXPRESSIONS) == (model.PROVENANCE, model.EXPRESSIONS), way
        assert "def rhs" not in str(pickle.dumps(model))


def test_what_follows_from_a_solution_is_made_again() -> None:
    sol = _solution()
    back = pickle.loads(pickle.dumps(sol))
    np.testing.assert_array_equal(back.joints, sol.joints)
    np.testing.assert_array_equal(back(0.25), sol(0.25))
    assert back.energy_error == sol.energy_error
    assert "joints" not in vars(copy.copy(sol))  # what can be made again is not carried


def test_errors_with_values_that_cannot_be_pickled_keep_their_words() -> None:
    error = rodgen.SceneError("rod.mass", lambda: None, "a number")
    for through in WAYS.values():
        assert str(through(error)) == str(error)


def test_errors_inside_survive_too() -> None:
    from rodgen.derive.proofs import DisagreementError

    for error in (LiveError("stopped", 1.0, None), DisagreementError("any n", "M[0]", 1, 2)):  # type: ignore[arg-type]
        for through in WAYS.values():
            assert _same(error, through(error))


BAD = TABLE | {"name": 3}


def test_one_bad_scene_spares_its_pool() -> None:
    """Every other job is done, and the error of the bad one is what it would be here."""
    rodgen.build(SCENE)  # once for all processes
    # Children that are forked inherit the locks of whatever thread runs here: these do not.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        before = pool.submit(rodgen.simulate, SCENE, target="numpy")
        bad = pool.submit(Scene.from_dict, BAD)
        after = pool.submit(Scene.from_dict, TABLE)
        with pytest.raises(rodgen.SceneError, match="name = 3: must be text") as found:
            bad.result(60)
        assert (found.value.field, found.value.value) == ("name", 3)
        assert after.result(60) == SCENE
        np.testing.assert_array_equal(before.result(60).y, _solution().y)


@pytest.mark.nightly
def test_one_bad_scene_spares_the_other_pool() -> None:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        bad, good = (pool.apply_async(Scene.from_dict, (table,)) for table in (BAD, TABLE))
        with pytest.raises(rodgen.SceneError, match="name = 3"):
            bad.get(60)
        assert good.get(60) == SCENE
