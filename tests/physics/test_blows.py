"""A base whose velocity jumps: blows, events and samples at them, and motions that cannot be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.scene import Scene
from tests.physics.moved_rods import LOOSE, TARGETS, TIGHT, largest, moved_rod
from tests.told import refused


@pytest.mark.parametrize("target", TARGETS)
def test_a_blow_turns_a_link_about_its_centre_of_percussion(target: str) -> None:
    """(m L^2/3) times the change of its rate is (m L/2) sin(phi) times that of the velocity."""
    scene = moved_rod(
        {"x": "max(0, 2*(t - 0.5))"},
        rod={"links": 1, "bending_stiffness": 0.0},
        loads={},
        initial={"phi": 0.7, "omega": 0.4},
        integrate=TIGHT | {"span": [0.0, 1.0], "output_every": 0.25},
    )
    run = rodgen.simulate(scene, target=target, progress=False)
    at = 0.7 + 0.4 * 0.5
    np.testing.assert_allclose(run.phi[2, 0], at, atol=1e-12)
    np.testing.assert_allclose(run.omega[2, 0] - 0.4, 1.5 * 2 * np.sin(at) / 1.5, atol=1e-11)
    assert largest(run.values("energy_balance")) <= 1e-10 * largest(run.work["base"])


@pytest.mark.parametrize("target", TARGETS)
def test_an_event_that_a_blow_passes_happens_then(target: str) -> None:
    """The rate jumps from 0 to -1.5 * 0.7 / 1.5."""
    event = {"quantity": "omega_0", "value": -0.5, "action": "stop"}
    scene = moved_rod(
        {"x": "max(0, 0.7*(t - 0.5))"},
        rod={"links": 1, "bending_stiffness": 0.0},
        initial={"phi": -np.pi / 2},
        events=[event],
    )
    run = rodgen.simulate(scene, target=target, progress=False)
    (met,) = run.events
    assert (met.t, run.t[-1]) == (0.5, 0.5)
    np.testing.assert_allclose(run.omega[-1, 0], -0.7, atol=1e-11)


def _hit(at: float, **tables: Any) -> Scene:
    """A link along x, whose pivot is hit upwards at a time."""
    rod = {"links": 1, "bending_stiffness": 0.0} | tables.pop("rod", {})
    span = LOOSE | {"span": [0.0, 0.6]}
    base = {"y": f"max(0, 0.7*(t - {at!r}))"}
    return moved_rod(base, rod=rod, initial={"phi": 0.0}, loads={}, integrate=span, **tables)


TANK = [{"name": "tank", "at": 1.0, "mass": "4.0 if t < 0.5 else 1.0"}]


@pytest.mark.parametrize(
    "masses",
    [
        {"bodies": TANK},
        {"rod": {"mass": None, "mass_per_length": "2 if t < 0.5 else 1"}},
        # Half of the link is lost within the blow, half of it not.
        {"rod": {"mass": None, "mass_per_length": "(2 if s < 0.5 else 1) if t < 0.5 else 1"}},
    ],
)
def test_a_blow_as_a_mass_jumps_is_refused(masses: dict[str, Any]) -> None:
    found = refused(rodgen.simulate, _hit(0.5, **masses), progress=False)
    assert (found.field, found.numbers[-1]) == ("base.y", 0.5)
    both = rodgen.simulate_many(_hit(0.5, **masses), {"initial.phi": [0, 1]})
    assert all(why.startswith("base_y = ") for why in both.message.values())


@pytest.mark.parametrize(("at", "mass"), [(0.5 - 1e-6, 4.0), (0.5 + 1e-6, 1.0)])
def test_a_blow_beside_a_jump_of_a_mass_is_that_of_the_mass_then(at: float, mass: float) -> None:
    """(M/3 + m) L w + (M/2 + m) v = 0; what leaves later takes its share of the momentum along."""
    run = rodgen.simulate(_hit(at, bodies=TANK), target="numpy", progress=False)
    expected = -(1 + mass) / (2 / 3 + mass) * 0.7 / 1.5
    np.testing.assert_allclose(run.omega[-1, 0], expected, rtol=1e-6)


@pytest.mark.parametrize(("boundary", "key"), [("clamped", "x"), ("cantilever", "angle")])
def test_a_blow_is_the_limit_of_a_short_push(boundary: str, key: str) -> None:
    """A push over 1e-5 s moves the rod by less than its share of the speed in that time."""
    blow = "0.6*max(0, t - 0.5)"
    push = "0.3*(t - 0.5) + 0.3*sqrt((t - 0.5)**2 + 1e-11)"
    sharp, soft = (
        rodgen.simulate(
            moved_rod({key: text}, boundary, integrate=LOOSE), target="numpy", progress=False
        )
        for text in (blow, push)
    )
    np.testing.assert_allclose(sharp.phi, soft.phi, rtol=0, atol=2e-4)
    work, other = (run.work["base"][-1] for run in (sharp, soft))
    assert abs(work - other) < 2e-4 * max(1.0, abs(work))


def test_states_between_samples_have_the_blows() -> None:
    scene = moved_rod({"x": "0.3*abs(sin(4*t))"}, integrate=LOOSE)
    run = rodgen.simulate(scene, target="numpy", progress=False)
    times = [0.77, 0.786, 0.834]
    fine = rodgen.simulate(scene, target="numpy", progress=False, t_eval=times)
    np.testing.assert_allclose(run(np.array(times)).T, fine.y, rtol=0, atol=1e-7)


# What cannot be --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("base", "boundary", "field"),
    [
        ({"x": "1 if t > 1 else 0"}, "pinned", "base.x"),
        ({"y": "interp(t, [0, 1, 2], [0, 1, 0])"}, "pinned", "base.y"),
        ({"x": "1/(t - 1)"}, "pinned", "base.x"),
        ({"x": "sqrt(t)"}, "pinned", "base.x"),
        ({"x": "t**1.5"}, "pinned", "base.x"),
        ({"x": "phi(1)"}, "pinned", "base.x"),
        ({"angle": "t"}, "pinned", "base.angle"),
        ({"x": "t"}, "free", "base"),
        ({}, "pinned", "base"),
        ({"x": float("inf")}, "pinned", "base.x"),
    ],
)
def test_motions_that_cannot_be_are_refused(
    base: dict[str, Any], boundary: str, field: str
) -> None:
    initial: dict[str, Any] = {"initial": {"phi": 0.1}}
    assert refused(moved_rod, base, boundary, **initial).field == field


def test_tangents_of_a_blow_are_refused() -> None:
    scene = moved_rod({"x": "0.1*abs(sin(4*t))"})
    assert refused(rodgen.floquet, scene).field == "base.x"
    assert refused(rodgen.find_cycle, scene).field == "base.x"
    assert refused(rodgen.lyapunov_exponents, scene).field == "base.x"
