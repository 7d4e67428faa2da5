"""Events against motions whose crossings are known: parabola, pendulum, polynomials."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import ellipk

import rodgen
from rodgen.integrate.events import EventDetector
from rodgen.loading import build
from rodgen.model.quantities import watchable_names
from rodgen.model.rod import BOUNDARIES
from rodgen.scene import Scene
from rodgen.system import System
from tests.sets import Make

Array = NDArray[np.float64]
G = 9.81
# What events can watch beside states and joints.
SINGLE = [name for name, span in watchable_names(BOUNDARIES["pinned"], 3) if len(span) == 1]


def _with(scene: Scene, *events: dict[str, Any]) -> Scene:
    named = [{"name": str(i), **event} for i, event in enumerate(events)]
    return Scene.from_dict(scene.model_dump(exclude_none=True) | {"events": named})


def _met(scene: Scene, end: float) -> list[tuple[int, float]]:
    """Numbers and times of the events of a run."""
    how: dict[str, Any] = {"method": "dop853", "rtol": 3e-14, "atol": 1e-15, "target": "numpy"}
    sol = rodgen.simulate(scene, span=(0.0, end), **how)
    return [(int(event.name), event.t) for event in sol.events]


def _pendulum(make_scene: Make, **initial: float) -> Scene:
    return make_scene(1, "pinned", ("gravity",), initial={"omega": 0.0, **initial})


# A uniform link of length L about its end: J = m L^2/3, m g L/2, so w0^2 = 3 g/(2 L), L = 2.
W0 = math.sqrt(3 * G / (2 * 2.0))


def test_a_pendulum_passes_the_vertical(make_scene: Make) -> None:
    """Released at the angle a from the vertical it passes at K(sin^2(a/2))/w0 and odd multiples."""
    a = 2.5
    scene = _pendulum(make_scene, phi=-math.pi / 2 + a)
    bottom = {"quantity": "phi_0", "value": -math.pi / 2}
    scene = _with(
        scene,
        bottom,
        bottom | {"direction": "rising"},
        bottom | {"direction": "falling"},
        {"quantity": "tip_x", "value": 0.0},
        {"quantity": "omega_0", "value": 0.0},
    )
    quarter = float(ellipk(math.sin(a / 2) ** 2)) / W0
    found = _met(scene, 7.5 * quarter)
    times = [[time for number, time in found if number == e] for e in range(5)]
    close = {"atol": 1e-12, "rtol": 0}
    np.testing.assert_allclose(times[0], quarter * np.array([1, 3, 5, 7]), **close)
    np.testing.assert_allclose(times[1], quarter * np.array([3, 7]), **close)
    np.testing.assert_allclose(times[2], quarter * np.array([1, 5]), **close)
    # Beyond the horizontal the tip is above the pivot; it crosses x = 0 at the bottom alone.
    np.testing.assert_allclose(times[3], times[0], **close)
    # It starts at rest: that is no crossing.
    np.testing.assert_allclose(times[4], quarter * np.array([2, 4, 6]), **close)


def test_a_run_goes_on_from_an_event_without_meeting_it_again(make_scene: Make) -> None:
    """The located state is on or past the value, so the crossing is not seen a second time."""
    bottom = {"quantity": "phi_0", "value": -math.pi / 2, "action": "stop"}
    scene = _with(_pendulum(make_scene, phi=-math.pi / 2 + 2.0), bottom)
    sol = rodgen.simulate(scene, target="numpy")
    (event,) = sol.events
    assert sol.t[-1] < 1.0
    assert event.y[0] <= -math.pi / 2
    after = rodgen.simulate(
        System(scene).at(y0=event.y), target="numpy", span=(event.t, event.t + 0.5)
    )
    assert not after.events


# Motions that are polynomials of degree 3 at most in phi: the cubic through the ends is exact.


class _Curve:
    """phi_0 of one pinned link along a polynomial, watched at the given times."""

    def __init__(self, make_scene: Make, coefficients: list[float], *events: dict[str, Any]):
        scene = _with(make_scene(1, "pinned"), *({"quantity": "phi_0", **e} for e in events))
        model = build(scene, "numpy")
        self.curve = np.polynomial.Polynomial(coefficients)
        self.watch = EventDetector(scene.events, model, model.parameters(**scene.parameters))

    def at(self, times: Array) -> Array:
        return np.stack((self.curve(times), self.curve.deriv()(times)), axis=1)

    def rates(self, times: Array) -> Array:
        return np.stack((self.curve.deriv()(times), self.curve.deriv(2)(times)), axis=1)

    def seen(self, times: Any, *, rates: bool = True) -> list[tuple[int, int]]:
        t = np.array(times, dtype=float)
        found = self.watch.crossings(t, self.at(t), self.rates(t) if rates else None)
        return [(k, number) for k, number, _ in found]

    def located(self, times: Any) -> list[float]:
        t = np.array(times, dtype=float)
        found = self.watch.crossings(t, self.at(t), self.rates(t))
        assert all(t[k] <= low < high <= t[k + 1] for k, _, (low, high) in found)
        return [self.watch.locate(number, *bracket, self.at) for _, number, bracket in found]


RISING, FALLING = {"direction": "rising"}, {"direction": "falling"}
CLOSE = np.polynomial.Polynomial.fromroots([0.51, 0.61]).coef.tolist()
THREE = np.polynomial.Polynomial.fromroots([0.2, 0.55, 0.8]).coef.tolist()
# Curve, events, times, and the crossings: with rates and without, as (step, event), and where.
CROSSINGS: dict[str, tuple[list[float], list[dict[str, Any]], list[float], Any, Any, Any]] = {
    "twice in a step": (
        [0.21, -1.0, 1.0],  # (x - 0.3)(x - 0.7), positive at both ends
        [{}, RISING, FALLING],
        [0, 1],
        [(0, 0), (0, 2), (0, 0), (0, 1)],
        [],
        [0.3, 0.3, 0.7, 0.7],
    ),
    "thrice in a step": (THREE, [{}], [0, 1], [(0, 0)] * 3, [(0, 0)], [0.2, 0.55, 0.8]),
    "thrice, rising": (THREE, [RISING], [0, 1], [(0, 0)] * 2, [(0, 0)], [0.2, 0.8]),
    "thrice, falling": (THREE, [FALLING], [0, 1], [(0, 0)], [], [0.55]),
    # x^2 + e: what stays clear of the value has not reached it, what touches it has.
    "clear": ([1e-9, 0.0, 1.0], [{}], [-1, 1], [], [], []),
    "clear at a step end": ([1e-9, 0.0, 1.0], [{}], [-1, 0, 1], [], [], []),
    "touching at a step end": (
        *([0.0, 0.0, 1.0], [FALLING, RISING], [-1, 0, 1]),
        *([(0, 0)], [(0, 0)], [0.0]),
    ),
    "touching in a step": ([0.0, 0.0, 1.0], [{}], [-1, 1], [(0, 0)], [], [0.0]),
    "hardly twice": ([-1e-4, 0.0, 1.0], [{}], [-1, 1], [(0, 0)] * 2, [], [-0.01, 0.01]),
    # x (0.6 - x) leaves 0 and comes back at 0.6; after that start it is not met again.
    "leaving the value": ([0.0, 0.6, -1.0], [{}], [0, 0.1, 0.3], [], [], []),
    "leaving and meeting": ([0.0, 0.6, -1.0], [{}], [0, 1], [(0, 0)], [], [0.6]),
    "leaving, meeting later": ([0.0, 0.6, -1.0], [{}], [0, 0.5, 0.7], [(1, 0)], [(1, 0)], [0.6]),
    "going on from it": ([0.0, 0.6, -1.0], [{}], [0.6, 1.0], [], [], []),
    "at a step end": (
        *([-1.0, 1.0], [{}, RISING], [0, 0.5, 1, 1.5, 2]),
        *([(1, 0), (1, 1)], [(1, 0), (1, 1)], [1.0, 1.0]),
    ),
    # In the block before it, that is, and not in the one behind it, which begins with this row.
    "at the end of a block": ([-1.0, 1.0], [{}], [0, 0.5, 1], [(1, 0)], [(1, 0)], [1.0]),
    "at the start of a block": ([-1.0, 1.0], [{}], [1, 1.5, 2], [], [], []),
    "a row given twice": ([-1.0, 1.0], [{}], [0, 1, 1, 2], [(0, 0)], [(0, 0)], [1.0]),
    # Pairs closer than the eighths of a step are not seen, as it is documented.
    "between two eighths": (CLOSE, [{}], [0, 1], [], [], []),
    "at other steps": (CLOSE, [{}], [0, 0.56, 1], [(0, 0), (1, 0)], [(0, 0), (1, 0)], [0.51, 0.61]),
    # A constant 0.1, which has no exact binary fraction, stays on 0.1 inside the steps too.
    "rest on the value": ([0.1], [{"value": 0.1}], [k / 7 for k in range(50)], [], [], []),
    "another row given twice": ([-1.0, 1.0], [{}], [0, 0.5, 0.5, 2], [(2, 0)], [(2, 0)], [1.0]),
}


@pytest.mark.parametrize("case", CROSSINGS)
def test_crossings_of_polynomials(make_scene: Make, case: str) -> None:
    coefficients, events, times, seen, by_ends, where = CROSSINGS[case]
    curve = _Curve(make_scene, coefficients, *({"value": 0.0, **event} for event in events))
    assert curve.seen(times) == seen
    assert curve.seen(times, rates=False) == by_ends
    # Rounding, but where a root is double: its square is rounded.
    np.testing.assert_allclose(curve.located(times), where, atol=1e-12)


def test_not_a_number_is_no_crossing(make_scene: Make) -> None:
    curve = _Curve(make_scene, [-1.0, 1.0], {"value": 0.0}, {"value": 0.0, "quantity": "tip_y"})
    t = np.array([0.0, 0.75, 1.25, 2.0])
    y, f = curve.at(t), curve.rates(t)
    broken = y.copy()
    broken[2] = np.nan
    assert curve.watch.crossings(t, broken, f) == []
    broken[2] = np.inf
    assert curve.watch.crossings(t, broken, f) == []
    # Rates that are not a number hide nothing that the step ends show.
    found = curve.watch.crossings(t, y, np.full_like(f, np.nan))
    assert [(k, number) for k, number, _ in found] == [(1, 0), (1, 1)]
    nothing = curve.watch.locate(0, 0.0, 2.0, lambda times: np.full((len(times), 2), np.nan))
    assert math.isnan(nothing)


def test_dense_output_decides(make_scene: Make) -> None:
    """Crossings that only the cubic has are located nowhere; those it has elsewhere are found."""
    zero = {"value": 0.0}
    curve = _Curve(make_scene, [0.21, -1.0, 1.0], zero)
    t = np.array([0.0, 1.0])
    brackets = [b for _, _, b in curve.watch.crossings(t, curve.at(t), curve.rates(t))]

    def clear(times: Array) -> Array:
        return curve.at(times) + 0.1

    assert all(math.isnan(curve.watch.locate(0, *b, clear)) for b in brackets)

    def later(times: Array) -> Array:  # the same motion 0.1 later in the middle of the step
        return curve.at(times - 0.1 * np.sin(np.pi * times))

    found = [curve.watch.locate(0, *b, later) for b in brackets]
    np.testing.assert_allclose(
        curve.curve(np.array(found) - 0.1 * np.sin(np.pi * np.array(found))), 0, atol=1e-15
    )


def test_an_end_on_the_value_but_for_rounding(make_scene: Make) -> None:
    line = _Curve(make_scene, [-1.0, 1.0], {"value": 0.0} | RISING, {"value": 0.0} | FALLING)

    def short(times: Array) -> Array:
        return line.at(times) - 1e-16

    def ahead(times: Array) -> Array:
        return line.at(times) + 1e-16

    assert line.watch.locate(0, 0.0, 1.0, short) == 1.0
    assert line.watch.locate(0, 1.0, 2.0, ahead) == 1.0
    assert math.isnan(line.watch.locate(1, 0.0, 1.0, short))
    assert math.isnan(line.watch.locate(1, 1.0, 2.0, ahead))


def test_every_quantity_is_the_module_s_own(make_scene: Make) -> None:
    scene = make_scene(3, "free", ("gravity",))
    model = build(scene, "numpy")
    names = [*model.STATE, *SINGLE, "joint_0_x", "joint_2_y", "joint_3_x"]
    scene = _with(scene, *({"quantity": name, "value": 0.0} for name in names))
    p = model.parameters(**scene.parameters)
    y = np.random.default_rng(1).normal(size=(4, 2, len(model.STATE)))
    values = dict(
        zip(names, np.moveaxis(EventDetector(scene.events, model, p).values(y), -1, 0), strict=True)
    )
    joints, centre = model.joints(y, p), model.centre_of_gravity(y, p)
    energy, inertia = model.energy(y, p), model.inertia(y, p)
    expected = {
        **{name: y[..., i] for i, name in enumerate(model.STATE)},
        **{f"tip_{axis}": joints[..., 3, i] for i, axis in enumerate("xy")},
        **{f"centre_of_gravity_{axis}": centre[..., i] for i, axis in enumerate("xy")},
        **{f"{kind}_energy": energy[i] for i, kind in enumerate(("kinetic", "spring", "gravity"))},
        "total_energy": sum(energy),
        **{name: inertia[i] for i, name in enumerate(("inertia_x", "inertia_y", "product_xy"))},
        "joint_0_x": y[..., 0],
        "joint_2_y": joints[..., 2, 1],
        "joint_3_x": joints[..., 3, 0],
    }
    assert expected.keys() == values.keys()
    for name, value in expected.items():
        np.testing.assert_allclose(values[name], value, rtol=1e-15, err_msg=name)
