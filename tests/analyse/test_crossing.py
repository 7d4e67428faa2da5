"""The equations of an eigenvalue on the imaginary axis: their derivatives against differences, and
one Hopf point by three analyses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csc_array

import rodgen
from rodgen.analyse.crossing import (
    Border,
    CrossingKind,
    Divergence,
    Flutter,
    NearSingular,
    UndampedFlutter,
)
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.hopf import HopfPoint, first_hopf, read_hopf
from rodgen.analyse.pencil import MatrixPencil
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.scene import Scene
from rodgen.system import ParameterRange, System
from tests.analyse.rods import FORCE, ONES, eigenvalues, rod

SIZE, NUMBERS = 4, 2
STEP = 1e-6  # of differences of second order, whose errors are its square: some 1e-10
RANDOM = np.random.default_rng(5)
HERE, *SLOPES = (MatrixPencil(*RANDOM.normal(size=(3, SIZE, SIZE))) for _ in range(1 + NUMBERS))
BORDER = Border(*RANDOM.normal(size=(2, SIZE)))
OMEGA = 1.3
INTERNAL = "loads.internal_damping.coefficient"


@pytest.mark.parametrize("kind", [Divergence(), Flutter(), UndampedFlutter()])
def test_derivatives_of_a_crossing(kind: CrossingKind) -> None:
    def residual(number: int | None, step: float) -> Array:
        here = HERE if number is None else HERE.add(SLOPES[number], step)
        omega = OMEGA + (step if number is None else 0.0)
        return kind.equations(here, SLOPES, BORDER, omega).residual

    def difference(number: int | None) -> Array:
        return (residual(number, STEP) - residual(number, -STEP)) / (2 * STEP)

    made = kind.equations(HERE, SLOPES, BORDER, OMEGA)
    for number in range(NUMBERS):
        np.testing.assert_allclose(made.by_numbers[:, number], difference(number), rtol=1e-7)
    for by_omega in made.by_omega.T:  # of divergence there is none
        np.testing.assert_allclose(by_omega, difference(None), rtol=1e-7)


@pytest.mark.parametrize("change", [np.array, csc_array], ids=["full", "sparse"])
@pytest.mark.parametrize("s", [0.0, 1.3j], ids=["real", "complex"])
def test_a_border_makes_a_singular_matrix_regular(change: Callable[[Array], Any], s: Any) -> None:
    """A matrix less an eigenvalue of its own: both null vectors, and a border with the signs of one
    before."""
    S = HERE.at(s) if s else HERE.S0 + HERE.S0.T  # whose eigenvalues are real
    S = S - np.linalg.eigvals(S)[0] * np.eye(SIZE)
    assert np.iscomplexobj(S) == bool(s)
    border = Border.of(change(S))
    near = NearSingular(change(S), border)
    assert abs(near.g) < 1e-12
    for vector, matrix in ((near.right, S), (near.left, S.T)):
        np.testing.assert_allclose(matrix @ vector, 0.0, atol=1e-12)
    other = Border(*(-part for part in border))
    for one, two in zip(Border.of(change(S), other), other, strict=True):
        np.testing.assert_allclose(one, two, atol=1e-12)


def hopf_of(scene: Scene, bounds: tuple[float, float], key: str = FORCE) -> HopfPoint:
    """The Hopf point in which cycles begin."""
    search = CycleSearch.of(System(scene), "numpy")
    return first_hopf(search, ParameterRange(search.system, key, bounds))[0]


@pytest.mark.parametrize(
    ("boundary", "tau", "bounds", "more"),
    [
        ("clamped", 0.02, (5.0, 40.0), {}),
        ("free", 0.003, (200.0, 50.0), {}),
        ("pinned", 0.003, (20.0, 80.0), {"bodies": [{"name": "p", "at": 0.5, "mass": 3.0}]}),
    ],
    ids=["held", "free, downwards", "turning freely"],
)
def test_three_analyses_have_one_hopf_point(
    boundary: str, tau: float, bounds: tuple[float, float], more: dict[str, Any]
) -> None:
    """The branch of equilibria, where cycles begin, and for one that is stable before it the search
    along a load; there an eigenvalue of the module's Jacobian lies on the imaginary axis."""
    loads = {"follower": {"force": 1.0}, "material_damping": {"time": tau}}
    scene = rod(5, boundary, loads, **ONES, **more)
    branch, hopf = rodgen.continue_equilibria(scene, FORCE, bounds), hopf_of(scene, bounds)
    at = branch["special_kind"].values.tolist().index("hopf")
    value, frequency = (float(branch[f"special_{x}"][at]) for x in ("value", "frequency"))
    assert (hopf.value, hopf.frequency) == pytest.approx((value, 2 * np.pi * frequency), rel=1e-12)
    if not more:  # which diverges before
        critical = rodgen.critical_load(scene)
        assert (value, frequency) == pytest.approx((critical.value, critical.frequency), rel=1e-12)
    s = eigenvalues(scene, follower_force=value)
    # Of a free rod they are next to zeros, of which rounding takes digits.
    assert np.abs(s - 1j * hopf.frequency).min() < 1e-8 * hopf.frequency


