"""Rods whose springs have a law of their own, against what one spring does and conserved energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import rodgen
from rodgen.check.module_check import check_module
from rodgen.emit.targets import FORMS
from rodgen.errors import InputError
from rodgen.loading import build
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.scene import Scene
from tests.agreement import assert_implicit_steps_are_explicit, differences
from tests.palette import cases
from tests.sets import sets

CUBIC, CAPPED = "k*(d + 5*d**3)", "min(max(k*d, -4), 6)"
# Rounding of some hundred operations.
ROUNDING = 1e-12


def _scene(spring: str, boundary: str = "clamped", links: int = 3, **tables: Any) -> Scene:
    rod = {"links": links, "length": 2.0, "mass": 3.0, "bending_stiffness": 8.0}
    rod |= {"boundary": boundary, "spring": spring}
    rod |= tables.pop("rod", {})
    return Scene.from_dict({"name": "law", "rod": rod, **tables})


@cases("boundary, form, inertia, spring", BOUNDARIES, FORMS, INERTIAS, (CUBIC, CAPPED))
def test_modules_agree_with_fifty_digits(
    boundary: str, form: str, inertia: str, spring: str
) -> None:
    loads = {"gravity": {}, "material_damping": {"time": 0.02}}
    scene = _scene(spring, boundary, rod={"inertia": inertia}, loads=loads)
    found = list(check_module(build(scene.structure, "numpy", form)))
    assert max(one.error for one in found) < ROUNDING


@pytest.mark.nightly
def test_implicit_steps_are_explicit_ones_and_energy_is_kept() -> None:
    scene = _scene(CUBIC, initial={"phi": "2*s"}, integrate={"span": [0.0, 1.0]})
    # Tolerances over the steps of a second, in which springs take and give some 40 J.
    assert_implicit_steps_are_explicit(scene, 1e-6, 1e-7)


@pytest.mark.parametrize(
    ("spring", "stiffness"),
    sets([(CUBIC, 8.0)], slow=[("k*tanh(3*d) + d*abs(d)", "8*(1 - 0.5*s)")]),
)
def test_derivatives_are_differences(spring: str, stiffness: Any) -> None:
    scene = _scene(spring, rod={"bending_stiffness": stiffness})
    model = build(scene, "numpy")
    p = model.parameters(**scene.parameters)
    y = np.random.default_rng(1).uniform(-1, 1, len(scene.initial_state()))
    J = model.jac(0.0, y, p)
    np.testing.assert_allclose(J, differences(model.rhs, 0.0, y, p), atol=1e-8 * np.abs(J).max())


@pytest.mark.slow
def test_one_spring_bears_its_load_and_swings_about_it() -> None:
    """One link of length 2 on a root spring of k = 2 EI/l = 8, weight and a tip load."""
    loads = {"tip": {"y": -30.0}}
    scene = _scene(CUBIC, links=1, loads=loads)

    def moment(d: float) -> float:
        return 8 * (d + 5 * d**3)

    rest = brentq(lambda d: moment(d) + 30 * 2 * np.cos(d), -1.5, 0.0, xtol=1e-14)
    found = rodgen.static_equilibrium(scene)
    assert found.phi[0] == pytest.approx(rest, abs=1e-10)
    slope = 8 * (1 + 15 * rest**2) - 30 * 2 * np.sin(rest)
    frequency = np.sqrt(slope / (3.0 * 2.0**2 / 3)) / (2 * np.pi)
    modes = rodgen.natural_modes(scene, 1)
    assert modes.frequencies[0] == pytest.approx(frequency, rel=1e-8)


def test_period_of_one_spring() -> None:
    """A quarter period is the integral of dphi/omega, which energy gives (phi = 1 sin u)."""
    scene = _scene(
        CUBIC, links=1, initial={"phi": 1.0}, integrate={"span": [0.0, 5.0], "rtol": 1e-11},
        events=[{"quantity": "phi_0", "value": 0.0, "name": "through"}],
    )  # fmt: skip
    sol = rodgen.simulate(scene, target="numpy", method="dop853", atol=1e-12)
    inertia = 3.0 * 2.0**2 / 3

    def slowness(u: float) -> float:
        return 1 / np.sqrt(2 * 8 / inertia * (1 / 2 + 5 / 4 * (1 + np.sin(u) ** 2)))

    quarter = quad(slowness, 0, np.pi / 2, epsabs=1e-13)[0]
    assert [e.t for e in sol.events[:2]] == pytest.approx([quarter, 3 * quarter], abs=1e-8)


@pytest.mark.slow
def test_a_straight_rod_buckles_by_the_slope_at_zero() -> None:
    load = {"follower": {"force": 1.0}}
    linear, twice = (
        rodgen.critical_load(_scene(spring, loads=load)).value for spring in ("k*d", "k*sin(2*d)")
    )
    assert twice == pytest.approx(2 * linear, rel=1e-9)
    with pytest.raises(InputError, match=r"rod\.spring"):
        rodgen.critical_load(_scene("k*d**3", loads=load))


@pytest.mark.slow
def test_a_rod_that_is_bent_by_itself() -> None:
    """Springs that are at rest at 0.1 rad, in the root as between links."""
    found = rodgen.static_equilibrium(_scene("k*(d - 0.1)"))
    np.testing.assert_allclose(found.phi, 0.1 * np.arange(1, 4), atol=1e-12)
