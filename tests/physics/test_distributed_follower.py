"""A thrust all along the rod: Newton's law for the whole, and work that is energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen.check.module import check_module
from rodgen.integrate import simulate
from rodgen.loading import build
from rodgen.scene import Scene, SceneError
from rodgen.scene.structure import Structure
from tests.physics.sets import sets


def _rod(force: Any, **tables: Any) -> Scene:
    rod = {"links": 5, "length": 2.0, "mass": 3.0, "bending_stiffness": 20.0}
    loads = {"distributed_follower": {"force_per_length": force}}
    return Scene.from_dict({"name": "rod", "rod": rod, "loads": loads} | tables)


@pytest.mark.parametrize(
    ("force", "total"),
    # In closed form: five Gauss points integrate polynomials to degree 9 exactly.
    [(7.0, 14.0), ("a*s**9", 5.0), ([1.0, 2.0, 3.0, 4.0, 5.0], 6.0)],
)
def test_a_straight_free_rod_is_pushed_along_itself(force: Any, total: float) -> None:
    scene = _rod(force, parameters={"a": 25.0}, initial={"phi": 0.3})
    model, y = build(scene), scene.initial_state()
    p = model.parameters(**scene.parameters)
    rates = model.rhs(0.0, y, p)[len(y) // 2 :]
    push = -total * np.array([np.cos(0.3), np.sin(0.3)])
    np.testing.assert_allclose(rates[:2], push / 3.0, rtol=1e-13)
    assert np.abs(rates[2:]).max() < 1e-12 * total
    forces = model.forces(0.0, y, p)["distributed_follower"]
    np.testing.assert_allclose(forces.sum(axis=0), push, rtol=1e-13)


def test_what_is_no_force_along_the_rod_is_refused() -> None:
    for force in ("1/max(0, s - 0.5)", "phi(0.5)", "x", [1.0, 2.0], float("nan"), None):
        with pytest.raises(SceneError) as refused:
            _rod(force).parameters  # noqa: B018
        assert refused.value.field == "loads.distributed_follower.force_per_length"


BURN = "a*s**2*min(t/0.2, 1)"


def test_it_may_change_with_time_and_place() -> None:
    """A straight free rod: M v = -the integral of a/3 L min(t/0.2, 1), a parabola and a line."""
    scene = _rod(BURN, parameters={"a": 9.0}, integrate={"span": [0, 0.5], "rtol": 1e-10})
    assert scene.breaks() == [pytest.approx(0.2, rel=1e-15)]
    assert scene.structure.hash == _rod(BURN, parameters={"a": 8.0}).structure.hash
    sol = simulate(scene)
    t = sol.t
    impulse = 6.0 * np.where(t < 0.2, t**2 / 0.4, t - 0.1)
    half = sol.y.shape[1] // 2
    np.testing.assert_allclose(sol.y[:, half], -impulse / 3.0, atol=1e-9)
    assert sol.energy_error < 1e-9


@pytest.mark.parametrize("form", sets([], slow=["dense"], nightly=["chain"]))
def test_its_module_equals_fifty_digit_arithmetic(form: str) -> None:
    expressions = (("distributed_follower", "q0*(1 - s)*sin(w*t) + max(s, t)"),)
    # Beside a force with more power: its own is next to none where the rod is straight.
    terms = ("follower", "distributed_follower")
    structure = Structure(3, "clamped", "uniform", terms, expressions)
    assert max(d.error for d in check_module(build(structure, "numpy", form), states=2)) < 1e-12


@pytest.mark.slow
@pytest.mark.compiler
def test_lanes_take_numbers_of_their_own() -> None:
    expressions = (("distributed_follower", "q0*(1 - s)*sin(w*t)"),)
    structure = Structure(3, "clamped", "uniform", ("distributed_follower",), expressions)
    one, other = build(structure), build(structure, "c")
    P = np.array([[1.0, 2.0, 30.0, 0.0, q, 3.0] for q in range(9)])
    Y = np.random.default_rng(1).standard_normal((9, 6))
    single = [one.rhs(0.4, y, p) for y, p in zip(Y, P, strict=True)]
    # Other orders of the same sums.
    np.testing.assert_allclose(other.rhs_batch(0.4, Y, P), single, rtol=1e-11, atol=1e-11)
    J = one.jac(0.4, Y[0], P[5])
    np.testing.assert_allclose(other.jac(0.4, Y[0], P[5]), J, rtol=0, atol=1e-11 * np.abs(J).max())
