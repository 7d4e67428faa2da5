"""Crossings and spectra side by side in C: those that runs one by one find, by other code."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen.studies import point_runs
from rodgen.studies.kept_quantities import variables
from rodgen.studies.point_arrays import PointArrays
from rodgen.studies.sampling import points_at
from rodgen.studies.study import Study
from tests.studies.conftest import PENDULUM, scene
from tests.studies.test_block import computed, same
from tests.told import numbers

pytestmark = pytest.mark.compiler
EVENTS = [
    {"quantity": "phi_0", "value": -1.0, "direction": "rising", "name": "up"},
    {"quantity": "kinetic_energy", "value": 2.0, "name": "fast"},
    {"quantity": "joint_3_x", "value": 0.1, "direction": "falling", "name": "left"},
]
STOP = {"quantity": "tip_x", "value": -0.9, "direction": "falling", "name": "end", "action": "stop"}
# Counts of what is a state and of what is observed, between times and not; sections of numbers that
# C has and of some that it has not, with fewer crossings than there are.
KEEP = [
    *("count(up)", "count(fast, from=0.3)", "count('left', to=2.5)", "max(phi_2)"),
    "section(tip_y, where='tip_x', rising=0.1, from=0.2, max_points=5)",
    "section(phi_1, where='omega_1', either=0.0, max_points=3)",
    "section(tip_vx, where='omega_1', falling=0.0)",
    "section(t, where='total_energy', falling=-6)",
    *("peak(phi_0, from=0.5)", "peak(tip_x, to=2.6)"),
]
STOPPED = ["count(end)", "last(tip_x)", "time_of_max(phi_0)", "mean(tip_y)"]
STATES = ["section(tip_y, where='omega_0', either=0)", "count(up)"]


def study(keep: list[str], *events: dict[str, Any], **integrate: Any) -> Study:
    """Pendulums let go from several angles, with a load that shakes them and without."""
    table = scene(PENDULUM, events=list(events), integrate={"span": [0.0, 3.0]} | integrate)
    vary = {"initial.phi": [-0.5, 0.4, 1.3, 2.2, 2.5], "parameters.w": [0.0, 2.0]}
    return Study.of(table, vary, keep=keep)


def one_by_one(of: Study) -> dict[str, np.ndarray]:
    """All points by `simulate`."""
    every, made = points_at(of, range(of.count)), PointArrays(variables(of), of.count)
    with np.errstate(all="ignore"):
        point_runs._run_one_by_one(of, every, range(of.count), made)
    return made.arrays


@pytest.mark.parametrize(
    ("keep", "events", "integrate"),
    [
        (KEEP, EVENTS, {"rtol": 1e-9}),
        (KEEP, EVENTS, {"method": "rk4", "step": 2e-3}),
        (STATES, EVENTS[:1], {"rtol": 1e-9}),
        ([*KEEP, *STOPPED], [*EVENTS, STOP], {"rtol": 1e-9}),
    ],
    ids=["dop853", "rk4", "states alone", "stopped"],
)
def test_crossings_are_those_of_runs_one_by_one(
    keep: list[str], events: Any, integrate: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the tolerance of the run; velocities of points are differences, of 1e-10 of their size."""
    table = study(keep, *events, **integrate)
    expected = one_by_one(table)
    monkeypatch.setattr(point_runs, "simulate", None)  # so that it is not asked
    found = computed(table)
    assert {*found} == {*expected}
    assert (found["status"] == "finished").all()
    assert sum(np.isfinite(v).sum() for name, v in expected.items() if name.endswith(".t")) > 20
    for name, values in expected.items():
        if name == "seconds":
            continue
        if values.dtype.kind == "f":
            np.testing.assert_allclose(found[name], values, rtol=1e-8, atol=1e-9, err_msg=name)
        elif name == "message":
            assert ((values != "") == (found[name] != "")).all()
        else:
            assert found[name].tolist() == values.tolist(), name
    if keep == KEEP:
        assert np.isfinite(found["peak(phi_0, from=0.5).frequency"]).sum() > 5
    if "count(end)" in keep:
        assert 0 < (found["message"] != "").sum() < table.count
        np.testing.assert_array_equal(found["count(end)"], found["message"] != "")
        np.testing.assert_allclose(found["last(tip_x)"][found["message"] != ""], -0.9, atol=1e-12)


def test_neighbours_and_order_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor how many runs are there at a time."""
    table = study([*KEEP, *STOPPED], *EVENTS, STOP)
    every = computed(table)
    order = np.random.default_rng(1).permutation(table.count).tolist()
    same(every, computed(table, order), order)
    same(every, computed(table, [7]), [7])
    monkeypatch.setattr(point_runs, "MOST_CROSSED", 20_000)
    same(every, computed(table))


def test_a_section_between_two_times_is_a_part_of_the_whole() -> None:
    """By both ways, side by side in C and run by run."""
    where = "where='omega_0', either=0"
    whole, part = f"section(t, {where})", f"section(t, {where}, from=1, to=2)"
    table = study([whole, part], rtol=1e-9)
    for found in (computed(table), one_by_one(table)):
        inside = (found[whole] >= 1) & (found[whole] <= 2)
        assert 0 < inside.sum() < np.isfinite(found[whole]).sum()
        for every, these, some in zip(found[whole], inside, found[part], strict=True):
            np.testing.assert_array_equal(some[np.isfinite(some)], every[these])


def test_a_run_that_fails_has_no_crossings() -> None:
    found = computed(study(KEEP, *EVENTS, max_steps=20))
    assert (found["status"] == "failed").all()
    assert (found["count(up)"] == -1).all()
    assert np.isnan(found[KEEP[4]]).all()
    assert all(20 in numbers(text) for text in found["message"])  # steps
