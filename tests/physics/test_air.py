"""Forces of the air: exact motions, aerodynamics by other routes, and stability in flight."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

import rodgen
from rodgen.scene.fin_set import FinSet
from rodgen.scene.standard_atmosphere import density_text, speed_of_sound
from tests.sets import sets

AREA, DENSITY, SPEED = np.pi / 4 * 0.1**2, 1.2, 90.0
ROCKET = {
    "name": "rocket",
    "rod": {"links": 12, "length": 2.0, "diameter": 0.1, "mass": 4.0, "bending_stiffness": 500.0},
    "air": {"density": DENSITY},
    "loads": {
        "follower": {"force": 100.0},
        "fins": [{"at": 0.95, "normal_slope": 6.0}],
        "nose": [{"at": 0.05}],
        "axial_drag": [{"at": 0.0, "coefficient": 0.5}],
    },
    "initial": {"phi": "-pi/2", "velocity": [0.0, SPEED]},
    "integrate": {"span": [0.0, 1.0], "rtol": 1e-10, "atol": 1e-12},
}


SHORT = {"rod.links": 4, "integrate.span": [0.0, 0.2]}  # in runs


def rocket(changes: dict | None = None) -> rodgen.Scene:
    return rodgen.Scene.from_dict(ROCKET).replace(changes or {})


# What the air does ------------------------------------------------------------------------------


def test_a_rod_that_falls_nose_first_reaches_its_last_speed() -> None:
    """v = v_t tanh(g t/v_t) with v_t = sqrt(2 m g/(rho A C))."""
    falling = {"initial.phi": "pi/2", "initial.velocity": [0.0, 0.0], "loads.gravity": {"g": 9.81}}
    rod = {"rod.links": 1, "integrate.span": [0.0, 20.0]}
    sol = rodgen.simulate(rocket(falling | rod | {"loads.follower": None}), output_every=1.0)
    last = np.sqrt(2 * 4.0 * 9.81 / (DENSITY * AREA * 0.5))
    expected = -last * np.tanh(9.81 * sol.t / last)
    np.testing.assert_allclose(sol.values("base_velocity")[:, 1], expected, atol=1e-7)
    np.testing.assert_allclose(sol.values("airspeed_nose"), -expected, atol=1e-7)


@pytest.mark.parametrize("degrees", [0.01, 5.0, 40.0, 90.0])
def test_normal_force_by_the_angle_of_attack(degrees: float) -> None:
    """rho v^2 A C a tanh(sin(alpha)/a)/2 across the rod, which is the slope at small angles."""
    angle, stall = np.radians(degrees), np.radians(15.0)
    scene = rocket({"initial.phi": -np.pi / 2 + angle})
    model, y = rodgen.build(scene), scene.initial_state()
    p = model.parameters(**scene.parameters)
    (force,) = (f for f in model.forces(0.0, y, p)["fins"].sum(axis=0, keepdims=True))
    pressure = DENSITY * SPEED**2 / 2 * AREA
    size = pressure * 6.0 * stall * np.tanh(np.sin(angle) / stall)
    across = np.array([np.cos(angle), np.sin(angle)])  # to the left of the link, as it flies up
    np.testing.assert_allclose(force, -size * across, rtol=1e-12, atol=1e-12 * size)
    if degrees < 1:
        assert size == pytest.approx(pressure * 6.0 * angle, rel=1e-6)
    motion = rodgen.simulate(scene, span=(0.0, 1e-5), output_every=1e-5)
    assert motion.values("attack_fins")[0] == pytest.approx(-angle, rel=1e-12)


def test_a_wind_is_a_motion_of_the_rod_through_still_air() -> None:
    """In the frame that goes with a steady wind the air is still."""
    turned = SHORT | {"initial.phi": "-pi/2 + 0.05*s"}
    still = rodgen.simulate(rocket(turned))
    wind = np.array([7.0, -3.0])
    blown = rocket(turned | {"air.wind": [*wind], "initial.velocity": [7.0, SPEED - 3.0]})
    sol = rodgen.simulate(blown)
    moved = still.values("joints") + (wind * still.t[:, None])[:, None]
    np.testing.assert_allclose(sol.values("joints"), moved, atol=2e-7)


def test_density_and_wind_are_those_at_the_height_of_a_point() -> None:
    """A clamped rod that stands upright: its forces, by the height of each point."""
    wind, thin = "2*y", "1.2*exp(-y/3)"
    stands = {"initial.velocity": None, "rod.boundary": "clamped", "rod.clamp_angle": np.pi / 2}
    air = {"density": thin, "wind": [wind, 0.0]}
    scene = rocket(stands | {"air": air, "initial.phi": None, "loads.follower": None})
    model = rodgen.build(scene)
    p, y = model.parameters(**scene.parameters), scene.initial_state()
    force = model.forces(0.0, y, p)["fins"].sum(axis=0)
    high = 0.95 * 2.0
    stall = np.radians(15.0)
    pressure = 1.2 * np.exp(-high / 3) * (2 * high) ** 2 / 2 * AREA
    expected = pressure * 6.0 * stall * np.tanh(1 / stall)
    np.testing.assert_allclose(force, [expected, 0.0], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    "air",
    [
        {"density": "isa", "height": 1500.0, "wind": ["interp(y, [0, 50], [2, 9])", 0.0]},
        {"density": "1.2 + 0.1*sin(9*t)", "wind": [0.0, "5*cos(7*t)"]},
    ],
)
def test_energy_balances(air: dict) -> None:
    """Kinetic and potential energy and that of the springs, less the work of all loads, of a
    rocket that bends and swings in its first second; beside its energy, 16 kJ."""
    turned = SHORT | {"air": air, "initial.phi": "-pi/2 + 0.1*sin(3*s)", "loads.gravity": {}}
    for method in ("dop853", "gauss"):
        sol = rodgen.simulate(rocket(turned), method=method)
        assert abs(sol.energy_balance).max() < 2e-6


# By other routes --------------------------------------------------------------------------------

FINS = (FinSet(0.12, 0.06, 0.08, 0.05, 4, 0.05), FinSet(0.3, 0.0, 0.1, 0.3, 3, 0.02))


@pytest.mark.parametrize("fins", FINS)
def test_fins_by_the_formula_of_a_wing(fins: FinSet) -> None:
    """F. W. Diederich's slope of a wing (NACA TN 2335) from its aspect ratio and the sweep of the
    line through the middles of its chords, half of it for each fin of a set, as seen from the
    plane; and the centre of its quarter chords."""
    area = fins.span * (fins.root + fins.tip) / 2
    ratio = 2 * fins.span**2 / area
    tangent = (fins.sweep + (fins.tip - fins.root) / 2) / fins.span
    cosine = np.cos(np.arctan(tangent))
    wing = 2 * np.pi * ratio / (2 + np.sqrt(4 + (ratio / cosine) ** 2)) * area / fins.area
    body = 1 + fins.body_radius / (fins.span + fins.body_radius)
    assert fins.normal_slope == pytest.approx(fins.number / 2 * wing * body, rel=1e-12)

    def chord(z: float) -> float:
        return fins.root + (fins.tip - fins.root) * z / fins.span

    def quarter(z: float) -> float:
        return chord(z) * (fins.sweep * z / fins.span + chord(z) / 4)

    moment, _ = scipy.integrate.quad(quarter, 0.0, fins.span)
    assert fins.centre == pytest.approx(moment / area, rel=1e-10)


@pytest.mark.parametrize(
    ("height", "density", "sound"),
    [
        (0.0, 1.2250, 340.29),
        (5000.0, 0.73643, 320.55),
        (11019.0, 0.36392, 295.07),
        (15000.0, 0.19476, 295.07),
        (20000.0, 0.08891, 295.07),
    ],
)
def test_standard_atmosphere(height: float, density: float, sound: float) -> None:
    """Against the tables of the U.S. Standard Atmosphere, 1976, by geometric height."""
    from rodgen.scene.expression import parse_expression

    for ground in (0.0, 1200.0):
        law = parse_expression(density_text(ground), "y", "density", ())
        assert law(height - ground) == pytest.approx(density, abs=6e-5)
        assert speed_of_sound(np.array(height - ground), ground) == pytest.approx(sound, abs=6e-3)


# Small motions in flight ------------------------------------------------------------------------


def test_a_stiff_rocket_pitches_as_a_rigid_one() -> None:
    """The pitching motion of a rigid rocket whose thrust exceeds its drag, by hand: of its angle
    and of the direction of its flight, of which the latter is kept by the speed that it has."""
    modes = rodgen.natural_modes(rocket({"rod.bending_stiffness": 5e6}), count=1)
    mass, length, thrust = 4.0, 2.0, 100.0
    pressure = DENSITY * SPEED**2 / 2 * AREA
    inertia, middle = mass * length**2 / 12, length / 2
    slopes, arms = np.array([6.0, 2.0]), np.array([0.95, 0.05]) * length - middle  # behind it
    lift = pressure * slopes
    # Angle of attack at a point behind the centre: theta - gamma + arm theta'/v.
    # theta'' = -sum(arm lift alpha)/I; v gamma' = ((T - D)(theta - gamma) + sum(lift alpha))/m
    push = thrust - pressure * 0.5
    A = np.zeros((3, 3))  # of theta, theta', gamma
    A[0, 1] = 1.0
    for f, arm in zip(lift, arms, strict=True):
        seen = np.array([1.0, arm / SPEED, -1.0])
        A[1] -= f * arm / inertia * seen
        A[2] += f / (mass * SPEED) * seen
    # Drag acts at the nose along the link, and the thrust at the tail: no moment about the middle.
    A[2] += push / (mass * SPEED) * np.array([1.0, 0.0, -1.0])
    rigid = max(np.linalg.eigvals(A), key=lambda s: s.imag)
    found = modes.growth[0] + 2j * np.pi * modes.frequencies[0]
    assert found.imag == pytest.approx(rigid.imag, rel=1e-5)
    assert found.real == pytest.approx(rigid.real, rel=1e-5)


def test_turning_the_flight_is_no_instability() -> None:
    """Of a rocket that gets faster or slower, one that has turned with its path is the same rocket:
    whatever its thrust, that does not grow."""
    for force in (0.0, 100.0, 300.0):
        assert rodgen.natural_modes(rocket({"loads.follower.force": force})).stable


@pytest.mark.parametrize("speed", [40.0, 0.0, 120.0])
@pytest.mark.parametrize("density", [DENSITY, f"{DENSITY} + 0*y"])
def test_a_wind_along_the_axis_adds_to_the_speed(speed: float, density: float | str) -> None:
    """What counts is the speed against the air, however it is made up."""
    still = rocket({"air.density": density, "rod.links": 6})
    windy = still.replace(
        {"initial.velocity": [0.0, speed], "air.wind": [0.0, speed - SPEED]}
    )  # it comes down from above, or follows
    one, two = rodgen.natural_modes(still), rodgen.natural_modes(windy)
    np.testing.assert_allclose(two.frequencies, one.frequencies, rtol=1e-8)
    np.testing.assert_allclose(two.growth, one.growth, rtol=1e-5, atol=1e-7)
    loads = [rodgen.critical_load(scene) for scene in (still, windy)]
    assert loads[1].value == pytest.approx(loads[0].value, rel=1e-7)


def test_what_turns_with_its_path_is_left_out_with_the_rigid_motions() -> None:
    assert rodgen.natural_modes(rocket()).rigid == 3
    falls = rocket({"loads.fins": None, "loads.nose": None, "loads.axial_drag": None})
    assert rodgen.natural_modes(falls).rigid == 3


FAST = {"initial.velocity": [0.0, 200.0]}
# At heights and speeds at which what bends them brings them down: by divergence and by flutter.
ROCKETS = {
    "fast": FAST,
    "head": {"bodies": [{"name": "head", "at": 0.2, "mass": 3.0}], "initial.velocity": [0, 150.0]},
    "canards": FAST
    | {"loads.fins": [{"at": 0.95, "normal_slope": 10.0}, {"at": 0.3, "normal_slope": 2.0}]},
    "engine": FAST
    | {"bodies": [{"name": "engine", "at": 0.9, "mass": 2.0}], "loads.fins.0.normal_slope": 15.0},
    "no nose": {"loads.nose": None, "loads.material_damping": {"time": 1e-4}}
    | {"initial.velocity": [0.0, 240.0]},
}


def _balanced(changes: dict, force: float) -> rodgen.Scene:
    """The rocket with a drag that is its thrust, so that it keeps its speed."""
    speed = changes["initial.velocity"][1]
    drag = force / (DENSITY * speed**2 / 2 * AREA)
    size = {"loads.axial_drag.0.coefficient": drag, "loads.follower.force": force}
    return rocket(changes | size)


def _critical(changes: dict) -> rodgen.Critical:
    """The critical thrust of the rocket whose drag is that thrust."""
    low, high = 500.0, 6000.0
    for _ in range(60):  # halve the thrusts between which the balanced rocket begins to grow
        middle = (low + high) / 2
        grows = rodgen.natural_modes(_balanced(changes, middle), count=30).growth.max() > 1e-3
        low, high = (low, middle) if grows else (middle, high)
    return rodgen.critical_load(_balanced(changes, high), bounds=(0.8 * high, 2 * high))


@pytest.mark.slow
@pytest.mark.compiler
@pytest.mark.parametrize("name", ROCKETS)
@pytest.mark.filterwarnings("ignore::rodgen.DoubtWarning")
def test_critical_thrust_in_flight_is_where_runs_begin_to_grow(name: str) -> None:
    """Runs of rockets that keep their speed, 3 % of thrust to either side: they grow above, and
    decay below, as their linearised equations do, to 3 %."""
    found = _critical(ROCKETS[name])
    for share in (0.97, 1.03):
        scene = _balanced(ROCKETS[name], share * found.value)
        modes = rodgen.natural_modes(scene, count=30)
        most = int(np.argmax(modes.growth))
        measured = _measured_growth(scene, modes, most)
        assert measured == pytest.approx(modes.growth[most], rel=0.03)
        assert (measured > 0) == (share > 1)


def _measured_growth(scene: rodgen.Scene, modes: rodgen.Modes, at: int) -> float:
    """Growth of a mode in a run that begins with a little of it [1/s]."""
    rate = modes.growth[at] + 2j * np.pi * modes.frequencies[at]
    shape, little = modes.phi[at], 1e-6
    speed = scene.initial.velocity + little * (rate * modes.displacements[at, 0]).real
    start = {
        "initial.phi": [*(-np.pi / 2 + little * shape.real)],
        "initial.omega": [*(little * (rate * shape).real)],
        "initial.velocity": [*speed],
        "integrate.span": [0.0, 1.5],
    }
    sol = rodgen.simulate(scene.replace(start), target="c", rtol=1e-10, atol=1e-13)
    angles, rates = sol.values("phi") + np.pi / 2, sol.values("omega") / abs(rate)
    size = np.log(np.hypot(np.linalg.norm(angles, axis=1), np.linalg.norm(rates, axis=1)))
    return float(np.polyfit(sol.t, size, 1)[0])


@pytest.mark.parametrize("compliance", sets([0.0], slow=[1e-4]))
def test_boundaries_in_flight_go_from_divergence_to_flutter(compliance: float) -> None:
    """By thrust and drag: each point is the critical thrust at its drag, which is found by counting
    growing motions of all of the rocket, with the turn of rod and path among them."""
    drag, scene = "loads.axial_drag.0.coefficient", rocket(ROCKETS["canards"])
    if compliance:
        scene = scene.replace({"loads.material_damping": {"time": compliance}})
    keys = ("loads.follower.force", drag)
    found = rodgen.stability_boundary(scene, keys, bounds=((0.0, 9000.0), (1.0, 25.0)))
    assert found["special_kind"].values.tolist() == ["zero frequency"]
    assert rodgen.result.notes_from(found.attrs) == ()  # none on branches that would cross it
    still = found["frequency"].values == 0.0
    for at in (*np.flatnonzero(still)[[0, 20, -5]], *np.flatnonzero(~still)[[15, -2]]):
        thrust = float(found["a"][at])
        point = scene.replace({drag: float(found["b"][at])})
        critical = rodgen.critical_load(point, bounds=(0.9 * thrust, None))
        assert thrust == pytest.approx(critical.value, rel=1e-9)
        assert float(found["frequency"][at]) == pytest.approx(critical.frequency, rel=1e-6)
