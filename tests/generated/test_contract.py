"""The contract of a generated module: alone in the world, checked parameters, shapes."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rodgen.loading import load_module

GENERATED = Path(__file__).parents[2] / "generated"
STEMS = ("rod_free_n5", "rod_free_n5_conservative", "rod_cantilever_n5")
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
assert all(np.isfinite(e) for e in rod.energy(y, p))
print(sorted(m for m in sys.modules if m.split(".")[0] in ("rodgen", "sympy")))
"""


def _values(module: ModuleType) -> dict[str, float]:
    return VALUES | {k: v for k, v in LOADS.items() if k in module.PARAMETERS}


@pytest.mark.parametrize("stem", STEMS)
def test_module_runs_without_rodgen_and_sympy(stem: str) -> None:
    values = _values(load_module(GENERATED / f"{stem}.py"))
    program = ALONE.format(folder=str(GENERATED), stem=stem, values=values)
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
    assert (rod.N, rod.INERTIA) == (5, "uniform")
    assert rod.BOUNDARY in stem
    assert len(p) == len(rod.PARAMETERS)
    y = np.random.default_rng(2).normal(size=states)
    assert rod.rhs(0.0, y, p).shape == (states,)
    np.testing.assert_array_equal(rod.rhs(0.0, y, p)[: states // 2], y[states // 2 :])
    mass = rod.mass_matrix(y, p)
    np.testing.assert_array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0
    solution = solve_ivp(rod.rhs, (0.0, 0.1), y, args=(p,))
    assert solution.success


@pytest.mark.parametrize("stem", STEMS)
def test_many_states_at_once(stem: str) -> None:
    rod = load_module(GENERATED / f"{stem}.py")
    p = rod.parameters(**_values(rod))
    y = np.random.default_rng(3).normal(size=(4, 3, len(rod.STATE)))
    for function in (rod.energy, rod.joints, rod.centre_of_gravity, rod.inertia):
        together = np.asarray(function(y, p))
        one = np.asarray(function(y[2, 1], p))
        if function in (rod.energy, rod.inertia):
            together = np.moveaxis(together, 0, -1)
        np.testing.assert_allclose(together[2, 1], one, rtol=1e-12, atol=1e-14)
    if hasattr(rod, "power"):
        together = rod.power(0.0, y, p)
        one = rod.power(0.0, y[2, 1], p)
        for term in one:
            np.testing.assert_allclose(together[term][2, 1], one[term], rtol=1e-12)


def test_rod_at_rest_has_no_drag() -> None:
    """0/0 in the direction of a velocity of zero is no force, and no warning."""
    rod = load_module(GENERATED / "rod_free_n5.py")
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
        ({"mass": "heavy"}, ValueError, "mass"),
        ({"external_damping": -0.1}, ValueError, "external_damping"),
        ({"gravity": math.nan}, ValueError, "gravity"),
        ({"mass": 10**400}, ValueError, "mass = inf"),
        ({"mass": True}, ValueError, "mass = True"),
        ({"fin_factor": [1.0, 2.0]}, ValueError, "fin_factor has 2 values"),
        ({"fin_factor": 3.0}, ValueError, "fin_factor = 3.0"),
        ({"fin_factor": ["a"] * 6}, ValueError, r"fin_factor\[0\] = 'a'"),
        ({"fin_factor": [1.0, [2.0, 3.0], 1.0, 1.0, 1.0, 1.0]}, ValueError, r"fin_factor\[1\]"),
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


@pytest.mark.parametrize(
    ("y", "error"),
    [
        (np.zeros(13), ValueError),
        (np.zeros((2, 14)), ValueError),
        (np.zeros(14, dtype=complex), TypeError),
        (np.array(["a"] * 14), TypeError),
    ],
)
def test_states_that_are_none_are_refused(y: np.ndarray, error: type[Exception]) -> None:
    rod = load_module(GENERATED / "rod_free_n5.py")
    with pytest.raises(error, match="y has"):
        rod.rhs(0.0, y, rod.parameters(**VALUES, **LOADS))


def test_parameters_of_another_module_are_refused() -> None:
    rod = load_module(GENERATED / "rod_free_n5.py")
    p = rod.parameters(**VALUES, **LOADS)
    for function in (lambda q: rod.rhs(0.0, np.zeros(14), q), lambda q: rod.energy(np.zeros(14), q)):
        with pytest.raises(ValueError, match=r"p has 3 values: must be the 14"):
            function(p[:3])


def test_states_of_other_make_give_the_same() -> None:
    rod = load_module(GENERATED / "rod_free_n5.py")
    p = rod.parameters(**VALUES, **LOADS)
    y = np.arange(14.0)
    expected = rod.rhs(0.0, y, p)
    spread = np.zeros(28)
    spread[::2] = y
    for other in (list(range(14)), np.arange(14), spread[::2], y.astype(np.float32)):
        np.testing.assert_array_equal(rod.rhs(0.0, other, p), expected)


def test_state_that_is_not_finite_gives_rates_that_are_not() -> None:
    rod = load_module(GENERATED / "rod_free_n5.py")
    y = np.zeros(14)
    y[4] = math.nan
    with np.errstate(all="ignore"):
        assert np.isnan(rod.rhs(0.0, y, rod.parameters(**VALUES, **LOADS))[7:]).any()
