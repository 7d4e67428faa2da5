"""Quantities of the live view by second routes: a Solution's own, exact motions, kinematics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from live.tests.runs import prepared
from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.model.quantities import watchable_names
from rodgen.model.rod import BOUNDARIES
from rodgen.model.terms import THESIS_TERMS
from rodgen.scene import Scene
from rodgen_live.plot_quantities import KINDS, Catalogue
from rodgen_live.sample_store import Chunk
from tests.palette import ALL, ENDS

Make = Callable[..., Scene]
# Links, terms and more of [rod], for each boundary, of structures that others build too.
HELD: dict[str, tuple[int, tuple[str, ...], dict[str, Any]]] = {
    "free": (5, THESIS_TERMS, {}),
    "pinned": (3, ("internal_damping",), {"inertia": "lumped"}),
    "clamped": (3, ENDS, {"clamp_angle": 0.4}),
    "cantilever": (2, ALL, {"clamp_angle": 0.4}),
}


def held(make_scene: Make, boundary: str, **integrate: Any) -> Scene:
    links, terms, rod = HELD[boundary]
    return make_scene(links, boundary, terms, rod=rod, **integrate)


def at_rest(scene: Scene, y: Array, t: Array | None = None) -> tuple[Catalogue, Chunk]:
    """States (K, states) that nobody has integrated."""
    catalogue, chunk = prepared(scene)
    return catalogue, chunk(np.arange(float(len(y))) if t is None else t, y)


def some_states(scene: Scene, count: int = 3) -> Array:
    return np.random.default_rng(7).normal(size=(count, len(scene.initial_state())))


@pytest.mark.slow
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


def test_supports_are_offered_where_they_are(make_scene: Make) -> None:
    """Each by itself, with its unit, and none for links without one or with one that does nothing:
    of what lies between two of them there is nothing to draw."""
    points = [{"at": 0.3, "stiffness": [3.0, 4.0]}, {"at": 0.9, "rotation": 2.0}, {"at": 0.5}]
    scene = make_scene(5, "free", ()).replace({"supports": points})
    catalogue, chunk = at_rest(scene, some_states(scene))
    offered = [name for name in catalogue.quantities if name.startswith("support_")]
    every = [f"support_force_{link}_{axis}" for axis in "xy" for link in (1, 4)]
    assert offered == [*every, "support_moment_1", "support_moment_4"]
    assert not [kind for kind in catalogue.along if kind.startswith("support")]
    motion = MotionSlice(catalogue.model, chunk.p, chunk.y)
    force, moment = motion.values("support_force"), motion.values("support_moment")
    expected = [force[:, link, axis] for axis in (0, 1) for link in (1, 4)]
    expected += [moment[:, link] for link in (1, 4)]
    np.testing.assert_array_equal(catalogue.columns(offered, chunk), np.transpose(expected))


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_quantities_that_depend_on_how_a_rod_is_held(make_scene: Make, boundary: str) -> None:
    """All that events can watch, and so what moves; curvature, which times the stiffness is the
    bending moment; places of joints."""
    scene = held(make_scene, boundary)
    n, y = scene.rod.links, some_states(scene)
    l = scene.rod.length / n
    catalogue, chunk = at_rest(scene, y)
    quantities, kinds = catalogue.quantities, catalogue.kinds
    # Zero without gravity, and not offered.
    light = set() if "gravity" in HELD[boundary][1] else {"gravity_energy"}
    every = {
        name.format(at)
        for name, numbers in watchable_names(scene.boundary_condition, n)
        for at in numbers
    }
    assert every | set(catalogue.model.STATE) <= set(quantities) | light
    assert not light & set(quantities)
    for name, quantity in quantities.items():
        assert (quantity.name, quantity.unit) == (name, KINDS[quantity.kind].unit)
    np.testing.assert_array_equal(catalogue.columns(list(catalogue.model.STATE), chunk), y)
    springs = [name.removeprefix("curvature_") for name in kinds["curvature"]]
    bent, moments = (
        catalogue.columns([f"{kind}_{spring}" for spring in springs], chunk)
        for kind in ("curvature", "bending_moment")
    )
    assert scene.rod.bending_stiffness * bent == pytest.approx(moments, rel=1e-12)
    phi = catalogue.columns(kinds["phi"], chunk)
    start = y[:, :2] if boundary == "free" else np.zeros((3, 2))
    along = l * np.stack((np.cos(phi), np.sin(phi)), axis=-1)
    places = start[:, None] + np.concatenate((np.zeros((3, 1, 2)), along.cumsum(axis=1)), axis=1)
    for axis, name in enumerate("xy"):
        found = catalogue.columns([*kinds[f"joint_{name}"], f"tip_{name}"], chunk)
        expected = np.concatenate((places[..., axis], places[:, -1:, axis]), axis=1)
        np.testing.assert_allclose(found, expected, atol=1e-14)  # of some metres


def test_loads_powers_and_balance_are_those_of_the_chunk(make_scene: Make) -> None:
    """At its times, with its parameters, and the energy that was given to it."""
    scene = held(make_scene, "clamped")
    t = np.array([0.0, 0.3, 1.7])
    catalogue, plain = at_rest(scene, some_states(scene), t)
    assert catalogue.kinds["load"] == ["follower_force", "tip_force_x", "tip_force_y"]
    found = catalogue.columns(catalogue.kinds["load"], plain)
    np.testing.assert_allclose(found.T, [[40.0] * 3, [6.0] * 3, -4 * np.cos(3 * t)], rtol=1e-14)
    # A dead force at the tail has the power F.v.
    vx, vy = catalogue.columns(["tip_vx", "tip_vy"], plain).T
    power = catalogue.columns(["power_tip_load"], plain)[:, 0]
    np.testing.assert_allclose(power, 6.0 * vx - 4 * np.cos(3 * t) * vy, rtol=1e-8)
    total = catalogue.columns(["total_energy"], plain)[:, 0]
    work = np.outer([0.5, 1.5, -2.0], np.ones(len(plain.works)))
    p = catalogue.model.parameters(**{**scene.parameters, "follower_force": 5.0})
    chunk = Chunk(t, plain.y, work, plain.works, p, given=7.0, start=11.0)
    names = ["energy_balance", "work_follower", "follower_force"]
    balance, by, load = catalogue.columns(names, chunk).T
    # Rounding of some tens of joules.
    np.testing.assert_allclose(balance, total - 11.0 - work.sum(axis=1) - 7.0, atol=1e-12)
    np.testing.assert_array_equal(by, work[:, 0])
    np.testing.assert_array_equal(load, 5.0)


def test_what_a_rod_does_not_have_is_neither_offered_nor_known(make_scene: Make) -> None:
    scene = make_scene(1)
    catalogue, chunk = at_rest(scene, some_states(scene))
    absent = {"bend", "bend_rate", "work", "power", "load"}
    assert absent.isdisjoint(catalogue.kinds)
    assert absent.isdisjoint(catalogue.along)
    every = [name for names in catalogue.kinds.values() for name in names]
    assert sorted(every) == sorted(catalogue.quantities)
    for name in ("phi_4", "kinetic", 3, None):
        with pytest.raises(InputError, match=r"^quantity = .*tip_x"):
            catalogue.columns([name], chunk)
        with pytest.raises(InputError, match=r"^plot"):
            catalogue.expand(name, "plot")
