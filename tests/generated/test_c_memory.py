"""The C module writes into the arrays that it is given, or refuses them; runs likewise."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from functools import partial
from types import ModuleType

import numpy as np
import pytest

from rodgen.emit.native import METHODS
from rodgen.scene.structure import Structure

pytestmark = pytest.mark.compiler
Built = Callable[..., ModuleType]
Array = np.ndarray
TARGETS = pytest.mark.parametrize(
    "target", [("numpy", "chain"), ("numpy", "dense"), ("c", "chain")], ids="-".join
)
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


@pytest.mark.parametrize("change", OF_OUT)
def test_out_that_changes_after_a_call_is_refused(
    rod: ModuleType, y: Array, p: Array, change: str
) -> None:
    """By NumPy where the call before forbids it to move the memory, else by the next call."""
    out = np.empty(14)
    rod.rhs(0.0, y, p, out)

    def again() -> None:
        OF_OUT[change](out)
        rod.rhs(0.0, y, p, out)

    with pytest.raises(ValueError, match=r"cannot resize|out"):
        again()


@pytest.mark.parametrize("change", OF_P)
def test_p_that_changes_after_a_call_is_refused(
    rod: ModuleType, y: Array, p: Array, change: str
) -> None:
    rod.rhs(0.0, y, p)

    def again() -> None:
        OF_P[change](p)
        rod.rhs(0.0, y, p)

    with pytest.raises((TypeError, ValueError), match=r"cannot resize|p has"):
        again()


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


@pytest.mark.parametrize("which", ["y", "p", "out"])
def test_masked_arrays_are_refused(rod: ModuleType, y: Array, p: Array, which: str) -> None:
    given = {"y": y, "p": p, "out": np.empty(14)}
    given[which] = np.ma.masked_array(given[which], np.arange(14) == 3)
    with pytest.raises((TypeError, ValueError), match=f"{which} is .*[Mm]asked"):
        rod.rhs(0.0, **given)


# Runs ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("samples", "trace", "match"),
    [
        ((2, 17), None, r"samples is float64 \(2, 17\): must be .*\(3, 17\)"),
        ((3, 16), None, "samples is"),
        ((3,), None, "samples is"),
        ((3, 17), (9, 29), r"trace is float64 \(9, 29\): must be .*\(10, 29\)"),
        ((3, 17), (10, 28), "trace is"),
    ],
)
def test_samples_and_traces_that_are_too_small_are_refused(
    rod: ModuleType,
    y: Array,
    p: Array,
    samples: tuple[int, ...],
    trace: tuple[int, ...] | None,
    match: str,
) -> None:
    run = rod.Run("rk4", 0.0, y, p, step=1e-3)
    assert run.begin(1.0) == rod.PAUSED
    times = np.array([0.001, 0.002, 0.003])
    with pytest.raises(ValueError, match=match):
        run.on(10, times, np.zeros(samples), None if trace is None else np.zeros(trace))
    assert run.numbers.steps == 0
    status, taken = run.on(10, times, np.zeros((4, 17)), np.zeros((11, 29)))
    assert (status, taken) == (rod.FULL, 3)


@pytest.mark.parametrize("bad", ["floats", "read-only", "every second", "list", "times"])
def test_samples_that_cannot_be_written_are_refused(
    rod: ModuleType, y: Array, p: Array, bad: str
) -> None:
    run = rod.Run("rk4", 0.0, y, p, step=1e-3)
    run.begin(1.0)
    times, samples = np.zeros(3), np.zeros((3, 17))
    other: dict[str, object] = {
        "floats": samples.astype("f4"),
        "read-only": np.broadcast_to(samples, samples.shape),
        "every second": np.zeros((6, 17))[::2],
        "list": samples.tolist(),
    }
    with pytest.raises(ValueError, match="times has" if bad == "times" else "samples"):
        run.on(1, times[None] if bad == "times" else times, other.get(bad, samples))


IMPOSSIBLE: dict[str, dict[str, float]] = {
    "method above": {"method": len(METHODS)},
    "method below": {"method": -1},
    "end before t": {"end": -1.0},
    "end no number": {"end": np.nan},
    "t no number": {"t": np.nan},
    "no step": {"method": 2, "step": 0.0},
    "no equal steps": {"method": METHODS.index("gauss_equal_steps"), "step": 0.0},
    "step backwards": {"method": 0, "step": -1e-3},
    "step no number": {"method": 3, "step": np.nan},
    "step without end": {"method": 1, "step": np.inf},
    "rtol": {"rtol": -1e-6},
    "atol": {"atol": np.nan},
}


@pytest.mark.parametrize("what", IMPOSSIBLE)
def test_runs_that_cannot_be_are_refused(rod: ModuleType, y: Array, p: Array, what: str) -> None:
    """By begin and, where they become so on the way, by on: nothing has changed then."""
    nothing = np.empty(0), np.empty((0, 17))
    for begun in (False, True):
        run = rod.Run("gauss", 0.0, y, p)
        run.numbers.low, run.numbers.high, run.numbers.longest = -np.inf, np.inf, np.inf
        if begun:
            assert run.begin(1.0) == rod.PAUSED
        run.numbers.end = 1.0
        for name, value in IMPOSSIBLE[what].items():
            setattr(run.numbers, name, value)
        before = run.memory.copy()
        go = partial(run.on, 10, *nothing) if begun else partial(run.begin, run.numbers.end)
        with pytest.raises(ValueError, match=r"no run of .* from t = "):
            go()
        np.testing.assert_array_equal(run.memory, before)


def test_run_that_was_not_begun_is_refused(rod: ModuleType, y: Array, p: Array) -> None:
    run = rod.Run("dop853", 0.0, y, p)
    with pytest.raises(ValueError, match="must be begun"):
        run.on(10, np.empty(0), np.empty((0, 17)))
    with pytest.raises(ValueError, match="method is 'rk5'"):
        rod.Run("rk5", 0.0, y, p)


def test_methods_and_endings_are_those_of_the_header(rod: ModuleType, written: Built) -> None:
    header = written(Structure(5), "c")["rod_free_n5_c.h"]
    names = {
        **{name.upper(): at for at, name in enumerate(rod.COMPILED)},
        **{name: getattr(rod, name) for name in ("PAUSED", "FULL", "TOO_SMALL", "REFUSED")},
        **{f"P_{rod.PARAMETERS[at].upper()}": at for at in range(9)},
        **{f"Y_{name.upper()}": at for at, name in enumerate(rod.STATE) if "_" not in name},
        "Y_PHI_0": rod.STATE.index("phi_0"),
        "Y_OMEGA_0": rod.STATE.index("omega_0"),
    }
    for name, number in names.items():
        assert f" ROD_FREE_N5_C_{name} = {number}" in header
    assert "#define ROD_FREE_N5_C_N 5\n" in header


# Parameters ---------------------------------------------------------------------------------------

NO_NUMBERS: dict[str, object] = {
    "truth": True,
    "NumPy's truth": np.True_,
    "array of truth": np.array(True),
    "bytes": b"3",
    "bytearray": bytearray(b"3"),
    "NumPy's bytes": np.bytes_(b"3"),
    "text": "3",
    "NumPy's text": np.str_("3"),
    "complex": 3 + 0j,
    "NumPy's complex": np.complex128(3),
    "time": np.timedelta64(3),
    "masked": np.ma.masked,
    "masked array": np.ma.array(3.0),
    "array of one": np.array([3.0]),
    "list": [3.0],
    "nothing": None,
}


@TARGETS
@pytest.mark.parametrize("what", NO_NUMBERS)
def test_parameters_that_are_no_real_numbers_are_refused(
    built: Built, target: tuple[str, str], what: str
) -> None:
    rod = built(Structure(5), *target)
    value = NO_NUMBERS[what]
    with pytest.raises(ValueError, match=r"(?s)length = .*must be a finite number"):
        rod.parameters(**{**VALUES, **DAMPING, "length": value})
    if value is not None:
        fins = [1.0, 1.0, value, 1.0, 1.0, 1.0]
        with pytest.raises(ValueError, match=r"fin_factor\[2\] = "):
            rod.parameters(**VALUES, **DAMPING, fin_factor=fins)


def test_numbers_of_other_make_are_parameters(rod: ModuleType, p: Array) -> None:
    for three in (3, np.int8(3), np.float32(3), np.array(3), Decimal(3), Fraction(3), np.uint64(3)):
        np.testing.assert_array_equal(rod.parameters(**{**VALUES, **DAMPING, "mass": three}), p)
    for wrong in (bytes(6), bytearray(6), memoryview(bytes(6)), np.ma.masked_equal([1] * 6, 1)):
        with pytest.raises(ValueError, match="fin_factor"):
            rod.parameters(**VALUES, **DAMPING, fin_factor=wrong)


@TARGETS
@pytest.mark.parametrize("value", [0.0, -0.0, 5e-324, 1e-200, 1e200, np.nan])
@pytest.mark.parametrize("name", ["mass", "length"])
def test_what_cannot_be_divided_by_gives_no_numbers(
    built: Built, y: Array, p: Array, target: tuple[str, str], name: str, value: float
) -> None:
    """Not an exception, nor numbers of another size from target to target."""
    rod = built(Structure(5), *target)
    p[rod.PARAMETERS.index(name)] = value
    rates = rod.rhs(0.0, y, p)
    np.testing.assert_array_equal(rates[:7], y[7:])
    assert np.isnan(rates[7:]).all()
    assert np.isnan(rod.jac(0.0, y, p)[9:, 2:7]).all()
    if target[0] == "c":
        many = rod.rhs_batch(0.0, np.tile(y, (9, 1)), p)
        assert np.isnan(many[:, 7:]).all()
        assert rod.Run("radau", 0.0, y, p).begin(1.0) == rod.NOT_FINITE