def test_branch_points_of_a_rod_that_turns_freely() -> None:
    """Where it diverges, and nowhere else, though turning the whole rod is neutral all along."""
    loads = {"follower": {"force": 1.0}, "material_damping": {"time": 0.003}}
    scene = rod(5, "pinned", loads, **ONES)
    found = rodgen.continue_equilibria(scene, FORCE, (1.0, 80.0))
    assert found.attrs["complete"]
    assert set(found["special_kind"].values.tolist()) == {"branch"}
    assert found.sizes["special"] == found["unstable"].values.max() > 0
    critical = rodgen.critical_load(scene)
    assert found["special_value"].values[0] == pytest.approx(critical.value, rel=1e-11)


def test_frequencies_that_meet_about_a_steady_motion() -> None:
    """Without damping they are those of the search along the load, and no cycles begin there."""
    scene = rod(5, "cantilever", {"follower": {"force": 1.0}}, **ONES)
    critical = rodgen.critical_load(scene)
    found = rodgen.continue_equilibria(scene, FORCE, (1.0, 40.0), motion="initial")
    assert found["special_kind"].values.tolist() == ["hopf"]
    values = [float(found[f"special_{x}"][0]) for x in ("value", "frequency")]
    assert values == pytest.approx([critical.value, critical.frequency], rel=1e-10)
    search = CycleSearch.of(System(scene), "numpy")
    along = ParameterRange(search.system, FORCE, (1.0, 40.0))
    with pytest.raises(AnalysisError, match="meet"):
        read_hopf(search, along, found, 1)


def test_a_hopf_point_of_a_branch_of_steady_motions() -> None:
    loads = {"follower": {"force": 1.0}, "material_damping": {"time": 0.02}}
    scene = rod(3, "clamped", loads, **ONES)
    found = rodgen.continue_equilibria(scene, FORCE, (1.0, 40.0), motion="initial")
    search = CycleSearch.of(System(scene), "numpy")
    hopf, _ = read_hopf(search, ParameterRange(search.system, FORCE, (1.0, 40.0)), found, 1)
    critical = rodgen.critical_load(scene)
    due = critical.value, 2 * np.pi * critical.frequency
    assert (hopf.value, hopf.frequency) == pytest.approx(due, rel=1e-11)


def test_no_cycles_begin_in_the_limit_of_no_damping() -> None:
    """Below the thrust of flutter without damping, above that with a little of it."""
    loads = {"follower": {"force": 12.0}, "internal_damping": {"coefficient": 0.3}}
    with pytest.raises(AnalysisError, match="without damping"):
        hopf_of(rod(3, "clamped", loads, **ONES), (0.0, 0.3), INTERNAL)


def test_no_cycles_begin_where_drag_follows_a_velocity_that_changes() -> None:
    """A free rod flies ever faster under its thrust: linearised about, and no equilibrium."""
    loads = {"follower": {"force": 20.0}, "material_damping": {"time": 0.003}}
    loads["drag"] = {"normal": 0.5, "tangential": 0.3}
    with pytest.raises(AnalysisError, match="accelerates"):
        hopf_of(rod(4, "free", loads, **ONES), (20.0, 150.0))


@pytest.mark.slow
def test_external_damping_of_no_size_is_smooth_about_a_bent_rod() -> None:
    """The onset, and what is stable of the equilibria, are those of the rod without it."""
    loads: dict[str, Any] = {"follower": {"force": 9.0, "angle": 0.3}, "gravity": {"g": 1.0}}
    loads["internal_damping"] = {"coefficient": 0.3}
    none = {"external_damping": {"coefficient": 0.0}}
    without, beside = (rod(3, "clamped", loads | more, **ONES) for more in ({}, none))
    due, found = (rodgen.critical_load(one, bounds=(9.0, 10.0)) for one in (without, beside))
    assert found.kind == due.kind == "flutter"
    assert found.value == pytest.approx(due.value, rel=1e-11)
    branches = (rodgen.continue_equilibria(one, FORCE, (9.0, 10.0)) for one in (without, beside))
    kinds, values, unstable = zip(
        *(
            (
                b["special_kind"].values.tolist(),
                b["special_value"].values,
                set(b["unstable"].values),
            )
            for b in branches
        ),
        strict=True,
    )
    assert kinds[0] == kinds[1] == ["hopf"]
    np.testing.assert_allclose(*values, rtol=1e-11)
    assert unstable[0] == unstable[1] == {0, 2}
