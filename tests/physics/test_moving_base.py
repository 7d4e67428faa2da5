"""A base that moves: frames that accelerate, given swings, shaken pivots, and their work."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import rodgen
from rodgen.loading import build
from rodgen.scene import Scene
from tests.physics.moved_rods import HELD, LOOSE, TARGETS, largest, moved_rod
from tests.told import refused

G = 9.81


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("boundary", HELD)
def test_a_frame_that_accelerates_is_gravity_against_it(boundary: str, target: str) -> None:
    """At random states, to rounding; its acceleration is differentiated by hand."""
    moved = moved_rod({"x": "0.3*sin(4*t)", "y": "0.2*t**3 - exp(-t)"}, boundary)
    falls = {"acceleration": ["4.8*sin(4*t)", "-9.81 - 1.2*t + exp(-t)"]}
    frame = moved_rod(None, boundary, loads={"gravity": falls})
    one, other = (build(scene, target) for scene in (moved, frame))
    p, q = (rodgen.System(scene).p for scene in (moved, frame))
    draw = np.random.default_rng(3)
    for t in (0.0, 0.7, 1.9):
        y = draw.normal(size=len(one.STATE))
        expected = other.rhs(t, y, q)
        assert largest(one.rhs(t, y, p) - expected) <= 1e-12 * largest(expected)


def test_a_swing_that_is_given_turns_a_link_by_its_spring_and_damper() -> None:
    """I phi'' = -k (phi - A) - c (phi' - A') - (m g L/2) cos(phi), by another integrator."""
    m, L, EI, tau, I = 2.0, 1.5, 4.0, 0.03, 1.5
    k = 2 * EI / L
    scene = moved_rod(
        {"angle": "0.8*sin(3*t)"},
        "clamped",
        rod={"links": 1, "clamp_angle": 0.2},
        loads={"gravity": {}, "material_damping": {"time": tau}},
        initial={"phi": 0.1, "omega": 1.0},
    )

    def rates(t: float, y: NDArray[np.float64]) -> list[float]:
        off, slip = y[0] - 0.2 - 0.8 * np.sin(3 * t), y[1] - 2.4 * np.cos(3 * t)
        moment = -k * (off + tau * slip) - m * G * L / 2 * np.cos(y[0])
        return [y[1], moment / I]

    run = rodgen.simulate(scene, target="numpy", progress=False)
    exact = solve_ivp(rates, (0, 2), [0.1, 1.0], "DOP853", run.t, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(run.phi[:, 0], exact.y[0], rtol=0, atol=1e-10)


def test_a_held_link_swings_a_pendulum_at_its_end() -> None:
    """The equation of a pendulum whose pivot moves on a circle, from its accelerations."""
    l, A, w = 0.75, 0.8, 3.0
    scene = moved_rod(
        {"angle": f"{A}*sin({w}*t)"},
        "cantilever",
        rod={"links": 2, "bending_stiffness": 0.0},
        initial={"phi": -1.0},
    )

    def rates(t: float, y: NDArray[np.float64]) -> list[float]:
        a, da, dda = A * np.sin(w * t), A * w * np.cos(w * t), -A * w * w * np.sin(w * t)
        ax = -l * (np.sin(a) * dda + np.cos(a) * da**2)
        ay = l * (np.cos(a) * dda - np.sin(a) * da**2)
        return [y[1], 1.5 / l * (ax * np.sin(y[0]) - (ay + G) * np.cos(y[0]))]

    run = rodgen.simulate(scene, target="numpy", progress=False)
    exact = solve_ivp(rates, (0, 2), [-1.0, 0.0], "DOP853", run.t, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(run.phi[:, 1], exact.y[0], rtol=0, atol=1e-9)
    held, rate = A * np.sin(w * run.t), A * w * np.cos(w * run.t)
    np.testing.assert_allclose(run.phi[:, 0], held, atol=1e-15)
    np.testing.assert_allclose(run.omega[:, 0], rate, atol=1e-14)


LOADS = {
    "gravity": {"g": "9.81*(1 + 0.1*sin(t))"},
    "drag": {"normal": 0.4, "tangential": 0.1, "wind": [1.0, 0.5]},
    "follower": {"force": "1 + t", "at": 0.2},
    "material_damping": {"time": 0.01},
    "distributed_follower": {"force_per_length": 0.7},
    "moment": {"moment": 0.3, "at": 0.1},
}
MOTIONS: list[tuple[str, dict[str, str]]] = [
    ("pinned", {"x": "0.2*sin(5*t)", "y": "0.1*t**2"}),
    ("clamped", {"y": "0.2*cos(4*t)", "angle": "0.5*sin(3*t)"}),
    ("cantilever", {"x": "0.2*t", "angle": "0.5*sin(3*t)"}),
    ("cantilever", {"y": "interp(t, [0, 0.5, 1, 2], [0, 0.2, 0.1, 0.3], 'cubic')"}),
]


@pytest.mark.parametrize(("boundary", "base"), MOTIONS)
def test_work_of_the_base_balances_and_is_that_of_the_joint_forces(
    boundary: str, base: dict[str, str]
) -> None:
    """Against the forces that the other form of derivation 3 finds in the joints."""
    run = rodgen.simulate(moved_rod(base, boundary, loads=LOADS), target="numpy", progress=False)
    exchanged = max(map(largest, run.work.values()))
    assert exchanged > 0.1
    assert largest(run.values("energy_balance")) <= 1e-9 * exchanged
    if boundary == "cantilever":  # whose first joint with a force is at the end of link 0
        return
    velocity = run.values("velocities")["start"]
    power = (run.values("reaction") * velocity).sum(axis=-1)
    if boundary == "clamped":
        power += run.values("reaction_moment") * 1.5 * np.cos(3 * run.t)
    np.testing.assert_allclose(run.values("power_base"), power, rtol=0, atol=1e-9)


def test_velocities_are_absolute() -> None:
    """Of the tail and the centre of gravity, by differences over the samples of a run."""
    scene = moved_rod({"x": "0.2*t", "angle": "0.5*sin(3*t)"}, "cantilever")
    run = rodgen.simulate(scene, target="numpy", progress=False, output_every=1e-3)
    for place, speed in (("tip", "tip_velocity"), ("centre_of_gravity", "centre_velocity")):
        x, v = run.values(place), run.values(speed)
        steps = (x[2:] - x[:-2]) / 2e-3
        np.testing.assert_allclose(v[1:-1], steps, rtol=0, atol=1e-3)  # h^2/6 times x'''


# A pivot that shakes ---------------------------------------------------------------------------

SPEED = 100.0  # rad/s


def _on_its_head(a: float, **tables: Any) -> Scene:
    rod = {"links": 1, "length": 1.0, "mass": 1.0, "bending_stiffness": 0.0}
    return moved_rod({"y": f"{a!r}*cos({SPEED!r}*t)"}, "pinned", rod=rod, **tables)


def _least_by_hill() -> float:
    """The least amplitude by Hill's determinant: of phi'' = (3/2) (g - a w^2 cos(w t)) phi the
    motion of the period of the pivot that neither grows nor decays, as a Fourier series."""

    def determinant(a: float) -> float:
        n = np.arange(-6, 7)
        matrix = np.diag(-((n * SPEED) ** 2) - 1.5 * G)
        beside = np.full(len(n) - 1, 1.5 * a * SPEED**2 / 2)
        matrix = matrix + np.diag(beside, 1) + np.diag(beside, -1)
        return float(np.linalg.det(matrix / (1 + np.abs(n[:, None]) * SPEED) ** 2))

    return float(brentq(determinant, 0.03, 0.04, xtol=1e-15))


def test_a_rod_stands_on_its_head_from_hills_amplitude_on() -> None:
    least = _least_by_hill()
    assert abs(least - 0.0361895552) < 1e-10  # as published for this rod

    def excess(a: float) -> float:  # of the trace over 2, which is linear there
        scene = _on_its_head(a, initial={"phi": np.pi / 2})
        return float(np.sum(rodgen.floquet(scene).multipliers).real) - 2

    assert abs(brentq(excess, 0.0361, 0.0363, xtol=1e-12) - least) < 1e-8

    def excess_of_run(a: float) -> float:
        """Small angles after whole periods are a sequence whose members next to one have the trace
        for a factor."""
        period = 2 * np.pi / SPEED
        scene = _on_its_head(a, initial={"phi": np.pi / 2 + 1e-5})
        run = rodgen.simulate(
            scene, target="numpy", progress=False, span=(0, 2 * period), output_every=period
        )
        before, here, after = run.phi[:, 0] - np.pi / 2
        return float((before + after) / here) - 2

    assert abs(brentq(excess_of_run, 0.0361, 0.0363, xtol=1e-9) - least) < 1e-4 * least


def test_the_motion_that_leans_beside_the_upright_is_told_by_its_amplitude() -> None:
    """It trembles by (3/2) (a/L) cos(phi) of the mean phi, to first order in a/L (Kapitza)."""
    a = 0.037
    leaning = rodgen.floquet(_on_its_head(a, initial={"phi": np.pi / 2 + 0.3}))
    mean = leaning.y[0] - leaning.amplitude  # at the highest point of the pivot it leans most
    assert abs(leaning.amplitude / (-1.5 * a * np.cos(mean)) - 1) < a
    assert not leaning.stable
    upright = rodgen.floquet(_on_its_head(a, initial={"phi": np.pi / 2}))
    assert (upright.amplitude, upright.stable) == (0.0, True)


# At one time -----------------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", ["clamped", "cantilever"])
def test_modes_at_a_time_count_place_and_acceleration(boundary: str) -> None:
    """Of a lift: more gravity. The speed does not count, nor does an angle that grows evenly."""
    ground = {"foundation": {"stiffness": 3.0}}
    lifted = moved_rod({"y": "1.5*t**2 + t", "x": "0.4*t", "angle": "0.1*t"}, boundary, **ground)
    still = moved_rod(
        None,
        boundary,
        rod={"clamp_angle": 0.15},
        loads={"gravity": {"g": G + 3.0}},
    )
    without = lifted.replace({"foundation": None})
    found = rodgen.natural_modes(without, t=1.5)
    expected = rodgen.natural_modes(still)
    np.testing.assert_allclose(found.frequencies, expected.frequencies, rtol=1e-10)
    assert "not its speed" in str(found)
    # The ground stays where it was: the foundation pulls the rod that has gone 0.6 and 4.9 m away.
    rest = rodgen.static_equilibrium(lifted, t=1.5).phi
    assert rest[-1] < rodgen.static_equilibrium(still).phi[-1] - 0.1


@pytest.mark.parametrize("boundary", HELD)
def test_a_base_at_one_time_is_that_of_the_equations_where_it_has_no_speed(boundary: str) -> None:
    base = {"x": "0.7*(t - 1)**2", "y": "0.2 - 0.4*(t - 1)**2"}
    if boundary != "pinned":
        base["angle"] = "0.3 + 1.1*(t - 1)**3"
    system = rodgen.System(moved_rod(base, boundary, foundation={"stiffness": 3.0}))
    frozen = system.steady(1.0)
    y = np.zeros(len(system.y0))
    y[: len(y) // 2] = np.linspace(0.1, 0.9, len(y) // 2)
    rates = [one.model("numpy").rhs(1.0, y, one.p) for one in (system, frozen)]
    np.testing.assert_allclose(rates[1], rates[0], rtol=1e-13)


def test_gravity_is_not_scaled_where_the_base_accelerates() -> None:
    lift = moved_rod({"y": "1.5*t**2"}, "clamped", rod={"clamp_angle": np.pi / 2}, initial={})
    assert refused(rodgen.critical_load, lift, load="gravity").field == "base"
    even = lift.replace({"base.y": "1.5*t"})
    assert rodgen.critical_load(even, load="gravity").value > 0


# On the ground ---------------------------------------------------------------------------------


def test_sensors_and_supports_are_on_the_ground() -> None:
    """A spring from the middle of the held link to the ground, and a thrust by what a sensor there
    measures, do nothing but what the place of the base says."""
    base = {"x": "0.3*sin(2*t)", "angle": "0.4*sin(t)"}
    felt = {"tip": {"y": "0.5*vy(0.25) + x(0.25)"}, "gravity": {}}
    scene = moved_rod(base, "cantilever", rod={"links": 2}, loads=felt)
    run = rodgen.simulate(scene, target="numpy", progress=False)
    a, da = 0.4 * np.sin(run.t), 0.4 * np.cos(run.t)
    signals = run.values("signals")
    np.testing.assert_allclose(signals["x(0.25)"], 0.3 * np.sin(2 * run.t) + 0.375 * np.cos(a))
    np.testing.assert_allclose(signals["vy(0.25)"], 0.375 * np.cos(a) * da, rtol=0, atol=1e-14)
    held = [{"at": 0.75, "stiffness": [3.0, 2.0]}]
    pulled = moved_rod(base | {"y": "1 + t**2"}, "clamped", supports=held, loads={})
    assert pulled.anchors.fixed_point(pulled.supports[0]) == pytest.approx((1.125, 1.0))
    still = moved_rod(None, "clamped", foundation={"stiffness": 3.0, "through": [5.0, 0.7]})
    there = pulled.replace({"supports": None, "foundation": {"stiffness": 3.0}})
    lines = [scene.anchors.foundation_line for scene in (still, there)]
    np.testing.assert_allclose(lines[0], [[5.0, 0.7], [6.5, 0.7]])
    np.testing.assert_allclose(lines[1], [[0.0, 1.0], [1.5, 1.0]])


def test_numbers_of_a_base_go_into_p_where_nothing_else_follows_from_them() -> None:
    """Of a clamp the state at the start does, and of a law that compares, whether it jumps."""
    on_head = rodgen.System(_on_its_head(0.05))
    more = on_head.at({"base.y.0": 0.06})
    assert more.structure is on_head.structure
    assert more.scene.base.y == "0.06*cos(100.0*t)"
    assert more.parameter("base_y_1") == 0.06
    held = rodgen.System(moved_rod({"angle": "0.3 + 0.1*t"}, "clamped", initial={}))
    assert held.at({"base.angle.0": 0.5}).y0[0] == 0.5
    later = held.with_settings(span=[1.0, 3.0])
    np.testing.assert_array_equal(later.y0, rodgen.System(later.scene).y0)
    assert later.y0[0] == 0.4
    jumps = rodgen.System(moved_rod({"x": "t if t < 1 else 1"}))
    assert refused(jumps.at, {"base.x.1": 2.0}).field == "base.x"


def test_events_know_where_the_base_is() -> None:
    base = {"x": "0.2*t", "angle": "0.4*sin(t)"}
    events = [{"quantity": "tip_x", "value": 1.6}]
    scene = moved_rod(base, "cantilever", events=events, initial={}, integrate=LOOSE)
    run = rodgen.simulate(scene, target="numpy", progress=False)
    assert run.events
    for one in run.events:
        there = run.model.joints(one.y, run.system.p, one.t)[-1, 0]
        np.testing.assert_allclose(there, 1.6, atol=1e-12)
