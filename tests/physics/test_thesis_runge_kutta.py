"""The thesis's Runge-Kutta method: against its Java listing, line by line, and its order."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import rodgen
from rodgen.integrate.methods import rk4, thesis_runge_kutta
from rodgen.integrate.stepper import Array, Rhs
from rodgen.scene import Scene

Make = Callable[..., Scene]
SMOOTH = ("follower", "gravity", "internal_damping")
Problem = tuple[Rhs, Array, Array]


class Listing:
    """stepRungeKutta (thesis 4.1.3) with the members it changes, named as there."""

    def __init__(self, rhs: Rhs, y: Array, step: float):
        half = len(y) // 2
        self.rhs, self.step, self.time = rhs, step, 0.0
        self.angles, self.omegas = y[:half].copy(), y[half:].copy()

    def get_solution(self) -> None:
        y = np.concatenate((self.angles, self.omegas))
        self.solution = self.rhs(self.time, y)[len(self.angles) :]

    def update(self) -> None:
        self.omegas += self.step * self.solution  # updateOmegas, line 131
        self.angles += self.step * self.omegas  # updateAngles, line 140

    def step_runge_kutta(self) -> None:
        angles_t, omegas_t = self.angles.copy(), self.omegas.copy()
        self.get_solution()
        self.update()
        ks = [self.solution.copy()]
        for divisor in (2.0, 2.0, 1.0):
            self.solution = ks[-1] / divisor
            self.angles, self.omegas = angles_t.copy(), omegas_t.copy()
            self.update()
            self.get_solution()
            ks.append(self.solution.copy())
        self.solution = (ks[0] + 2 * ks[1] + 2 * ks[2] + ks[3]) / 6
        self.angles, self.omegas = angles_t.copy(), omegas_t.copy()
        self.update()
        self.time += self.step


def _problem(make_scene: Make, boundary: str) -> Problem:
    scene = make_scene(3, boundary, SMOOTH)
    model = rodgen.build(scene)
    p = model.parameters(**scene.parameters)
    y = scene.initial_state()
    return lambda t, state: model.rhs(t, state, p), y, p


def _end(advance: Callable[..., Array], rhs: Rhs, y: Array, span: float, count: int) -> Array:
    h = span / count
    for i in range(count):
        y = advance(rhs, i * h, y, rhs(i * h, y), h)
    return y


@pytest.mark.parametrize("boundary", ["free", "pinned"])
def test_it_is_the_listing(make_scene: Make, boundary: str) -> None:
    """A free rod too: joint 0 is moved (updateVelocities, updateCoords) as the angles are."""
    rhs, y, _ = _problem(make_scene, boundary)
    listing = Listing(rhs, y, 0.01)
    for _ in range(20):
        listing.step_runge_kutta()
    ours = _end(thesis_runge_kutta.advance, rhs, y, 0.2, 20)
    theirs = np.concatenate((listing.angles, listing.omegas))
    # The same sums in another order.
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12)


@pytest.mark.parametrize("boundary", ["pinned", "free"])
def test_measured_order(make_scene: Make, boundary: str) -> None:
    """Slope of the error against the step, fitted over four steps; the reference is rk4's."""
    rhs, y, _ = _problem(make_scene, boundary)
    exact = _end(rk4.advance, rhs, y, 0.5, 1000)
    counts = np.array([250, 500, 1000, 2000])
    errors = [
        np.abs(_end(thesis_runge_kutta.advance, rhs, y, 0.5, c) - exact).max() for c in counts
    ]
    slope = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(thesis_runge_kutta.ORDER, abs=0.2)


def test_it_damps_what_nothing_damps() -> None:
    """q'' = -q: after a step h the amplitude is sqrt(1 - 5/6 h^2 + 1/3 h^4 - 1/12 h^6), the root
    of the determinant of the step, worked out by hand."""

    def swing(_: float, y: Array) -> Array:
        return np.array([y[1], -y[0]])

    h = 0.1
    columns = [thesis_runge_kutta.advance(swing, 0.0, y, swing(0.0, y), h) for y in np.eye(2)]
    matrix = np.array(columns).T
    by_hand = 1 - 5 / 6 * h**2 + h**4 / 3 - h**6 / 12
    assert np.linalg.det(matrix) == pytest.approx(by_hand, abs=1e-14)
    trace = 2 - 11 / 6 * h**2 + 5 / 6 * h**4 - h**6 / 4 + h**8 / 24
    assert np.trace(matrix) == pytest.approx(trace, abs=1e-14)
