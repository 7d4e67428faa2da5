"""Everything public goes through pickle, cloudpickle and copy, and through pools of processes."""

from __future__ import annotations

import copy
import inspect
import multiprocessing
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, is_dataclass
from functools import partial
from types import ModuleType
from typing import Any

import cloudpickle
import numpy as np
import pytest
import xarray

import rodgen
from rodgen.scene import Scene
from tests.view.results import MAKERS, SCENE, TABLE, made

BAD = TABLE | {"name": 3}


def _refusal() -> BaseException:
    with pytest.raises(rodgen.InputError) as found:
        Scene.from_dict(BAD)
    return found.value


# How to come by one of every class that is public. What is missing here fails the test below.
EXAMPLES: dict[str, Callable[[], Any]] = {
    **{name: partial(made, name) for name in MAKERS},
    "AnalysisError": lambda: rodgen.AnalysisError("none found"),
    "BranchInterrupted": lambda: rodgen.BranchInterrupted(xarray.Dataset({"a": ("point", [1.0])})),
    "BuildError": lambda: rodgen.BuildError("no compiler"),
    "Event": lambda: made("Solution").events[0],
    "System": lambda: rodgen.System(rodgen.Scene.example("ziegler")).at(t=0.0),
    "FileWarning": lambda: rodgen.FileWarning("damaged"),
    "Interrupted": lambda: rodgen.Interrupted(made("Solution")),
    "RunError": lambda: rodgen.RunError("stopped at t = 1 s", made("Solution")),
    "InputError": _refusal,
    "DoubtWarning": lambda: rodgen.DoubtWarning("the step is too long", {"longest": 0.1}),
    "Note": lambda: rodgen.Note("doubt", "the step is too long", {"longest": 0.1}),
    "Result": lambda: rodgen.Result(),
    "Structure": lambda: SCENE.structure,
    "StudyError": lambda: rodgen.StudyError("the scheduler does not answer any more"),
}
WAYS: dict[str, Callable[[Any], Any]] = {
    **{
        f"protocol {n}": lambda it, n=n: pickle.loads(pickle.dumps(it, n))
        for n in (2, pickle.HIGHEST_PROTOCOL)
    },
    "cloudpickle": lambda it: pickle.loads(cloudpickle.dumps(it)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


CLASSES = [name for name in rodgen.__all__ if inspect.isclass(getattr(rodgen, name))]
FUNCTIONS = [name for name in rodgen.__all__ if inspect.isfunction(getattr(rodgen, name))]


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
        return _same([str(one), one.args, vars(one)], [str(other), other.args, vars(other)])
    if type(one) is rodgen.Result:
        return vars(one) == vars(other)
    if is_dataclass(one):
        names = [field.name for field in fields(one)]
        return all(_same(getattr(one, name), getattr(other, name)) for name in names)
    return bool(one == other) or bool(one != one and other != other)


def test_every_public_object_survives() -> None:
    for name in CLASSES:
        value = EXAMPLES[name]()
        assert type(value) is getattr(rodgen, name)
        for way, through in WAYS.items():
            assert _same(value, through(value)), (name, way)


def test_every_public_function_survives() -> None:
    for name in FUNCTIONS:
        for way, through in WAYS.items():
            assert through(getattr(rodgen, name)) is getattr(rodgen, name), (name, way)


def test_a_module_is_built_again_where_it_arrives() -> None:
    timed = copy.deepcopy(TABLE)
    timed["rod"]["links"], timed["loads"]["follower"]["force"] = 1, "4*cos(t)"
    del timed["events"]
    model = rodgen.build(Scene.from_dict(timed))
    for way, through in WAYS.items():
        back = through(model)
        assert (back.PROVENANCE, back.EXPRESSIONS) == (model.PROVENANCE, model.EXPRESSIONS), way
    assert b"def rhs" not in pickle.dumps(model)


def test_what_follows_from_a_solution_is_made_again() -> None:
    sol = made("Solution")
    back = pickle.loads(pickle.dumps(sol))
    np.testing.assert_array_equal(back.joints, sol.joints)
    np.testing.assert_array_equal(back(0.25), sol(0.25))
    assert back.energy_error == sol.energy_error
    assert "joints" not in vars(copy.copy(sol))  # what can be made again is not carried


def test_errors_of_all_kinds_keep_their_words() -> None:
    """Also with a value that cannot be pickled, and of parts that are not public."""
    from rodgen.derive.proofs import DisagreementError

    unportable = rodgen.InputError("rod.mass", lambda: None, "a number")
    inner = DisagreementError("any n", "M[0]", 1, 2)
    for through in WAYS.values():
        assert str(through(unportable)) == str(unportable)
        assert _same(inner, through(inner))


@pytest.mark.slow
def test_one_bad_scene_spares_its_pool() -> None:
    """Every other job is done, and the error of the bad one is what it would be here."""
    rodgen.build(SCENE)  # once for all processes
    # Children that are forked inherit the locks of whatever thread runs here: these do not.
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        before = pool.submit(rodgen.simulate, SCENE, target="numpy")
        bad = pool.submit(Scene.from_dict, BAD)
        after = pool.submit(Scene.from_dict, TABLE)
        with pytest.raises(rodgen.InputError, match=r"^name = 3") as found:
            bad.result(600)
        assert (found.value.field, found.value.value) == ("name", 3)
        assert after.result(600) == SCENE
        np.testing.assert_array_equal(before.result(600).y, made("Solution").y)


@pytest.mark.nightly
def test_one_bad_scene_spares_the_other_pool() -> None:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        bad, good = (pool.apply_async(Scene.from_dict, (table,)) for table in (BAD, TABLE))
        with pytest.raises(rodgen.InputError, match=r"^name = 3"):
            bad.get(600)
        assert good.get(600) == SCENE
