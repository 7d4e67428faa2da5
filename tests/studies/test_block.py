"""Points in blocks: each what its scene gives by itself, and no exception for one that fails."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import InputError, Scene, Solution
from rodgen.analyse.spectrum import find_peaks
from rodgen.errors import AnalysisError
from rodgen.studies import point_arrays, point_runs, task
from rodgen.studies.sampling import points_at
from rodgen.studies.study import Study
from rodgen.studies.task import evaluate
from rodgen.system import System
from tests.studies.conftest import BECK, PENDULUM, scene
from tests.told import numbers

pytestmark = pytest.mark.compiler
KEEP = ["last(tip_x)", "max(phi_2)", "rms(omega_0, from=0.5)", "time_of_max(kinetic_energy)"]


def computed(study: Study, indices: Any = None) -> dict[str, np.ndarray]:
    """What a study keeps of its points."""
    at = range(study.count) if indices is None else indices
    return evaluate(study, points_at(study, at))


def same(a: dict[str, np.ndarray], b: dict[str, np.ndarray], at: Any = slice(None)) -> None:
    """Both have the same bits, the second of some of the points of the first."""
    for name, values in a.items():
        if name != "seconds":
            np.testing.assert_array_equal(values[at], b[name], name)


@pytest.fixture(scope="module")
def grid() -> Study:
    """Numbers that are copied, one that two others follow from, and one of [integrate]."""
    vary = {
        "parameters.A": [0.5, 1.0, 2.0],
        "initial.phi": [0.1, 0.8],
        "rod.length": [1.0, 1.2],
        "integrate.rtol": [1e-6, 1e-8],
    }
    return Study.of(scene(PENDULUM), vary, keep=KEEP)


def test_numbers_are_what_runs_of_their_scenes_give(grid: Study) -> None:
    """By simulate and NumPy on its samples."""
    found = computed(grid)
    assert (found["status"] == "finished").all()
    for at in range(0, grid.count, 5):
        sol = rodgen.simulate(grid.scene_at(points_at(grid, [at])[0]), target="c")
        late = sol.t >= 0.5
        expected = {
            "last(tip_x)": sol.tip[-1, 0],
            "max(phi_2)": sol.phi[:, 2].max(),
            "rms(omega_0, from=0.5)": np.sqrt(np.mean(sol.omega[late, 0] ** 2)),
            "time_of_max(kinetic_energy)": sol.t[sol.energy.kinetic.argmax()],
        }
        for name, value in expected.items():
            np.testing.assert_allclose(found[name][at], value, rtol=1e-7, atol=1e-9, err_msg=name)
        np.testing.assert_allclose(found["energy_error"][at], sol.energy_error, rtol=1e-2)


def test_blocks_and_their_order_do_not_matter(grid: Study) -> None:
    every = computed(grid)
    order = np.random.default_rng(1).permutation(grid.count).tolist()
    same(every, computed(grid, order), order)
    for part in ([3], [17, 2], list(range(5, 16))):
        same(every, computed(grid, part), part)


def test_what_has_a_slot_is_what_a_scene_makes_of_it(grid: Study) -> None:
    """To the bit; and what more follows from has none."""
    names = point_arrays.slot_names(grid)
    assert names == ("parameters.A", "initial.phi", "rod.length")
    bodies = [{"name": "tip", "at": 1.0, "mass": 1.0, "offset": [0.1, 0.0]}]
    other = Study.of(scene(PENDULUM, bodies=bodies), {"rod.length": [1.0, 2.0]}, keep="last(tip_x)")
    assert point_arrays.slot_names(other) == ()
    every = points_at(grid, range(grid.count))
    (_, members), *_ = point_arrays.group_by(every, ["integrate.rtol"])
    share = point_arrays.PointBatch.of(grid, every[0], names)
    assert share is not None
    p, y, taken = share.rows([every[at] for at in members])
    assert all(taken)
    for row, at in enumerate(members):
        alone = System(grid.scene_at(every[at]))
        np.testing.assert_array_equal(p[row], alone.p)
        np.testing.assert_array_equal(y[row], alone.y0)


def test_what_an_expression_makes_of_a_number_has_no_slot() -> None:
    """It may switch at a value that was not tried; and a law may have a value that it refuses."""
    switching = scene(PENDULUM, initial={"phi": "0.5 + s if A < 100 else 0.2"})
    study = Study.of(switching, {"parameters.A": [0.5, 1.0, 2.0, 200.0]}, keep=["last(tip_x)"])
    assert point_arrays.slot_names(study) == ()
    alone = rodgen.simulate(study.scene_at({"parameters.A": 200.0}), target="c")
    np.testing.assert_allclose(computed(study)["last(tip_x)"][3], alone.tip[-1, 0], rtol=1e-7)
    divided = scene(PENDULUM, parameters={"A": 2.0}, loads={"tip": {"x": "sin(w*t)*(1/(A - 1))"}})
    study = Study.of(divided, {"parameters.A": [0.5, 1.0, 2.0, 3.0, 4.0]}, keep=["last(tip_x)"])
    assert point_arrays.slot_names(study) == ("parameters.A",)
    found = computed(study)
    assert found["status"].tolist() == ["finished", "failed", *["finished"] * 3]
    with pytest.raises(InputError) as refused:
        study.scene_at({"parameters.A": 1.0})
    assert found["message"][1] == str(refused.value)[:200]


def test_points_that_fail_are_alone() -> None:
    """One that the scene refuses, one that spends its budget, and one without the link that is
    asked for: each with its reason, and nothing but fill values."""
    vary = {"rod.mass": [2.0, -1.0, 0.5, 1.0, 4.0, 3.0], "integrate.max_steps": [1000, 3]}
    found = computed(Study.of(scene(PENDULUM), vary, keep=KEEP))
    refused = [2, 3]
    assert (found["status"][refused] == "failed").all()
    assert found["message"][2].startswith("rod.mass = -1.0: ")
    spent = [1, 5, 7, 9, 11]
    assert all(3 in numbers(found["message"][at]) for at in spent)  # steps
    fine = [0, 4, 6, 8, 10]
    assert (found["status"][fine] == "finished").all()
    assert set(found["message"][fine]) == {""}
    for name in (*KEEP, "energy_error"):
        assert np.isfinite(found[name][fine]).all()
        assert np.isnan(found[name][refused + spent]).all()
    links = computed(Study.of(scene(PENDULUM, events=[]), {"rod.links": [3, 2]}, keep="max(phi_2)"))
    assert links["status"].tolist() == ["finished", "failed"]
    assert "phi_2" in links["message"][1]


# One by one --------------------------------------------------------------------------------------

SECTION = "section(tip_y, where='tip_x', rising=0.1, from=0.2, max_points=5)"
PEAK = "peak(phi_0, from=0.5)"


def angle(solution: Solution) -> float:
    """The last angle of the first link."""
    if solution.phi[0, 0] > 0.75:
        raise ValueError("too large")
    return float(solution.phi[-1, 0])


def test_events_sections_peaks_and_functions() -> None:
    """By a run whose events are those of the section, and by its samples."""
    table = scene(PENDULUM, integrate={"span": [0.0, 6.0], "output_every": 0.02})
    keep = ["count(up)", SECTION, PEAK, "max(tip_x)", angle]
    study = Study.of(table, {"initial.phi": [0.1, 0.5, 0.8]}, keep=keep)
    found = computed(study)
    assert found["status"].tolist() == ["finished", "finished", "failed"]
    assert found["message"][2] == "angle: ValueError: too large"
    assert found["count(up)"][2] == -1
    sol = rodgen.simulate(study.scene_at({"initial.phi": 0.5}), target="c")
    x, y = sol.tip.T
    up = np.flatnonzero((x[:-1] < 0.1) & (x[1:] >= 0.1) & (sol.t[1:] >= 0.2))
    assert len(up) >= 2
    share = (0.1 - x[up]) / (x[up + 1] - x[up])
    met = found[f"{SECTION}.t"][1]
    np.testing.assert_allclose(met[: len(up)], sol.t[up] + share * 0.02, atol=2e-3)
    # The tail falls with up to 25 m/s^2: a line between samples is off by 25 * 0.02^2 / 8 at most.
    between = np.interp(met[: len(up)], sol.t, y)
    np.testing.assert_allclose(found[SECTION][1, : len(up)], between, atol=2e-3)
    assert np.isnan(found[SECTION][1, len(up) :]).all()
    phi = sol.phi[:, 0]
    assert found["count(up)"][1] == ((phi[:-1] < -1) & (phi[1:] >= -1)).sum() > 0
    late = sol.t >= 0.5
    peak = find_peaks(sol.t[late], phi[late], peaks=1)
    assert found[f"{PEAK}.frequency"][1] == peak.frequencies[0]
    assert found[f"{PEAK}.amplitude"][1] == peak.amplitudes[0]
    assert found["angle"][1] == phi[-1]
    assert found["max(tip_x)"][1] == x.max()
    same(found, computed(study, [1]), [1])


@pytest.mark.slow
def test_auto_finds_the_method_of_every_point(monkeypatch: pytest.MonkeyPatch) -> None:
    """One for all where the ends of the axes agree, else what `choose` finds of each; a point has
    the same bits with and without its neighbours."""
    table = scene(PENDULUM, integrate={"method": "auto"})
    alike = Study.of(table, {"initial.phi": [0.1, 0.2, 0.3, 0.4, 0.5]}, keep=["last(tip_x)"])
    asked: list[Any] = []
    monkeypatch.setattr(point_runs, "choose_from", lambda *given: asked.append(given))
    every = computed(alike)
    assert set(every["method"]) == {"dop853"}
    assert not asked
    monkeypatch.undo()
    point_runs._common_method.cache_clear()
    same(every, computed(alike, [3]), [3])
    stiff = Scene.from_dict(DAMPED | {"integrate": {"span": [0.0, 400.0]}})
    apart = Study.of(stiff, {TIME: [0.0, 1e-3, 0.1, 3.0]}, keep=["last(tip_y)"])
    due = [
        rodgen.choose(one := apart.scene_at(point), rodgen.build(one)).method
        for point in points_at(apart, range(apart.count))
    ]
    every = computed(apart)
    assert every["method"].tolist() == due
    assert len(set(due)) > 1
    point_runs._common_method.cache_clear()
    same(every, computed(apart, [3, 1]), [3, 1])


@pytest.mark.parametrize("together", [True, False])
def test_doubts_of_runs_are_counted(together: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Angles of more than a turn at the start, in lanes and one by one, and nobody is warned."""
    study = Study.of(scene(PENDULUM), {"initial.phi": [0.1, 7.0, 40.0]}, keep=["last(tip_x)"])
    if not together:
        monkeypatch.setattr(point_runs, "_run_together", _by_themselves)
    with warnings.catch_warnings():
        warnings.simplefilter("error", rodgen.DoubtWarning)
        found = task.compute_points(study, [0, 1, 2])
    assert found["doubts"].tolist() == [0, 1, 1]


