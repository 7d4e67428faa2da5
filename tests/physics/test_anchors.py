"""Rods on supports and foundations, against limits, what is known of beams, and energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.references.follower_columns import beck
from rodgen.loading import build
from rodgen.model.rod import BOUNDARIES
from rodgen.scene import Scene
from rodgen.show.time_pictures import shapes
from tests.sets import sets
from tests.told import refused

ROD = {"links": 4, "length": 2.0, "mass": 6.0, "bending_stiffness": 10.0}


def _scene(boundary: str, rod: dict[str, Any] | None = None, **tables: Any) -> Scene:
    table = {"name": "held", "rod": ROD | {"boundary": boundary} | (rod or {})}
    return Scene.from_dict(table | tables)


SUPPORTS = [
    {"at": 0.0, "stiffness": [3.0, 40.0], "damping": [0.5, 0.0], "rotation": 2.0},
    {"at": 0.37, "stiffness": [0.0, 25.0], "to": [0.7, 0.1], "rotation_damping": 0.3},
    {"at": 1.0, "stiffness": [7.0, 0.0], "damping": [0.0, 1.5]},
]
BOTH: dict[str, Any] = {
    "supports": SUPPORTS,
    "foundation": {"stiffness": "40*(1 + s)", "damping": 1.5},
}


@pytest.mark.parametrize("boundary", sets([], slow=["free"], nightly=BOUNDARIES))
def test_squared_frequencies_grow_by_stiffness_over_mass(boundary: str) -> None:
    """Of a beam on a foundation omega^2 + k/m; with the mass in the joints, as the foundation has
    its springs, of every number of links."""
    rod = {"inertia": "lumped"}
    bare = rodgen.natural_modes(_scene(boundary, rod), 3).frequencies
    held = rodgen.natural_modes(_scene(boundary, rod, foundation={"stiffness": 90.0}), 6)
    raised = np.sqrt(bare**2 + 90.0 / 3.0 / (2 * np.pi) ** 2)
    for frequency in raised:
        assert np.abs(held.frequencies - frequency).min() < 1e-8 * frequency
    rest = np.sqrt(30.0) / (2 * np.pi)  # of a rod that moves as a whole
    whole = {"free": 2, "pinned": 1}.get(boundary, 0)
    assert (np.abs(held.frequencies - rest) < 1e-8 * rest).sum() == whole


@pytest.mark.nightly
def test_a_foundation_does_not_change_the_critical_force_of_becks_column() -> None:
    """T. E. Smith and G. Herrmann, J. Appl. Mech. 39 (1972)."""
    forces = []
    for stiffness in (0.0, 100.0):
        founded = {"foundation": {"stiffness": stiffness}}
        found = rodgen.critical_load(Scene.example("foundation").replace(founded))
        assert found.kind == "flutter"
        forces.append(found.value)
    assert forces[0] == pytest.approx(forces[1], rel=1e-9)
    # The error of 40 links is 0.3 %.
    assert forces[1] == pytest.approx(beck().load, rel=5e-3)


def test_a_weight_on_a_foundation_settles_evenly() -> None:
    """A free rod goes down by m g/k: its joints have mass and springs alike."""
    scene = _scene(
        "free",
        {"inertia": "lumped"},
        foundation={"stiffness": 100.0, "damping": 30.0},
        loads={"gravity": {"g": 10.0}},
        integrate={"span": [0.0, 30.0]},
    )
    sol = rodgen.simulate(scene, target="numpy", rtol=1e-10)
    np.testing.assert_allclose(sol.joints[-1, :, 1], -6.0 / 2.0 * 10.0 / 100.0, rtol=1e-8)


def test_a_support_against_turning_is_the_root_of_a_clamped_rod() -> None:
    """A spring of 2 EI/l that holds link 0 of a pinned rod."""
    rotation = 2 * 10.0 / (2.0 / 4)
    held = _scene("pinned", supports=[{"at": 0.0, "rotation": rotation}])
    rates = []
    for scene in (held, _scene("clamped")):
        model = build(scene, "numpy")
        p = model.parameters(**scene.parameters)
        y = np.linspace(-1, 1, 8)
        rates.append(np.append(model.rhs(0.0, y, p), model.energy(y, p)))
    np.testing.assert_allclose(rates[0], rates[1], rtol=1e-12)


@pytest.mark.nightly
def test_a_propped_rod_by_extrapolation() -> None:
    """Clamped and simply supported at the other end: (beta L)^2 of tan = tanh, 15.41820571698."""
    links, prop = (10, 20, 40), [{"at": 1.0, "stiffness": [0.0, 1e9]}]
    scenes = [_scene("clamped", {"links": n}, supports=prop) for n in links]
    found = [2 * np.pi * rodgen.natural_modes(scene, 1).frequencies[0] for scene in scenes]
    limit = rodgen.richardson(links, found).value / np.sqrt(10.0 / (3.0 * 2.0**4))
    assert limit == pytest.approx(15.41820571698, rel=1e-5)


def test_supports_of_one_point_are_one() -> None:
    two = [
        {"at": 0.5, "stiffness": [0.0, 10.0], "to": [1.0, 0.3], "damping": [0.0, 1.0]},
        {"at": 0.5, "stiffness": [4.0, 30.0], "to": [1.0, -0.1], "rotation": 2.0},
    ]
    one = {"at": 0.5, "stiffness": [4.0, 40.0], "to": [1.0, 0.0]}
    one |= {"damping": [0.0, 1.0], "rotation": 2.0}
    together, single = (_scene("clamped", supports=of).parameters for of in (two, [one]))
    assert set(together) == set(single)
    for name, value in single.items():
        np.testing.assert_allclose(together[name], value, atol=1e-15)
    # Each way has numbers of its own, those of link 2.
    ways = {"x": 1.0, "y": 0.0, "stiffness_x": 4.0, "stiffness_y": 40.0}
    ways |= {"damping_x": 0.0, "damping_y": 1.0, "rotation": 2.0, "rotation_damping": 0.0}
    assert {way: single[f"support_{way}"][2] for way in ways} == ways


@pytest.mark.parametrize(
    ("boundary", "rod", "initial", "rest"),
    [
        ("free", {}, {"position": [0.5, -0.3]}, (0.5 + 1.5, -0.3)),
        ("clamped", {"clamp_angle": np.pi / 6}, {}, (1.5 * np.sqrt(3) / 2, 0.75)),
    ],
)
def test_a_support_rests_where_the_straight_rod_has_its_point(
    boundary: str, rod: dict[str, Any], initial: dict[str, Any], rest: tuple[float, float]
) -> None:
    """At 3/4 of 2 m from joint 0, which is on link 3 of 4."""
    support = {"at": 0.75, "stiffness": [1.0, 2.0]}
    scene = _scene(boundary, rod, supports=[support], initial=initial)
    found = [scene.parameters[f"support_{axis}"][3] for axis in "xy"]
    np.testing.assert_allclose(found, rest, rtol=1e-15)


def test_pictures_show_where_supports_are_fixed() -> None:
    scene = _scene("free", integrate={"span": [0.0, 0.1]}, **BOTH)
    axes, *_ = shapes(rodgen.simulate(scene, target="numpy")).axes
    fixed = {tuple(line.get_xydata()[0]) for line in axes.lines if line.get_marker() == "^"}
    assert fixed == {(0.0, 0.0), (0.7, 0.1), (2.0, 0.0)}
    springs = [line.get_xydata() for line in axes.lines if line.get_linestyle() == ":"]
    assert any(np.allclose(spring[0], (0.74, 0.0), atol=1e-3) for spring in springs)


@pytest.mark.parametrize(
    ("table", "given", "field"),
    [
        ("supports", {"at": 0.5}, ""),
        ("supports", [{}], "[0].at"),
        ("supports", [{"at": 1.5}], "[0].at"),
        ("supports", [{"at": 0.5}, {"at": 0.5, "stiffness": [1.0]}], "[1].stiffness"),
        ("supports", [{"at": 0.5, "stiffness": [1.0, -1.0]}], "[0].stiffness.1"),
        ("supports", [{"at": 0.5, "rotation": -1.0}], "[0].rotation"),
        ("supports", [{"at": 0.41}, {"at": 0.45}], "[1].at"),
        ("supports", [{"at": 0.1}], "[0].at"),
        ("foundation", {}, ".stiffness"),
        *(("foundation", {"stiffness": k}, ".stiffness") for k in (-1.0, "1 - 2*s", "1/s", "t")),
        ("foundation", {"stiffness": 1.0, "damping": -1.0}, ".damping"),
        ("foundation", {"stiffness": 1.0, "depth": 1.0}, ".depth"),
    ],
)
def test_what_holds_no_rod_is_refused(table: str, given: Any, field: str) -> None:
    assert refused(_scene, "cantilever", **{table: given}).field == table + field
