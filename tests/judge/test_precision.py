"""References, error measures, sweeps, orders and fronts of the work-precision sets."""

from __future__ import annotations

import copy
import json
import os
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import rodgen
from rodgen.emit.by_hand import ByHand
from rodgen.judge import peers
from rodgen.judge.cases import Case, cases
from rodgen.judge.found import kind_of
from rodgen.judge.precision import duels, growth, ours, references, sweep
from rodgen.judge.precision import ladder as ladder_module
from rodgen.judge.precision.contestant import Contestant, Deadline, Finish, NotModelledError
from rodgen.judge.precision.errors import Measures
from rodgen.judge.precision.extended import extended, library
from rodgen.judge.precision.job import Job
from rodgen.judge.precision.ladder import Way, ladder, stops
from rodgen.judge.precision.measured import Limits, attempt, in_a_row
from rodgen.judge.precision.measured import sweep as measured
from rodgen.judge.precision.orders import finest, fits, unfitted
from rodgen.judge.precision.pareto import cheapest, front
from rodgen.judge.precision.references import NoReferenceError, Reference
from rodgen.judge.precision.setup import setup
from rodgen.judge.unit import Row

pytestmark = pytest.mark.compiler
TAKEN = {f"{t}_{k}": s for t in ("c", "numpy") for k, s in (("generate", 1.5), ("compile", 2.5))}
PUBLISHED = Path(__file__).parents[1] / "physics" / "ivp_beam_t5.json"


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


def swung(times: np.ndarray) -> np.ndarray:
    """Its angle from the vertical, by Jacobi's elliptic functions: 2 asin(k sn(K - w t))."""
    k, w = np.sin(1.0), np.sqrt(9.81 / 2.0)
    sine, *_ = ellipj(ellipk(k**2) + w * times, k**2)
    return np.asarray(2 * np.arcsin(k * sine))


def made(name: str, table: dict[str, Any], folder: Path) -> tuple[Row, Reference]:
    (row,) = references.reference(name, table, str(folder), quick=True)
    return row, Reference.load(folder, name, table)


# References --------------------------------------------------------------------------------------


def test_reference_of_a_pendulum_is_that_of_elliptic_functions(tmp_path: Path) -> None:
    row, held = made("pendulum", pendulum(3.0), tmp_path)
    exact = swung(Job.of("pendulum", pendulum(3.0)).times) - np.pi / 2
    # SciPy's elliptic functions are good to some 1e-15; the estimate is to be as honest.
    assert np.abs(held.states[:, 0] - exact).max() < 2e-14
    assert row["failed"] == ""  # type: ignore[operator]
    assert row["estimate_phi"] < 1e-13  # type: ignore[operator]
    assert row["check_phi"] < 1e-10  # type: ignore[operator]
    assert row["estimate_modes"] is None
    assert held.estimate["error_modes"] is None


def test_setup_is_that_of_an_empty_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path))
    scene = rodgen.Scene.from_dict(pendulum(1.0))
    taken = [setup(scene, "c") for _ in range(2)]
    assert all(set(one) == {"generate", "compile"} for one in taken)
    assert min(second for one in taken for second in one.values()) > 0.05  # again each time
    assert list(tmp_path.iterdir()) == []
    assert os.environ["RODGEN_CACHE"] == str(tmp_path)


def test_stiff_reference_of_a_damped_link_is_an_exponential() -> None:
    """One clamped link: J phi'' = -2 EI/l phi; the implicit method, whatever the scene's rate."""
    table = {
        "name": "spring",
        "rod": {"links": 1, "length": 1.0, "bending_stiffness": 2.0, "mass": 3.0}
        | {"boundary": "clamped", "clamp_angle": 0.0},
        "initial": {"phi": 0.5},
        "integrate": {"span": [0.0, 2.0]},
    }
    job = Job.of("spring", table)
    way = Way.of(job)
    implicit = Way(True, True, way.rate, way.first, False)
    *_, other, best = ladder(job, implicit, library(job.scene.structure, True), 1.0)
    exact = 0.5 * np.cos(np.sqrt(4.0 / 1.0) * job.times)  # M l^2/3 = 1, root spring 4
    # Errors of a step of 1e-11, some hundred steps.
    assert np.abs(best.states[:, 0] - exact).max() < 1e-9
    assert np.abs(best.states - other.states).max() < 1e-9


