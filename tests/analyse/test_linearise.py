"""Linear models: against 50-digit arithmetic, runs, and the systems that they stand for."""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
import scipy

import rodgen
from rodgen.analyse.state_space import StateSpace, minimal_part, slow_part
from rodgen.check.module_check import DIGITS, assemble
from rodgen.errors import InputError
from tests.sets import sets

ROD = {"links": 4, "length": 2.0, "mass": 3.0, "bending_stiffness": 40.0}
# A rocket with a lagging gimbal, in a wind that blows harder in the height.
STEERED: dict[str, Any] = {
    "name": "steered",
    "rod": ROD,
    "parameters": {"command": 0.02, "lag": 0.1, "rise": 0.3},
    "air": {"density": 1.1, "wind": ["rise*y", 0.5]},
    "loads": {
        "follower": {"force": "40*exp(-t/5)", "angle": "gimbal + 0.1*command"},
        "fins": [{"at": 0.9, "normal_slope": 6.0, "area": 0.02}],
        "tip": {"x": 0.0, "y": 1.0},
    },
    "states": {
        "filtered": {"rate": "omega(0.3) - 2*filtered"},
        "gimbal": {"rate": "(command - 0.4*filtered - gimbal)/lag"},
    },
    "initial": {"phi": "-pi/2", "velocity": [0.0, 30.0]},
    "integrate": {"span": [0.0, 1.0], "rtol": 1e-11, "atol": 1e-13},
}
COLUMN: dict[str, Any] = {
    "name": "column",
    "rod": ROD | {"boundary": "clamped", "links": 6},
    "loads": {
        "follower": {"force": 3.0, "angle": 0.0},
        "moment": [{"at": 0.5, "moment": 0.0}],
        "material_damping": {"time": 0.02},
    },
    "initial": {"phi": 0.0},
    "integrate": {"span": [0.0, 1.0], "rtol": 1e-11, "atol": 1e-13},
}
ANGLE, FORCE, SIDEWAYS = "loads.follower.angle", "loads.follower.force", "loads.tip.x"


def steered(changes: dict[str, Any] | None = None) -> rodgen.Scene:
    return rodgen.Scene.from_dict(STEERED).replace(changes or {})


def column(changes: dict[str, Any] | None = None) -> rodgen.Scene:
    return rodgen.Scene.from_dict(COLUMN).replace(changes or {})


def bent_state(scene: rodgen.Scene) -> np.ndarray:
    """A state in which everything bends, turns and moves, of numbers that are short in binary."""
    y0 = scene.initial_state()
    draw = np.random.default_rng(3).standard_normal(len(y0))
    return y0 + np.round(0.3 * draw * 2**20) / 2**20


# Derivatives ------------------------------------------------------------------------------------

H = 2.0**-26  # of differences in 50 digits, whose errors are its square


