"""References, error measures, sweeps, orders and fronts of the work-precision sets."""

from __future__ import annotations

import copy
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.precision import method_families
from rodgen.analyse.precision.contestant import (
    Limits,
    Measurement,
    NotModelledError,
)
from rodgen.analyse.precision.contestant import sweep as measured
from rodgen.analyse.precision.job import Job, Measures
from rodgen.analyse.precision.work_precision import Reference
from rodgen.scene import Scene
from rodgen_evidence.report import peers
from rodgen_evidence.report.cases import Case, cases
from rodgen_evidence.report.contents import kind_of
from rodgen_evidence.report.costs.cold import cold
from rodgen_evidence.report.precision import contests, duels, growth, references
from rodgen_evidence.report.precision.orders import finest, looked_at
from rodgen_evidence.report.precision.references import NoReferenceError

pytestmark = pytest.mark.compiler
TAKEN = {f"{t}_{k}": s for t in ("c", "numpy") for k, s in (("generate", 1.5), ("compile", 2.5))}


def scene_of(name: str) -> dict[str, Any]:
    """A scene of the set, to be changed."""
    return copy.deepcopy(next(case.scene for case in cases() if case.name == name))


def pendulum(span: float) -> dict[str, Any]:
    """One lumped link of 2 m that hangs from a pin, released at rest 2 rad from the vertical."""
    rod = {"links": 1, "length": 2.0, "bending_stiffness": 0.0, "mass": 3.0, "inertia": "lumped"}
    return {
        "name": "pendulum",
        "rod": rod | {"boundary": "pinned"},
        "loads": {"gravity": {"g": 9.81}},
        "initial": {"phi": 2.0 - np.pi / 2},
        "integrate": {"span": [0.0, span]},
    }


def made(name: str, table: dict[str, Any], folder: Path) -> tuple[Measurement, Reference]:
    (row,) = references.measure(name, table, str(folder), quick=True)
    return row, references.load(folder, name, table)


# References --------------------------------------------------------------------------------------


@pytest.mark.nightly
def test_setup_is_that_of_an_empty_cache(tmp_path: Path) -> None:
    taken = [cold(pendulum(1.0), str(tmp_path / str(at))) for at in range(2)]
    assert all(set(one) == {"generate", "compile"} for one in taken)
    assert min(second for one in taken for second in one.values()) > 0.05  # again each time
    assert set(cold(pendulum(1.0), str(tmp_path / "numpy"), "numpy")) == {"generate"}


def test_missing_reference_says_so(tmp_path: Path) -> None:
    with pytest.raises(NoReferenceError, match=r"\bnothing\b"):
        references.load(tmp_path, "nothing", {})


def test_reference_of_another_scene_is_refused(tmp_path: Path) -> None:
    states = np.zeros((2, 2))
    references.save(
        Reference(states, states, states[:, 0], {"error_phi": 0.0}),
        tmp_path,
        "pendulum",
        pendulum(1.0),
    )
    assert references.load(tmp_path, "pendulum", pendulum(1.0)).estimate == {"error_phi": 0.0}
    with pytest.raises(NoReferenceError, match=r"\bpendulum\b"):
        references.load(tmp_path, "pendulum", pendulum(2.0))


