"""Work-precision sets of a scene: reference, sweeps, fronts, the function and the command."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import rodgen
from rodgen.analyse.precision import contestant
from rodgen.analyse.precision import work_precision as sets
from rodgen.analyse.precision.contestant import Contestant, Deadline, Limits, Measurement, RunResult
from rodgen.analyse.precision.job import Job, Measures
from rodgen.analyse.precision.rows import find_cheapest, pareto_front
from rodgen.scene import Scene
from tests.told import numbers

PENDULUM: dict[str, Any] = {
    "name": "pendulum",
    "rod": {"links": 1, "length": 2.0, "bending_stiffness": 0.0, "mass": 3.0}
    | {"inertia": "lumped", "boundary": "pinned"},
    "loads": {"gravity": {"g": 9.81}},
    "initial": {"phi": 2.0 - np.pi / 2},
    "integrate": {"span": [0.0, 3.0]},
}


@pytest.fixture(autouse=True)
def _processor_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seconds are of the processor here, so that a busy machine comes as far as a quiet one."""
    monkeypatch.setattr(time, "perf_counter", time.process_time)


@pytest.fixture(scope="module")
def job() -> Job:
    """One lumped link of 2 m that hangs from a pin, released at rest 2 rad from the vertical."""
    return Job.of("pendulum", Scene.from_dict(PENDULUM))


def swung(times: np.ndarray) -> np.ndarray:
    """Its angle from the x axis, by Jacobi's elliptic functions: 2 asin(k sn(K - w t)) - pi/2."""
    k, w = np.sin(1.0), np.sqrt(9.81 / 2.0)
    sine, *_ = ellipj(ellipk(k**2) + w * times, k**2)
    return np.asarray(2 * np.arcsin(k * sine) - np.pi / 2)


# The whole set -----------------------------------------------------------------------------------