def _by_themselves(study: Study, given: Any, made: Any) -> None:
    point_runs._run_one_by_one(study, given, range(len(given)), made)


def test_a_study_tells_how_many_points_are_doubtful() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", rodgen.DoubtWarning)
        data = rodgen.study(scene(BECK), {FORCE: [20.0, 95.0]}, analysis="modes", workers=1)
    assert data["doubts"].values.tolist() == [0, 1]
    assert data.rodgen.notes[0].figures == {"points": 1}
    assert data.rodgen.to_dict()["notes"] == [data.rodgen.notes[0].to_dict()]
    assert data["frequencies"].attrs == {"long_name": "frequency", "units": "Hz"}
    assert (
        rodgen.study(scene(BECK), {FORCE: [20.0]}, analysis="modes", workers=1).rodgen.notes == ()
    )


def test_what_is_not_known_of_a_point_is_none_in_plain_data() -> None:
    """Of points that failed, along one axis and two."""
    vary = {FORCE: [20.0], "rod.mass": [50.0, -1.0]}
    data = rodgen.study(scene(BECK), vary, analysis="modes", keep=["stable"], workers=1)
    found = data.rodgen.to_dict()
    assert (found["stable"], found["doubts"]) == ([[1, None]], [[0, None]])
    assert data.isel({FORCE: 0}).rodgen.to_dict()["stable"] == [1, None]
    assert not {"token", "digest", "variables"} & found.keys()


