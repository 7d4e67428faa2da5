"""Rods that differ along their length and carry bodies, held against laws and known limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.loading import build
from rodgen.scene import Scene
from tests.agreement import assert_implicit_steps_are_explicit
from tests.sets import sets

TAPERED: dict[str, Any] = {"links": 4, "length": 2.0}
TAPERED |= {"bending_stiffness": "40*(1 - 0.6*s)", "mass_per_length": "3*(1 - 0.7*s)"}
BODIES: list[dict[str, Any]] = [
    {"name": "payload", "at": 0.0, "mass": 2.0, "inertia": 0.1, "offset": [0.05, -0.1]},
    {"name": "engine", "at": 0.7, "mass": 4.0, "offset": [0.0, 0.2]},
]
PUSHED = {"follower": {"force": 20.0, "angle": 0.1}, "gravity": {}}


def _scene(rod: dict[str, Any], **tables: Any) -> Scene:
    return Scene.from_dict({"name": "nonuniform", "rod": rod, **tables})


def _state(scene: Scene) -> np.ndarray:
    y: np.ndarray = np.random.default_rng(1).uniform(-1, 1, len(scene.initial_state()))
    return y


def test_a_free_rod_keeps_its_energy_and_its_centre_falls() -> None:
    """Whatever the rod does; and its momenta are those of the mass matrix."""
    start = {"phi": "0.4*sin(5*s)", "omega": "2*s"}
    tables = {"loads": {"gravity": {"g": 2.0}}, "integrate": {"span": [0.0, 1.0]}}
    scene = _scene(TAPERED, bodies=BODIES, initial=start, **tables)
    sol = rodgen.simulate(scene, target="numpy", method="dop853", rtol=1e-11, atol=1e-12)
    model = build(scene, "numpy")
    p = model.parameters(**scene.parameters)
    ends = [(model.mass_matrix(y, p) @ y[len(y) // 2 :])[:2] for y in (sol.y[0], sol.y[-1])]
    # Tolerances of the run over some hundred steps.
    np.testing.assert_allclose(ends[1] - ends[0], [0.0, -2.0 * scene.mass], atol=1e-8)
    assert sol.energy_error < 1e-8
    t = sol.t[:, None]
    path = sol.centre_of_gravity[0] + ends[0] / scene.mass * t - [0.0, 1.0] * t**2
    np.testing.assert_allclose(sol.centre_of_gravity, path, atol=1e-8)


def test_a_body_like_part_of_the_rod_changes_nothing() -> None:
    """The second half of an even rod as a body of its own: its mass, place and moment."""
    whole = _scene({"links": 1, "length": 2.0, "mass": 6.0, "bending_stiffness": 1.0}, loads=PUSHED)
    half = {"name": "half", "at": 0.0, "mass": 3.0, "inertia": 3.0 / 12, "offset": [1.5, 0.0]}
    light = half | {"name": "rest", "mass": 3.0 - 1e-9, "offset": [0.5, 0.0]}
    rod = {"links": 1, "length": 2.0, "mass": 1e-9, "bending_stiffness": 1.0}
    parts = _scene(rod, bodies=[half, light], loads=PUSHED)
    y = _state(whole)
    one, two = (build(s, "numpy") for s in (whole, parts))
    due = one.rhs(0.0, y, one.parameters(**whole.parameters))
    np.testing.assert_allclose(two.rhs(0.0, y, two.parameters(**parts.parameters)), due, rtol=1e-8)


def test_bodies_are_drawn_where_their_mass_is() -> None:
    """The centre of gravity of the whole is that of links and bodies at their places."""
    scene = _scene(TAPERED, bodies=BODIES, loads={"gravity": {}})
    model, y = build(scene, "numpy"), _state(scene)
    joints = model.joints(y, model.parameters(**scene.parameters))
    marks, links = scene.distribution.body_outlines, scene.distribution.link_masses
    places = np.concatenate(((joints[1:] + joints[:-1]) / 2, [m.positions(joints) for m in marks]))
    masses = [*links, *(body.mass for body in scene.bodies)]
    centre = model.centre_of_gravity(y, model.parameters(**scene.parameters))
    np.testing.assert_allclose(np.average(places, axis=0, weights=masses), centre, rtol=1e-12)
    assert [mark.size**2 * scene.mass for mark in marks] == pytest.approx([2.0, 4.0])
    assert scene.mass == pytest.approx(2.0 + 4.0 + 3 * 2.0 * (1 - 0.35), rel=1e-14)


@pytest.mark.parametrize("inertia", sets(["uniform"], slow=["lumped"]))
def test_a_huge_body_at_the_nose_pins_it(inertia: str) -> None:
    rod = TAPERED | {"inertia": inertia}
    wall = {"name": "wall", "at": 0.0, "mass": 1e11}
    huge = _scene(rod, bodies=[wall], loads={"gravity": {"g": 0.0}})
    pinned = _scene(rod | {"boundary": "pinned"})
    y = _state(pinned)
    n = len(y) // 2
    state = np.concatenate(([0.0, 0.0], y[:n], [0.0, 0.0], y[n:]))
    one, two = (build(s, "numpy") for s in (huge, pinned))
    free = one.rhs(0.0, state, one.parameters(**huge.parameters))
    held = two.rhs(0.0, y, two.parameters(**pinned.parameters))
    # The ratio of the masses, and as many digits as are lost to it.
    np.testing.assert_allclose(free[-n:], held[-n:], rtol=1e-8, atol=1e-8)


@pytest.mark.nightly
def test_pflueger_column() -> None:
    """A column under a follower force with a mass at its tip as large as its own: flutter at
    16.21212894249526 EI/L^2."""
    scene = Scene.example("pflueger")
    forces = {
        links: rodgen.critical_load(scene.with_links(links)).value for links in (5, 10, 20, 40)
    }
    found = rodgen.richardson(list(forces), list(forces.values()))
    assert found.value == pytest.approx(16.21212894249526, rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("bodies", [True, False])
def test_ziegler_pendulum(bodies: bool) -> None:
    """Masses 2m and m on massless links of length l, springs k: flutter at P l/k = 7/2 - sqrt 2
    (H. Ziegler, Ing.-Arch. 20 (1952) 49-56), be the masses those of the links or bodies too."""
    scene = Scene.example("ziegler")
    if bodies:
        elbow, end = (
            {"name": "elbow", "at": 2 / 3, "mass": 1.0},
            {"name": "end", "at": 1.0, "mass": 0.5},
        )
        # Of the 3 kg of the links 1 kg and 0.5 kg stand in the joints.
        scene = scene.replace({"rod.mass": 3.0, "bodies": [elbow, end]})
    found = rodgen.critical_load(scene)
    assert found.kind == "flutter"
    assert found.value == pytest.approx(3.5 - np.sqrt(2), rel=1e-9)


@pytest.mark.slow
def test_a_body_at_rest_is_its_weight() -> None:
    """As heavy as the rod, at its tail."""
    rod, mass = TAPERED | {"boundary": "clamped"}, 3.9
    held = _scene(rod, bodies=[{"name": "twin", "at": 1.0, "mass": mass}], loads={"gravity": {}})
    loaded = _scene(rod, loads={"gravity": {}, "tip": {"y": -mass * 9.81}})
    assert held.mass == pytest.approx(2 * mass)
    rests = [rodgen.static_equilibrium(scene) for scene in (held, loaded)]
    np.testing.assert_allclose(rests[0].phi, rests[1].phi, rtol=1e-8)
    assert abs(rests[0].phi[-1]) > 0.5


@pytest.mark.nightly
@pytest.mark.parametrize("boundary", ["clamped", "free"])
def test_critical_forces_of_a_tapered_damped_rod_are_of_second_order(boundary: str) -> None:
    """Masses at both ends, and one with inertia in the middle of a link, whose angle is there that
    of the rod."""
    loads = {"follower": {"force": 1.0}, "material_damping": {"time": 1e-3}}
    bodies = [
        {"name": "payload", "at": 0.0, "mass": 2.0},
        {"name": "wheel", "at": 0.5, "mass": 1.0, "inertia": 0.2},
        {"name": "engine", "at": 1.0, "mass": 4.0},
    ]
    found = []
    for links in (9, 27, 81):
        rod = TAPERED | {"links": links, "boundary": boundary}
        found.append(rodgen.critical_load(_scene(rod, bodies=bodies, loads=loads)).value)
    order = np.log((found[1] - found[0]) / (found[2] - found[1])) / np.log(3)
    assert order == pytest.approx(2.0, abs=0.1)


@pytest.mark.nightly
def test_implicit_steps_are_explicit_ones() -> None:
    """The Newton matrix of a rod with bodies, in C, against a method that has none."""
    drag = {"external_damping": {"coefficient": 0.3}, "material_damping": {"time": 0.01}}
    tables = {"initial": {"phi": "0.2*s"}, "integrate": {"span": [0.0, 0.5]}}
    scene = _scene(TAPERED, bodies=BODIES, loads=PUSHED | drag, **tables)
    # Tolerances over the steps of half a second.
    assert_implicit_steps_are_explicit(scene, 1e-7, target="c")