@pytest.mark.compiler
@pytest.mark.parametrize(
    "families", [("gauss", "radau"), pytest.param(("dop853", "gauss"), marks=pytest.mark.slow)]
)
def test_reference_is_as_close_as_it_says(
    job: Job, families: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a pendulum, to elliptic functions, by an explicit method and by one for stiff scenes."""
    monkeypatch.setattr(sets, "FAMILIES", families)
    found = sets.compute_reference(job, 5.0)
    assert (found.method, found.checked_by.split(",")[0]) == families
    exact = swung(job.sample_times)
    errors = [np.abs(states[:, 0] - exact).max() for states in (found.states, found.other)]
    # The larger error of two is near their difference; elliptic functions are good to some 1e-15.
    assert max(errors) < 3 * (found.off.max() + 1e-14)
    assert found.off.max() < 1e-9
    assert found.estimate["error_modes"] is None
    # A method is held against the solution that is not its own.
    for method, held in ((families[0], found.other), ("rk4", found.states)):
        assert found.measures(job, method).exact is held
    assert found.measures(job, families[0].upper()).exact is found.other


@pytest.mark.slow
@pytest.mark.compiler
def test_set_of_a_pendulum() -> None:
    """Errors in the set are those to elliptic functions, and the cheapest setting is within."""
    told: list[str] = []
    scene = Scene.from_dict(PENDULUM)
    found = rodgen.work_precision(scene, seconds=3.0, progress=told.append)
    assert {"reference", "rk4", "dop853", "SciPy radau"} <= set(told)
    best = found.cheapest(1e-6, method="dop853")
    assert best is not None
    run = rodgen.simulate(scene, target="c", rtol=best["setting"], atol=0.01 * best["setting"])
    own = abs(run.y[-1, 0] - swung(run.t[-1:])[0])
    # Up to the reference's own error.
    assert best["error_phi"] == pytest.approx(own, abs=2 * found.trusted["error_phi"])
    assert found.trusted["error_phi"] < 1e-9
    points = found.front()
    assert points
    assert points[0] in found.rows
    assert {str(row["who"]) for row in found.rows} == {"rodgen", "SciPy"}
    assert set(found.limits) >= {"euler", "rk4", "dop853"}
    assert len(found.table) == len(found.rows)
    json.dumps(found.to_dict(), allow_nan=False)


@pytest.mark.slow
@pytest.mark.compiler
def test_command_draws_tells_and_prints_json(tmp_path: Path, rodgen: Callable[..., Any]) -> None:
    scene = tmp_path / "pendulum.toml"
    scene.write_text(Scene.from_dict(PENDULUM).to_toml(), encoding="utf-8")
    done = rodgen("precision", scene, "--seconds", 0.5, cwd=tmp_path)
    assert done.returncode == 0
    assert "dop853" in done.stdout
    assert (tmp_path / "results" / "pendulum" / "precision.png").stat().st_size > 1000
    done = rodgen("precision", scene, "--seconds", 0.5, "--json", cwd=tmp_path)
    found = json.loads(done.stdout)
    assert found["links"] == 1
    assert {"rk4", "gauss"} <= {row["method"] for row in found["rows"]}
    assert "rk4" in found["limits"]  # where the time allows to find one
    done = rodgen("precision", scene, "--seconds", 0, cwd=tmp_path)
    assert done.returncode == 2
    assert "seconds = 0" in done.stderr


@pytest.mark.slow
def test_scene_without_a_reference_is_an_error() -> None:
    """Thrust that grows beyond all bounds: the run blows up whatever the step."""
    table = PENDULUM | {"loads": {"follower": {"force": "exp(2000*t)"}}}
    with pytest.raises(rodgen.AnalysisError):
        rodgen.work_precision(Scene.from_dict(table), seconds=1.0)


# Sweeps ------------------------------------------------------------------------------------------

LABEL: Measurement = {"scene": "pendulum", "n": 1, "who": "nobody", "method": "m", "target": "c"}


class Stage:
    """A pendulum at rest, and a clock that stands still but for what runs take."""

    def __init__(self, job: Job, monkeypatch: pytest.MonkeyPatch):
        self.states, self.now = (
            np.tile(np.zeros_like(job.initial_state), (len(job.sample_times), 1)),
            0.0,
        )
        self.measures = Measures(job, self.states)
        monkeypatch.setattr(contestant, "time", SimpleNamespace(perf_counter=lambda: self.now))

    def run(self, wanted: float | Exception, states: np.ndarray) -> RunResult:
        """A run that takes so many seconds, or raises."""
        if isinstance(wanted, Exception):
            raise wanted
        self.now += wanted
        Deadline.check()
        return RunResult(states, {"nsteps": round(100 * wanted)}, wanted)

    def family(
        self, *seconds: float | Exception, method: str = "m", states: np.ndarray | None = None
    ) -> Iterator[Contestant]:
        """Settings of 1e-1, 1e-2, .. of a method, with what their runs take."""
        for at, wanted in enumerate(seconds):
            one = partial(self.run, wanted, self.states if states is None else states)
            yield Contestant("nobody", method, "c", "rtol", 10.0 ** -(at + 1), one)

    def swept(self, family: Iterator[Contestant], most: float = 0.1) -> list[Measurement]:
        return contestant.sweep(family, LABEL, self.measures, Limits(most, 1.0))


@pytest.fixture
def stage(job: Job, monkeypatch: pytest.MonkeyPatch) -> Stage:
    return Stage(job, monkeypatch)


def test_sweep_lists_failures_and_what_is_not_tried(stage: Stage) -> None:
    rows = stage.swept(stage.family(ArithmeticError("fell over"), 0.001, 0.03, 10.0, 0.0))
    assert [row["failed"] for row in rows[:3]] == ["fell over", "", ""]
    assert (rows[1]["error_phi"], rows[2]["rounds"], rows[2]["nsteps"]) == (0.0, 3, 3)
    assert rows[2]["seconds"] == pytest.approx(0.03)
    # 30 times longer than the one before: four times as long is expected of the next.
    (last,) = rows[3:]
    assert {0.1, 1e-4} <= {*numbers(last["failed"])}  # longer than this, from that setting on
    assert (last["seconds"], last["setting"]) == (None, 1e-4)


def test_counts_are_those_of_the_median_round(stage: Stage) -> None:
    seconds = iter((0.03, 0.01, 0.02))
    one = Contestant(
        "nobody", "m", "c", "rtol", 0.1, lambda: stage.run(next(seconds), stage.states)
    )
    tried = contestant.attempt(one, Limits(1.0, 1.0))
    assert tried.finish is not None
    assert (tried.finish.inside, tried.finish.counts["nsteps"]) == (0.02, 2)
    assert tried.seconds == pytest.approx(0.02)


def test_family_that_breaks_off_keeps_its_rows(stage: Stage) -> None:
    def broken() -> Iterator[Contestant]:
        yield from stage.family(0.0)
        raise OSError("no compiler")

    assert [row["failed"] for row in stage.swept(broken())] == ["", "no compiler"]
    (row,) = stage.swept(stage.family(0.0, states=stage.states[:-1]))  # of the wrong shape
    assert row["failed"]


def test_methods_in_a_row_have_limits_of_their_own(stage: Stage) -> None:
    two = chain(stage.family(10.0, 0.0, 0.0), stage.family(0.0, 0.0, method="other"))
    rows = contestant.sweep_methods(two, LABEL, stage.measures, Limits(0.05, 1.0))
    found = [(row["method"], bool(row["failed"])) for row in rows]
    assert found == [("m", True), ("m", True), ("other", False), ("other", False)]


def test_slow_contestant_is_stopped_and_told_from_one_that_fails(stage: Stage) -> None:
    (row,) = stage.swept(stage.family(10.0))
    assert numbers(row["failed"]) == [0.1]  # seconds
    assert np.isinf(Deadline.at)
    slow, failing = (
        contestant.attempt(one, Limits(0.02, 1.0)) for one in stage.family(10.0, ValueError("no"))
    )
    assert slow.slow
    assert (failing.slow, failing.failed) == (False, "no")


# Fronts ------------------------------------------------------------------------------------------


def row(method: str, setting: float, seconds: float, error: float, **more: Any) -> Measurement:
    known = {"scene": "s", "who": "rodgen", "method": method, "target": "c", "kind": "step"}
    made_up = {"setting": setting, "seconds": seconds, "error_phi": error, "failed": ""}
    return known | made_up | more


def test_front_of_made_up_rows() -> None:
    """What is closer than the reference beats what is not, but nobody can tell how close it is."""
    fast, near = row("a", 0.1, 1.0, 1e-3), row("b", 0.1, 3.0, 1e-8)
    below, slower = row("c", 0.1, 2.0, 1e-12), row("d", 0.1, 4.0, 1e-14)
    failed = row("c", 0.1, 0.1, 1e-9, failed="fell over")
    assert pareto_front([row("b", 0.2, 2.0, 1e-2), near, failed, fast]) == [fast, near]
    rows = [fast, near, below, slower]
    assert pareto_front(rows) == [fast, below, slower]
    assert pareto_front(rows, trusted=1e-10) == [fast]
    assert pareto_front([fast, near, slower], trusted=1e-10) == [fast, near]


def test_cheapest_is_not_by_chance() -> None:
    lucky, unlucky = row("a", 0.4, 1.0, 1e-7), row("a", 0.2, 2.0, 1e-3)
    good = row("a", 0.1, 4.0, 1e-7)
    failed = row("c", 0.1, 0.1, 1e-9, failed="fell over")
    rows = [failed, unlucky, lucky, good, row("b", 0.1, 5.0, 1e-9)]
    assert find_cheapest(rows, 1e-6) is good
    assert find_cheapest(rows, 1e-8) is rows[-1]
    assert find_cheapest(rows, 1e-10) is None


@pytest.mark.slow
def test_a_rod_that_does_not_turn_is_held_by_its_tail() -> None:
    """A straight rod in free flight under a thrust along it: all angles are zero, whatever its
    steps are. A state that is added is no angle."""
    table = {
        "name": "dart",
        "rod": {"links": 2, "length": 2.0, "bending_stiffness": 10.0, "mass": 3.0},
        "loads": {"follower": {"force": "6*cos(2*t)"}},
        "states": {"z": {"rate": "1 - z"}, "w": {"rate": "z"}},
        "integrate": {"span": [0.0, 1.0], "output_every": 0.25},
    }
    job = Job.of("dart", Scene.from_dict(table))
    t = np.linspace(0.0, 1.0, 5)
    exact = np.zeros((5, 10))
    exact[:, 0], exact[:, 4] = -(1 - np.cos(2 * t)) / 2, -np.sin(2 * t)
    exact[:, 8], exact[:, 9] = 1 - np.exp(-t), t - 1 + np.exp(-t)
    measures = Measures(job, exact)
    assert measures.default_measure == "error_tail"
    off = exact.copy()
    off[2, 0] += 1e-3
    found = measures.errors(off)
    assert (found["error_phi"], found["error_modes"]) == (0.0, 0.0)
    assert found["error_tail"] == pytest.approx(1e-3)
    off[-1, 3] += 1e-4  # of the last link, before the velocities
    assert measures.errors(off)["error_phi"] == pytest.approx(1e-4)
    off[1, 2] += 2e-4  # an angle on the way
    off[3, 7] -= 3e-2  # the last rate, before the states that are added
    off[2, 9] += 1.0
    found = measures.errors(off)
    assert found["error_phi"] == pytest.approx(1e-4)
    assert found["error_angles"] == pytest.approx(2e-4)
    assert found["error_rates"] == pytest.approx(3e-2)
    turned = exact.copy()
    turned[:, 2:4] += 0.1 * t[:, None]
    assert Measures(job, turned).default_measure == "error_phi"
    fast = row("a", 0.1, 1.0, 0.0, error_tail=1e-2)
    close = row("a", 0.1, 2.0, 0.0, error_tail=1e-5)
    scene = Scene.from_dict(table)
    trusted = dict.fromkeys(found, 0.0)
    made = sets.WorkPrecision(scene, [fast, close], {}, trusted, {}, measures.default_measure)
    assert made.front() == [fast, close]
    assert made.to_dict()["measure"] == "error_tail"
