"""Local forms of special points: coefficients of a Hopf point and tangents of a branch point of
equations that are made from them, the cycles of a bent rod beside its Hopf point, and the flutter
of a rod that has buckled already."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

import rodgen
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.curves.continuation import continue_curve
from rodgen.analyse.curves.curve import BRANCH, ContinuationProblem, start_point
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.hopf import first_hopf, normal_form
from rodgen.analyse.cycles.periodic_motion import find_cycle
from rodgen.arrays import Array
from rodgen.scene import Scene
from rodgen.system import ParameterRange, System
from tests.analyse.rods import COLUMN, FORCE, ONES, beside_hopf, exact_rates, rod

SCENES = Path(__file__).parents[2] / "scenes"
OMEGA, DECAY = 1.7, 0.6
CUBIC, STILL, DOUBLE, PUSH, PULSE = -0.3 + 0.2j, 0.9 - 0.4j, -0.7 + 1.1j, 1.3, 0.8 + 0.5j


def planar(x: Array) -> Array:
    """Jacobian at x = (Re z, w, Im z, v) of z' = i OMEGA z + CUBIC z |z|^2 + STILL z w +
    DOUBLE z~ w beside w' = -DECAY w + PUSH |z|^2 + Re(PULSE z^2) and v' = -v."""
    z, w = complex(x[0], x[2]), x[1]
    J = np.zeros((4, 4))
    by_z = 1j * OMEGA + 2 * CUBIC * abs(z) ** 2 + STILL * w
    by_conjugate = CUBIC * z**2 + DOUBLE * w
    for column, way in ((0, 1.0), (2, 1j)):
        change = by_z * way + by_conjugate * np.conj(way)
        J[0, column], J[2, column] = change.real, change.imag
        J[1, column] = 2 * PUSH * (z.conjugate() * way).real + 2 * (PULSE * z * way).real
    change = STILL * z + DOUBLE * z.conjugate()
    J[0, 1], J[2, 1], J[1, 1], J[3, 3] = change.real, change.imag, -DECAY, -1.0
    return J


def test_coefficient_of_equations_that_are_made_from_it() -> None:
    """On the centre manifold w = PUSH |z|^2 / DECAY + Re(PULSE z^2 / (DECAY + 2 i OMEGA)), which
    put into z' gives the coefficient of z |z|^2. z here is twice that of a vector whose real part
    is one. Differences of a polynomial are exact but for rounding over their step squared."""
    one = PUSH / DECAY * STILL
    two = DOUBLE * PULSE / (2 * (DECAY + 2j * OMEGA))
    q, c = normal_form(planar, np.zeros(4), OMEGA, np.arange(2), np.arange(2, 4))
    assert c == pytest.approx(4 * (CUBIC + one + two), rel=1e-9)
    np.testing.assert_allclose(q, [1.0, 0.0, -1j, 0.0], atol=1e-12)


def test_the_motion_of_a_hopf_point_has_its_largest_angle_one() -> None:
    """Also where added states, which follow a thousandfold, come behind the rates."""
    states = {name: {"rate": f"1000*phi({at}) - {name}"} for name, at in (("a", 0.5), ("b", 1.0))}
    scene = Scene.from_dict(COLUMN.model_dump(exclude_none=True) | {"states": states})
    search = CycleSearch.of(System(scene), "numpy")
    hopf, _ = first_hopf(search, ParameterRange(search.system, FORCE, (8.0, 22.0)))
    assert np.abs(hopf.way[:3]).max() == pytest.approx(1.0)
    assert np.abs(hopf.way).max() > 10


@pytest.mark.slow
def test_a_bent_rod_has_the_cycles_of_its_normal_form() -> None:
    """With a thrust aside and a weight nothing is symmetric, and derivatives of second order count:
    the periods of small cycles are those of the normal form but for the fourth power of the
    amplitude."""
    aside = {"loads.follower": {"force": 9.0, "angle": 0.3}, "loads.gravity.g": 1.0}
    hopf, errors = beside_hopf(COLUMN.replace(aside), (9.0, 10.0))
    assert np.abs(hopf.x[:3]).max() > 0.5
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.25)


@pytest.mark.slow
@pytest.mark.parametrize(("medium", "subcritical"), [(55.0, False), (60.0, True)])
def test_whether_flutter_in_a_viscous_medium_is_hard(medium: float, subcritical: bool) -> None:
    """The column with a tip mass of docs/tip-mass.md. Small cycles are those of the normal form:
    stable ones beyond the onset, unstable ones before it."""
    table = Scene.from_toml(SCENES / "tip_mass.toml").model_dump(exclude_none=True)
    del table["foundation"]
    table["loads"]["viscous_drag"] = {"normal": medium, "tangential": medium}
    scene = Scene.from_dict(table)
    search = CycleSearch.of(System(scene))
    hopf, flow = first_hopf(search, ParameterRange(search.system, FORCE, (20.0, 40.0)))
    x, force, period = hopf.cycle_guess(0.04)
    assert (force < hopf.value) == subcritical
    y0 = flow(force).quotient.lift(x)
    with nullcontext() if not subcritical else pytest.warns(rodgen.DoubtWarning, match="unstable"):
        found = find_cycle(scene.replace({FORCE: force}), y0=y0, period=period)
    assert found.stable == (not subcritical)
    assert found.amplitude == pytest.approx(0.04, rel=0.01)  # but for its cube


def test_flutter_of_a_rod_that_is_unstable_already() -> None:
    """A dead force has buckled the straight rod: beside what diverges an oscillation begins to
    grow, of the frequency and at the thrust that the closed form has in fifty digits."""
    loads = {"tip": {"x": -25.0}, "follower": {"force": 0.0}, "material_damping": {"time": 0.02}}
    found = continue_equilibria(rod(4, "clamped", loads, **ONES), FORCE, (0.0, 40.0), step=0.1)
    assert found["special_kind"].values.tolist() == ["hopf"]
    force, turns = (float(found[f"special_{name}"][0]) for name in ("value", "frequency"))
    pushed = loads | {"follower": {"force": force}}
    rates = [complex(s) for s in exact_rates(rod(4, "clamped", pushed, **ONES))]
    (s,) = (s for s in rates if s.imag > 0 and abs(s.real) < 1e-8 * abs(s))
    assert s.imag == pytest.approx(2 * np.pi * turns, rel=1e-8)
    growing = sum(s.real > 1e-3 for s in rates)
    assert set(found["unstable"].values.tolist()) == {growing, growing + 2}
    assert growing > 0


class Crossing(ContinuationProblem):
    """Two lines that cross at no right angle, x = 2 l and x = -l / 3."""

    weights = np.ones(2)

    def evaluate(self, u: Array) -> tuple[Array, Array]:
        x, l = u
        one, two = x - 2 * l, x + l / 3
        return np.array([one * two]), np.array([[one + two, -2 * two + one / 3]])


def test_tangents_of_both_branches_through_a_branch_point() -> None:
    problem = Crossing()
    (special,) = continue_curve(
        problem, start_point(problem, np.array([-2.0, -1.0])), -1.0, 1.0
    ).special
    assert special.kind == BRANCH
    assert special.ways is not None
    for way, slope in zip(special.ways, (2.0, -1 / 3), strict=True):
        assert way[0] / way[1] == pytest.approx(slope, rel=1e-9)
