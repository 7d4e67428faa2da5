"""Loads all along the rod, a thrust or a pressure, drag against a medium with a wind, and couples:
Newton's law for the whole, terminal speed, and work that is energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen.check.module_check import check_module
from rodgen.integrate import simulate
from rodgen.loading import build
from rodgen.scene import Scene
from rodgen.scene.structure import Structure
from tests.sets import sets
from tests.told import refused


def _rod(loads: dict[str, Any], **tables: Any) -> Scene:
    rod = {"links": 5, "length": 2.0, "mass": 3.0, "bending_stiffness": 20.0}
    return Scene.from_dict({"name": "rod", "rod": rod, "loads": loads} | tables)


def _pushed(force: Any, **tables: Any) -> Scene:
    return _rod({"distributed_follower": {"force_per_length": force}}, **tables)


@pytest.mark.parametrize(
    ("force", "total"),
    # In closed form: five Gauss points integrate polynomials to degree 9 exactly.
    [(7.0, 14.0), ("a*s**9", 5.0), ([1.0, 2.0, 3.0, 4.0, 5.0], 6.0)],
)
def test_a_straight_free_rod_is_pushed_along_itself(force: Any, total: float) -> None:
    scene = _pushed(force, parameters={"a": 25.0}, initial={"phi": 0.3})
    model, y = build(scene), scene.initial_state()
    p = model.parameters(**scene.parameters)
    rates = model.rhs(0.0, y, p)[len(y) // 2 :]
    push = -total * np.array([np.cos(0.3), np.sin(0.3)])
    np.testing.assert_allclose(rates[:2], push / 3.0, rtol=1e-13)
    assert np.abs(rates[2:]).max() < 1e-12 * total
    forces = model.forces(0.0, y, p)["distributed_follower"]
    np.testing.assert_allclose(forces.sum(axis=0), push, rtol=1e-13)


def test_what_is_no_force_along_the_rod_is_refused() -> None:
    for force in ("1/max(0, s - 0.5)", "phi(0.5)", "x", [1.0, 2.0], float("nan"), None):
        told = refused(lambda force=force: _pushed(force).parameters)
        assert told.field == "loads.distributed_follower.force_per_length"


BURN = "a*s**2*min(t/0.2, 1)"


def test_it_may_change_with_time_and_place() -> None:
    """A straight free rod: M v = -the integral of a/3 L min(t/0.2, 1), a parabola and a line."""
    scene = _pushed(BURN, parameters={"a": 9.0}, integrate={"span": [0, 0.5], "rtol": 1e-10})
    assert scene.breaks() == [pytest.approx(0.2, rel=1e-15)]
    assert scene.structure.hash == _pushed(BURN, parameters={"a": 8.0}).structure.hash
    sol = simulate(scene)
    t = sol.t
    impulse = 6.0 * np.where(t < 0.2, t**2 / 0.4, t - 0.1)
    half = sol.y.shape[1] // 2
    np.testing.assert_allclose(sol.y[:, half], -impulse / 3.0, atol=1e-9)
    assert sol.energy_error < 1e-9


@pytest.mark.parametrize("form", sets([], slow=["dense"], nightly=["chain"]))
def test_its_module_equals_fifty_digit_arithmetic(form: str) -> None:
    expressions = (("distributed_follower", "q0*(1 - s)*sin(w*t) + max(s, t)"),)
    # Beside a force with more power: its own is next to none where the rod is straight.
    terms = ("follower", "distributed_follower")
    structure = Structure(3, "clamped", "uniform", terms, expressions)
    assert max(d.error for d in check_module(build(structure, "numpy", form), states=2)) < 1e-12


@pytest.mark.slow
@pytest.mark.compiler
def test_lanes_take_numbers_of_their_own() -> None:
    expressions = (("distributed_follower", "q0*(1 - s)*sin(w*t)"),)
    structure = Structure(3, "clamped", "uniform", ("distributed_follower",), expressions)
    one, other = build(structure), build(structure, "c")
    P = np.array([[1.0, 2.0, 30.0, 0.0, q, 3.0] for q in range(9)])
    Y = np.random.default_rng(1).standard_normal((9, 6))
    single = [one.rhs(0.4, y, p) for y, p in zip(Y, P, strict=True)]
    # Other orders of the same sums.
    np.testing.assert_allclose(other.rhs_batch(0.4, Y, P), single, rtol=1e-11, atol=1e-11)
    J = one.jac(0.4, Y[0], P[5])
    np.testing.assert_allclose(other.jac(0.4, Y[0], P[5]), J, rtol=0, atol=1e-11 * np.abs(J).max())


# Drag ------------------------------------------------------------------------------------------

M, L, G, NORMAL = 3.0, 2.0, 9.81, 0.4
TERMINAL = np.sqrt(M * G / (NORMAL * L))


def test_a_level_rod_falls_to_its_terminal_speed() -> None:
    """M dv/dt = -M g + c_n L (v - w)^2 across it, M dv/dt = c_t L (v - w)^2 along it, v < w; the
    drag of a link lies as its weight does, so that nothing bends it."""
    c_t, wind = 0.1, (3.0, -2.0)
    drag = {"normal": NORMAL, "tangential": c_t, "wind": list(wind)}
    scene = _rod(
        {"drag": drag, "gravity": {"g": G}},
        initial={"velocity": [0.0, wind[1]]},
        integrate={"span": [0.0, 3.0], "rtol": 1e-11, "atol": 1e-13},
    )
    sol = simulate(scene)
    across = wind[1] - TERMINAL * np.tanh(G * sol.t / TERMINAL)
    along = wind[0] - 1 / (1 / wind[0] + c_t * L / M * sol.t)
    v = sol.y[:, sol.y.shape[1] // 2 :][:, :2]
    np.testing.assert_allclose(v, np.stack((along, across), -1), rtol=0, atol=1e-9)
    assert np.abs(sol.phi).max() < 1e-9
    assert abs(v[-1, 1] - wind[1] + TERMINAL) < 0.01 * TERMINAL
    assert sol.energy_error < 1e-8


def test_what_is_no_drag_is_refused() -> None:
    for drag, field in (
        ({"normal": -1.0}, "normal"),
        ({"wind": [1.0]}, "wind"),
        ({"wind": [1.0, "x*t"]}, "wind.1"),
        ({"wind": [1.0, float("nan")]}, "wind.1"),
        ({"wind": 3.0}, "wind"),
    ):
        for kind in ("drag", "viscous_drag"):
            assert refused(_rod, {kind: drag}).field == f"loads.{kind}.{field}"


def test_a_level_rod_in_a_viscous_medium() -> None:
    """M dv/dt = -M g - c_n L (v - w) across it, M dv/dt = -c_t L (v - w) along it; the drag of a
    link lies as its weight does, so that nothing bends it."""
    c_t, wind = 0.1, (3.0, -2.0)
    drag = {"normal": NORMAL, "tangential": c_t, "wind": list(wind)}
    tight = {"span": [0.0, 3.0], "rtol": 1e-11, "atol": 1e-13}
    sol = simulate(_rod({"viscous_drag": drag, "gravity": {"g": G}}, integrate=tight))
    terminal, fade = M * G / (NORMAL * L), np.exp(-NORMAL * L / M * sol.t)
    across = wind[1] - terminal + (terminal - wind[1]) * fade
    along = wind[0] * (1 - np.exp(-c_t * L / M * sol.t))
    v = sol.y[:, sol.y.shape[1] // 2 :][:, :2]
    np.testing.assert_allclose(v, np.stack((along, across), -1), rtol=0, atol=1e-9)
    assert np.abs(sol.phi).max() < 1e-9
    assert sol.energy_error < 1e-9


# A pressure ------------------------------------------------------------------------------------


def test_a_pressure_pushes_every_link_to_one_side() -> None:
    """At -pi/2 to the left: of a rod that is a half circle, along the diameter at right angles to
    the chord alone, and with what the whole chord would feel."""
    ring = {"phi": [np.pi * (k + 0.5) / 5 for k in range(5)]}
    push = {"force_per_length": 7.0, "angle": -np.pi / 2}
    scene = _rod({"distributed_follower": push}, initial=ring)
    model, y = build(scene), scene.initial_state()
    p = model.parameters(**scene.parameters)
    chord = np.subtract(*model.joints(y, p)[[-1, 0]])
    forces = model.forces(0.0, y, p)["distributed_follower"]
    np.testing.assert_allclose(forces.sum(axis=0), 7.0 * chord @ [[0, 1], [-1, 0]], atol=1e-14)


def test_a_module_has_the_angle_where_a_scene_has_it() -> None:
    """Also an angle of zero, which can be varied; without a key the module is that without one."""
    push = {"force_per_length": 7.0}
    angles: tuple[dict[str, Any], ...] = ({}, {"angle": 0.0}, {"angle": "0.0*t"})
    scenes = [_rod({"distributed_follower": push | angle}) for angle in angles]
    bare, level, swung = scenes
    name = "distributed_follower_angle"
    assert bare.structure.terms == ("distributed_follower",)
    assert name not in bare.structure.parameters
    assert name in level.structure.parameters
    assert name in dict(swung.structure.expressions)
    y = np.random.default_rng(1).standard_normal(len(bare.initial_state()))
    rates = [build(one).rhs(0.5, y, build(one).parameters(**one.parameters)) for one in scenes]
    np.testing.assert_allclose(rates[1:], [rates[0]] * 2, rtol=0, atol=1e-12 * abs(rates[0]).max())


# Couples ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("moment", "law"),
    [(0.7, lambda t: 0.7 * t), ("0.7*sin(3*t)", lambda t: 0.7 * (1 - np.cos(3 * t)) / 3)],
    ids=["constant", "in time"],
)
def test_a_couple_turns_a_free_rod(moment: Any, law: Any) -> None:
    """Its angular momentum is the integral of the couple, wherever that acts; its centre rests. A
    constant couple has a potential, of another the work is counted."""
    tight = {"span": [0.0, 2.0], "rtol": 1e-11, "atol": 1e-13}
    sol = simulate(_rod({"moment": {"moment": moment, "at": 0.3}}, integrate=tight))
    np.testing.assert_allclose(sol.values("angular_momentum"), law(sol.t), rtol=0, atol=1e-9)
    assert np.abs(sol.centre_of_gravity - sol.centre_of_gravity[0]).max() < 1e-9
    exchange = np.abs(sol.values("kinetic_energy")).max()
    turned = sol.phi[:, 1] - sol.phi[0, 1]  # of the link on which it acts
    if isinstance(moment, str):
        assert set(sol.work) == {"moment"}
        assert not sol.values("gravity_energy").any()
    else:
        assert not sol.work
        np.testing.assert_allclose(sol.values("gravity_energy"), -moment * turned, atol=1e-14)
    assert np.abs(sol.values("energy_balance")).max() < 1e-9 * exchange


def test_a_couple_on_a_held_link_does_no_work() -> None:
    rod = {"links": 5, "length": 2.0, "mass": 3.0, "bending_stiffness": 20.0}
    rod |= {"boundary": "cantilever"}
    table = {"name": "held", "rod": rod, "loads": {"moment": {"moment": "3*t", "at": 0.1}}}
    sol = simulate(Scene.from_dict(table | {"integrate": {"span": [0.0, 0.5]}}))
    assert not sol.phi.any()
    assert not sol.work