def test_extrapolation_reproduces_the_published_beam() -> None:
    """Up to the break point of its load at pi, and beyond it; in doubles, a tenth of the time."""
    job = Job.of("ivp_beam", scene_of("ivp_beam"))
    way = Way.of(job)
    assert not way.implicit
    methods = library(job.scene.structure, False)
    times, inside = stops(job)
    given = (job.p, np.ones(80), job.start, times, inside)
    states, _ = methods.extrapolate(False, 8, 1e-11, way.first, *given)
    published = np.array(json.loads(PUBLISHED.read_text(encoding="utf-8"))["y"])
    # The fastest of 6400 rad/s have errors in the rates that are so much larger.
    np.testing.assert_allclose(states[-1, :40], published[:40], rtol=0, atol=1e-11)
    np.testing.assert_allclose(states[-1, 40:], published[40:], rtol=0, atol=1e-7)


def test_long_doubles_are_closer_to_fifty_digits() -> None:
    table = scene_of("missile")
    table["rod"]["links"] = 4
    job = Job.of("missile", table)
    methods = library(job.scene.structure, True)
    if methods.bits <= 53:
        pytest.skip("long double has no more digits than double here")
    y = job.start + 0.1 * np.random.default_rng(1).standard_normal(len(job.start))
    t = 1.0  # where the thrust no longer rises
    timed = {key: float(force(t)) for key, force in job.scene.timed.items()}
    defaults = {"follower_angle": 0.0, "fin_factor": np.ones(5)}
    with mpmath.workdps(50):
        exact = ByHand(job.model, {**defaults, **job.scene.parameters, **timed}, y).rhs()
        largest = max(map(abs, exact))

        def off(parts: list[tuple[float, float]]) -> float:
            sums = (mpmath.mpf(float(a)) + mpmath.mpf(float(b)) for a, b in parts)
            return float(max(abs(s - e) for s, e in zip(sums, exact, strict=True)) / largest)

        double = off([(value, 0.0) for value in job.model.rhs(t, y, job.p)])
        long = off(list(zip(*methods.rates(t, y, job.p), strict=True)))
    # 11 bits more are a factor of 2048; the rest is luck.
    assert long < double / 200
    assert long < 1e-17


def test_text_that_is_not_known_is_refused() -> None:
    with pytest.raises(ValueError, match="found 0 times"):
        extended("static double sine(double v);")


def test_missing_reference_says_so(tmp_path: Path) -> None:
    with pytest.raises(NoReferenceError, match="no reference solution of nothing"):
        Reference.load(tmp_path, "nothing", {})


def test_reference_of_another_scene_is_refused(tmp_path: Path) -> None:
    states = np.zeros((2, 2))
    Reference(states, states[:, 0], {"error_phi": 0.0}).save(tmp_path, "pendulum", pendulum(1.0))
    assert Reference.load(tmp_path, "pendulum", pendulum(1.0)).estimate == {"error_phi": 0.0}
    with pytest.raises(NoReferenceError, match="the reference of pendulum is of another scene"):
        Reference.load(tmp_path, "pendulum", pendulum(2.0))


