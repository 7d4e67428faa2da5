"""The C module writes into the arrays that it is given, or refuses them; runs likewise."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial
from itertools import product
from types import ModuleType

import numpy as np
import pytest

from rodgen.model.methods import COMPILED
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built, Whole

pytestmark = pytest.mark.compiler
Array = np.ndarray
VALUES = {"mass": 3.0, "length": 2.0, "bending_stiffness": 30.0, "follower_force": 20.0}
DAMPING = {"internal_damping": 0.1, "external_damping": 0.5}


@pytest.fixture(scope="module")
def rod(built: Built) -> ModuleType:
    return built(Structure(5), "c")


@pytest.fixture
def p(rod: ModuleType) -> Array:
    values: Array = rod.parameters(**VALUES, **DAMPING)
    return values


@pytest.fixture
def y(rod: ModuleType) -> Array:
    return np.linspace(0.1, 0.4, len(rod.STATE))


# What is written into ----------------------------------------------------------------------------


def test_result_goes_into_out(rod: ModuleType, y: Array, p: Array) -> None:
    """Also where it overlaps the state, by so many numbers."""
    expected = rod.rhs(0.0, y, p)
    for shift in (None, 0, 1, 7, -3):
        memory = np.full(34, np.nan)
        memory[10:24] = y
        out = np.full(14, np.nan) if shift is None else memory[10 + shift : 24 + shift]
        assert rod.rhs(0.0, memory[10:24], p, out) is out
        np.testing.assert_array_equal(out, expected, err_msg=f"shift {shift}")


BAD_OUT: dict[str, object] = {
    "short": np.zeros(13),
    "long": np.zeros(15),
    "two axes": np.zeros((1, 14)),
    "integers": np.zeros(14, dtype=int),
    "floats": np.zeros(14, dtype=np.float32),
    "big-endian": np.zeros(14, dtype=">f8"),
    "every second": np.zeros(28)[::2],
    "backwards": np.zeros(14)[::-1],
    "read-only": np.frombuffer(bytes(8 * 14)),
    "list": [0.0] * 14,
    "masked": np.ma.masked_array(np.zeros(14), np.arange(14) == 3),
}


def test_out_that_cannot_be_written_is_refused(rod: ModuleType, y: Array, p: Array) -> None:
    for name, out in BAD_OUT.items():
        with pytest.raises((TypeError, ValueError), match=r"^out\b"):
            rod.rhs(0.0, y, p, out)
        assert not np.any(np.asarray(out)), name


# What is changed in place -------------------------------------------------------------------------


def _reshaped(array: Array) -> None:
    with warnings.catch_warnings():  # newer NumPy would rather have it done otherwise
        warnings.simplefilter("ignore")
        array.shape = (2, -1)


def _retyped(array: Array, dtype: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        array.dtype = np.dtype(dtype)


OF_OUT: dict[str, Callable[[Array], None]] = {
    "shorter": lambda a: a.resize(2, refcheck=False),
    "longer": lambda a: a.resize(10**6, refcheck=False),
    "shorter and back": lambda a: (a.resize(2, refcheck=False), a.resize(14, refcheck=False)),
    "read-only": lambda a: a.setflags(write=False),
    "reshaped": _reshaped,
    "integers": lambda a: _retyped(a, "i8"),
    "floats": lambda a: _retyped(a, "f4"),
    "big-endian": lambda a: _retyped(a, ">f8"),
}
OF_P = {name: change for name, change in OF_OUT.items() if name not in ("read-only", "big-endian")}
OF_P["integers"] = lambda a: _retyped(a, "c16")


def test_arrays_that_change_after_a_call_are_refused(rod: ModuleType, y: Array, p: Array) -> None:
    """By NumPy, where the call before forbids it to move the memory, or else by the next call."""
    changes = [("out", one) for one in OF_OUT.values()] + [("p", one) for one in OF_P.values()]
    for name, change in changes:
        given = {"p": p.copy(), "out": np.empty(14)}
        rod.rhs(0.0, y, **given)
        try:
            change(given[name])
        except ValueError:
            continue
        with pytest.raises((TypeError, ValueError), match=rf"^{name}\b"):
            rod.rhs(0.0, y, **given)


def test_doubles_of_another_order_after_a_call_are_read_as_such(
    rod: ModuleType, y: Array, p: Array
) -> None:
    expected = rod.rhs(0.0, y, p)
    rod.rhs(0.0, y, p)
    p.byteswap(inplace=True)
    _retyped(p, ">f8")
    np.testing.assert_array_equal(rod.rhs(0.0, y, p), expected)


def test_values_of_p_may_change_in_place(rod: ModuleType, y: Array, p: Array) -> None:
    out = rod.rhs(0.0, y, p, np.empty(14))
    p[3] *= 2
    np.testing.assert_array_equal(rod.rhs(0.0, y, p), rod.rhs(0.0, y, p.copy()))
    assert np.any(rod.rhs(0.0, y, p) != out)


def test_arrays_of_before_are_free_again_after_others(rod: ModuleType, y: Array, p: Array) -> None:
    out = rod.rhs(0.0, y, p, np.empty(14))
    rod.rhs(0.0, y, p.copy(), np.empty(14))
    out.resize(2, refcheck=False)
    p.resize(2, refcheck=False)


def test_masked_arrays_are_refused(rod: ModuleType, y: Array, p: Array) -> None:
    for which, right in (("y", y), ("p", p)):
        given = {"y": y, "p": p, which: np.ma.masked_array(right, np.arange(14) == 3)}
        with pytest.raises((TypeError, ValueError), match=rf"^{which}\b"):
            rod.rhs(0.0, **given)


# Runs ---------------------------------------------------------------------------------------------


# Shapes of samples and of a trace, and which of them is too small for three and ten.
SMALL_ROOM: list[tuple[tuple[int, ...], tuple[int, ...] | None, str]] = [
    ((2, 17), None, "samples"),
    ((3, 16), None, "samples"),
    ((3,), None, "samples"),
    ((3, 17), (9, 29), "trace"),
    ((3, 17), (10, 28), "trace"),
]


def test_samples_and_traces_that_are_too_small_are_refused(
    rod: ModuleType, y: Array, p: Array
) -> None:
    run = rod.Run("rk4", 0.0, y, p, step=1e-3)
    assert run.begin(1.0) == rod.PAUSED
    times = np.array([0.001, 0.002, 0.003])
    for samples, trace, name in SMALL_ROOM:
        with pytest.raises(ValueError, match=rf"^{name}\b"):
            run.advance(10, times, np.zeros(samples), None if trace is None else np.zeros(trace))
        assert run.numbers.steps == 0
    status, taken = run.advance(10, times, np.zeros((4, 17)), np.zeros((11, 29)))
    assert (status, taken) == (rod.FULL, 3)


def test_samples_that_cannot_be_written_are_refused(rod: ModuleType, y: Array, p: Array) -> None:
    run = rod.Run("rk4", 0.0, y, p, step=1e-3)
    run.begin(1.0)
    times, samples = np.zeros(3), np.zeros((3, 17))
    others: list[object] = [samples.astype("f4"), np.broadcast_to(samples, samples.shape)]
    for other in (*others, np.zeros((6, 17))[::2], samples.tolist()):
        with pytest.raises(ValueError, match=r"^samples\b"):
            run.advance(1, times, other)
    with pytest.raises(ValueError, match=r"^times\b"):
        run.advance(1, times[None], samples)


# Changes of a run that could be: of its method, times, step and tolerances.
IMPOSSIBLE: list[dict[str, float]] = [
    {"method": len(COMPILED)},
    {"method": -1},
    {"end": -1.0},
    {"end": np.nan},
    {"t": np.nan},
    {"method": 2, "step": 0.0},
    {"method": COMPILED.index("gauss_equal_steps"), "step": 0.0},
    {"method": 0, "step": -1e-3},
    {"method": 3, "step": np.nan},
    {"method": 1, "step": np.inf},
    {"rtol": -1e-6},
    {"atol": np.nan},
]


def test_runs_that_cannot_be_are_refused(rod: ModuleType, y: Array, p: Array) -> None:
    """By begin and, where they become so on the way, by on: nothing has changed then."""
    nothing = np.empty(0), np.empty((0, 17))
    for change, begun in product(IMPOSSIBLE, (False, True)):
        run = rod.Run("gauss", 0.0, y, p)
        run.numbers.low, run.numbers.high, run.numbers.longest = -np.inf, np.inf, np.inf
        if begun:
            assert run.begin(1.0) == rod.PAUSED
        run.numbers.end = 1.0
        for name, value in change.items():
            setattr(run.numbers, name, value)
        before = run.memory.copy()
        go = partial(run.advance, 10, *nothing) if begun else partial(run.begin, run.numbers.end)
        (*_, (name, value)) = ({"end": 1.0} | change).items()
        said = "end = " if name == "method" else rf"\b{name} = {value}"
        with pytest.raises(ValueError, match=said):
            go()
        np.testing.assert_array_equal(run.memory, before)


def test_run_that_was_not_begun_is_refused(rod: ModuleType, y: Array, p: Array) -> None:
    run = rod.Run("dop853", 0.0, y, p)
    with pytest.raises(ValueError, match="end = "):
        run.advance(10, np.empty(0), np.empty((0, 17)))
    with pytest.raises(ValueError, match=r"^method .*'rk5'"):
        rod.Run("rk5", 0.0, y, p)


def test_methods_and_endings_are_those_of_the_header(rod: ModuleType, whole: Whole) -> None:
    header = whole(Structure(5))["rod_free_n5_c.h"]
    names = {
        **{f"P_{rod.PARAMETERS[at].upper()}": at for at in range(9)},
        **{f"Y_{name.upper()}": at for at, name in enumerate(rod.STATE) if "_" not in name},
        "Y_PHI_0": rod.STATE.index("phi_0"),
        "Y_OMEGA_0": rod.STATE.index("omega_0"),
    }
    for name in (*map(str.upper, rod.COMPILED), "PAUSED", "FULL", "TOO_SMALL", "REFUSED"):
        assert f" ROD_FREE_N5_C_{name} = RODGEN_{name}" in header
    assert rod.COMPILED == COMPILED
    assert (rod.PAUSED, rod.FULL, rod.TOO_SMALL, rod.REFUSED) == (0, 2, -2, -4)
    for name, number in names.items():
        assert f" ROD_FREE_N5_C_{name} = {number}" in header
    assert "#define ROD_FREE_N5_C_N 5\n" in header