def test_matrices_are_derivatives_in_fifty_digits() -> None:
    """Of rates and of what is measured, by states and inputs, to 1e-10 of every row; about a state
    that is no equilibrium."""
    scene, t = steered(), 0.25
    y = bent_state(scene)
    inputs = [SIDEWAYS, "states.gimbal", "parameters.command"]
    outputs = [
        "omega(0.3) + 2*command",
        "x(1) - x(0)",
        "bending_moment_2",
        "phi_1",
        "attack_fins",
        "y(0.6)",
    ]
    model = rodgen.linearise(scene, inputs, outputs, about=y, t=t)
    module = rodgen.build(scene)
    values = dict(scene.parameters)
    steered_at = module.STATE.index("gimbal")
    kept = [at for at in range(len(y)) if at != steered_at]
    assert model.states == tuple(module.STATE[at] for at in kept)
    with mpmath.workdps(DIGITS):

        def exact(change: np.ndarray, given: dict[str, Any]) -> np.ndarray:
            """Rates and outputs beside the state."""
            of = assemble(module, values | given, t, y + change)
            joints, flow = of.joints(), of.air()
            rates = of.rhs()
            phi, omega = (y + change)[2:6], (y + change)[8:12]
            measured = [
                mpmath.mpf(omega[1]) + 2 * mpmath.mpf((values | given)["command"]),
                joints[-1][0] - joints[0][0],
                of.bending_moments()[2],
                mpmath.mpf(phi[1]),
                mpmath.atan2(-flow["across_fins"], -flow["along_fins"]),
                joints[2][1] + mpmath.mpf(2) / 5 * (joints[3][1] - joints[2][1]),
            ]
            return np.array([*(rates[at] for at in kept), *measured])

        def slope(change: np.ndarray, given: dict[str, Any] | None = None) -> np.ndarray:
            name, value = next(iter((given or {}).items()), ("", 0))
            sides = []
            for way in (1, -1):
                here = {name: mpmath.mpf(values[name]) + way * value} if given else {}
                sides.append(exact(way * change, here))
            return ((sides[0] - sides[1]) / (2 * H)).astype(float)

        by_state = np.array([slope(H * one) for one in np.eye(len(y))[kept]]).T
        none = np.zeros(len(y))
        by_inputs = [
            slope(none, {"tip_force_x": H}),
            slope(H * np.eye(len(y))[steered_at]),
            slope(none, {"command": H}),
        ]
        value = exact(none, {}).astype(float)
    whole = np.hstack((by_state, np.array(by_inputs).T))
    found = np.block([[model.A, model.B], [model.C, model.D]])
    off = np.abs(found - whole).max(axis=1)
    assert (off <= 1e-10 * np.maximum(np.abs(whole).max(axis=1), 1.0)).all()
    constant = np.concatenate((model.rates, model.output_values))
    np.testing.assert_allclose(constant, value, rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(model.input_values, [0.0, y[steered_at], 0.02])


def test_an_expression_in_time_is_an_input_by_its_value() -> None:
    scene = steered({"loads.follower.angle": 0.1, "states": None})
    y = bent_state(scene)
    model = rodgen.linearise(scene, [FORCE], about=y, t=0.5)
    number = scene.replace({FORCE: float(40 * np.exp(-0.1))})
    other = rodgen.linearise(number, [FORCE], about=y)
    np.testing.assert_allclose(model.B, other.B, rtol=1e-13)
    assert model.input_values == pytest.approx(40 * np.exp(-0.1))
    rhs, p = rodgen.build(number).rhs, [rodgen.System(number.replace({FORCE: f})) for f in (0, 1.0)]
    exact = rhs(0.0, y, p[1].p) - rhs(0.0, y, p[0].p)  # in which the rates are linear
    np.testing.assert_allclose(model.B[:, 0], exact, atol=1e-11 * np.abs(exact).max())


def test_a_wind_by_height_is_one_input_for_all_points() -> None:
    """What a wind adds at every point is what its number adds where it does not follow y."""
    scene = steered({"air.wind": [0.5, 0.25], "loads.nose": [{"at": 0.1, "area": 0.01}]})
    high = scene.replace({"air.wind": ["0.5 + 0*y", 0.25]})
    y = bent_state(scene)
    one, two = (
        rodgen.linearise(of, ["air.wind.0"], ["airspeed_nose", "attack_fins"], about=y)
        for of in (scene, high)
    )
    np.testing.assert_allclose(two.B, one.B, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(two.D, one.D, rtol=1e-12)
    assert np.abs(one.D).min() > 0


# Runs -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "key", "outputs"),
    sets(
        [
            (
                column(),
                "loads.moment.0.moment",
                ["phi(1)", "omega(0.4)", "bending_moment_2", "tip_y"],
            )
        ],
        slow=[
            (
                steered(
                    {"air": None, "loads.fins": None, FORCE: 40.0, "loads.tip": None}
                    | {"parameters.command": 0.0, "parameters.rise": None}
                ),
                "parameters.command",
                ["phi(0.1)", "omega(0.9)", "x(0)", "gimbal", "bending_moment_2"],
            ),
        ],
    ),
    ids=["column", "rocket"],
)
def test_a_step_response_is_that_of_a_run(
    scene: rodgen.Scene, key: str, outputs: list[str]
) -> None:
    """A step of a thousandth of what would bend it by a radian, against the run less the one
    without: to 1e-3 of the largest response; what a run has beyond is quadratic in the step."""
    model = rodgen.linearise(scene, [key], outputs)
    size = 1e-4
    before = float(model.input_values[0])
    times = np.linspace(0.0, 1.0, 201)
    made = [
        rodgen.simulate(scene.replace({key: value}), output_every=0.005)
        for value in (before, before + size)
    ]
    step = scipy.signal.lsim(model.to_scipy(), np.full(201, size), times)[1]
    for name, linear in zip(outputs, step.T, strict=True):
        one, two = (_measured(sol, name, scene.rod.links) for sol in made)
        change = two - one
        assert np.abs(change).max() > 1e-9
        np.testing.assert_allclose(linear, change, atol=1e-3 * np.abs(change).max())


def _measured(sol: rodgen.Solution, name: str, links: int) -> np.ndarray:
    what, _, rest = name.partition("(")
    if not rest:
        return {
            "tip_y": lambda: sol.values("tip")[:, 1],
            "gimbal": lambda: sol.values("gimbal"),
            "bending_moment_2": lambda: sol.values("bending_moments")[:, 2],
        }[name]()
    if what == "x":
        return sol.values("joints")[:, 0, 0]
    link = min(int(float(rest[:-1]) * links), links - 1)
    return sol.values(what)[:, link]


@pytest.mark.parametrize("changes", [{}, {FORCE: 9.0, "rod.inertia": "lumped"}])
def test_eigenvalues_are_those_of_modes(changes: dict[str, Any]) -> None:
    scene = column(changes)
    modes = rodgen.natural_modes(scene, count=6)
    s = rodgen.linearise(scene).eigenvalues
    s = s[s.imag > 0]
    s = s[np.argsort(s.imag)][: len(modes.frequencies)]
    np.testing.assert_allclose(s.imag / (2 * np.pi), modes.frequencies, rtol=1e-9)
    np.testing.assert_allclose(s.real, modes.growth, rtol=1e-6, atol=1e-7)


def test_about_an_equilibrium_nothing_is_constant() -> None:
    hangs = column({"loads.gravity": {}, "loads.follower.angle": 0.3})
    model = rodgen.linearise(hangs, [ANGLE])
    assert model.in_equilibrium
    assert not model.notes
    rest = rodgen.static_equilibrium(hangs)
    np.testing.assert_allclose(model.point[:6], rest.phi, atol=1e-12)
    moved = rodgen.static_equilibrium(hangs.replace({ANGLE: 0.3 + 1e-5})).phi - rest.phi
    gain = rodgen.linearise(hangs, [ANGLE], [f"phi_{at}" for at in range(6)]).static_gain
    np.testing.assert_allclose(gain[:, 0], moved / 1e-5, rtol=1e-3)


def test_about_the_start_and_after_a_run() -> None:
    scene = steered({"loads.follower.angle": "gimbal"})
    start = rodgen.linearise(scene, about="start")
    system = rodgen.System(scene)
    rhs = rodgen.build(scene).rhs
    np.testing.assert_array_equal(start.point, system.y0)
    np.testing.assert_allclose(start.rates, rhs(0.0, system.y0, system.p))
    later = rodgen.linearise(scene, about="steady", after=0.5)
    run = rodgen.simulate(scene, span=(0.0, 0.5), output_every=0.5)
    np.testing.assert_allclose(later.point, run.y[-1], rtol=1e-12)
    assert later.t == 0.5
    np.testing.assert_allclose(later.rates, rhs(0.5, run.y[-1], system.p))
    assert [note.kind for note in later.notes] == ["remark"]


def test_a_steady_flight_is_where_the_scene_has_it() -> None:
    scene = steered({"initial.position": [3.0, 50.0], "air.wind": [0.0, 0.0]})
    still = scene.replace({"parameters": None, "states": None, ANGLE: 0.0, "loads.tip": None})
    model = rodgen.linearise(still, outputs=["joint_0_y"], speed=25.0)
    np.testing.assert_allclose(model.point[:2], [3.0, 50.0])
    np.testing.assert_allclose(model.rates[:2], [0.0, 25.0], atol=1e-12)
    assert model.output_values == pytest.approx(50.0)


def test_masses_that_change_count_as_in_rhs() -> None:
    """Jet damping, and whatever else rhs has of a mass that flows off."""
    scene = steered({"rod.mass": None, "rod.mass_per_length": "1.5 - 0.9*t"})
    y = bent_state(scene)
    model = rodgen.linearise(scene, about=y, t=0.5)
    jac = rodgen.build(scene).jac(0.5, y, rodgen.System(scene).p)
    np.testing.assert_array_equal(model.A, jac)


# Smaller models ---------------------------------------------------------------------------------


def test_a_reduced_model_keeps_the_static_gain_and_the_slow_motions() -> None:
    model = rodgen.linearise(column(), [ANGLE, "loads.moment.0.moment"], ["phi(1)", "tip_y"])
    small = model.reduce(2)
    assert len(small.states) == 4
    np.testing.assert_allclose(small.eigenvalues, model.eigenvalues[:4], rtol=1e-9)
    np.testing.assert_allclose(small.static_gain, model.static_gain, rtol=1e-9)
    below = np.abs(model.eigenvalues[2].imag) / (2 * np.pi) / 3
    for hertz in (0.0, 0.3 * below, below):
        off = small.response(hertz) - model.response(hertz)
        assert np.abs(off).max() < 0.02 * np.abs(model.response(hertz)).max()
    truncated = small.C @ np.linalg.solve(-small.A, small.B)  # without what follows at once
    assert np.abs(truncated - model.static_gain).max() > 1e-6 * np.abs(model.static_gain).max()
    assert model.reduce(100) is model
    shape = small.basis @ np.linalg.eig(small.A)[1][:, 0]
    whole = np.linalg.eig(model.A)
    s = np.linalg.eig(small.A)[0][0]
    nearest = whole[1][:, np.argmin(np.abs(whole[0] - s))]
    assert abs(np.vdot(shape, nearest)) / np.linalg.norm(shape) == pytest.approx(1.0, abs=1e-8)


def test_a_free_rod_reduces_with_its_rigid_motions() -> None:
    """Six eigenvalues zero, with one eigenvector for two: three modes that are kept together."""
    scene = steered({"air": None, "loads": {"follower": {"force": 40.0}}, "states": None})
    scene = scene.replace({"parameters": None})
    model = rodgen.linearise(scene, [ANGLE, FORCE], ["phi(0)", "x(0)", "vy(1)"])
    small = model.reduce(4)
    assert len(small.states) == 8
    for hertz in (0.01, 0.3):
        whole = model.response(hertz)
        off = np.abs(small.response(hertz) - whole).max(axis=(0, 1))  # of each input
        assert (off < 1e-3 * np.abs(whole).max(axis=(0, 1))).all()
    assert np.isnan(model.static_gain[0, 0])  # it goes on turning
    at_once = model.minimal()
    angles = rodgen.linearise(scene, [ANGLE], ["phi(0)"]).minimal()
    assert len(angles.states) < len(at_once.states) < len(model.states) + 1
    np.testing.assert_allclose(
        angles.response(2.0)[0, 0, 0], model.response(2.0)[0, 0, 0], rtol=1e-8
    )


@pytest.mark.parametrize("links", [6, 60])
def test_a_free_rod_that_is_pushed_turns_and_bends(links: int) -> None:
    """A force F across at one end: the moments of a uniform rod are F s (1 - s/L)^2, F L/8 in the
    middle, while its angle and its place go on by themselves."""
    rod = ROD | {"links": links}
    loads = {"tip": {"x": 0.0, "y": 0.0}}
    scene = rodgen.Scene.from_dict(
        {"name": "pushed", "rod": rod, "loads": loads, "initial": {"phi": "-pi/2"}}
    )
    outputs = [f"bending_moment_{links // 2}", "phi(0.5)", "x(0.5)"]
    model = rodgen.linearise(scene, [SIDEWAYS], outputs)
    slow = model.reduce(1)
    assert len(slow.states) == 6
    assert (slow.eigenvalues == 0.0).all()
    for one in (model, model.reduce(10).minimal()):
        bent, *others = one.static_gain[:, 0]
        assert abs(bent) == pytest.approx(ROD["length"] / 8, rel=1e-6)
        assert np.isnan(others).all()
        np.testing.assert_array_equal(one.response(0.0)[0], one.static_gain)
    turning = [abs(one.response(0.01)[0, 1, 0]) for one in (slow, model)]
    assert turning[0] == pytest.approx(turning[1], rel=1e-4)


def test_a_moved_base_is_no_input_and_its_places_are_outputs() -> None:
    scene = column({"base": {"y": "0.01*sin(3*t)"}})
    model = rodgen.linearise(scene, [FORCE], ["joint_2_y", "y(1)"], about="start")
    still = rodgen.linearise(column(), [FORCE], ["joint_2_y", "y(1)"], about="start")
    np.testing.assert_allclose(model.C, still.C, rtol=1e-12, atol=1e-15)
    with pytest.raises(InputError) as raised:
        rodgen.linearise(scene, ["base.y"], about="start")
    assert raised.value.field == "inputs"


@pytest.mark.parametrize("given", ["fast", np.inf, [[1.0, 2.0]], None])
def test_a_frequency_is_a_finite_number(given: Any) -> None:
    model = rodgen.linearise(column(), [ANGLE], ["phi(1)"])
    with pytest.raises(InputError) as raised:
        model.response(given)
    assert raised.value.field == "frequencies"


def test_constant_rates_of_what_is_fast_become_constant_outputs() -> None:
    """x_1' = -x_1 + u, x_2' = 100 (3 - x_2), y = x_1 + 2 x_2: y = x_1 + 6."""
    of = StateSpace(
        np.diag([-1.0, -100.0]),
        np.array([[1.0], [0.0]]),
        np.array([[1.0, 2.0]]),
        np.zeros((1, 1)),
        np.array([0.0, 300.0]),
        np.zeros(1),
    )
    made, basis = slow_part(of, 1)
    assert made.A.tolist() == [[-1.0]]
    assert float(made.values[0]) == pytest.approx(6.0)
    assert (made.C @ np.linalg.solve(-made.A, made.B)).item() == pytest.approx(1.0)
    assert basis.shape == (2, 1)
    reached, _ = minimal_part(of._replace(rates=np.zeros(2)))
    assert len(reached.A) == 1
    assert len(minimal_part(of)[0].A) == 2


# Other libraries and files ----------------------------------------------------------------------


def test_python_control_has_the_same_response() -> None:
    model = rodgen.linearise(column(), [ANGLE], ["phi(1)", "bending_moment_2"])
    other = model.to_control()
    assert other.input_labels == ["loads_follower_angle"]
    assert other.state_labels[0] == "phi_0"
    response = other(2j * np.pi * 3.0)
    np.testing.assert_allclose(response, model.response(3.0)[0], rtol=1e-9)


def test_python_control_is_named_where_it_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(ImportError, match=r"\[control\]"):
        rodgen.linearise(column()).to_control()


def test_a_table_has_all_digits(tmp_path: Path) -> None:
    model = rodgen.linearise(steered(), ["parameters.command"], ["omega(0.3)"], about="start")
    model.to_csv(tmp_path / "model.csv")
    with open(tmp_path / "model.csv", encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert head[1:] == [*model.states, "parameters.command", "constant"]
    numbers = np.array([[float(cell) for cell in row[1:]] for row in rows])
    np.testing.assert_array_equal(numbers[:-1, :-2], model.A)
    np.testing.assert_array_equal(numbers[-1, :-2], model.C[0])
    np.testing.assert_array_equal(numbers[:-1, -1], model.rates)


# Refusals and doubts ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"inputs": ["loads.fins.0.force"]}, "inputs"),
        ({"inputs": ["states.pump"]}, "inputs"),
        ({"inputs": ["parameters.other"]}, "inputs"),
        ({"inputs": FORCE}, "inputs"),
        ({"inputs": [FORCE, FORCE]}, "inputs"),
        ({"outputs": ["phi(2)"]}, "outputs"),
        ({"outputs": ["joint_9_x"]}, "outputs"),
        ({"outputs": ["bending"]}, "outputs"),
        ({"outputs": ["phi(0.1) + nothing"]}, "outputs"),
        ({"outputs": ["__import__('os')"]}, "outputs"),
        ({"about": "rest"}, "about"),
        ({"about": [0.0, 1.0]}, "about"),
        ({"about": None}, "about"),
        ({"about": "start", "speed": 3.0}, "speed"),
        ({"about": "start", "after": 0.5}, "after"),
        ({"about": "start", "t": 7.0}, "t"),
    ],
)
def test_what_cannot_be_used_is_refused(given: dict[str, Any], field: str) -> None:
    with pytest.raises(InputError) as raised:
        rodgen.linearise(steered(), **{"about": "start"} | given)
    assert raised.value.field == field


def test_a_number_of_the_rod_is_no_input() -> None:
    scene = steered({"rod.spring": "k*d*(1 + command*d**2)"})
    with pytest.raises(InputError, match="nothing else"):
        rodgen.linearise(scene, ["parameters.command"], about="start")


def test_an_angle_of_attack_at_rest_is_refused() -> None:
    scene = steered({"initial.velocity": [0.0, 0.0], "air.wind": None})
    with pytest.raises(InputError, match="at rest"):
        rodgen.linearise(scene, outputs=["attack_fins"], about="start")


def test_damping_without_a_derivative_is_doubted() -> None:
    scene = column({"loads.external_damping": {"coefficient": 0.5}})
    with pytest.warns(rodgen.DoubtWarning, match="no derivative"):
        model = rodgen.linearise(scene)
    without = rodgen.linearise(column())
    np.testing.assert_allclose(model.A, without.A, atol=1e-12 * np.abs(without.A).max())
