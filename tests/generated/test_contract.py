"""The contract of a generated module: alone in the world, checked parameters, shapes."""

from __future__ import annotations

import math
import shutil
import subprocess
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
from rodgen.model.parameter import JOINTS, LINKS
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS
from rodgen.scene.structure import Structure
from tests.palette import SMALL, cases, short

Built = Callable[..., ModuleType]
GENERATED = Path(__file__).parents[2] / "generated"
STEMS = (
    "rod_free_n5",
    "rod_free_n5_conservative",
    "rod_free_n5_dense",
    "rod_free_n5_c",
    "rod_cantilever_n5",
    "rod_clamped_n5_tip_load_lumped",
)
EVERY_TARGET = pytest.mark.parametrize(
    "target", [("numpy", "chain"), ("numpy", "dense"), ("c", "chain")], ids="-".join
)
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
import {stem} as rod
values = dict({values!r})
p = rod.parameters(**values)
y = np.linspace(0.1, 0.4, len(rod.STATE))
assert np.isfinite(rod.rhs(0.0, y, p)).all()
assert np.isfinite(rod.jac(0.0, y, p)).all()
assert all(np.isfinite(e) for e in rod.energy(y, p))
print(sorted(m for m in sys.modules if m.split(".")[0] in ("rodgen", "sympy")))
"""


def _values(module: ModuleType) -> dict[str, float]:
    return VALUES | {k: v for k, v in LOADS.items() if k in module.PARAMETERS}


@pytest.mark.parametrize("stem", STEMS)
def test_module_runs_without_rodgen_and_sympy(stem: str, tmp_path: Path) -> None:
    module = load_module(GENERATED / f"{stem}.py")
    values = _values(module)
    for file in GENERATED.glob(f"{stem}.*"):
        shutil.copy(file, tmp_path)
    for name, text in companions(module.PROVENANCE["target"]).items():
        write_whole(tmp_path / name, text)
    program = ALONE.format(folder=str(tmp_path), stem=stem, values=values)
    done = subprocess.run(
        [sys.executable, "-B", "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("stem", STEMS)
def test_names_and_shapes(stem: str) -> None:
    rod = load_module(GENERATED / f"{stem}.py")
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


@pytest.mark.parametrize("stem", STEMS)
def test_many_states_at_once(stem: str) -> None:
    rod = load_module(GENERATED / f"{stem}.py")
    p = rod.parameters(**_values(rod))
    y = np.random.default_rng(3).normal(size=(4, 3, len(rod.STATE)))
    whole = (rod.energy, rod.joints, rod.centre_of_gravity, rod.inertia, rod.bending_moments)
    for function in whole:
        together = np.asarray(function(y, p))
        one = np.asarray(function(y[2, 1], p))
        if function in (rod.energy, rod.inertia):
            together = np.moveaxis(together, 0, -1)
        np.testing.assert_allclose(together[2, 1], one, rtol=1e-12, atol=1e-14)
    for function in (rod.forces, *([rod.power] if hasattr(rod, "power") else [])):
        together = function(0.0, y, p)
        one = function(0.0, y[2, 1], p)
        for term in one:
            np.testing.assert_allclose(together[term][2, 1], one[term], rtol=1e-12)


@EVERY_TARGET
def test_rod_at_rest_has_no_drag(built: Built, target: tuple[str, str]) -> None:
    """0/0 in the direction of a velocity of zero is no force, and no warning."""
    rod = built(Structure(5), *target)
    p = rod.parameters(**VALUES, follower_force=0.0, internal_damping=0.0, external_damping=9.0)
    y = np.zeros(14)
    rates = rod.rhs(0.0, y, p)
    expected = np.zeros(14)
    expected[8] = -9.81  # free fall: vy0
    np.testing.assert_allclose(rates, expected, atol=1e-12)
    assert rod.power(0.0, y, p)["external_damping"] == 0


@pytest.mark.parametrize(
    ("change", "error", "name"),
    [
        ({"mass": None}, TypeError, "mass"),
        ({"colour": 1.0}, TypeError, "colour"),
        ({"mass": -1.0}, ValueError, "mass"),
        ({"mass": 0.0}, ValueError, "mass"),
        ({"length": math.nan}, ValueError, "length"),
        ({"length": math.inf}, ValueError, "length"),
        ({"bending_stiffness": -2.0}, ValueError, "bending_stiffness"),
        ({"external_damping": -0.1}, ValueError, "external_damping"),
        ({"gravity": math.nan}, ValueError, "gravity"),
        ({"mass": 10**400}, ValueError, "mass = inf"),
        ({"fin_factor": [1.0, 2.0]}, ValueError, "fin_factor has 2 values"),
        ({"fin_factor": 3.0}, ValueError, "fin_factor = 3.0"),
        ({"fin_factor": [1.0, 2.0, -3.0, 1.0, 1.0, 1.0]}, ValueError, r"fin_factor\[2\]"),
    ],
)
def test_parameters_are_refused_by_name(
    change: dict[str, object], error: type[Exception], name: str
) -> None:
    rod = load_module(GENERATED / "rod_free_n5.py")
    values: dict[str, object] = {**VALUES, **LOADS, **change}
    values = {k: v for k, v in values.items() if v is not None}
    with pytest.raises(error, match=name):
        rod.parameters(**values)


def test_defaults() -> None:
    rod = load_module(GENERATED / "rod_free_n5.py")
    p = dict(zip(rod.PARAMETERS, rod.parameters(**VALUES, **LOADS), strict=True))
    assert p["gravity"] == 9.81
    assert p["follower_angle"] == 0.0
    assert all(p[f"fin_factor_{k}"] == 1.0 for k in range(6))


# States and parameters, by target -----------------------------------------------------------------


def _rod(built: Built, target: tuple[str, str]) -> tuple[ModuleType, np.ndarray]:
    rod = built(Structure(5), *target)
    return rod, rod.parameters(**VALUES, **LOADS)


@EVERY_TARGET
@pytest.mark.parametrize("function", ["rhs", "jac"])
@pytest.mark.parametrize(
    ("y", "error"),
    [
        (np.zeros(13), ValueError),
        (np.zeros(15), ValueError),
        (np.zeros((2, 13)), ValueError),
        (np.zeros((13, 2)), ValueError),
        (np.float64(1.0), ValueError),
        (np.zeros(14, dtype=complex), TypeError),
        (np.zeros(14, dtype=bool), TypeError),
        (np.array(["a"] * 14), TypeError),
        (np.array([None] * 14), TypeError),
    ],
)
def test_states_that_are_none_are_refused(
    built: Built, target: tuple[str, str], function: str, y: np.ndarray, error: type[Exception]
) -> None:
    rod, p = _rod(built, target)
    with pytest.raises(error, match="y has"):
        getattr(rod, function)(0.0, y, p)


@EVERY_TARGET
@pytest.mark.parametrize("shape", [(2, 14), (1, 14), (14, 2)])
def test_one_state_alone_has_a_jacobian(
    built: Built, target: tuple[str, str], shape: tuple[int, ...]
) -> None:
    rod, p = _rod(built, target)
    with pytest.raises(ValueError, match="y has shape"):
        rod.jac(0.0, np.zeros(shape), p)


@EVERY_TARGET
@pytest.mark.parametrize("function", ["rhs", "jac", "energy"])
def test_parameters_of_another_module_are_refused(
    built: Built, target: tuple[str, str], function: str
) -> None:
    rod, p = _rod(built, target)
    time = () if function == "energy" else (0.0,)
    for wrong in (p[:3], np.append(p, 1.0)):
        with pytest.raises(ValueError, match=rf"p has \D*{len(wrong)}\b.*: must be the 14"):
            getattr(rod, function)(*time, np.zeros(14), wrong)
    for wrong, error in ((p.astype(complex), TypeError), (p.astype(str), TypeError)):
        with pytest.raises(error, match="p has"):
            getattr(rod, function)(*time, np.zeros(14), wrong)


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


@EVERY_TARGET
@pytest.mark.parametrize("make", OTHER_MAKES)
@pytest.mark.parametrize("function", ["rhs", "jac"])
def test_states_and_parameters_of_other_make_give_the_same(
    built: Built, target: tuple[str, str], function: str, make: str
) -> None:
    rod, p = _rod(built, target)
    y, p = np.arange(14.0), np.ceil(p)
    call, other = getattr(rod, function), OTHER_MAKES[make]
    expected = call(0.0, y, p)
    # To rounding: long doubles may stay what they are for a part of the way.
    limit = 1e-12 * np.abs(expected).max()
    np.testing.assert_allclose(call(0.0, other(y), p), expected, rtol=0, atol=limit)
    np.testing.assert_allclose(call(0.0, y, other(p)), expected, rtol=0, atol=limit)
    assert y.tolist() == list(range(14))  # nothing writes into what it is given


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


@EVERY_TARGET
@pytest.mark.parametrize("what", NO_NUMBERS)
def test_parameters_that_are_no_real_numbers_are_refused(
    built: Built, target: tuple[str, str], what: str
) -> None:
    rod = built(Structure(5), *target)
    value = NO_NUMBERS[what]
    with pytest.raises(ValueError, match=r"(?s)length = .*must be a finite number"):
        rod.parameters(**{**VALUES, **LOADS, "length": value})
    if value is not None:
        fins = [1.0, 1.0, value, 1.0, 1.0, 1.0]
        with pytest.raises(ValueError, match=r"fin_factor\[2\] = "):
            rod.parameters(**VALUES, **LOADS, fin_factor=fins)


def test_numbers_of_other_make_are_parameters(built: Built) -> None:
    rod, p = _rod(built, ("c", "chain"))
    for three in (3, np.int8(3), np.float32(3), np.array(3), Decimal(3), Fraction(3), np.uint64(3)):
        np.testing.assert_array_equal(rod.parameters(**{**VALUES, **LOADS, "mass": three}), p)
    for wrong in (bytes(6), bytearray(6), memoryview(bytes(6)), np.ma.masked_equal([1] * 6, 1)):
        with pytest.raises(ValueError, match="fin_factor"):
            rod.parameters(**VALUES, **LOADS, fin_factor=wrong)


@EVERY_TARGET
@pytest.mark.parametrize("value", [0.0, -0.0, 5e-324, 1e-200, 1e200, np.nan])
@pytest.mark.parametrize("name", ["mass", "length"])
def test_what_cannot_be_divided_by_gives_no_numbers(
    built: Built, target: tuple[str, str], name: str, value: float
) -> None:
    """Not an exception, nor numbers of another size from target to target."""
    rod, p = _rod(built, target)
    y = np.linspace(0.1, 0.4, len(rod.STATE))
    p[rod.PARAMETERS.index(name)] = value
    rates = rod.rhs(0.0, y, p)
    np.testing.assert_array_equal(rates[:7], y[7:])
    assert np.isnan(rates[7:]).all()
    assert np.isnan(rod.jac(0.0, y, p)[9:, 2:7]).all()
    if target[0] == "c":
        many = rod.rhs_batch(0.0, np.tile(y, (9, 1)), p)
        assert np.isnan(many[:, 7:]).all()
        assert rod.Run("radau", 0.0, y, p).begin(1.0) == rod.NOT_FINITE


@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("structure", [*SMALL[5:]], ids=short)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_seen_in_the_rates(
    built: Built, point: type, target: str, structure: Structure, value: float
) -> None:
    at = point(built(structure, target))
    rod, half = at.module, len(at.y) // 2
    # Joints and links that never move have no use for what acts on them.
    still = range({"free": 0, "cantilever": 2}.get(rod.BOUNDARY, 1))
    rows = [one for one in structure.rows if one.several]
    held = [f"{one.name}_{s}" for one in rows if one.each == JOINTS for s in still]
    held += [f"{one.name}_0" for one in rows if one.each == LINKS and rod.BOUNDARY == "cantilever"]
    with np.errstate(all="ignore"):
        for place, name in enumerate(rod.STATE):
            y = at.y.copy()
            y[place] = value
            rates = rod.rhs(0.0, y, at.p)
            # Rates do not depend on where joint 0 is; what its angles do is in the accelerations.
            seen = rates[half:] if name.startswith("phi") else rates
            assert name in ("x0", "y0") or not np.isfinite(seen).all(), name
        for place, name in enumerate(rod.PARAMETERS):
            p = at.p.copy()
            p[place] = value
            finite = np.isfinite(rod.rhs(0.0, at.y, p)).all()
            # Infinite mass or length only make a rod slow: parameters() refuses them.
            slow = math.isinf(value) and name in ("mass", "length")
            assert name in held or slow or not finite, name


@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("structure", [SMALL[6], SMALL[7]], ids=short)
@pytest.mark.parametrize("angle", [1e4, 1e6, 1e9, -1e12])
def test_many_turns_cost_only_the_digits_of_the_angles(
    built: Built, point: type, target: str, structure: Structure, angle: float
) -> None:
    at = point(built(structure, target))
    angles = [place for place, name in enumerate(at.module.STATE) if name.startswith("phi")]
    at.y[angles] += angle
    exact = np.array(at.exact_rhs(at.y), float)
    off = np.abs(at.module.rhs(at.t, at.y, at.p) - exact)
    # A unit in the last place of every angle, and of the sums of two that loads are taken at.
    J = np.abs(at.module.jac(at.t, at.y, at.p)[:, angles]).sum(axis=1)
    assert np.all(off <= 2 * np.spacing(abs(angle)) * J + 1e-13 * np.abs(exact).max())


@cases("boundary, inertia", BOUNDARIES, INERTIAS)
def test_a_full_turn_changes_nothing(
    built: Built, point: type, boundary: str, inertia: str
) -> None:
    """Of angles that springs see only by their differences; supports hold an angle itself."""
    turning = tuple(term for term in TERMS if term != "supports")
    at = point(built(Structure(3, boundary, inertia, turning)))
    y, p = at.y.copy(), at.p.copy()
    angles = [place for place, name in enumerate(at.module.STATE) if name.startswith("phi")]
    y[angles] += 2 * np.pi
    if "clamp_angle" in at.module.PARAMETERS:
        p[at.module.PARAMETERS.index("clamp_angle")] += 2 * np.pi
    one, two = at.module.rhs(0.0, at.y, at.p), at.module.rhs(0.0, y, p)
    np.testing.assert_allclose(one, two, rtol=0, atol=1e-12 * np.abs(one).max())
