"""What is given for one run: a start, times of samples, parameters; and what it gives back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.model.terms import THESIS_TERMS
from rodgen.scene import Scene
from rodgen.show.summary import summary
from rodgen.system import System
from tests.sets import Make, sets


@pytest.fixture
def scene(make_scene: Make) -> Scene:
    return make_scene(5, "free", THESIS_TERMS, output_every=0.1, rtol=1e-7)  # of the palette


def test_a_run_goes_on_from_a_state_of_another(make_scene: Make) -> None:
    how = {"output_every": 0.1, "method": "dop853", "rtol": 1e-8}
    whole = make_scene(5, "free", THESIS_TERMS, **how)
    first = rodgen.simulate(whole, target="numpy")
    second = rodgen.simulate(System(whole).at(y0=first.y[4]), target="numpy", span=(0.4, 1.0))
    np.testing.assert_array_equal(second.y[0], first.y[4])
    # Of the tolerance's size, 1e-8 of rates of 10 to 100 in each step.
    np.testing.assert_allclose(second.y[-1], first.y[-1], rtol=0, atol=1e-5)


def test_other_times_are_refused(scene: Scene) -> None:
    for t_eval in ([], [0.5, 0.5], [0.5, 0.2], [-0.1], [0.1, 1.1], 0.5, ["a"]):
        with pytest.raises(rodgen.InputError, match=r"^integrate\.t_eval\b"):
            rodgen.simulate(scene, t_eval=t_eval)


def test_samples_are_at_the_times_that_are_asked_for(scene: Scene, tmp_path: Path) -> None:
    whole = rodgen.simulate(scene, target="numpy")
    times = [0.2, 0.7]
    sol = rodgen.simulate(scene, target="numpy", t_eval=np.array(times))
    np.testing.assert_array_equal(sol.t, times)
    np.testing.assert_allclose(sol.y, whole.y[[2, 7]], rtol=0, atol=1e-6)
    for term, values in sol.work.items():
        np.testing.assert_allclose(values, whole.work[term][[2, 7]], rtol=0, atol=1e-5)
    # Energy is counted from the start, at which is no sample: what is there less what loads did.
    start = whole.energy.total[0] + whole.energy_balance[2]
    assert sol.start_energy == pytest.approx(start, abs=1e-5)
    np.testing.assert_allclose(sol(0.4), whole.y[4], rtol=0, atol=1e-6)
    np.testing.assert_array_equal(sol(0.0), scene.initial_state())
    file = tmp_path / "run.nc"
    streamed = rodgen.simulate(scene, target="numpy", t_eval=times, out=file)
    for other in (streamed, rodgen.load(file)):
        np.testing.assert_array_equal(other.t, times)
        np.testing.assert_array_equal(other.y, sol.y)
        # Differences of energies of some 100 J, to rounding.
        np.testing.assert_allclose(other.energy_balance, sol.energy_balance, rtol=0, atol=1e-12)


@pytest.mark.parametrize("method", sets(["gauss"], slow=["rk4"], nightly=["dop853", "radau"]))
@pytest.mark.compiler
def test_compiled_methods_end_after_the_last_sample(scene: Scene, method: str) -> None:
    step = {"step": 1e-3} if method == "rk4" else {}
    whole = rodgen.simulate(scene, target="c", method=method, **step)
    sol = rodgen.simulate(scene, target="c", method=method, t_eval=[whole.t[3]], **step)
    np.testing.assert_array_equal(sol.y[0], whole.y[3])
    assert sol.stats.nsteps == whole.stats.nsteps
    assert sol.stats.target == "c"


def test_times_and_their_spacing_exclude_each_other(scene: Scene) -> None:
    with pytest.raises(rodgen.InputError, match=r"output_every = 0\.1\b"):
        rodgen.simulate(scene, t_eval=[0.5], output_every=0.1)
    asked = scene.with_integrate(t_eval=[0.5])
    assert asked.with_integrate(output_every=0.5).integrate.t_eval is None
    assert asked.with_integrate(rtol=1e-6).integrate.t_eval == [0.5]


def test_a_run_with_other_numbers_is_that_of_a_scene_that_has_them(scene: Scene) -> None:
    given: dict[str, Any] = {"loads.follower.force": np.float32(20), "rod.mass": 4}
    sol = rodgen.simulate(System(scene).at(given), target="numpy", span=(0, 0.1))
    written = rodgen.simulate(scene.replace(given), target="numpy", span=(0, 0.1))
    assert sol.scene == written.scene
    np.testing.assert_array_equal(sol.y, written.y)


def test_a_load_may_become_a_number(make_scene: Make) -> None:
    """Another module then: one that was built for the function of time is refused."""
    timed = make_scene(3, "pinned", ("tip_load",), span=[0.0, 0.1])
    model = rodgen.build(timed)
    assert "tip_force_y" in model.EXPRESSIONS
    dead = System(timed).at({"loads.tip.y": 2.0})
    assert rodgen.simulate(dead, target="numpy").scene.parameters["tip_force_y"] == 2.0
    with pytest.raises(rodgen.InputError, match="model = 'rod_pinned"):
        rodgen.simulate(dead, model=model)


def test_a_number_that_no_expression_names_is_not_changed() -> None:
    """It would change nothing; one that an expression comes to name by the change is."""
    rod = {"links": 3, "length": 1.0, "mass": 1.0, "bending_stiffness": "EI0*(2 - s)"}
    scene = Scene.from_dict({"name": "EI", "rod": rod, "parameters": {"EI0": 3.0, "EI": 2.0}})
    assert System(scene).at({"parameters.EI0": 4.0}).scene.numbers["EI0"] == 4.0
    for changed in (
        lambda: System(scene).at({"parameters.EI": 1.0}),
        lambda: scene.replace({"parameters.EI": 1.0}),
        lambda: scene.replace({"parameters.P9": 1.0}),
        lambda: rodgen.study(scene, vary={"parameters.P9": [1.0, 2.0]}, analysis="modes"),
    ):
        with pytest.raises(rodgen.InputError, match=r"(EI|P9)\b"):
            changed()
    law = {"parameters.P9": 1.0, "rod.bending_stiffness": "P9*(2 - s)"}
    assert scene.replace(law).numbers["P9"] == 1.0


def test_moments_and_forces_of_a_run(scene: Scene, tmp_path: Path) -> None:
    sol = rodgen.simulate(scene, target="numpy")
    stiffness = 30.0 / (2.0 / 5)  # EI over the length of a link
    by_hand = np.zeros((len(sol.t), 6))
    by_hand[:, 1:-1] = stiffness * np.diff(sol.phi, axis=1)
    np.testing.assert_allclose(sol.bending_moments, by_hand, rtol=1e-12, atol=1e-12)
    assert list(sol.forces) == ["follower", "external_damping"]
    thrust = np.linalg.norm(sol.forces["follower"], axis=-1)
    np.testing.assert_allclose(thrust[:, -1], 40.0, rtol=1e-12)
    assert not thrust[:, :-1].any()
    sol.save(tmp_path / "run.nc")
    for data in (sol.to_xarray(), rodgen.load(tmp_path / "run.nc").to_xarray()):
        np.testing.assert_array_equal(data["bending_moments"], sol.bending_moments)
        np.testing.assert_array_equal(data["force_follower"], sol.forces["follower"])


def test_a_run_that_stops_before_its_first_sample_is_summed_up(scene: Scene) -> None:
    """With steps far beyond what is stable."""
    far = scene.with_integrate(span=[0.0, 1e3], t_eval=[999.0], method="rk4", step=0.5)
    with pytest.warns(rodgen.DoubtWarning), pytest.raises(rodgen.RunError) as stopped:
        rodgen.simulate(far, target="numpy")
    solution = stopped.value.solution
    assert solution is not None
    assert len(solution.t) == 0
    assert "rk4" in summary(solution)
