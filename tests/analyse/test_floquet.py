"""Floquet multipliers against Mathieu's functions, eigenvalues, and products of maps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import mathieu_a, mathieu_b

import rodgen
from rodgen.analyse.cycles.floquet import floquet, multipliers_of
from rodgen.analyse.errors import AnalysisError
from rodgen.scene import Scene, SceneError

pytestmark = pytest.mark.compiler


def _pendulum(a: float, b: float) -> Scene:
    """One pinned link with a moment of inertia of 1 kg m^2 under a tip load: Mathieu's equation
    x'' + (a - 2q cos 2t) x = 0 with b = -2q, for small angles."""
    rod = {"links": 1, "length": 1.0, "bending_stiffness": 0.0, "mass": 3.0, "boundary": "pinned"}
    return Scene.from_dict(
        {
            "name": "mathieu",
            "parameters": {"a": a, "b": b},
            "rod": rod,
            "loads": {"tip": {"x": "a + b*cos(2*t)"}},
        }
    )


def _edge(low: float, high: float, q: float) -> float:
    """Where between two values of a stability changes, by bisection."""
    stable = floquet(_pendulum(low, 2 * q)).stable
    for _ in range(24):
        middle = (low + high) / 2
        low, high = (
            (middle, high) if floquet(_pendulum(middle, 2 * q)).stable == stable else (low, middle)
        )
    return low


@pytest.mark.parametrize(
    ("exact", "bracket", "q"),
    [
        (mathieu_b(1, 0.15), (0.5, 1.0), 0.15),
        (mathieu_a(1, 0.15), (1.0, 1.5), 0.15),
        (mathieu_b(2, 1.0), (3.0, 4.1), 1.0),
        (mathieu_a(2, 1.0), (4.1, 5.0), 1.0),
    ],
)
def test_boundaries_of_mathieus_equation(
    exact: float, bracket: tuple[float, float], q: float
) -> None:
    """The edges of the first two tongues: b1, a1, b2, a2 (SciPy). What counts as on the circle,
    1e-5, moves them by its square."""
    assert _edge(*bracket, q) == pytest.approx(exact, abs=2e-7)


def test_multipliers_answer_each_other_and_do_not_depend_on_segments() -> None:
    """Without damping their product is 1; in the first tongue the largest is negative."""
    whole = floquet(_pendulum(1.0, 0.3), segments=1)
    assert whole.period == pytest.approx(np.pi)
    assert np.prod(whole.multipliers) == pytest.approx(1.0, abs=1e-9)
    assert whole.argument == pytest.approx(np.pi)
    assert not whole.stable
    assert whole.growth == pytest.approx(np.log(whole.modulus) / np.pi)
    for segments in (3, 5, 20):
        found = floquet(_pendulum(1.0, 0.3), segments=segments)
        np.testing.assert_allclose(found.multipliers, whole.multipliers, atol=1e-9)


def _column(amplitude: float = 0.0, rate: float = 1.0, load: float = -4.0) -> Scene:
    """A clamped column under a dead load at its tip that swings a little."""
    rod = {"links": 3, "length": 1.0, "bending_stiffness": 30.0, "mass": 3.0}
    return Scene.from_dict(
        {
            "name": "column",
            "parameters": {"P": load, "a": amplitude, "w": rate},
            "rod": {**rod, "boundary": "clamped"},
            "loads": {"tip": {"x": "P + a*cos(w*t)"}},
        }
    )


def test_principal_tongue_of_a_column() -> None:
    """Of small amplitude it is that of Mathieu's equation for the first mode, whose stiffness
    follows the load by the matrices of the linear motion: within 1 % of its width."""

    def matrix(load: float) -> np.ndarray:
        scene = _column(load=load)
        model = rodgen.build(scene, "numpy")
        y = scene.initial_state()
        return model.jac(0.0, y, model.parameters(**scene.parameters))[3:, :3]

    P, a = -4.0, 0.6
    A, slope = matrix(P), (matrix(P + 0.5) - matrix(P - 0.5))
    values, right = np.linalg.eig(-A)
    left = np.linalg.inv(right)
    first = int(np.argmin(values))
    square, change = values[first], -(left @ slope @ right)[first, first]

    def beside(edge: Any, sign: float) -> float:
        """Where x'' + (square + change a cos wt) x = 0 is on an edge of its first tongue."""

        def off(w: float) -> float:
            return float(4 * square / w**2 - edge(1, abs(2 * change * a / w**2)))

        centre = 2 * np.sqrt(square)
        return float(brentq(off, centre, centre * (1 + 0.3 * sign)))

    low, high = beside(mathieu_a, -1), beside(mathieu_b, 1)
    width = high - low
    assert 0.002 < width / low < 0.02

    def measured(inside: float, outside: float) -> float:
        for _ in range(14):
            middle = (inside + outside) / 2
            stable = floquet(_column(a, middle)).stable
            inside, outside = (inside, middle) if stable else (middle, outside)
        return (inside + outside) / 2

    centre = (low + high) / 2
    assert measured(centre, low - width) == pytest.approx(low, abs=0.005 * width)
    assert measured(centre, high + width) == pytest.approx(high, abs=0.005 * width)


def test_multipliers_of_many_segments_keep_their_digits() -> None:
    """Of a known matrix whose multipliers are thirty orders apart, by any number of segments."""
    draw = np.random.default_rng(3)
    V = np.linalg.qr(draw.standard_normal((6, 6)))[0] + 0.2 * draw.standard_normal((6, 6))
    blocks = [[-0.1, 2.0], [-2.0, -0.1]], [[-9.0, 5.0], [-5.0, -9.0]], [[0.3, 0], [0, -60.0]]
    A = np.zeros((6, 6))
    for at, block in enumerate(blocks):
        A[2 * at : 2 * at + 2, 2 * at : 2 * at + 2] = block
    A = V @ A @ np.linalg.inv(V)
    exact = np.exp([0.3, -0.1 + 2j, -0.1 - 2j, -9 + 5j, -9 - 5j, -60.0])
    for segments, tolerance in ((3, 1e-6), (5, 1e-9), (20, 1e-10)):
        found = multipliers_of([expm(A / segments)] * segments)
        for one in exact:
            off = np.abs(found - one).min() / abs(one)
            assert off < (tolerance if abs(one) > 1e-9 else 1e3 * tolerance), (segments, one)
    # Their product has lost the smallest.
    lost = np.linalg.eigvals(np.linalg.matrix_power(expm(A / 20), 20))
    assert np.abs(lost - exact[-1]).min() > 0.1 * abs(exact[-1])


def test_forced_motion_is_found_and_its_multipliers_are_those_of_the_matrix() -> None:
    """A load across a damped column drives it round; the motion is small, and decays towards it as
    about rest."""
    scene = Scene.from_dict(
        _column().model_dump(exclude_none=True)
        | {
            "loads": {
                "tip": {"x": 0.0, "y": "a*sin(w*t)"},
                "internal_damping": {"coefficient": 2.0},
            },
            "parameters": {"a": 1e-4, "w": 8.0},
        }
    )
    found = floquet(scene)
    assert found.closed < 1e-9
    assert np.abs(found.y).max() > 1e-7
    sol = rodgen.simulate(scene, span=[0.0, found.period], y0=found.y, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(sol.y[-1], found.y, atol=1e-9)
    model = rodgen.build(scene, "numpy")
    J = model.jac(0.0, np.zeros(6), model.parameters(**scene.parameters))
    exact = np.exp(np.linalg.eigvals(J) * found.period)
    for one in exact[np.abs(exact) > 1e-6]:
        assert np.abs(found.multipliers - one).min() < 1e-6
    assert found.stable


def test_rod_that_flies_is_judged_beside_its_place() -> None:
    scene = Scene.from_dict(
        {
            "name": "thrust",
            "rod": {"links": 3, "length": 2.0, "bending_stiffness": 30.0, "mass": 3.0},
            "loads": {"follower": {"force": "20*(1 + 0.2*sin(9*t))"}},
            "initial": {"phi": "0.01*cos(pi*s)"},
        }
    )
    found = floquet(scene)
    assert len(found.multipliers) == 6
    # That it may point anywhere is a multiplier of one, twice.
    assert np.sort(np.abs(found.multipliers - 1))[1] < 1e-4


@pytest.mark.parametrize(
    ("load", "options", "says"),
    [
        ("1.0", {}, "period = None: must be given in seconds: no load changes"),
        ("exp(-t)", {}, "none is found from the sines"),
        ("sin(t)*t", {}, "none is found from the sines"),
        ("sin(t) + sin(sqrt(2)*t)", {}, "none is found from the sines"),
        ("sin(t)", {"period": -1.0}, "period = -1.0: must be seconds above 0"),
        ("sin(t)", {"segments": 0}, "segments = 0"),
        ("sin(t)", {"y": [1.0]}, r"y = .*\(1,\).*: must be a state, \(2,\)"),
    ],
)
def test_what_cannot_be_is_refused(load: str, options: dict[str, Any], says: str) -> None:
    scene = Scene.from_dict(
        _pendulum(1.0, 0.3).model_dump(exclude_none=True)
        | {"loads": {"tip": {"x": load}}, "parameters": {}}
    )
    with pytest.raises(SceneError, match=says):
        floquet(scene, model=rodgen.build(scene, "numpy"), **options)


def test_no_motion_of_a_period(monkeypatch: pytest.MonkeyPatch) -> None:
    """From a state that a period does not bring back, with too few iterations to find one."""
    monkeypatch.setattr("rodgen.analyse.cycles.floquet.ITERATIONS", 1)
    with pytest.raises(AnalysisError, match=r"mathieu: no motion of period 3\.14159 s was found"):
        floquet(_pendulum(1.0, 0.3), y=[1.0, 5.0])
