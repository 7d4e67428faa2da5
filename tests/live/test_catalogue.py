"""Quantities of the live view by second routes: a Solution's own, exact motions, kinematics."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate import Solution
from rodgen.integrate.catalogue import Piece
from rodgen.integrate.stepper import Array
from rodgen.live.catalogue import KINDS, Catalogue
from rodgen.live.samples import Chunk
from rodgen.model.quantities import watched
from rodgen.model.rod import BOUNDARIES
from rodgen.model.terms import TERMS
from rodgen.scene import Scene, SceneError

Make = Callable[..., Scene]
HELD = ("cantilever", "clamped")  # at a clamp_angle
CLAMP = 0.4


def chunk_of(sol: Solution) -> Chunk:
    """All samples of a run."""
    p = rodgen.build(sol.scene).parameters(**sol.scene.parameters)
    work = np.array(list(sol.work.values())).reshape(-1, len(sol.t)).T
    return Chunk(sol.t, sol.y, work, tuple(sol.work), p, start=float(sol.energy.total[0]))


def at_rest(scene: Scene, y: Array, t: Array | None = None) -> tuple[Catalogue, Chunk]:
    """States (K, states) that nobody has integrated."""
    model = rodgen.build(scene)
    catalogue = Catalogue(scene, model)
    works = catalogue.works
    t = np.arange(float(len(y))) if t is None else t
    p = model.parameters(**scene.parameters)
    return catalogue, Chunk(t, y, np.zeros((len(y), len(works))), works, p)


def clamped_at(boundary: str) -> dict[str, Any]:
    return {"clamp_angle": CLAMP} if boundary in HELD else {}


def some_states(scene: Scene, count: int = 3) -> Array:
    size = len(scene.initial_state())
    return np.random.default_rng(7).normal(size=(count, size))


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_columns_are_the_quantities_of_a_solution(make_scene: Make, boundary: str) -> None:
    scene = make_scene(4, boundary, TERMS, rod=clamped_at(boundary), span=[0.0, 0.2])
    sol = rodgen.simulate(scene, output_every=0.02, target="numpy")
    catalogue, chunk = Catalogue(scene, rodgen.build(scene)), chunk_of(sol)
    axes, inertia = sol.principal_axes, sol.inertia
    expected = {
        "t": sol.t,
        **{f"phi_{i}": sol.phi[:, i] for i in range(4)},
        **{f"omega_{i}": sol.omega[:, i] for i in range(4)},
        **{f"joint_{s}_{'xy'[d]}": sol.joints[:, s, d] for s in range(5) for d in (0, 1)},
        "tip_x": sol.tip[:, 0],
        "tip_y": sol.tip[:, 1],
        "centre_of_gravity_x": sol.centre_of_gravity[:, 0],
        "centre_of_gravity_y": sol.centre_of_gravity[:, 1],
        "kinetic_energy": sol.energy.kinetic,
        "spring_energy": sol.energy.spring,
        "gravity_energy": sol.energy.gravity,
        "total_energy": sol.energy.total,
        "energy_balance": sol.energy_balance,
        **{f"work_{term}": work for term, work in sol.work.items()},
        "inertia_x": inertia.x,
        "inertia_y": inertia.y,
        "product_xy": inertia.xy,
        "principal_angle": axes.angle,
        "principal_moment_1": axes.moments[:, 0],
        "principal_moment_2": axes.moments[:, 1],
    }
    moments = sol.to_xarray()["bending_moments"].values
    held = boundary == "cantilever"  # by a link, which has no spring in joint 0
    assert catalogue.kinds["bending_moment"] == [f"bending_moment_{j}" for j in range(held, 5)]
    expected |= {f"bending_moment_{j}": moments[:, j] for j in range(held, 5)}
    if boundary == "free":
        names = ("x0", "y0", "vx0", "vy0")
        expected |= {name: sol.y[:, i] for name, i in zip(names, (0, 1, 6, 7), strict=True)}
    found = catalogue.columns(list(expected), chunk)
    # The same functions of the same states: rounding of some sums of tens of joules.
    np.testing.assert_allclose(found.T, list(expected.values()), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_all_that_events_can_watch_is_there(make_scene: Make, boundary: str) -> None:
    scene = make_scene(3, boundary)
    model = rodgen.build(scene)
    quantities = Catalogue(scene, model).quantities
    assert set(model.STATE) <= set(quantities)
    light = {"gravity_energy"}  # zero without gravity, and not offered
    for name, numbers in watched(scene.hold, 3):
        assert {name.format(number) for number in numbers} - light <= set(quantities)
    assert not light & set(quantities)
    for name, quantity in quantities.items():  # and so they can be watched, if they move
        assert quantity.name == name
        assert quantity.unit == KINDS[quantity.kind].unit


@pytest.mark.parametrize(
    ("boundary", "away"), [("free", 0.0), ("free", 1e12), ("cantilever", 0.0), ("clamped", 0.0)]
)
def test_velocities_are_those_of_rigid_links(make_scene: Make, boundary: str, away: float) -> None:
    n, l = 4, 0.5
    scene = make_scene(n, boundary, rod=clamped_at(boundary))
    y = some_states(scene)
    if boundary == "free":
        y[:, 0] += away
    catalogue, chunk = at_rest(scene, y)
    phi = catalogue.columns(catalogue.kinds["phi"], chunk)
    omega = catalogue.columns(catalogue.kinds["omega"], chunk)
    start = y[:, n + 2 : n + 4] if boundary == "free" else np.zeros((3, 2))
    turning = l * omega[..., None] * np.stack((-np.sin(phi), np.cos(phi)), axis=-1)
    joints = start[:, None] + np.concatenate((np.zeros((3, 1, 2)), turning.cumsum(axis=1)), axis=1)
    centre = (joints[:, :-1] + joints[:, 1:]).mean(axis=1) / 2
    kinds = (("tip_velocity", joints[:, -1]), ("centre_velocity", centre))
    for kind, expected in kinds:
        found = catalogue.columns(catalogue.kinds[kind], chunk)
        # A difference over 1e-5 rad misses 1e-10/6 of what the links turn with; some m/s here.
        np.testing.assert_allclose(found, expected, atol=1e-8)


def test_given_energy_and_another_start_are_in_the_balance(make_scene: Make) -> None:
    scene = make_scene(2, terms=("follower",))
    catalogue, plain = at_rest(scene, some_states(scene))
    total = catalogue.columns(["total_energy"], plain)[:, 0]
    work = np.array([[0.5], [1.5], [-2.0]])
    chunk = Chunk(plain.t, plain.y, work, plain.works, plain.p, given=7.0, start=11.0)
    found = catalogue.columns(["energy_balance", "work_follower"], chunk)
    np.testing.assert_allclose(found[:, 0], total - 11.0 - work[:, 0] - 7.0, rtol=1e-14)
    np.testing.assert_array_equal(found[:, 1], work[:, 0])


def test_loads_and_powers_at_their_times(make_scene: Make) -> None:
    scene = make_scene(3, "pinned", ("follower", "tip_load"))
    t = np.array([0.0, 0.3, 1.7])
    catalogue, chunk = at_rest(scene, some_states(scene), t)
    found = catalogue.columns(catalogue.kinds["load"], chunk)
    assert catalogue.kinds["load"] == ["follower_force", "tip_force_x", "tip_force_y"]
    np.testing.assert_allclose(found.T, [[40.0] * 3, [6.0] * 3, -4 * np.cos(3 * t)], rtol=1e-14)
    # A dead force at the tail has the power F.v.
    vx, vy = catalogue.columns(["tip_vx", "tip_vy"], chunk).T
    power = catalogue.columns(["power_tip_load"], chunk)[:, 0]
    np.testing.assert_allclose(power, 6.0 * vx - 4 * np.cos(3 * t) * vy, rtol=1e-8)


def test_parameters_are_those_of_the_chunk(make_scene: Make) -> None:
    scene = make_scene(2, "clamped", ("follower",))
    catalogue, plain = at_rest(scene, some_states(scene))
    model = rodgen.build(scene)
    p = model.parameters(**{**scene.parameters, "clamp_angle": 1.0, "follower_force": 5.0})
    chunk = Chunk(plain.t, plain.y, plain.work, plain.works, p)
    bend, load = catalogue.columns(["bend_0", "follower_force"], chunk).T
    np.testing.assert_allclose(bend, plain.y[:, 0] - 1.0, rtol=1e-14)
    np.testing.assert_array_equal(load, 5.0)


def test_each_group_is_made_once_and_only_if_asked_for(make_scene: Make) -> None:
    scene = make_scene(3, "free", TERMS)
    model, calls = rodgen.build(scene), []

    def counted(name: str) -> Any:
        def call(*arguments: Any) -> Any:
            calls.append(name)
            return getattr(model, name)(*arguments)

        return call

    names = ("joints", "energy", "inertia", "power", "centre_of_gravity", "bending_moments")
    members = {name: counted(name) for name in names}
    proxy: Any = SimpleNamespace(**{**vars(model), **members})
    catalogue = Catalogue(scene, proxy)
    _, chunk = at_rest(scene, some_states(scene))
    calls.clear()
    catalogue.columns(["phi_1", "t", "omega_2", "x0", "bend_1", "work_follower"], chunk)
    assert calls == []
    catalogue.columns(["tip_x", "joint_1_y", "kinetic_energy", "total_energy"], chunk)
    catalogue.columns(["energy_balance", "joint_0_x"], chunk)
    assert sorted(calls) == ["energy", "joints"]
    catalogue.columns(["tip_x"], chunk.last())
    assert sorted(calls) == ["energy", "joints", "joints"]


@pytest.mark.parametrize(
    ("name", "close"), [("phi_4", "phi_"), ("kinetic", "kinetic_energy"), (3, ""), (None, "")]
)
def test_an_unknown_name_is_refused_with_what_there_is(
    make_scene: Make, name: Any, close: str
) -> None:
    scene = make_scene(3)
    catalogue, chunk = at_rest(scene, some_states(scene))
    with pytest.raises(SceneError, match=rf"quantity = .*one of t, .*tip_x.*{close}"):
        catalogue.columns([name], chunk)
    with pytest.raises(SceneError, match="plot"):
        catalogue.expand(name, "plot")


def test_what_a_rod_does_not_have_is_not_offered(make_scene: Make) -> None:
    scene = make_scene(1)
    catalogue = Catalogue(scene, rodgen.build(scene))
    absent = {"bend", "bend_rate", "work", "power", "load"}
    assert absent.isdisjoint(catalogue.kinds)
    assert absent.isdisjoint(catalogue.along)
    every = [name for names in catalogue.kinds.values() for name in names]
    assert sorted(every) == sorted(catalogue.quantities)


@pytest.mark.nightly
def test_a_state_that_is_not_finite_gives_no_warning(make_scene: Make) -> None:
    scene = make_scene(2, "free", TERMS)
    y = some_states(scene)
    y[1, 3], y[2, 5] = np.inf, np.nan
    catalogue, chunk = at_rest(scene, y)
    names = list(catalogue.quantities)
    found = catalogue.columns(names, chunk)
    assert np.isfinite(found[0]).all()
    for name in ("tip_x", "total_energy", "inertia_x", "principal_angle", "principal_moment_1"):
        assert np.isnan(found[1, names.index(name)]), name


def test_labels_have_greek_and_subscripts(make_scene: Make) -> None:
    scene = make_scene(13)
    quantities = Catalogue(scene, rodgen.build(scene)).quantities
    assert quantities["phi_3"].label == "φ₃"
    assert quantities["omega_12"].label == "ω₁₂"
    assert quantities["bending_moment_10"].label == "M₁₀"
    assert quantities["vx0"].unit == "m/s"


def test_states_that_are_added_and_loads_that_follow_are_shown(make_scene: Make) -> None:
    table = make_scene(3).model_dump(exclude_none=True) | {
        "loads": {"follower": {"force": "20 + gimbal", "angle": "0.1*phi(0.5)"}},
        "states": {"gimbal": {"rate": "omega(1) - gimbal", "initial": 0.5}},
    }
    scene = Scene.from_dict(table)
    catalogue, chunk = at_rest(scene, some_states(scene))
    found = catalogue.columns(["gimbal", "follower_force", "omega_2"], chunk)
    np.testing.assert_array_equal(found[:, 0], chunk.y[:, -1])
    np.testing.assert_allclose(found[:, 1], 20 + chunk.y[:, -1], rtol=1e-15)
    np.testing.assert_array_equal(found[:, 2], chunk.y[:, -2])
    assert catalogue.kinds["state"] == ["gimbal"]


def test_momenta_are_those_of_the_centre_and_of_a_rigid_turn(make_scene: Make) -> None:
    """Mass times the velocity of the centre; moment of inertia times the rate of all links, however
    the rod moves on, and however bent it is."""
    scene = make_scene(4, "free", TERMS)
    y = some_states(scene)
    turning = y.copy()
    turning[:, 8:] = 0.7
    for states in (y, turning):
        catalogue, chunk = at_rest(scene, states)
        names = ("momentum_x", "momentum_y", "angular_momentum", "inertia_x", "inertia_y")
        speeds = ("centre_of_gravity_vx", "centre_of_gravity_vy")
        px, py, spin, ix, iy, vx, vy = catalogue.columns((*names, *speeds), chunk).T
        # The velocity is a difference of 1e-5 rad.
        assert px == pytest.approx(scene.mass * vx, rel=1e-8, abs=1e-8)
        assert py == pytest.approx(scene.mass * vy, rel=1e-8, abs=1e-8)
    assert spin == pytest.approx(0.7 * (ix + iy), rel=1e-12)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_curvature_times_stiffness_is_the_bending_moment(make_scene: Make, boundary: str) -> None:
    scene = make_scene(4, boundary, (), rod=clamped_at(boundary))
    catalogue, chunk = at_rest(scene, some_states(scene))
    springs = [name.removeprefix("curvature_") for name in catalogue.kinds["curvature"]]
    bent = catalogue.columns([f"curvature_{spring}" for spring in springs], chunk)
    moments = catalogue.columns([f"bending_moment_{spring}" for spring in springs], chunk)
    assert scene.rod.bending_stiffness * bent == pytest.approx(moments, rel=1e-12)


def test_supports_are_offered_where_they_are(make_scene: Make) -> None:
    """Each by itself, with its unit, and none for links without one or with one that does nothing:
    of what lies between two of them there is nothing to draw."""
    held = [{"at": 0.3, "stiffness": [3.0, 4.0]}, {"at": 0.9, "rotation": 2.0}, {"at": 0.5}]
    scene = make_scene(5, "free", ()).replace({"supports": held})
    catalogue, chunk = at_rest(scene, some_states(scene))
    offered = [name for name in catalogue.quantities if name.startswith("support_")]
    every = [f"support_force_{link}_{axis}" for axis in "xy" for link in (1, 4)]
    assert offered == [*every, "support_moment_1", "support_moment_4"]
    assert not [kind for kind in catalogue.along if kind.startswith("support")]
    motion = Piece(catalogue.model, chunk.p, chunk.y)
    force, moment = motion.values("support_force"), motion.values("support_moment")
    expected = [force[:, link, axis] for axis in (0, 1) for link in (1, 4)]
    expected += [moment[:, link] for link in (1, 4)]
    np.testing.assert_array_equal(catalogue.columns(offered, chunk), np.transpose(expected))
