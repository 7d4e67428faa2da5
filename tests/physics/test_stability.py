"""The largest stable step: eigenvalues by two routes, limits by formula and by trying them out."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest
from scipy.integrate import DOP853, RK23, RK45, OdeSolver

import rodgen
from rodgen.arrays import Array
from rodgen.errors import DoubtWarning
from rodgen.integrate import RunError, stability
from rodgen.integrate.methods.python_steppers import explicit_step
from rodgen.integrate.stability import LIMITS, Dominant, dominant, step_doubt, step_limit
from rodgen.integrate.stepper import Rhs, StepError
from rodgen.model.methods import TABLEAUX
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS
from tests.palette import cases
from tests.sets import Make, sets
from tests.told import numbers

# Loads that ask nothing of joints or links one by one, and damping.
DAMPED = tuple(t for t in TERMS if TERMS[t].is_load and t not in ("distributed_follower", "drag"))
Advance = Callable[[Rhs, float, Array, Array, float], Array]
VALUES = {
    "mass": 20.0,
    "length": 5.0,
    "bending_stiffness": 100.0,
    "follower_force": 300.0,
    "internal_damping": 0.2,
    "material_damping_time": 0.02,
    "external_damping": 0.5,
    "tip_force_x": 3.0,
    "tip_force_y": 2.0,
    "moment_size": 5.0,
    "viscous_drag_normal": 0.3,
    "joint_friction_moment": 0.4,
    "joint_friction_rate": 0.5,
    "air_density": 1.2,
    "fins_normal_slope": 6.0,
    "axial_drag_coefficient": 0.5,
    **dict.fromkeys(("fins_area", "nose_area", "axial_drag_area"), 0.02),
}


def _model(
    n: int, boundary: str, inertia: str = "uniform", terms: tuple[str, ...] = (), **values: float
) -> tuple[ModuleType, Array]:
    model = rodgen.build(rodgen.Structure(n, boundary, inertia, terms))
    known = {name: v for name, v in (VALUES | values).items() if name in model.PARAMETERS}
    return model, model.parameters(**known)


def _bent(model: ModuleType) -> Array:
    """A wild state: nothing about it is small."""
    size = len(model.STATE) // 2
    rng = np.random.default_rng(1)
    turns = np.cumsum(0.3 * rng.standard_normal(size))
    return np.concatenate((turns, rng.standard_normal(size)))


def _dense(model: ModuleType, y: Array, p: Array) -> tuple[complex, Array]:
    """The eigenvalue of largest modulus, above the real axis, and its mode, from jac."""
    values, vectors = np.linalg.eig(model.jac(0.0, y, p))
    at = int(np.argmax(np.abs(values) + (values.imag > 0) * 1e-9 * np.abs(values)))
    return complex(values[at]), vectors[: len(y) // 2, at]


# Every boundary, and every inertia twice.
PAIRS = list(zip(BOUNDARIES, 2 * list(INERTIAS), strict=True))


@pytest.mark.parametrize(("boundary", "inertia"), sets(PAIRS[:1], slow=PAIRS[1:]))
def test_spectrum_is_that_of_the_whole_matrix(boundary: str, inertia: str) -> None:
    model, p = _model(40, boundary, inertia, DAMPED)
    y = _bent(model)
    found = dominant(model, 0.0, y, p)
    value, _ = _dense(model, y, p)
    assert found.converged
    # ARPACK is asked for a residual of 1e-4.
    assert abs(found.value - value) < 1e-5 * abs(value)


@cases("boundary, damping", ["free", "clamped"], (0.0, 0.01, 1.0, 5.0, 6e4, 1e8))
def test_spectrum_of_a_damped_rod(boundary: str, damping: float) -> None:
    """Undamped up to far beyond critical, where it is real; the partner is the other root."""
    model, p = _model(60, boundary, terms=("internal_damping",), internal_damping=damping)
    y = np.zeros(len(model.STATE))
    found = dominant(model, 0.0, y, p)
    value, mode = _dense(model, y, p)
    along = abs(np.vdot(found.mode, mode)) / np.linalg.norm(found.mode) / np.linalg.norm(mode)
    # Neighbours are 1e-3 apart, and mix by the residual over that.
    assert along == pytest.approx(1.0, abs=0.02)
    # Near critical damping (1.4 m^2/s) the two roots are close, and ill-conditioned.
    assert abs(found.value - value) < (1e-3 if damping == 1.0 else 1e-5) * abs(value)
    ratio = damping * (20.0 / 60) / (100.0 * 60 / 5.0)  # c m/k
    # Damping and springs are in that proportion: -(lambda + partner) = c m/k lambda partner.
    square = (found.value * found.partner).real
    drag = -(found.value + found.partner).real
    assert drag == pytest.approx(ratio * square, rel=1e-3, abs=1e-5 * found.rate)


@pytest.mark.slow
def test_fastest_motion_at_critical_damping_is_found_soon() -> None:
    """The root is double, where an iteration hardly converges: a percent above it is enough."""
    n, omega = 500, 4 * np.sqrt(3) * 500**2 * np.sqrt(100.0 / (20.0 * 5.0**3))
    critical = 2 / (4 * np.sqrt(3)) * np.sqrt(100.0 * 5.0 / 20.0)  # m^2/s
    model, p = _model(n, "free", "uniform", ("internal_damping",), internal_damping=critical)
    found = dominant(model, 0.0, np.zeros(len(model.STATE)), p)
    assert found.rate == pytest.approx(omega, rel=0.02)
    assert found.damping == pytest.approx(1.0, abs=0.01)
    assert found.evaluations < 20 * 366  # what the undamped rod takes


@pytest.mark.parametrize("damping", [0.0, 1e8])
def test_spectrum_of_very_many_states_by_few_products(
    damping: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    model, p = _model(60, "free", terms=("internal_damping",), internal_damping=damping)
    y = np.zeros(len(model.STATE))
    exact, _ = _dense(model, y, p)
    monkeypatch.setattr(stability, "MANY", 100)
    stability._cached_dominant.cache_clear()
    found = dominant(model, 0.0, y, p)
    stability._cached_dominant.cache_clear()
    assert abs(found.value - exact) < 0.02 * abs(exact)  # of 60 links: 0.011; of more links, less
    assert found.evaluations < 40  # of 24 vectors, 150 and more


def test_damping_that_the_matrix_misses_at_rest() -> None:
    """External damping is of degree one in a velocity that is zero: it has no derivative there,
    which jac says with a zero. The differences see it work."""
    model, p = _model(50, "free", terms=("external_damping",), external_damping=1e6)
    y = np.zeros(len(model.STATE))
    assert abs(_dense(model, y, p)[0]) < 1e4
    assert dominant(model, 0.0, y, p).rate > 1e6


def test_spectrum_of_a_body_that_nothing_holds() -> None:
    model, p = _model(1, "free")
    found = dominant(model, 0.0, np.zeros(6), p)
    assert found.rate == 0
    assert found.damping == 0
    assert all(step_limit(method, found.value, found.partner) == np.inf for method in LIMITS)


def test_spectrum_of_rates_that_are_not_finite() -> None:
    model, p = _model(20, "free")
    with pytest.raises(StepError):
        dominant(model, 0.0, np.full(44, np.nan), p)
    assert step_doubt("rk4", 1.0, 10.0, model, 0.0, np.full(44, np.nan), p) is None


# Limits -----------------------------------------------------------------------------------------


def test_limits_of_an_oscillation_and_of_a_decay() -> None:
    """Imaginary and real intervals. rk4: sqrt(8), and the root of 1 - x/2 + x^2/6 - x^3/24 (E.
    Hairer, G. Wanner 1996, IV.2); the thesis's method: the square root of that root, since
    1 - trace + determinant is x (1 - x/2 + x^2/6 - x^3/24) of x = (h omega)^2."""
    cubic = np.roots([-1 / 24, 1 / 6, -1 / 2, 1])
    root = cubic[np.abs(cubic.imag) < 1e-9].real[0]
    of = {
        "euler": (0.0, 2.0),
        "semi_implicit_euler": (2.0, 2.0),
        "rk4": (np.sqrt(8), root),
        "thesis_runge_kutta": (np.sqrt(root), root),
        "rk23": (np.sqrt(3), 2.5127),  # of order 3 in 3 stages, as any such
        "rk45": (0.9972, 3.3066),  # 1 + z + ... + z^5/120 + z^6/600 (the same, IV.2)
        "dop853": (5.9604, 6.3937),  # by the next test
    }
    assert set(of) == set(LIMITS)
    for method, (swinging, decaying) in of.items():
        # The slack moves rk4's by 1e-9; others have as many digits as are given.
        digits = 1e-4 if method in ("dop853", "rk23", "rk45") else 1e-7
        assert step_limit(method, 50j) * 50 == pytest.approx(swinging, abs=digits)
        assert step_limit(method, -50 + 0j, 0j) * 50 == pytest.approx(decaying, abs=digits)


def test_growing_motions_are_not_the_method() -> None:
    assert step_limit("rk4", 3 + 0j) == np.inf
    assert step_limit("rk4", 0.1 + 1j) == step_limit("rk4", 1j)


def _of_scipy(method: type[OdeSolver]) -> Advance:
    """A step without error control."""

    def advance(rhs: Rhs, t: float, y: Array, f: Array, h: float) -> Array:
        k = np.zeros((method.n_stages, len(y)))
        k[0] = f
        for s in range(1, method.n_stages):
            k[s] = rhs(t + method.C[s] * h, y + h * (method.A[s, :s] @ k[:s]))
        return np.asarray(y + h * (method.B @ k))

    return advance


ADVANCE: dict[str, Advance] = {
    **{name: explicit_step(tableau) for name, tableau in TABLEAUX.items()},
    "dop853": _of_scipy(DOP853),
    "rk23": _of_scipy(RK23),
    "rk45": _of_scipy(RK45),
}


def _is_seen(method: str, damping: float) -> bool:
    """Undamped, no step of Euler's is stable; rk45's limit there has three digits."""
    return damping != 0 or method not in ("euler", "rk45")


def _radius(advance: Advance, J: Array, h: float) -> float:
    """The largest modulus of the eigenvalues of a step of y' = J y."""
    step = np.array([advance(lambda _, y: J @ y, 0.0, y, J @ y, h) for y in np.eye(len(J))]).T
    return float(np.abs(np.linalg.eigvals(step)).max())