@pytest.mark.parametrize(("force", "why"), [("exp(200*t)", "radau: "), ("exp(2000*t)", "radau: ")])
def test_scene_that_blows_up_is_a_row(
    force: str, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In bounded time; and what needs its reference is a row with the reason each."""
    monkeypatch.setattr(references, "QUICKLY", 0.5)
    table = pendulum(1.0) | {"loads": {"follower": {"force": force}}}
    folder = str(tmp_path)
    references.save(
        Reference(np.zeros((2, 2)), np.zeros((2, 2)), np.zeros(2), {}), tmp_path, "pendulum", table
    )  # an old one
    start = time.process_time()
    (row,) = references.measure("pendulum", table, folder, quick=True)
    assert time.process_time() - start < 10.0  # with the import of SymPy
    assert re.search(why, str(row["failed"]))
    assert set(row) >= {"method", "order", "estimate_phi", "checked_by", "check_phi", "nfev"}
    assert not list(tmp_path.glob("*.npz"))
    (mine,) = contests.rodgens("pendulum", table, folder, True)
    (theirs,) = contests.of_peer("pendulum", table, folder, True, ["SciPy DOP853", "SciPy RK45"])
    (grown,) = growth.growth("pendulum", table, folder)
    for one in (mine, theirs, grown):
        assert one["failed"] == f"no reference: {row['failed']}"
        assert one["n"] == 1
    assert (mine["who"], theirs["who"]) == ("rodgen", "SciPy")


# Error measures ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def still() -> tuple[Job, np.ndarray]:
    """A free rod, straight and at rest at every sample, that moves to the right."""
    job = Job.of("free_n10", Scene.from_dict(scene_of("free_n10")))
    states = np.tile(np.zeros_like(job.initial_state), (len(job.sample_times), 1))
    states[:, 12] = 2.0
    return job, states


def test_measures_of_made_up_errors(still: tuple[Job, np.ndarray]) -> None:
    job, states = still
    measures = Measures(job, states)
    off = states.copy()
    off[-1, 5] += 1e-3
    off[50, 1] += 0.5
    errors = measures.errors(off)
    assert errors["error_phi"] == pytest.approx(1e-3)
    assert errors["error_tail"] == pytest.approx(0.5)
    assert measures.angle_errors(off)[50] == 0.0
    # 50 kg at 2 m/s; the bent springs of 200 Nm hold 2 * 200 * 1e-6 / 2 J.
    assert measures.energy_scale == pytest.approx(100.0)
    assert errors["error_energy"] == pytest.approx(2 * 200.0 * 1e-6 / 2 / 100.0, rel=1e-9)


def test_amplitudes_are_those_of_the_modes(still: tuple[Job, np.ndarray]) -> None:
    """A mode is found as itself; turning and moving the rod belong to no mode."""
    job, states = still
    measures = Measures(job, states)
    found = rodgen.natural_modes(job.scene, 3).phi
    off = states.copy()
    off[7, 2:12] += 1e-3 * found[1] / np.abs(found[1]).max()
    # Shapes come from eigenvectors, good to some 1e-8, and from differences.
    assert measures.errors(off)["error_modes"] == pytest.approx(1e-3, rel=1e-6)
    rigid = states.copy()
    rigid[:, 2:12] += 0.7
    rigid[:, :2] += 3.0
    assert measures.errors(rigid)["error_modes"] == pytest.approx(0.0, abs=1e-8)


def test_states_that_are_not_finite_are_infinitely_wrong(still: tuple[Job, np.ndarray]) -> None:
    job, states = still
    off = states.copy()
    off[-1, 5] = np.nan
    errors = Measures(job, states).errors(off)
    assert errors["error_phi"] == errors["error_energy"] == np.inf


# Sweeps ------------------------------------------------------------------------------------------


def test_refusals_are_told_from_failures(
    still: tuple[Job, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    job, states = still
    errors: dict[str, Exception] = {
        "not modelled": NotModelledError("SciPy: too large"),
        "failed": ValueError("shapes differ"),
        "not installed": ModuleNotFoundError("No module named 'scipy'", name="scipy"),
    }

    def rows_of(error: Exception) -> list[Measurement]:
        def fail(*_: Any) -> Any:
            raise error

        monkeypatch.setattr(peers, "family", fail)
        return contests._of_method(
            job, Reference(states, states, states[:, 0], {}), True, "SciPy DOP853"
        )

    for kind, error in errors.items():
        (row,) = rows_of(error)
        assert kind_of(str(row["failed"])) == kind
    (row,) = rows_of(ModuleNotFoundError("No module named 'yaml'", name="yaml"))
    assert row["failed"] == "No module named 'yaml'"
    (row,) = rows_of(ImportError("libmkl.so: cannot open"))
    assert row["failed"] == "libmkl.so: cannot open"


def test_first_fixed_step_is_the_stability_limit(still: tuple[Job, np.ndarray]) -> None:
    """h omega = 2 for semi_implicit_euler (docs/methods.md), samples on steps."""
    job, _ = still
    first, second, *_ = method_families.step_settings(job, "semi_implicit_euler", quick=False)
    rate = 4 * np.sqrt(3) * 10**2 * np.sqrt(100 / (50 * 125))
    # Below it by at most one more step between two samples, of four or five.
    assert 1.6 < first * rate < 2.0
    assert second == pytest.approx(first / 2)
    assert (job.sample_times[1] / first) == pytest.approx(
        round(job.sample_times[1] / first), rel=1e-12
    )


def test_rodgens_rows_come_to_an_order_and_a_duel(tmp_path: Path) -> None:
    """From the reference to the fit, on a pendulum."""
    table = pendulum(10.0)
    made("pendulum", table, tmp_path)
    job, held = contests.load_job("pendulum", table, str(tmp_path))
    rows: list[Measurement] = []
    for method, target in contests.own_methods(job):
        if (method, target) in {("rk4", "c"), ("dop853", "c")}:
            family = method_families.own_family(job, method, target, quick=False)
            one = contests.label(job, method, target, TAKEN)
            rows += measured(family, one, held.measures(job, method), Limits(0.1, 0.3))
    by_method = {fit["method"]: fit for fit in fits(rows) if fit["against"] == "step"}
    # Off by the largest steps, a fifth of a radian each: without them it is within 0.1.
    assert by_method["rk4"]["exponent"] == pytest.approx(4.0, abs=0.3)
    assert by_method["rk4"]["order"] == 4.0
    assert all(row["setup_compile"] == TAKEN["c_compile"] for row in rows if row["seconds"])
    # With the smallest steps that a busy machine has time for.
    assert min(row["error_phi"] or 1.0 for row in rows) < 1e-8
    (unit, *_) = duels.units([type(cases()[0])(table, "")], True, tmp_path, rows)
    (row,) = unit.call()
    assert row["failed"]
    assert row["ours"]


# Orders and fronts -------------------------------------------------------------------------------


def row(method: str, setting: float, seconds: float, error: float, **more: Any) -> Measurement:
    known = {"scene": "s", "who": "rodgen", "method": method, "target": "c", "kind": "step"}
    made_up = {"setting": setting, "seconds": seconds, "error_phi": error, "failed": "", "order": 3}
    return known | made_up | more


def fits(rows: list[Measurement]) -> list[Measurement]:
    """Where an exponent is seen."""
    return [fit for fit in looked_at(rows) if fit["exponent"] is not None]


def unfitted(rows: list[Measurement], **floor: float) -> list[Measurement]:
    """Where none is."""
    return [fit for fit in looked_at(rows, **floor) if fit["exponent"] is None]


def test_orders_of_made_up_rows() -> None:
    steps = [0.1 / 2**k for k in range(6)]
    rows = [row("a", h, 1 / h, 1e-3 * h**3) for h in steps]
    rows += [row("a", 1e-4, 1.0, 1e-14), row("a", 1.0, 1.0, 5.0), row("a", 0.5, 1.0, np.inf)]
    (fit,) = fits(rows)
    assert fit["observed"] == pytest.approx(3.0)
    assert fit["points"] == 6
    assert fit["order"] == 3.0
    adaptive = [
        row("b", 10.0**-k, 1.0, 10.0 ** (-0.8 * k), kind="rtol", nfev=10 ** (k / 5))
        for k in range(3, 9)
    ]
    found = {fit["against"]: fit for fit in fits(adaptive)}
    assert found["rtol"]["exponent"] == pytest.approx(0.8)
    assert found["rtol"]["observed"] is None
    assert found["rhs"]["observed"] == pytest.approx(4.0)
    assert fits(rows[:2]) == []


def test_slope_of_the_two_smallest_steps() -> None:
    """Whatever the ones before did: 8 to 1 over a halved step is an order of 3."""
    errors = (0.05, 0.04, 8e-6, 1e-6)
    rows = [row("a", 0.1 / 2**at, 1.0, error) for at, error in enumerate(errors)]
    assert finest(rows) == pytest.approx(3.0)
    assert finest(rows, floor=1e-5) == pytest.approx(np.log2(0.05 / 0.04))
    assert finest(rows[:1]) is None
    assert [one["finest"] for one in unfitted(rows)] == pytest.approx([3.0])


def test_slopes_that_are_not_steady_are_no_order() -> None:
    orders = [1.0, 1.7, 3.0, 1.2, 2.4]
    errors = 1e-2 / 2 ** np.cumsum([0.0, *orders])
    early = [row("a", 0.1 / 2**k, 1.0, float(error)) for k, error in enumerate(errors)]
    assert fits(early) == []
    (left,) = unfitted(early)
    assert left["method"] == "a"
    late = [row("a", 0.1 / 2**k, 1.0, errors[-1] / 16.0 ** (k - 5)) for k in range(6, 8)]
    (fit,) = fits([*early, *late])
    assert fit["observed"] == pytest.approx(4.0)
    assert fit["points"] == 3
    # A setting that failed parts those beside it.
    failed = row("a", late[0]["setting"], 1.0, np.nan, failed="fell over")
    assert fits([*early, failed, late[1]]) == []
    assert "less than 3 errors" in unfitted(early, floor=2e-3)[0]["why"]
    assert unfitted([failed]) == []


def test_scene_without_a_reference_has_no_duel() -> None:
    lost = row("", 0.0, 0.0, 0.0, failed="no reference: not a number")
    case = Case(pendulum(1.0), "")
    for unit in duels.units([case], True, "", [lost | {"scene": case.name}]):
        assert [r["failed"] for r in unit.call()] == ["no reference: not a number"]


def test_events_take_no_part(tmp_path: Path) -> None:
    """The rod would stop at once: all go on to the end of the span."""
    table = pendulum(1.0)
    events = [{"quantity": "phi_0", "value": 0.2, "action": "stop"}]
    assert rodgen.simulate(rodgen.Scene.from_dict(table | {"events": events})).t[-1] < 0.9
    told, known = made("stopping", table | {"events": events}, tmp_path)
    plain, free = made("plain", table, tmp_path)
    assert told["failed"] == plain["failed"] == ""
    assert (told["events"], plain["events"]) == (1, 0)
    np.testing.assert_array_equal(known.states, free.states)


# Growth ------------------------------------------------------------------------------------------


def test_rate_of_a_made_up_error() -> None:
    times = np.linspace(0.0, 4.0, 101)
    error = np.minimum(1e-9 * np.exp(7.0 * times), 3.0)
    error[-1] = 1e-5  # by chance
    assert growth.rate(times, error, np.full(101, 1e-12)) == pytest.approx(7.0)
    assert growth.rate(times, error, np.full(101, 1.0)) is None


def test_growth_has_a_curve_for_every_tolerance(tmp_path: Path) -> None:
    made("pendulum", pendulum(1.0), tmp_path)
    rows = growth.growth("pendulum", pendulum(1.0), str(tmp_path))
    assert [row["setting"] for row in rows] == [*growth.TOLERANCES, None]
    assert all(len(row["error"]) == len(row["t"]) == 101 for row in rows)
    assert rows[0]["error"][-1] > rows[1]["error"][-1]


def test_growth_is_of_all_scenes_where_none_is_chaotic() -> None:
    def names(some: list[Any]) -> list[str]:
        return [unit.name for unit in growth.units(some, True, "folder")]

    assert names(cases()) == ["growth-falling_chain", f"growth-{cases()[0].name}"]
    assert len(names([case for case in cases() if case.name != "falling_chain"])) == 5
