"""Lyapunov exponents against spectra of matrices, and what theory says."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.signal import lfilter

import rodgen
from rodgen.analyse.chaos.lyapunov import half_differences, lyapunov_exponents, standard_errors
from rodgen.analyse.chaos.metrics import Metric, zero_exponents
from rodgen.errors import AnalysisError
from rodgen.integrate.stepper import StepError
from rodgen.integrate.variations import Variations
from rodgen.scene import Scene
from tests.analyse.rods import eigenvalues, rod

DAMPING = "loads.internal_damping.coefficient"
LIMIT = 3.338  # 1/s, of a pendulum of three links, known to 0.05


@pytest.fixture(scope="module")
def pendulum() -> Scene:
    """A double pendulum of two uniform rods, each of 1 m and 1 kg, let go from angles that make it
    tumble."""
    keys = {"length": 2.0, "bending_stiffness": 0.0, "mass": 2.0, "initial": {"phi": [1.5, 0.5]}}
    keys |= {"integrate": {"span": [0.0, 10.0], "rtol": 1e-12, "atol": 1e-13}}
    return rod(2, "pinned", {"gravity": {"g": 9.81}}, **keys)


@pytest.mark.compiler
def test_exponents_without_damping(pendulum: Scene) -> None:
    """Volumes are kept (Liouville); exponents come in pairs, one is zero by the time and one by the
    energy; what the errors say holds."""
    found = lyapunov_exponents(pendulum, span=200.0)
    one, two, three, four = found.exponents
    assert abs(found.exponents.sum()) < 1e-6
    assert found.chaotic
    assert found.zero_one > 0.95
    assert abs(one + four) < found.errors[0]
    # In 200 s zeros come to within some hundredths of the largest: growth rates there drift.
    for zero, error in ((two, found.errors[1]), (three, found.errors[2])):
        assert abs(zero) < 2 * error < 0.2 * one
    assert found.zeros == {"time": 1, "energy": 1}
    alone = lyapunov_exponents(pendulum, span=200.0, count=1)
    assert abs(alone.exponents[0] - one) < 3 * np.hypot(alone.errors[0], found.errors[0])
    assert found.running[-1] == pytest.approx(found.exponents)


@pytest.mark.slow
@pytest.mark.compiler
def test_small_swings_are_regular(pendulum: Scene) -> None:
    found = lyapunov_exponents(pendulum.replace({"initial.phi": [-1.4, -1.5]}), span=200.0)
    assert (np.abs(found.exponents) < 2 * found.errors).all()
    assert found.chaotic is False
    assert found.zero_one < 0.1


@pytest.mark.parametrize("memory", [4, 60, 200, 400])
def test_errors_cover_rates_that_drift(memory: int) -> None:
    """Rates x' = r x + noise that remember up to a fifth of their 2000 pieces: four fifths of the
    means lie within one error of the limit, 0, and 93 % or more within two. If the correlation of
    batches is taken as they show it, 61 % and 86 % of the longest do."""
    pieces, series, r = 2000, 1500, np.exp(-1 / memory)
    noise = np.random.default_rng(0).standard_normal((3 * pieces, series))
    rates = lfilter([1.0], [1.0, -r], noise, axis=0)[-pieces:]
    off = np.abs(rates.mean(axis=0)) / np.hypot(standard_errors(rates), half_differences(rates))
    assert 0.7 < (off < 1).mean() < 0.9
    assert (off < 2).mean() > 0.91


def _three_links(span: float, phi: Any) -> Scene:
    """A pendulum of three links of a third of a metre."""
    keys: dict[str, Any] = {"length": 1.0, "mass": 1.0, "bending_stiffness": 0.0}
    keys |= {"integrate": {"span": [0.0, span], "rtol": 1e-9, "atol": 1e-10}}
    return rod(3, "pinned", {"gravity": {"g": 9.81}}, initial={"phi": list(phi)}, **keys)


@pytest.mark.slow
@pytest.mark.compiler
@pytest.mark.parametrize("span", [36.0, 60.0])
def test_spans_of_a_chaotic_pendulum_agree_within_their_errors(span: float) -> None:
    """Let go from the level. Starts 1e-6 rad apart have parted after six seconds. The limit is that
    of an independent program over 1200 s."""
    starts = 1e-6 * np.random.default_rng(0).standard_normal((24, 3))
    every = [lyapunov_exponents(_three_links(span, start), count=1) for start in starts]
    found = np.array([[one.exponents[0], one.errors[0]] for one in every])
    off = np.abs(found[:, 0] - LIMIT) / found[:, 1]
    assert (off < 1).mean() > 0.5  # 0.80 of sixty; 0.5 is three standard deviations of 24 below
    assert (off < 2).mean() > 0.8  # 0.98 of sixty
    assert 0.5 < found[:, 0].std() / np.median(found[:, 1]) < 1.5
    assert all(one.chaotic for one in every)


@pytest.mark.slow
@pytest.mark.compiler
@pytest.mark.parametrize("phi", [-1.5, -1.3, -1.0, -0.8])
def test_a_stretched_pendulum_is_regular(phi: float) -> None:
    """Also where few samples give the 0-1 test up to 0.94 (at -1.0)."""
    found = lyapunov_exponents(_three_links(60.0, [phi] * 3), count=1)
    assert abs(found.exponents[0]) < found.errors[0] < 0.2
    assert found.chaotic is not True


@pytest.fixture(scope="module")
def damped() -> Scene:
    """Three links on a pin, bent and let go, damped across their joints."""
    keys: dict[str, Any] = {"length": 1.0, "bending_stiffness": 1.0, "mass": 3.0}
    keys |= {"inertia": "lumped", "initial": {"phi": "2*s", "omega": "3 - 4*s"}}
    keys |= {"integrate": {"span": [0.0, 10.0], "rtol": 1e-11, "atol": 1e-12}}
    return rod(3, "pinned", {"internal_damping": {"coefficient": 0.05}}, **keys)


@pytest.mark.slow
@pytest.mark.compiler
def test_exponents_add_up_to_the_mean_divergence(damped: Scene) -> None:
    """That of the numbers of the state is the trace of the Jacobian, here by Simpson's rule along
    a run; that of positions and momenta has the density of mass besides."""
    found = lyapunov_exponents(damped, transient=0.0)
    sol = rodgen.simulate(damped, output_every=0.0125)
    model = rodgen.build(damped, "numpy")
    p = model.parameters(**damped.parameters)
    traces = [np.trace(model.jac(t, y, p)) for t, y in zip(sol.t, sol.y, strict=True)]
    mean = simpson(traces, x=sol.t) / 10.0
    assert mean < -0.1
    assert found.divergence == pytest.approx(mean, abs=1e-6)
    dense = Metric(model, p).log_density
    kept = (dense(10.0, sol.y[-1]) - dense(0.0, sol.y[0])) / 10.0
    assert found.exponents.sum() == pytest.approx(mean + kept, abs=1e-6)


@pytest.mark.slow
@pytest.mark.compiler
@pytest.mark.parametrize(
    ("start", "coefficient", "span", "quick"),
    [
        (0.3, 0.05, 400.0, slice(2, None)),
        # With steps at their limit of stability, 1e-11 or not, the last two would be -0.144. The
        # others are slow to part, which their errors know.
        (0.0, 0.002, 1000.0, slice(-2, None)),
    ],
)
def test_exponents_at_rest_are_those_of_the_matrix(
    damped: Scene, start: float, coefficient: float, span: float, quick: slice
) -> None:
    """A rod that is straight and still stays so: growth rates of its linear motion, of which two
    are zero, as it may turn freely."""
    still = damped.replace({"initial": {"phi": start}, DAMPING: coefficient})
    found = lyapunov_exponents(still, span=span)
    off = np.abs(found.exponents - np.sort(eigenvalues(still).real)[::-1])
    assert (off < 2 * found.errors).all()
    assert off[quick].max() < 2 / (0.9 * span)  # logarithms of how modes turn
    assert (found.errors < 0.02).all()
    assert found.zero_one == 0.0


@pytest.mark.parametrize(
    ("boundary", "loads", "zeros"),
    [
        ("free", {}, 8),
        ("free", {"gravity": {"g": 9.81}}, 6),
        ("free", {"follower": {"force": 5.0}}, 4),
        ("free", {"follower": {"force": "5*sin(t)"}}, 3),
        ("free", {"drag": {"normal": 1.0, "tangential": 0.1, "wind": [1.0, 0.0]}}, 3),
        ("pinned", {}, 4),
        ("clamped", {"external_damping": {"coefficient": 1.0}}, 1),
    ],
)
def test_zero_exponents_by_what_the_motion_keeps(
    boundary: str, loads: dict[str, Any], zeros: int
) -> None:
    """Time, energy, place and momentum (two each), direction and angular momentum."""
    scene = rod(2, boundary, loads)
    assert sum(zero_exponents(scene, rodgen.build(scene, "numpy")).values()) == zeros


@pytest.mark.compiler
def test_motion_that_cannot_go_on(pendulum: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Variations, end: float, most: int | None = None) -> bool:
        raise StepError("the step becomes too small to move on at t = 0 s")

    monkeypatch.setattr(Variations, "advance_to", fail)
    with pytest.raises(AnalysisError, match="too small to move on at t = 0 s"):  # what was raised
        lyapunov_exponents(pendulum)


@pytest.mark.compiler
def test_scene_that_is_too_stiff_is_refused_at_once(damped: Scene) -> None:
    with pytest.raises(AnalysisError, match=r"integrate\.max_steps"):
        lyapunov_exponents(damped.replace({DAMPING: 1e9}), count=1)


@pytest.mark.slow
@pytest.mark.compiler
def test_command(pendulum: Scene, rodgen: Callable[..., Any], tmp_path: Path) -> None:
    file = tmp_path / "pendulum.toml"
    slower = pendulum.with_integrate(method="bdf", rtol=1e-8, atol=1e-10)
    file.write_text(slower.to_toml(), encoding="utf-8")
    done = rodgen("exponents", file, "--count", 2, "--span", 20, "--json", cwd=tmp_path)
    assert done.returncode == 0
    told = json.loads(done.stdout)
    assert len(told["exponents"]) == len(told["errors"]) == 2
    assert told["exponents"][0] > told["exponents"][1]
    assert len(told["notes"]) == 1  # bdf takes no tangents along
    done = rodgen("exponents", file, cwd=tmp_path)
    assert done.returncode == 0
    (picture,) = (tmp_path / "results" / "rod").iterdir()
    assert picture.name == "exponents.png"
    done = rodgen("exponents", file, "--count", 9, cwd=tmp_path)
    assert done.returncode == 2
    assert "count = 9" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("method", ["dop853", "radau"])
def test_a_law_that_chatters_ends_the_exponents(method: str) -> None:
    """As it ends a run; without that, steps of nanoseconds would follow it for hours."""
    rod = {"links": 1, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}
    states = {"relay": {"rate": "-1 if relay > 0 else 1", "initial": 0.01}}
    integrate = {"span": [0.0, 0.05], "method": method}
    scene = Scene.from_dict({"name": "relay", "rod": rod, "states": states, "integrate": integrate})
    with pytest.raises(AnalysisError, match=r"states\.relay\.rate"):
        rodgen.lyapunov_exponents(scene, count=1)