# Analyses ----------------------------------------------------------------------------------------


FORCE, TIME = "loads.follower.force", "loads.material_damping.time"
DAMPED = {
    **BECK,
    "loads": {**BECK["loads"], "material_damping": {"time": 0.05}},
    "initial": {"phi": "0.1*s"},
    "integrate": {"span": [0.0, 200.0]},
}
Alone = Callable[..., dict[str, Any]]


def critical(of: Scene, **options: Any) -> dict[str, Any]:
    found = rodgen.critical_load(of, **options)
    return {"value": found.value, "kind": found.kind}


def modes(of: Scene) -> dict[str, Any]:
    found = rodgen.natural_modes(of, 16)
    growth = found.growth.max()
    return {"stable": growth < 0, "largest_growth": growth, "frequencies(3)": found.frequencies[:3]}


def static(of: Scene) -> dict[str, Any]:
    found = rodgen.static_equilibrium(of)
    return {"tip_y": found.tip[1], "stable": found.stable}


def cycle(of: Scene) -> dict[str, Any]:
    found = rodgen.find_cycle(of)
    return {"period": found.period, "stable": True, "moduli(2)": np.abs(found.nontrivial[:2])}


def lyapunov(of: Scene, **options: Any) -> dict[str, Any]:
    found = rodgen.lyapunov_exponents(of, count=2, **options)
    first, *_ = found.exponents
    return {"exponents(2)": found.exponents, "errors(2)": found.errors, "exponents": first}


