"""Cycles: against runs of SciPy and their differences, by any number of segments."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rodgen
from rodgen.analyse.cycles.cycle_result import Cycle
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.periodic_motion import find_cycle
from rodgen.scene import Scene
from rodgen.system import System
from tests.analyse.rods import COLUMN, rod

# Near the cycle; three digits suffice to begin with.
NEAR, ABOUT = [0.397, 1.249, 1.647, 1.617, 4.071, 4.251], 0.915


@pytest.fixture(scope="module")
def cycle() -> Cycle:
    return find_cycle(COLUMN, y0=NEAR, period=ABOUT)


def test_by_runs_of_scipy(cycle: Cycle) -> None:
    """A run of the period comes back, and the multipliers are those of differences of such runs."""
    model = rodgen.build(COLUMN, "c")
    p = model.parameters(**COLUMN.parameters)

    def after(y: Any) -> Any:
        found = solve_ivp(
            model.rhs, (0, cycle.period), y, "DOP853", args=(p,), rtol=1e-11, atol=1e-12
        )
        return found.y[:, -1]

    np.testing.assert_allclose(after(cycle.y0), cycle.y0, atol=1e-8)
    columns = [after(cycle.y0 + d) - after(cycle.y0 - d) for d in 1e-5 * np.eye(6)]
    for mu in np.linalg.eigvals(np.array(columns).T / 2e-5):
        assert np.abs(cycle.multipliers - mu).min() < 1e-6
    assert cycle.trivial_error < 1e-8
    assert cycle.trivial == 1
    assert cycle.stable


@pytest.mark.parametrize(
    ("how", "by"),
    [
        ({}, "collocation"),
        ({"method": "shooting"}, "shooting"),
        *(({"segments": count}, "shooting") for count in (1, 3, 20)),
        # Newton's method on a few directions, Picard's iteration on the rest.
        *(({"multipliers": count}, "newton_picard") for count in (2, 4)),
    ],
    ids=str,
)
def test_every_way_finds_the_cycle_of_a_run(cycle: Cycle, how: dict[str, Any], by: str) -> None:
    """Discretisations with nothing in common but the rates: to the tolerance of either."""
    assert cycle.error < 1e-9
    near = {} if by == "collocation" else {"y0": NEAR, "period": ABOUT}
    found = find_cycle(COLUMN, **near, **how)
    assert found.method == by
    assert found.period == pytest.approx(cycle.period, rel=1e-9)
    count = how.get("multipliers", len(cycle.multipliers))
    # In the order of their moduli.
    np.testing.assert_allclose(found.multipliers, cycle.multipliers[:count], atol=1e-8)
    assert found.trivial_error < 1e-8
    # What thrust brings in, damping takes out.
    assert sum(found.work.values()) == pytest.approx(0, abs=1e-9 * found.work["follower"])


def test_of_loads_of_a_time(cycle: Cycle) -> None:
    """A thrust that has risen by then is the column's own."""
    risen = COLUMN.replace({"loads.follower.force": "20*min(t/2, 1)"})
    frozen = System(risen).at(t=3.0)
    found = find_cycle(frozen, y0=NEAR, period=ABOUT)
    assert found.period == cycle.period
    assert found.scene.loads == COLUMN.loads
    assert found.work == pytest.approx(cycle.work, abs=1e-12)


def test_tangents_of_an_implicit_stepper(cycle: Cycle) -> None:
    """By radau as by dop853, over an eighth of the period."""
    flow = CycleSearch.of(System(COLUMN)).flow(0.0, cycle.y0)
    x = cycle.y0[flow.quotient.kept]
    by = [
        replace(flow, method=method).state_and_tangents_after(0.0, x, cycle.period / 8)
        for method in ("dop853", "radau")
    ]
    for one, other in zip(*by, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-8 * np.abs(one).max())


@pytest.mark.nightly  # it compiles a structure of its own
def test_stiff_cycles_by_radau() -> None:
    """Of steps that are longer than the fastest motion lasts: it decays by exp(-60000) in a
    period."""
    finer = {"rod.links": 20, "loads.material_damping.time": 0.01}
    scene = Scene.example("beck_after_flutter").replace(finer)
    leading = find_cycle(scene, multipliers=3)
    flow = CycleSearch.of(System(scene)).flow(0.0, leading.y0)
    x = leading.y0[flow.quotient.kept]
    assert flow.choose_method(0.0, x, leading.period).method == "radau"
    whole = find_cycle(scene, y0=leading.y0, period=leading.period)
    assert whole.method == "collocation"
    assert whole.period == pytest.approx(leading.period, rel=1e-9)
    sizes = np.abs(whole.multipliers)
    np.testing.assert_allclose(sizes[:3], np.abs(leading.multipliers), atol=1e-8)
    # Nothing of the fastest motions is left after a period, whatever the steps.
    assert sizes[8:].max() < 1e-12


def test_a_kink_takes_more_intervals_and_what_is_left_is_told() -> None:
    """The order of collocation is lost; the mesh gathers at the kinks. Multipliers by shooting are
    right to some 1e-6 there."""
    scene = COLUMN.replace({"loads.external_damping.coefficient": 0.1})
    found = find_cycle(scene, y0=NEAR, period=ABOUT)
    assert 1e-10 < found.error < 1e-6
    assert found.trivial_error < 10 * found.error
    shot = find_cycle(scene, y0=found.y0, period=found.period, method="shooting")
    assert shot.period == pytest.approx(found.period, rel=1e-9)
    assert np.abs(shot.nontrivial[0] - found.nontrivial[0]) < 1e-5


def test_what_is_doubtful_about_a_cycle_is_among_its_notes() -> None:
    """That it is unstable, and multipliers with an error; where energy is kept, they move by the
    root of the rounding."""
    kept = rod(1, "pinned", {"gravity": {}}, bending_stiffness=0.0, initial={"phi": -1.0})
    model, y0 = rodgen.build(kept, "numpy"), kept.initial_state()
    about: dict[str, Any] = {"t": 0.0, "period": 3.0, "y0": y0, "trivial": 0, "angle": 0.0}
    about |= {"energy": 0.0, "amplitude": 0.1, "forced": False, "residual": 0.0, "iterations": 3}
    about |= {"method": "collocation", "model": model, "trivial_error": 0.0}
    about |= {"multipliers": np.array([0.5 + 0.0j]), "system": System(kept)}
    assert Cycle(**about).notes == ()
    (told,) = Cycle(**about | {"multipliers": np.array([2.0 + 0.0j, 0.5])}).doubts
    assert told.figures == {"multiplier": 2.0}
    (told,) = Cycle(**about | {"error": 1e-3}).doubts
    assert told.figures == {"error": 1e-3}
    for forced, errors in ((False, (1e-5, 1e-3)), (True, (1e-7, 1e-5))):
        few, many = (
            Cycle(**about | {"forced": forced, "trivial_error": error}).doubts for error in errors
        )
        assert (few, [one.figures for one in many]) == ((), [{"error": errors[1]}])