@cases("method, damping", LIMITS, (0.0, 0.3, 1.0, 3.0), where=_is_seen)
def test_limit_is_where_steps_begin_to_grow(method: str, damping: float) -> None:
    """Of an oscillator of 20 rad/s with no, less, just, and more than critical damping."""
    J = np.array([[0.0, 1.0], [-400.0, -40.0 * damping]])
    value, partner = sorted(np.linalg.eigvals(J), key=lambda root: (-abs(root), -root.imag))
    most = step_limit(method, complex(value), complex(partner))
    radii = [_radius(ADVANCE[method], J, x * most) for x in (0.1, 0.3, 0.5, 0.7, 0.9, 0.999, 1.001)]
    # A double root, of critical damping, is known to the root of what a number is rounded to.
    assert max(radii[:-1]) < 1 + 1e-7 < radii[-1]


def test_a_step_far_beyond_the_limit_is_warned_of(make_scene: Make) -> None:
    """The growth over the span is more than a number can hold."""
    scene = make_scene(3, "clamped", span=[0.0, 3.0])
    with pytest.warns(DoubtWarning, match="rk4"), pytest.raises(RunError):
        rodgen.simulate(scene, method="rk4", step=0.5)


# Warnings ---------------------------------------------------------------------------------------


def test_warning_has_step_limit_and_rate() -> None:
    model, p = _model(20, "clamped", terms=("internal_damping",), internal_damping=0.2)
    y = np.zeros(len(model.STATE))
    found: Dominant = dominant(model, 0.0, y, p)
    most = step_limit("rk4", found.value, found.partner)
    assert step_doubt("rk4", 0.999 * most, 10.0, model, 0.0, y, p) is None
    assert step_doubt("radau", 1.0, 10.0, model, 0.0, y, p) is None
    told = step_doubt("rk4", 0.1, 10.0, model, 0.0, y, p)
    assert told is not None
    assert told.figures == {"step": 0.1, "longest": most, "rate": found.rate}
    # In two or three digits; the damping in per cent of critical.
    for value in (0.1, most, found.rate, 100 * found.damping):
        assert any(number == pytest.approx(value, rel=0.06) for number in numbers(told))


def test_warning_of_euler_without_damping() -> None:
    model, p = _model(20, "clamped")
    y = np.zeros(len(model.STATE))
    assert step_doubt("euler", 1e-4, 10.0, model, 0.0, y, p) is not None
    # exp(h omega^2/2 T) with h = 1e-9 s, omega = 547 rad/s, T = 10 s: a growth of 0.2 %.
    assert step_doubt("euler", 1e-9, 10.0, model, 0.0, y, p) is None
