"""Branches of cycles: the normal form against the cycles beside a Hopf point, known thrusts of
Ziegler's pendulum, periods of single cycles; nonlinear modes against a pendulum's elliptic integral
and linear modes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

import rodgen
from rodgen.analyse.curves import curve_datasets
from rodgen.analyse.cycles import cycle_data
from rodgen.analyse.cycles.cycle_continuation import continue_cycles
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.hopf import first_hopf
from rodgen.analyse.cycles.nonlinear_modes import continue_mode, nonlinear_mode
from rodgen.analyse.cycles.periodic_motion import find_cycle
from rodgen.errors import AnalysisError, InputError
from rodgen.scene import Scene
from rodgen.system import ParameterRange, System
from tests.analyse.rods import COLUMN, FORCE, NOTHING, ONES, ZIEGLER, beside_hopf, rod


@pytest.fixture(scope="module")
def branch() -> Any:
    return continue_cycles(COLUMN, FORCE, (8.0, 22.0))


def test_flutter_of_zieglers_pendulum_is_a_hopf_point() -> None:
    """At the thrust of Herrmann and Jong (1965) for this damping, 9 (41/28 + 0.18/2)."""
    search = CycleSearch.of(System(ZIEGLER), "numpy")
    hopf, _ = first_hopf(search, ParameterRange(search.system, FORCE, (12.0, 17.0)))
    assert hopf.value == pytest.approx(9 * (41 / 28 + 0.18 / 2), rel=1e-11)
    assert hopf.supercritical


@pytest.mark.slow
def test_cycles_begin_where_flutter_does(branch: Any) -> None:
    without = COLUMN.replace({f"loads.{name}": None for name in NOTHING})
    critical = rodgen.critical_load(without)
    assert branch["special_kind"].values[0] == "hopf"
    assert float(branch["special_value"][0]) == pytest.approx(critical.value, rel=1e-9)
    assert float(branch["special_frequency"][0]) == pytest.approx(critical.frequency, rel=1e-9)
    stable = branch["unstable"].values[0] == 0
    assert stable == bool(branch.attrs["supercritical"])
    assert (np.diff(branch["amplitude"].values[:10]) > 0).all()
    assert branch.attrs["complete"]
    assert branch["trivial_error"].values.max() < 1e-8


@pytest.mark.slow
def test_the_normal_form_has_the_cycles_beside_it() -> None:
    """Value and period of small cycles differ from those of the normal form by the fourth power of
    the amplitude."""
    hopf, errors = beside_hopf(COLUMN, (8.0, 22.0))
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.25)
    assert errors[1] < 1e-5 * 2 * np.pi / hopf.frequency


def test_a_branch_has_the_cycle_of_a_run(branch: Any, tmp_path: Any) -> None:
    alone = find_cycle(COLUMN)
    at = cycle_data.nearest_point(branch, COLUMN)
    _, known = cycle_data.system_and_cycle_at(branch, at)
    found = find_cycle(COLUMN, y0=known.y0, period=known.period)
    assert found.period == pytest.approx(alone.period, rel=1e-9)
    # What thrust brings in, damping takes out, in every cycle of the branch.
    work = branch["work"].values
    np.testing.assert_allclose(work.sum(axis=1), 0, atol=1e-9 * np.abs(work).max())
    curve_datasets.save_curve(branch, tmp_path / "cycles.nc")
    again = cycle_data.FORMAT.read(tmp_path / "cycles.nc")
    np.testing.assert_array_equal(again["y0"].values, branch["y0"].values)
    # From there both ways: the same curve.
    both = continue_cycles(COLUMN, FORCE, (19.0, 20.5), start=alone)
    values = both["value"].values
    periods = np.interp(20.0, values, both["period"].values)
    assert periods == pytest.approx(alone.period, rel=1e-4)  # of a line between points
    assert (values.min(), values.max()) == (19.0, 20.5)


@pytest.mark.slow
def test_a_scene_at_a_point_of_a_branch_starts_on_its_cycle() -> None:
    """Where the load grows at the start of the span, it starts when that has ended."""
    grows = COLUMN.replace({FORCE: "P0*min(t/0.5, 1)", "parameters": {"P0": 20.0}})
    found = continue_cycles(grows, "parameters.P0", (19.0, 20.5), start="run", step=1.0)
    for at in (0, found.sizes["point"] - 1):
        scene = cycle_data.scene_at(found, at)
        start, period = scene.integrate.span[0], float(found["period"][at])
        assert start == 20.0
        run = rodgen.simulate(scene, span=[start, start + period], rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(run.y[-1], run.y[0], atol=1e-7 * np.abs(run.y).max())
    with pytest.raises(InputError, match=r"^point = "):
        cycle_data.scene_at(found, found.sizes["point"])


def test_what_no_branch_begins_with() -> None:
    """No flutter in the range; a pair that does not cross, as nothing damps it; what is not smooth
    at rest."""
    bare = ZIEGLER.replace({"loads.internal_damping": None})
    braked = COLUMN.replace({"loads.external_damping.coefficient": 0.5})
    for scene, ends, target in (
        (COLUMN, (1.0, 5.0), None),
        (bare, (15.0, 25.0), "numpy"),
        (braked, (5.0, 25.0), None),
    ):
        with pytest.raises(AnalysisError):
            continue_cycles(scene, FORCE, ends, target=target)


@pytest.mark.slow
def test_a_pendulum_by_an_elliptic_integral() -> None:
    """Energy m g L/2 (1 - cos a) above rest; period 4 sqrt(2 L/3 g) K(sin^2 a/2)."""
    length, mass, g = 1.3, 2.0, 9.81
    sizes = {"length": length, "mass": mass, "bending_stiffness": 0.0}
    scene = rod(1, "pinned", {"gravity": {}}, initial={"phi": -1.0}, **sizes)

    def period(a: float) -> float:
        return float(4 * np.sqrt(2 * length / (3 * g)) * ellipk(np.sin(a / 2) ** 2))

    a = np.pi / 2 - 1.0
    found = find_cycle(scene)  # with the energy of its start
    assert found.period == pytest.approx(period(a), rel=1e-9)
    assert found.amplitude == pytest.approx(a, rel=1e-4)  # of 64 samples
    wide = nonlinear_mode(scene, 1, mass * g * length / 2 * (1 - np.cos(2.0)))
    assert wide.period == pytest.approx(period(2.0), rel=1e-9)
    assert wide.trivial == 2  # one by the time, one by the energy


@pytest.mark.slow
def test_families_begin_with_linear_modes_and_keep_energy() -> None:
    scene = rod(2, "free", **ONES, inertia="lumped", initial={"phi": 0.0})
    family = continue_mode(scene, 1, 0.5)
    linear = rodgen.natural_modes(scene, 1).frequencies[0]
    assert family["frequency"].values[0] == pytest.approx(linear, rel=1e-8)
    assert family["energy_error"].values.max() < 1e-9
    assert family["energy"].values[-1] == pytest.approx(0.5, rel=1e-12)
    assert family.attrs["complete"]
    # The motion of that energy, as a run has it.
    mode = nonlinear_mode(scene, 1, 0.5)
    assert mode.energy == pytest.approx(0.5, rel=1e-9)
    assert np.ptp(mode.motion.energy.total) < 1e-9
    np.testing.assert_allclose(mode.motion.y[-1, 2:4], mode.motion.y[0, 2:4], atol=1e-8)


@pytest.mark.nightly
def test_a_free_rod_swings_while_its_thrust_carries_it_off() -> None:
    """Its cycle needs neither its place nor its velocity, and comes back turned by nothing: two
    multipliers are 1."""
    loads = NOTHING | {"follower": {"force": 150.0}, "internal_damping": {"coefficient": 1.0}}
    tables = {"initial": {"phi": "0.1*s"}, "integrate": {"span": [0, 10]}}
    found = find_cycle(rod(10, "free", loads, **ONES, **tables))
    assert found.trivial == 2
    assert found.trivial_error < 1e-8
    assert len(found.multipliers) == 20
    # A run from there comes back to the same shape, moved.
    motion = found.motion
    np.testing.assert_allclose(motion.y[-1, 2:12], motion.y[0, 2:12] + found.angle, atol=1e-7)
    assert np.linalg.norm(found.drift) > 1.0


@pytest.mark.slow
def test_loads_that_repeat_give_the_period() -> None:
    damped = {"internal_damping": {"coefficient": 1.0}}
    keys = ONES | {
        "bending_stiffness": 2.0,
        "integrate": {"span": [0, 12]},
        "initial": {"phi": 0.0},
    }

    def shaken(force: str) -> Scene:
        return rod(2, "clamped", damped | {"tip": {"x": 0.0, "y": force}}, **keys)

    found = find_cycle(shaken("min(t, 1)*sin(7*t)**2"), target="numpy")
    assert found.forced
    assert found.period == pytest.approx(np.pi / 7, rel=1e-14)
    assert found.trivial == 0
    y = found.motion.y
    np.testing.assert_allclose(y[-1], y[0], atol=1e-8 * np.abs(y).max())
    with pytest.raises(AnalysisError):
        find_cycle(shaken("sin(t**2)"), target="numpy")