KEPT = {
    "critical": ["value", "kind"],
    "modes": ["stable", "largest_growth", "frequencies(3)"],
    "static": ["tip_y", "stable"],
    "cycle": ["period", "stable", "moduli(2)"],
    "lyapunov": ["exponents(2)", "errors(2)", "exponents", "chaotic"],
}
# Columns of which thrust, damping, mass or weight are varied, and pendulums. Some have no result: a
# mass below zero, thrust too small for flutter, a motion that comes to rest, and a transient longer
# than the span.
ANALYSES: list[tuple[Alone, dict[str, Any], dict[str, Any], dict[str, Any], int]] = [
    (critical, BECK, {TIME: [1e-3, 1.0], "rod.mass": [20.0, -1.0]}, {}, 2),
    (critical, BECK, {TIME: [1e-3]}, {"bounds": (None, 20.0)}, 1),
    (modes, BECK, {FORCE: [20.0, 95.0]}, {}, 0),
    (static, {**BECK, "loads": {"gravity": {"g": 9.81}}}, {"loads.gravity.g": [0.0, 1.0]}, {}, 0),
    (lyapunov, PENDULUM, {"initial.phi": [0.2]}, {"transient": 1e9}, 1),
    (cycle, DAMPED, {FORCE: [0.0, 96.0]}, {}, 1),
    (lyapunov, PENDULUM, {"initial.phi": [0.2, 0.5]}, {"span": 8.0, "transient": 1.0}, 0),
]


@pytest.mark.parametrize(
    "analysis",
    [*ANALYSES[:5], *(pytest.param(one, marks=pytest.mark.slow) for one in ANALYSES[5:])],
    ids=lambda analysis: analysis[0].__name__,
)
def test_analyses_are_those_of_their_scenes(analysis: tuple[Any, ...]) -> None:
    """And what they refuse is a failed point with the reason."""
    alone, table, vary, options, failures = analysis
    what = alone.__name__
    study = Study.of(scene(table), vary, analysis=what, keep=KEPT[what], options=options)
    found = computed(study)
    failed = found["status"] == "failed"
    assert failed.sum() == failures
    for at, point in enumerate(points_at(study, range(study.count))):
        if failed[at]:
            with pytest.raises((InputError, AnalysisError)) as refused:
                alone(study.scene_at(point), **options)
            assert found["message"][at] == str(refused.value)[:200]
        else:
            for name, value in alone(study.scene_at(point), **options).items():
                np.testing.assert_array_equal(found[name][at], value, name)


def test_tongues() -> None:
    """Mathieu's equation inside and outside of its first tongue."""
    rod = {"links": 1, "length": 1.0, "bending_stiffness": 0.0, "mass": 3.0, "boundary": "pinned"}
    mathieu = {
        "name": "mathieu",
        "parameters": {"a": 1.0, "b": 0.3},
        "rod": rod,
        "loads": {"tip": {"x": "a + b*cos(2*t)"}},
    }
    found = computed(
        Study.of(scene(mathieu), {"parameters.a": [0.8, 1.0, 1.2]}, analysis="floquet")
    )
    assert found["stable"].tolist() == [1, 0, 1]
    assert found["growth"][1] > 0.05
    assert found["modulus"][[0, 2]] == pytest.approx(1.0, abs=1e-6)
