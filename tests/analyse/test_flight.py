"""Linearisation about a rod in flight: against differences of the generated right-hand side, the
rod without external damping, and runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.critical import Critical, critical_force, family_of
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.growth import SimulatedCritical, doubt, simulated_critical_force
from rodgen.analyse.modes import Modes, natural_modes
from rodgen.analyse.steady import steady
from rodgen.analyse.system import System
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError

Rod = Callable[..., Scene]
SPEED = 1.0  # m/s
# Of second order are c_ext s times NUDGE times SPEED or over it; roundings are 1e-16 over it.
NUDGE = 1e-7
FINS = {"nose": 1.0, "body": 1.0, "tail": 20.0}
DRAG: dict[str, Any] = {"external_damping": {"coefficient": 0.5, "fin_factor": FINS}}
PUSHED: dict[str, Any] = {
    "follower": {"force": 50.0},
    "internal_damping": {"coefficient": 0.2},
    **DRAG,
}


def of_speed(found: Modes | Critical) -> list[str]:
    """Notes of a result that tell of the speed, not of the number of links."""
    return [note for note in found.notes if "number of links" not in note]


@pytest.fixture
def flying(rod: Rod) -> Callable[..., Scene]:
    """A free rod of four links at an angle, with an initial velocity [m/s] along and across it."""

    def make(along: float, across: float = 0.0, angle: float = 2.0, **keys: Any) -> Scene:
        c, s = np.cos(angle), np.sin(angle)
        table = rod(4, "free", keys.pop("loads", PUSHED), **keys).model_dump(exclude_none=True)
        velocity = [-along * c + across * s, -along * s - across * c]
        return Scene.from_dict(table | {"initial": {"phi": angle, "velocity": velocity}})

    return make


def _motions(scene: Scene) -> tuple[Array, Array, Array]:
    """Eigenvalues, angles and displacements across the rod of joint 0, of all small motions, by
    central differences of the right-hand side."""
    system = System.of(scene)
    state = steady(system)
    y = system.flying(state.at)
    columns = [
        (system.model.rhs(0.0, y + d, state.p) - system.model.rhs(0.0, y - d, state.p))
        for d in NUDGE * np.eye(len(y))
    ]
    s, vectors = np.linalg.eig(np.column_stack(columns) / (2 * NUDGE))
    across = np.array([-np.sin(state.phi[0]), np.cos(state.phi[0])])
    return s, vectors[2 : 2 + system.cells], across @ vectors[:2]


def _same_as_differences(found: Modes, scene: Scene, rel: float) -> None:
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


def test_modes_in_flight_by_differences(flying: Callable[..., Scene]) -> None:
    scene = flying(SPEED)
    found = natural_modes(scene)
    assert found.speed == pytest.approx(SPEED, rel=1e-9)
    assert of_speed(found) == []
    assert len(found.frequencies) == 3
    _same_as_differences(found, scene, rel=1e-5)


def test_modes_at_rest_by_differences(flying: Callable[..., Scene]) -> None:
    """Motions across the rod alone: drag is linear there, and joint 0 moves as it brakes."""
    scene = flying(0.0, angle=0.0)
    found = natural_modes(scene)
    assert "at rest" in of_speed(found)[0]
    _same_as_differences(found, scene, rel=1e-5)


@pytest.mark.parametrize("speed", [1e-3, -20.0, 300.0])
def test_in_flight_external_damping_brakes_nothing(rod: Rod, speed: float) -> None:
    """Across the rod its force is of second order, at any speed along it."""
    bare = {name: load for name, load in PUSHED.items() if name not in DRAG}
    found, other = (critical_force(rod(4, "free", loads), speed=speed) for loads in (PUSHED, bare))
    # 1e-9: what Newton's method leaves; the matrices are the same but for roundings.
    assert found.force == pytest.approx(other.force, rel=1e-9)
    assert (found.speed, of_speed(found), found.turning) == (speed, [], 0.0)


def test_speed_of_the_initial_state(flying: Callable[..., Scene]) -> None:
    assert natural_modes(flying(-7.0)).speed == pytest.approx(-7.0, rel=1e-12)
    across = natural_modes(flying(0.0, 20.0))
    assert across.speed == 0.0
    assert "90 degrees" in of_speed(across)[0]
    # An angle of attack of 3 degrees is still flight along the axis, one of 30 is said.
    assert of_speed(natural_modes(flying(20.0, 1.0))) == []
    assert "30 degrees" in of_speed(natural_modes(flying(20.0, 20.0 * np.tan(np.pi / 6))))[0]
    assert of_speed(natural_modes(flying(20.0, 20.0), speed=5.0)) == []


def test_what_does_not_depend_on_speed_says_nothing(rod: Rod) -> None:
    bare = {name: load for name, load in PUSHED.items() if name not in DRAG}
    assert of_speed(natural_modes(rod(4, "free", bare))) == []
    held = natural_modes(rod(5, "clamped", {"follower": {"force": 5.0}, **DRAG}))
    assert (held.speed, of_speed(held)) == (0.0, [])


def test_speed_of_a_spinning_rod_is_that_of_its_centre(flying: Callable[..., Scene]) -> None:
    """Joint 0 moves across at omega L/2, which the centre does not."""
    table = flying(20.0, 3.0 * 2.5).model_dump(exclude_none=True)
    table["initial"]["omega"] = 3.0
    system = System.of(Scene.from_dict(table))
    # Differences over 1e-5 s of positions of size 1.
    assert system.speed == pytest.approx(20.0, abs=1e-8)
    assert abs(system.across) < 1e-8


def test_after_a_run(flying: Callable[..., Scene], monkeypatch: pytest.MonkeyPatch) -> None:
    """The state of the run at that time: speed of the centre along the mean angle."""
    monkeypatch.setenv("CC", "no-such-compiler")  # one short run is not worth a compilation
    table = flying(20.0, 2.0).model_dump(exclude_none=True)
    table["loads"]["follower"]["force"] = "200*t"
    table["integrate"] = {"span": [0.0, 2.0], "rtol": 1e-9, "atol": 1e-11}
    scene = Scene.from_dict(table)
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
    table["loads"]["follower"]["force"] = 300.0
    same = natural_modes(Scene.from_dict(table), speed=found.speed)
    np.testing.assert_allclose(found.frequencies, same.frequencies, rtol=1e-9)


@pytest.mark.parametrize(
    ("boundary", "given", "message"),
    [
        ("clamped", {"speed": 3.0}, "speed = 3.0: must be absent: a clamped rod"),
        ("free", {"speed": np.nan}, "speed = nan: must be a finite number"),
        ("free", {"speed": "fast"}, "speed"),
        ("free", {"speed": True}, "speed"),
        ("free", {"after": 11.0}, r"after = 11.0: must be a time in the span, 0 to 10 s"),
        ("free", {"after": -1.0}, "after"),
        ("free", {"after": np.inf}, "after"),
        ("free", {"after": 1.0, "speed": 2.0}, "speed = 2.0: must be absent"),
        ("free", {"after": 1.0, "t": 2.0}, "t = 2.0: must be absent"),
    ],
)
def test_bad_input(rod: Rod, boundary: str, given: dict[str, Any], message: str) -> None:
    for analysis in (natural_modes, critical_force):
        with pytest.raises(SceneError, match=message):
            analysis(rod(4, boundary, PUSHED), **given)


@pytest.mark.nightly
def test_runs_find_it_too(rod: Rod) -> None:
    """Measured growth sees the onset of flutter in damped flight; a hundredfold comes far later."""
    scene, span = rod(4, "free", PUSHED, mass=20.0), 4.0
    exact = critical_force(scene, speed=20.0).force
    how: dict[str, Any] = {"span": span, "speed": 20.0, "target": "numpy", "tolerance": 4e-3}
    found = simulated_critical_force(scene, low=0.98 * exact, high=1.1 * exact, **how)
    assert (found.growth, found.speed) == (None, 20.0)
    # By eigenvalues, growth of 1 % in the span begins between the two; to a tenth, since the drag
    # of a disturbance that is not infinitely small counts.
    rates = family_of(scene, speed=20.0).rates(np.array([found.low, found.high])).real.max(axis=1)
    assert rates[0] * 0.9 < np.log(1.01) / span < rates[1] * 1.1
    with pytest.raises(AnalysisError, match="no motion grows 100 times within 4 s"):
        simulated_critical_force(scene, growth=100.0, high=1.05 * exact, **how)


def _simulated(force: float, growth: float | None = None) -> SimulatedCritical:
    return SimulatedCritical(force, force, force, 8.0, growth, 1, 0.0, "numpy", 20.0)


def test_doubt(rod: Rod) -> None:
    scene = rod(4, "free", PUSHED)
    flies: Critical = critical_force(scene, speed=20.0)
    family = family_of(scene, speed=20.0)
    assert doubt(flies, _simulated(1.04 * flies.force), family) is None
    slow = doubt(flies, _simulated(1.06 * flies.force, growth=1e6), family)
    assert slow is not None
    assert "simulate for longer" in slow
    unknown = doubt(flies, _simulated(0.5 * flies.force), family)
    assert unknown is not None
    assert unknown.endswith("not to be trusted")
    rests = doubt(flies, _simulated(1.5 * flies.force), family_of(scene, speed=0.0))
    assert rests is not None
    assert "at rest" in rests


@pytest.mark.nightly
@pytest.mark.compiler
def test_the_missile_in_flight() -> None:
    """At 20 m/s: eigenvalues against runs of 20 s from a disturbance of 1e-6."""
    scene = Scene.from_toml("scenes/missile.toml")
    exact = critical_force(scene)
    assert exact.speed == 20.0
    found = simulated_critical_force(scene, span=20.0, tolerance=1e-3)
    assert found.force == pytest.approx(exact.force, rel=0.05)
    # By eigenvalues, growth of 1 % in 20 s: slower growth is not seen, and explains what is left.
    rates = family_of(scene).rates(np.array([found.low, found.high])).real.max(axis=1)
    assert rates[0] * 0.95 < np.log(1.01) / 20.0 < rates[1] * 1.05
