"""The contract of a generated module: alone in the world, checked parameters, shapes."""

from __future__ import annotations

import math
import shutil
import sys
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rodgen.loading import load_module
from rodgen.loading.build import companions
from rodgen.loading.cache import write_whole
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built, ran
from tests.reference import GENERATED, MODULES

Made = tuple[ModuleType, np.ndarray]
VALUES = {"mass": 3.0, "length": 2.0, "bending_stiffness": 30.0}
LOADS = {"follower_force": 20.0, "internal_damping": 0.1, "external_damping": 0.5}

ALONE = """
import sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("rodgen", "sympy", "mpmath", "jinja2"):
            raise ImportError("refused: " + name)

sys.meta_path.insert(0, Refuse())
for name in ("rodgen", "sympy"):
    try:
        __import__(name)
    except ImportError:
        continue
    sys.exit(name + " can still be imported")
sys.path.insert(0, {folder!r})
import numpy as np
for stem, values in {given!r}.items():
    rod = __import__(stem)
    p = rod.parameters(**values)
    y = np.linspace(0.1, 0.4, len(rod.STATE))
    assert np.isfinite(rod.rhs(0.0, y, p)).all()
    assert np.isfinite(rod.jac(0.0, y, p)).all()
    assert all(np.isfinite(e) for e in rod.energy(y, p))
print(sorted(m for m in sys.modules if m.split(".")[0] in ("rodgen", "sympy")))
"""


def _values(module: ModuleType) -> dict[str, float]:
    return VALUES | {k: v for k, v in LOADS.items() if k in module.PARAMETERS}


@pytest.fixture(scope="module", params=MODULES)
def kept(request: pytest.FixtureRequest) -> ModuleType:
    """A reference module."""
    return load_module(GENERATED / f"{request.param}.py")


@pytest.fixture(
    scope="module", params=[("numpy", "chain"), ("numpy", "dense"), ("c", "chain")], ids="-".join
)
def made(built: Built, request: pytest.FixtureRequest) -> Made:
    """A module of a target and form, and its parameters."""
    rod = built(Structure(5), *request.param)
    return rod, rod.parameters(**VALUES, **LOADS)


def test_modules_run_without_rodgen_and_sympy(tmp_path: Path) -> None:
    modules = {stem: load_module(GENERATED / f"{stem}.py") for stem in MODULES}
    for stem, module in modules.items():
        for file in GENERATED.glob(f"{stem}.*"):
            shutil.copy(file, tmp_path)
        for name, text in companions(module.PROVENANCE["target"]).items():
            write_whole(tmp_path / name, text)
    given = {stem: _values(module) for stem, module in modules.items()}
    program = ALONE.format(folder=str(tmp_path), given=given)
    done = ran(sys.executable, "-B", "-c", program)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"


