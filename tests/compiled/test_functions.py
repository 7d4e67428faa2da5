"""C functions of a module for what calls them without Python: addresses, ctypes, SciPy."""

from __future__ import annotations

import ctypes
import gc
import pickle
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.scene import Structure

STRUCTURE = Structure(2, "pinned", terms=("gravity",))
Y = np.array([0.1, 0.2, 0.3, 0.4])


@pytest.fixture(scope="module")
def rod() -> Any:
    return rodgen.build(STRUCTURE, "c")


@pytest.fixture(scope="module")
def p(rod: Any) -> Any:
    return rod.parameters(mass=1.0, length=2.0, bending_stiffness=3.0)


def _at(*arrays: Any) -> list[Any]:
    """Where they are, for ctypes."""
    return [one.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for one in arrays]


def test_a_pointer_of_ctypes_calls_the_function(rod: Any, p: Any) -> None:
    out = np.empty(4)
    rod.rhs.compiled.ctypes_pointer()(0.0, *_at(Y, p, out))
    assert np.array_equal(out, rod.rhs(0.0, Y, p))
    out, many = np.empty((3, 4)), np.stack([Y, 2 * Y, 3 * Y])
    states, parameters, rates = _at(many, p, out)
    rod.rhs_batch.compiled.ctypes_pointer()(3, 0.0, states, parameters, 0, rates)
    assert np.array_equal(out, rod.rhs_batch(0.0, many, p))


def test_a_callable_of_scipy(rod: Any) -> None:
    made = rod.jac.compiled.low_level_callable()
    assert made.signature == "void (double, double *, double *, double *)"
    address = ctypes.cast(made.function, ctypes.c_void_p).value
    assert address == rod.jac.compiled.address


def test_functions_say_what_they_are(rod: Any) -> None:
    for name in ("rhs", "rhs_batch", "jac", "tangents"):
        function = getattr(rod, name).compiled
        assert f"rod_pinned_n2_gravity_c_{name})(" in repr(function)
        assert hex(function.address) in repr(function)
    assert not hasattr(rodgen.build(STRUCTURE).rhs, "compiled")
    assert pickle.loads(pickle.dumps(rod)) is rod


def test_a_pointer_keeps_its_library(p: Any) -> None:
    from rodgen.loading import sources
    from rodgen.loading.generated_module import load_files

    made = load_files(sources(STRUCTURE, "c", parts=("rhs",)), whole=False)
    due, pointer = made.rhs(0.0, Y, p), made.rhs.compiled.ctypes_pointer()
    del made
    gc.collect()
    out = np.empty(4)
    pointer(0.0, *_at(Y, p, out))
    assert np.array_equal(out, due)