@pytest.mark.parametrize(
    ("force", "why"), [("exp(200*t)", "time is up"), ("exp(2000*t)", "t = 0.* s of 1 s")]
)
def test_scene_that_blows_up_is_a_row(
    force: str, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In bounded time; and what needs its reference is a row with the reason each."""
    monkeypatch.setattr(ladder_module, "FIRST", 0.5)
    table = pendulum(1.0) | {"loads": {"follower": {"force": force}}}
    folder = str(tmp_path)
    Reference(np.zeros((2, 2)), np.zeros(2), {}).save(tmp_path, "pendulum", table)  # an old one
    start = time.process_time()
    (row,) = references.reference("pendulum", table, folder, quick=True)
    assert time.process_time() - start < 10.0  # with the import of SymPy
    assert re.search(why, str(row["failed"]))
    assert set(row) >= {"method", "order", "estimate_phi", "checked_by", "check_phi", "rhs"}
    assert not list(tmp_path.glob("*.npz"))
    (mine,) = sweep.rodgens("pendulum", table, folder, True)
    (theirs,) = sweep.peers("pendulum", table, folder, True, ["SciPy DOP853", "SciPy RK45"])
    (grown,) = growth.growth("pendulum", table, folder)
    for one in (mine, theirs, grown):
        assert one["failed"] == f"no reference: {row['failed']}"
        assert one["n"] == 1
    assert (mine["who"], theirs["who"]) == ("rodgen", "SciPy")


# Error measures ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def still() -> tuple[Job, np.ndarray]:
    """A free rod, straight and at rest at every sample, that moves to the right."""
    job = Job.of("free_n10", scene_of("free_n10"))
    states = np.tile(np.zeros_like(job.start), (len(job.times), 1))
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
    assert measures.over_time(off)[50] == 0.0
    # 50 kg at 2 m/s; the bent springs of 200 Nm hold 2 * 200 * 1e-6 / 2 J.
    assert measures.scale == pytest.approx(100.0)
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

LABEL: Row = {"scene": "free_n10", "n": 10, "who": "nobody", "method": "m", "target": "c"}


def family(job: Job, states: np.ndarray, seconds: Any) -> Iterator[Contestant]:
    """Settings of 1e-1, 1e-2, .. that take so many seconds, or raise."""

    def integrate(wanted: Any) -> Finish:
        if isinstance(wanted, Exception):
            raise wanted
        end = time.perf_counter() + wanted
        while time.perf_counter() < end:
            Deadline.look()
        return Finish(states, {"steps": 3})

    for at, wanted in enumerate(seconds):
        one = lambda wanted=wanted: integrate(wanted)  # noqa: E731
        yield Contestant("nobody", "m", "c", "rtol", 10.0 ** -(at + 1), one)


def test_sweep_lists_failures_and_what_is_not_tried(still: tuple[Job, np.ndarray]) -> None:
    job, states = still
    settings = family(job, states, [ArithmeticError("fell over"), 0.001, 0.03, 10.0, 0.0])
    rows = measured(settings, LABEL, Measures(job, states), Limits(0.1, 1.0))
    said = [str(row["failed"]) for row in rows]
    assert said[:3] == ["fell over", "", ""]
    assert rows[1]["error_phi"] == 0.0
    assert rows[1]["rounds"] == 3
    assert rows[1]["steps"] == 3
    assert 0.03 <= rows[2]["seconds"] < 0.1  # type: ignore[operator]
    # 30 times longer than the one before: four times as long is expected of the next.
    assert said[3:] == ["not tried: would take more than 0.1 s, from rtol 0.0001 on"]
    assert rows[3]["seconds"] is None
    assert rows[3]["setting"] == 1e-4


def test_slow_run_is_stopped(still: tuple[Job, np.ndarray]) -> None:
    job, states = still
    rows = measured(family(job, states, [10.0]), LABEL, Measures(job, states), Limits(0.05, 1.0))
    assert [row["failed"] for row in rows] == ["stopped after 0.05 s"]
    assert np.isinf(Deadline.at)


def test_counts_are_those_of_the_median_round(still: tuple[Job, np.ndarray]) -> None:
    _, states = still
    seconds = iter((0.03, 0.01, 0.02))

    def integrate() -> Finish:
        wanted = next(seconds)
        time.sleep(wanted)
        return Finish(states, {"steps": round(100 * wanted)}, wanted)

    tried = attempt(Contestant("nobody", "m", "c", "rtol", 0.1, integrate), Limits(1.0, 1.0))
    assert tried.finish is not None
    assert (tried.finish.inside, tried.finish.counts["steps"]) == (0.02, 2)
    assert tried.finish.inside <= tried.seconds


def test_refusals_are_told_from_failures(
    still: tuple[Job, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    job, states = still
    errors: dict[str, Exception] = {
        "not modelled": NotModelledError("SciPy: too large"),
        "failed": ValueError("shapes differ"),
        "not installed": ModuleNotFoundError("No module named 'scipy'", name="scipy"),
    }

    def rows_of(error: Exception) -> list[Row]:
        def fail(*_: Any) -> Any:
            raise error

        monkeypatch.setattr(peers, "family", fail)
        return sweep._of_peer(job, Measures(job, states), True, "SciPy DOP853")

    for kind, error in errors.items():
        (row,) = rows_of(error)
        assert kind_of(str(row["failed"])) == kind
    (row,) = rows_of(ModuleNotFoundError("No module named 'yaml'", name="yaml"))
    assert row["failed"] == "No module named 'yaml'"
    (row,) = rows_of(ImportError("libmkl.so: cannot open"))
    assert row["failed"] == "libmkl.so: cannot open"


def test_family_that_breaks_off_keeps_its_rows(still: tuple[Job, np.ndarray]) -> None:
    job, states = still

    def broken() -> Iterator[Contestant]:
        yield from family(job, states, [0.0])
        raise OSError("no compiler")

    rows = measured(broken(), LABEL, Measures(job, states), Limits(0.1, 1.0))
    assert [row["failed"] for row in rows] == ["", "no compiler"]


def test_methods_in_a_row_have_limits_of_their_own(still: tuple[Job, np.ndarray]) -> None:
    job, states = still

    def two() -> Iterator[Contestant]:
        yield from family(job, states, [10.0, 0.0, 0.0])
        for one in family(job, states, [0.0, 0.0]):
            yield Contestant("nobody", "other", "c", one.kind, one.setting, one.integrate)

    rows = in_a_row(two(), LABEL, Measures(job, states), Limits(0.05, 1.0))
    assert [(row["method"], bool(row["failed"])) for row in rows] == [
        *(("m", True), ("m", True)),
        *(("other", False), ("other", False)),
    ]


def test_states_of_the_wrong_shape_are_a_failure(still: tuple[Job, np.ndarray]) -> None:
    job, states = still
    (row,) = measured(family(job, states[:-1], [0.0]), LABEL, Measures(job, states), Limits(1, 1))
    assert "cannot be compared" in str(row["failed"])


def test_first_fixed_step_is_the_stability_limit(still: tuple[Job, np.ndarray]) -> None:
    """h omega = 2 for semi_implicit_euler (docs/methods.md), samples on steps."""
    job, _ = still
    first, second, *_ = ours.steps(job, "semi_implicit_euler", quick=False)
    rate = 4 * np.sqrt(3) * 10**2 * np.sqrt(100 / (50 * 125))
    # Below it by at most one more step between two samples, of four or five.
    assert 1.6 < first * rate < 2.0
    assert second == pytest.approx(first / 2)
    assert (job.times[1] / first) == pytest.approx(round(job.times[1] / first), rel=1e-12)


def test_rodgens_rows_come_to_an_order_and_a_duel(tmp_path: Path) -> None:
    """From the reference to the fit, on a pendulum."""
    table = pendulum(10.0)
    made("pendulum", table, tmp_path)
    job, _, measures = sweep.prepared("pendulum", table, str(tmp_path))
    rows: list[Row] = []
    for one in ours.families(job, False, TAKEN):
        if (one.method, one.target) in {("rk4", "c"), ("dop853", "c")}:
            rows += measured(one.make(), sweep.label(job, one), measures, Limits(0.1, 0.3))
    by_method = {fit.method: fit for fit in fits(rows) if fit.against == "step"}
    # Off by the largest steps, a fifth of a radian each: without them it is within 0.1.
    assert by_method["rk4"].exponent == pytest.approx(4.0, abs=0.3)
    assert by_method["rk4"].nominal == 4.0
    assert all(row["setup_compile"] == TAKEN["c_compile"] for row in rows if row["seconds"])
    assert min(row["error_phi"] or 1.0 for row in rows) < 1e-10  # type: ignore[type-var]
    (unit, *_) = duels.units([type(cases()[0])(table, "")], True, tmp_path, rows)
    (row,) = unit.call()
    assert row["failed"] == "every peer missed this error in the time of a run"
    assert row["ours"]


# Orders and fronts -------------------------------------------------------------------------------


def row(method: str, setting: float, seconds: float, error: float, **more: Any) -> Row:
    known = {"scene": "s", "who": "rodgen", "method": method, "target": "c", "kind": "step"}
    made_up = {"setting": setting, "seconds": seconds, "error_phi": error, "failed": "", "order": 3}
    return known | made_up | more


def test_orders_of_made_up_rows() -> None:
    steps = [0.1 / 2**k for k in range(6)]
    rows = [row("a", h, 1 / h, 1e-3 * h**3) for h in steps]
    rows += [row("a", 1e-4, 1.0, 1e-14), row("a", 1.0, 1.0, 5.0), row("a", 0.5, 1.0, np.inf)]
    (fit,) = fits(rows)
    assert fit.order == pytest.approx(3.0)
    assert fit.points == 6
    assert fit.nominal == 3.0
    adaptive = [
        row("b", 10.0**-k, 1.0, 10.0 ** (-0.8 * k), kind="rtol", rhs=10 ** (k / 5))
        for k in range(3, 9)
    ]
    found = {fit.against: fit for fit in fits(adaptive)}
    assert found["rtol"].exponent == pytest.approx(0.8)
    assert found["rtol"].order is None
    assert found["rhs"].order == pytest.approx(4.0)
    assert fits(rows[:2]) == []


def test_slope_of_the_two_smallest_steps() -> None:
    """Whatever the ones before did: 8 to 1 over a halved step is an order of 3."""
    errors = (0.05, 0.04, 8e-6, 1e-6)
    rows = [row("a", 0.1 / 2**at, 1.0, error) for at, error in enumerate(errors)]
    assert finest(rows, "error_phi") == pytest.approx(3.0)
    assert finest(rows, "error_phi", floor=1e-5) == pytest.approx(np.log2(0.05 / 0.04))
    assert finest(rows[:1], "error_phi") is None
    assert [one.finest for one in unfitted(rows)] == pytest.approx([3.0])


def test_slopes_that_are_not_steady_are_no_order() -> None:
    orders = [1.0, 1.7, 3.0, 1.2, 2.4]
    errors = 1e-2 / 2 ** np.cumsum([0.0, *orders])
    early = [row("a", 0.1 / 2**k, 1.0, float(error)) for k, error in enumerate(errors)]
    assert fits(early) == []
    (left,) = unfitted(early)
    assert left.why == "not asymptotic in the steps tried"
    late = [row("a", 0.1 / 2**k, 1.0, errors[-1] / 16.0 ** (k - 5)) for k in range(6, 8)]
    (fit,) = fits([*early, *late])
    assert fit.order == pytest.approx(4.0)
    assert fit.points == 3
    # A setting that failed parts those beside it.
    failed = row("a", late[0]["setting"], 1.0, np.nan, failed="fell over")  # type: ignore[arg-type]
    assert fits([*early, failed, late[1]]) == []
    assert "less than 3 errors" in unfitted(early, floor=2e-3)[0].why
    assert unfitted([failed]) == []


def test_front_of_made_up_rows() -> None:
    fast, close = row("a", 0.1, 1.0, 1e-3), row("b", 0.1, 5.0, 1e-8)
    beaten = row("b", 0.2, 2.0, 1e-2)
    failed = row("c", 0.1, 0.1, 1e-9, failed="fell over")
    rows = [beaten, close, failed, fast]
    assert front(rows) == [fast, close]


def test_errors_below_the_references_own_are_not_on_the_front() -> None:
    """What is that close beats what is not, but nobody can tell how close it is."""
    fast, near = row("a", 0.1, 1.0, 1e-3), row("b", 0.1, 3.0, 1e-8)
    below, slower = row("c", 0.1, 2.0, 1e-12), row("d", 0.1, 4.0, 1e-14)
    rows = [fast, near, below, slower]
    assert front(rows) == [fast, below, slower]
    assert front(rows, trusted=1e-10) == [fast]
    assert front([fast, near, slower], trusted=1e-10) == [fast, near]


def test_cheapest_is_not_by_chance() -> None:
    lucky, unlucky = row("a", 0.4, 1.0, 1e-7), row("a", 0.2, 2.0, 1e-3)
    good = row("a", 0.1, 4.0, 1e-7)
    failed = row("c", 0.1, 0.1, 1e-9, failed="fell over")
    rows = [failed, unlucky, lucky, good, row("b", 0.1, 5.0, 1e-9)]
    assert cheapest(rows, 1e-6) is good
    assert cheapest(rows, 1e-8) is rows[-1]
    assert cheapest(rows, 1e-10) is None


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
    assert all(len(row["error"]) == len(row["t"]) == 101 for row in rows)  # type: ignore[arg-type]
    assert rows[0]["error"][-1] > rows[1]["error"][-1]  # type: ignore[index]


def test_growth_is_of_all_scenes_where_none_is_chaotic() -> None:
    def names(some: list[Any]) -> list[str]:
        return [unit.name for unit in growth.units(some, True, "folder")]

    assert names(cases()) == ["growth-falling_chain", f"growth-{cases()[0].name}"]
    assert len(names([case for case in cases() if case.name != "falling_chain"])) == 5


def test_units_have_names_of_files_and_one_function_each() -> None:
    planned = [
        unit
        for plan in (references.units, sweep.units, growth.units)
        for unit in plan(cases(quick=True), True, "folder")
    ]
    names = [unit.name for unit in planned]
    assert len(set(names)) == len(names)
    assert all(name.replace("-", "").replace("_", "").isalnum() for name in names)
    assert {unit.section for unit in planned} == {"references", "precision", "growth"}
    assert all(json.dumps(unit.arguments) for unit in planned)


def test_slow_contestant_is_told_from_one_that_fails(still: tuple[Job, np.ndarray]) -> None:
    job, states = still
    slow, failing = family(job, states, [10.0, ValueError("no")])
    assert attempt(slow, Limits(0.02, 1.0)).slow
    tried = attempt(failing, Limits(0.02, 1.0))
    assert not tried.slow
    assert tried.failed == "no"