def test_names_and_shapes(kept: ModuleType) -> None:
    rod, stem = kept, kept.__name__
    p = rod.parameters(**_values(rod))
    states = len(rod.STATE)
    assert (rod.N, rod.INERTIA == "lumped") == (5, stem.endswith("lumped"))
    assert rod.BOUNDARY in stem
    assert rod.PROVENANCE["target"] == ("c" if stem.endswith("_c") else "numpy")
    assert rod.PROVENANCE["form"] == ("dense" if stem.endswith("_dense") else "chain")
    assert len(p) == len(rod.PARAMETERS)
    y = np.random.default_rng(2).normal(size=states)
    assert rod.rhs(0.0, y, p).shape == (states,)
    np.testing.assert_array_equal(rod.rhs(0.0, y, p)[: states // 2], y[states // 2 :])
    mass = rod.mass_matrix(y, p)
    np.testing.assert_array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0
    assert rod.jac(0.0, y, p).shape == (states, states)
    solution = solve_ivp(rod.rhs, (0.0, 0.1), y, "Radau", args=(p,), jac=rod.jac)
    assert solution.success


def test_many_states_at_once(kept: ModuleType) -> None:
    p = kept.parameters(**_values(kept))
    y = np.random.default_rng(3).normal(size=(4, 3, len(kept.STATE)))
    whole = (kept.energy, kept.joints, kept.centre_of_gravity, kept.inertia, kept.bending_moments)
    for function in whole:
        together = np.asarray(function(y, p))
        one = np.asarray(function(y[2, 1], p))
        if function in (kept.energy, kept.inertia):
            together = np.moveaxis(together, 0, -1)
        np.testing.assert_allclose(together[2, 1], one, rtol=1e-12, atol=1e-14)
    for function in (kept.forces, *([kept.power] if hasattr(kept, "power") else [])):
        together = function(0.0, y, p)
        one = function(0.0, y[2, 1], p)
        for term in one:
            np.testing.assert_allclose(together[term][2, 1], one[term], rtol=1e-12)


def test_rod_at_rest_has_no_drag(made: Made) -> None:
    """0/0 in the direction of a velocity of zero is no force, and no warning."""
    rod, _ = made
    p = rod.parameters(**VALUES, follower_force=0.0, internal_damping=0.0, external_damping=9.0)
    y = np.zeros(14)
    rates = rod.rhs(0.0, y, p)
    expected = np.zeros(14)
    expected[8] = -9.81  # free fall: vy0
    np.testing.assert_allclose(rates, expected, atol=1e-12)
    assert rod.power(0.0, y, p)["external_damping"] == 0


# A parameter, what it is given (None: it is left out), and the exception.
REFUSED: list[tuple[str, object, type[Exception]]] = [
    ("mass", None, TypeError),
    ("colour", 1.0, TypeError),
    ("mass", -1.0, ValueError),
    ("mass", 0.0, ValueError),
    ("length", math.nan, ValueError),
    ("length", math.inf, ValueError),
    ("bending_stiffness", -2.0, ValueError),
    ("external_damping", -0.1, ValueError),
    ("gravity", math.nan, ValueError),
    ("mass", 10**400, ValueError),
    ("fin_factor", [1.0, 2.0], ValueError),
    ("fin_factor", 3.0, ValueError),
    ("fin_factor", [1.0, 2.0, -3.0, 1.0, 1.0, 1.0], ValueError),
]


def test_parameters_are_refused_by_name() -> None:
    rod = load_module(GENERATED / "rod_free_n5.py")
    p = dict(zip(rod.PARAMETERS, rod.parameters(**VALUES, **LOADS), strict=True))
    defaults = {
        "gravity": 9.81,
        "follower_angle": 0.0,
        **{f"fin_factor_{k}": 1.0 for k in range(6)},
    }
    assert p == {**VALUES, **LOADS, **defaults}
    for name, value, error in REFUSED:
        values: dict[str, object] = {**VALUES, **LOADS, name: value}
        if value is None:
            del values[name]
        with pytest.raises(error, match=rf"\b{name}\b"):
            rod.parameters(**values)


# States and parameters, by target -----------------------------------------------------------------

NO_STATES: list[tuple[np.ndarray, type[Exception]]] = [
    (np.zeros(13), ValueError),
    (np.zeros(15), ValueError),
    (np.zeros((2, 13)), ValueError),
    (np.zeros((13, 2)), ValueError),
    (np.array(1.0), ValueError),
    (np.zeros(14, dtype=complex), TypeError),
    (np.zeros(14, dtype=bool), TypeError),
    (np.array(["a"] * 14), TypeError),
    (np.array([None] * 14), TypeError),
]


@pytest.mark.parametrize("function", ["rhs", "jac"])
def test_states_that_are_none_are_refused(made: Made, function: str) -> None:
    """One state alone has a Jacobian."""
    rod, p = made
    several = [(np.zeros(shape), ValueError) for shape in ((2, 14), (1, 14), (14, 2))]
    for y, error in (*NO_STATES, *(several if function == "jac" else [])):
        with pytest.raises(error, match=r"^y\b"):
            getattr(rod, function)(0.0, y, p)


def test_parameters_of_another_module_are_refused(made: Made) -> None:
    rod, p = made
    wrong = [(p[:3], ValueError), (np.append(p, 1.0), ValueError)]
    wrong += [(p.astype(complex), TypeError), (p.astype(str), TypeError)]
    for values, error in wrong:
        for function, given in (("rhs", (0.0,)), ("jac", (0.0,)), ("energy", ())):
            with pytest.raises(error, match=r"^p\b"):
                getattr(rod, function)(*given, np.zeros(14), values)


OTHER_MAKES: dict[str, Callable[[np.ndarray], object]] = {
    "list": lambda x: [float(v) for v in x],
    "tuple": tuple,
    "integers": lambda x: x.astype(int),
    "floats": lambda x: x.astype(np.float32),
    "long doubles": lambda x: x.astype(np.longdouble),
    "big-endian": lambda x: x.astype(">f8"),
    "every second": lambda x: np.repeat(x, 2)[::2],
    "backwards": lambda x: x[::-1].copy()[::-1],
    "column": lambda x: np.tile(x, (2, 1)).T.copy()[:, 1],
    "read-only": lambda x: np.frombuffer(x.tobytes()),
    "not aligned": lambda x: np.frombuffer(b"x" + x.tobytes(), np.uint8)[1:].view(float),
    "subclass": lambda x: x.view(type("Other", (np.ndarray,), {})),
}


@pytest.mark.parametrize("function", ["rhs", "jac"])
def test_states_and_parameters_of_other_make_give_the_same(made: Made, function: str) -> None:
    rod, p = made
    y, p = np.arange(14.0), np.ceil(p)
    call = getattr(rod, function)
    expected = call(0.0, y, p)
    # To rounding: long doubles may stay what they are for a part of the way.
    limit = 1e-12 * np.abs(expected).max()
    for name, other in OTHER_MAKES.items():
        for given in ((other(y), p), (y, other(p))):
            np.testing.assert_allclose(
                call(0.0, *given), expected, rtol=0, atol=limit, err_msg=name
            )
    assert y.tolist() == list(range(14))  # nothing writes into what it is given


NO_NUMBERS: list[object] = [
    *(True, np.True_, np.array(True)),
    *(b"3", bytearray(b"3"), np.bytes_(b"3"), "3", np.str_("3")),
    *(3 + 0j, np.complex128(3), np.timedelta64(3)),
    *(np.ma.masked, np.ma.array(3.0), np.array([3.0]), [3.0], None),
]
NO_LISTS = (bytes(6), bytearray(6), memoryview(bytes(6)), np.ma.masked_equal([1] * 6, 1))
OF_OTHER_MAKE = (3, np.int8(3), np.float32(3), np.array(3), Decimal(3), Fraction(3), np.uint64(3))


def test_parameters_are_real_numbers_of_any_make(made: Made) -> None:
    rod, p = made
    for three in OF_OTHER_MAKE:
        np.testing.assert_array_equal(rod.parameters(**{**VALUES, **LOADS, "mass": three}), p)
    for value in NO_NUMBERS:
        with pytest.raises(ValueError, match=r"^length = "):
            rod.parameters(**{**VALUES, **LOADS, "length": value})
        if value is not None:
            fins = [1.0, 1.0, value, 1.0, 1.0, 1.0]
            with pytest.raises(ValueError, match=r"^fin_factor\[2\] = "):
                rod.parameters(**VALUES, **LOADS, fin_factor=fins)
    for wrong in NO_LISTS:
        with pytest.raises(ValueError, match=r"^fin_factor"):
            rod.parameters(**VALUES, **LOADS, fin_factor=wrong)


def test_what_cannot_be_divided_by_gives_no_numbers(made: Made) -> None:
    """Not an exception, nor numbers of another size from target to target."""
    rod, right = made
    y = np.linspace(0.1, 0.4, len(rod.STATE))
    for name in ("mass", "length"):
        for value in (0.0, -0.0, 5e-324, 1e-200, 1e200, np.nan):
            p = right.copy()
            p[rod.PARAMETERS.index(name)] = value
            rates = rod.rhs(0.0, y, p)
            np.testing.assert_array_equal(rates[:7], y[7:])
            assert np.isnan(rates[7:]).all()
            assert np.isnan(rod.jac(0.0, y, p)[9:, 2:7]).all()
            if rod.PROVENANCE["target"] == "c":
                many = rod.rhs_batch(0.0, np.tile(y, (9, 1)), p)
                assert np.isnan(many[:, 7:]).all()
                assert rod.Run("radau", 0.0, y, p).begin(1.0) == rod.NOT_FINITE
