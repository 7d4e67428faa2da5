"""Linearisation about a rod in flight: against differences of the generated right-hand side, the
rod without external damping, and runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.critical import Critical, critical_load
from rodgen.analyse.modes import Modes, natural_modes
from rodgen.analyse.scene_family import load_family
from rodgen.analyse.simulated_critical import (
    SimulatedCritical,
    find_difference,
    simulated_critical_load,
)
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.analyse.steady_state import find_steady_state
from rodgen.arrays import Array
from rodgen.scene import Scene
from rodgen.scene.mesh import mesh_notes
from tests.analyse.rods import rod
from tests.told import numbers

SPEED = 1.0  # m/s
# Of second order are c_ext s times NUDGE times SPEED or over it; roundings are 1e-16 over it.
NUDGE = 1e-7
FINS = {"nose": 1.0, "body": 1.0, "tail": 20.0}
DRAG: dict[str, Any] = {"external_damping": {"coefficient": 0.5, "fin_factor": FINS}}
BARE: dict[str, Any] = {"follower": {"force": 50.0}, "internal_damping": {"coefficient": 0.2}}
PUSHED = BARE | DRAG


def of_speed(found: Modes | Critical) -> list[str]:
    """Notes of a result that tell of the speed, not of the number of links."""
    return [
        str(note)
        for note in found.notes
        if note.text not in mesh_notes(found.scene) and "growth" not in note.figures
    ]


def flying(
    along: float, across: float = 0.0, angle: float = 2.0, loads: Any = None, **tables: Any
) -> Scene:
    """A free rod of four links at an angle, with an initial velocity [m/s] along and across it."""
    c, s = np.cos(angle), np.sin(angle)
    velocity = [-along * c + across * s, -along * s - across * c]
    initial = {"phi": angle, "velocity": velocity} | tables.pop("initial", {})
    return rod(4, "free", loads or PUSHED, initial=initial, **tables)


def _motions(scene: Scene) -> tuple[Array, Array, Array]:
    """Eigenvalues, angles and displacements across the rod of joint 0, of all small motions, by
    central differences of the right-hand side."""
    system = SteadyRod.of(scene)
    state = find_steady_state(system)
    y = system.state_in_flight(state.at)
    columns = [
        (system.model.rhs(0.0, y + d, state.p) - system.model.rhs(0.0, y - d, state.p))
        for d in NUDGE * np.eye(len(y))
    ]
    s, vectors = np.linalg.eig(np.column_stack(columns) / (2 * NUDGE))
    across = np.array([-np.sin(state.phi[0]), np.cos(state.phi[0])])
    return s, vectors[2 : 2 + system.n_moving], across @ vectors[:2]


@pytest.mark.parametrize(("speed", "angle"), [(SPEED, 2.0), (0.0, 0.0)])
def test_modes_by_differences(speed: float, angle: float) -> None:
    """In flight, and at rest: there drag is linear across the rod, and joint 0 moves as it
    brakes."""
    scene, rel = flying(speed, angle=angle), 1e-5
    found = natural_modes(scene)
    assert found.speed == pytest.approx(speed, rel=1e-9)
    assert len(of_speed(found)) == (speed == 0.0)  # rest is said
    s, angles, base = _motions(scene)
    n, length = scene.rod.links, scene.rod.length
    normal = np.diff(found.joints, axis=0)[0] @ np.array([[0.0, 1.0], [-1.0, 0.0]]) * n / length
    for rate, moved in zip(
        found.growth + 2j * np.pi * found.frequencies, found.displacements, strict=True
    ):
        at = int(np.abs(s - rate).argmin())
        assert abs(s[at] - rate) <= rel * abs(rate)
        steps = np.concatenate(([base[at]], angles[:, at] * length / n))
        shape, other = np.cumsum(steps), moved @ normal
        most = int(np.abs(shape).argmax())
        np.testing.assert_allclose(other / other[most], shape / shape[most], atol=rel)


def test_in_flight_external_damping_brakes_nothing() -> None:
    """Across the rod its force is of second order, at any speed along it; without it, or of a rod
    that is held, nothing is said of the speed."""
    other = critical_load(rod(4, "free", BARE))
    for speed in (1e-3, -20.0, 300.0):
        found = critical_load(rod(4, "free", PUSHED), speed=speed)
        # 1e-9: what Newton's method leaves; the matrices are the same but for roundings.
        assert found.value == pytest.approx(other.value, rel=1e-9)
        assert (found.speed, of_speed(found), found.turning) == (speed, [], 0.0)
    assert of_speed(natural_modes(rod(4, "free", BARE))) == []
    held = natural_modes(rod(3, "clamped", {"follower": {"force": 5.0}, **DRAG}))
    assert (held.speed, of_speed(held)) == (0.0, [])


@pytest.mark.parametrize(
    ("along", "across", "of_attack"),
    [
        (-7.0, 0.0, None),
        (20.0, 1.0, None),
        (20.0, 20.0 * np.tan(np.pi / 6), 30.0),
        (0.0, 20.0, 90.0),
    ],
)
def test_speed_of_the_initial_state(along: float, across: float, of_attack: float | None) -> None:
    """An angle of attack of 3 degrees is still flight along the axis, one of 30 is said; a speed
    that is given is the one that counts."""
    found = natural_modes(flying(along, across))
    assert found.speed == pytest.approx(along, rel=1e-12, abs=1e-12)
    said = of_speed(found)
    assert len(said) == (of_attack is not None)
    assert of_attack is None or of_attack in numbers(said[0])
    given = natural_modes(flying(20.0, 20.0), speed=5.0)
    assert (given.speed, of_speed(given)) == (5.0, [])


def test_speed_of_a_spinning_rod_is_that_of_its_centre() -> None:
    """Joint 0 moves across at omega L/2, which the centre does not."""
    system = SteadyRod.of(flying(20.0, 3.0 * 2.5, initial={"omega": 3.0}))
    # Differences over 1e-5 s of positions of size 1.
    assert system.speed == pytest.approx(20.0, abs=1e-8)
    assert abs(system.across) < 1e-8


def test_after_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """The state of the run at that time: speed of the centre along the mean angle."""
    monkeypatch.setenv("CC", "no-such-compiler")  # one short run is not worth a compilation
    rising = PUSHED | {"follower": {"force": "200*t"}}
    integrate = {"span": [0.0, 2.0], "rtol": 1e-9, "atol": 1e-11}
    scene = flying(20.0, 2.0, loads=rising, integrate=integrate)
    sol = rodgen.simulate(scene, target="numpy", output_every=0.005)
    at = int(np.searchsorted(sol.t, 1.5 - 1e-9))
    velocity = (sol.centre_of_gravity[at + 1] - sol.centre_of_gravity[at - 1]) / 0.01
    angle = sol.phi[at].mean()
    found = natural_modes(scene, after=1.5)
    # Differences over 0.01 s of a speed that bends with it: 1e-5 of it.
    expected = -velocity @ [np.cos(angle), np.sin(angle)]
    assert found.speed == pytest.approx(expected, rel=1e-4)
    assert found.t == 1.5
    tail_to_nose = found.joints[0] - found.joints[-1]
    along = -scene.rod.length * np.array([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(tail_to_nose, along, atol=1e-6)
    # Loads as at that time.
    steady_loads = PUSHED | {"follower": {"force": 300.0}}
    same = natural_modes(flying(20.0, 2.0, loads=steady_loads), speed=found.speed)
    np.testing.assert_allclose(found.frequencies, same.frequencies, rtol=1e-9)


@pytest.mark.nightly
def test_runs_find_it_too() -> None:
    """Measured growth sees the onset of flutter in damped flight."""
    scene, span = rod(4, "free", PUSHED, mass=20.0), 4.0
    exact = critical_load(scene, speed=20.0).value
    how: dict[str, Any] = {"span": span, "speed": 20.0, "target": "numpy", "tolerance": 4e-3}
    found = simulated_critical_load(scene, bounds=(0.98 * exact, 1.1 * exact), **how)
    assert (found.growth, found.speed) == (None, 20.0)
    # By eigenvalues, growth of 1 % in the span begins between the two; to a tenth, since the drag
    # of a disturbance that is not infinitely small counts.
    rates = (
        load_family(scene, speed=20.0)
        .eigenvalues(np.array([found.low, found.high]))
        .real.max(axis=1)
    )
    assert rates[0] * 0.9 < np.log(1.01) / span < rates[1] * 1.1


def _simulated(force: float, growth: float | None = None) -> SimulatedCritical:
    return SimulatedCritical(force, force, force, 8.0, growth, 1, 0.0, "numpy", 20.0)


def test_doubt() -> None:
    """Of an onset that simulations miss by more than slow growth explains."""
    scene = rod(4, "free", PUSHED)
    flies: Critical = critical_load(scene, speed=20.0)
    family = load_family(scene, speed=20.0)
    assert not [*find_difference(flies.value, _simulated(1.04 * flies.value), family)]
    said = {
        str(one)
        for share, growth, speed in ((1.06, 1e6, 20.0), (0.5, None, 20.0), (1.5, None, 0.0))
        for one in find_difference(
            flies.value,
            _simulated(share * flies.value, growth),
            load_family(scene, speed=speed),
        )
    }
    assert len(said) == 3  # each has a reason of its own
