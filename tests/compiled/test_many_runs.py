"""Many runs at once: each bitwise what it is by itself, and what a run of its scene is."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from rodgen.integrate import lane_runs
from rodgen.integrate.module_facts import facts_of
from rodgen.integrate.reductions import REDUCTIONS
from rodgen.native import native_batch
from rodgen.native.native_batch import LANES
from rodgen.native.native_run import METHODS
from tests.compiled.conftest import SMOOTH
from tests.told import refused

pytestmark = pytest.mark.compiler
Array = np.ndarray
FIXED = ("euler", "semi_implicit_euler", "rk4", "thesis_runge_kutta")
TIP = SMOOTH["loads"]["tip"]["x"]
SPAN = {"span": [0.0, 1.0], "output_every": 0.1}
# At the largest step that is stable for all methods and the stiffest rod, but for Euler's.
STEPS: dict[str, dict[str, Any]] = {"dop853": {}} | {name: {"step": 2e-3} for name in FIXED}
STEPS["euler"] = {"step": 2e-4}
KEEP = [
    *(f"{kind}(omega_1)" for kind in REDUCTIONS),
    *("max(tip_x, from=0.25)", "min(tip_y, to=0.5)", "mean(kinetic_energy)", "last(total_energy)"),
    *("rms(spring_energy)", "std(gravity_energy, from=0.2, to=0.8)", "max(bending_moment_1)"),
    *("last(work_internal_damping)", "last(total_work)", "max(energy_balance)", "max(bend_1)"),
    *("min(bend_rate_2)", "last(centre_of_gravity_x)", "time_of_max(joint_2_y)", "max(phi_0)"),
]


@pytest.fixture(scope="module")
def bundle(missile: Scene) -> ModuleType:
    """Of the other scene, whose loads have break points."""
    return rodgen.build(missile, "c", parts=("flow", "power", "lanes"))


def varied(model: ModuleType, scene: Scene, rods: int) -> tuple[Array, Array]:
    """Parameters and states of so many rods, none of which is another's."""
    p = np.tile(model.parameters(**scene.parameters), (rods, 1))
    p[:, model.PARAMETERS.index("bending_stiffness")] *= np.linspace(0.5, 30.0, rods)
    p[:, model.PARAMETERS.index("internal_damping")] *= np.linspace(1.0, 2.0, rods)
    y = np.random.default_rng(1).normal(size=(rods, len(model.STATE)))
    return p, y


def same(a: rodgen.Ensemble, b: rodgen.Ensemble, rods: Any = slice(None)) -> None:
    """Both have the same bits, the second in some of the rods of the first."""
    for name in ("t", "y", "nsteps", "rejected", "nfev", "energy_error", "status"):
        np.testing.assert_array_equal(getattr(a, name)[rods], getattr(b, name), name)
    for mine, other in ((a.values, b.values), (a.work, b.work)):
        for name, values in mine.items():
            np.testing.assert_array_equal(values[rods], other[name], name)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["dop853", "rk4"])
def test_nothing_of_it_matters_to_what_users_compile(
    flags_of_users: None, smooth: Scene, method: str
) -> None:
    """Where lanes are vectors."""
    model = rodgen.build(smooth, "c", parts=("flow", "power", "lanes"))
    test_neighbours_order_and_lane_do_not_matter(model, smooth, method)
    test_a_run_is_that_of_its_scene(model, smooth, method)


@pytest.mark.parametrize("method", STEPS)
def test_neighbours_order_and_lane_do_not_matter(
    model: ModuleType, smooth: Scene, method: str
) -> None:
    p, y = varied(model, smooth, 2 * LANES + 5)
    how = SPAN | STEPS[method] | {"method": method, "keep": KEEP}
    every = rodgen.simulate_many(model, p, y, **how)
    assert (every.status == "finished").all()
    if method == "dop853":
        assert len(set(every.nsteps.tolist())) > LANES  # so that lanes are filled at all times
    order = np.random.default_rng(2).permutation(len(p))
    same(every, rodgen.simulate_many(model, p[order], y[order], **how), order)
    for rods in (slice(3, 4), slice(1, LANES + 2)):
        same(every, rodgen.simulate_many(model, p[rods], y[rods], **how), rods)
    same(every, rodgen.simulate_many(model, p, y, workers=3, **how))


@pytest.mark.parametrize("method", STEPS)
def test_a_run_is_that_of_its_scene(model: ModuleType, smooth: Scene, method: str) -> None:
    """But for rounding, which the motion of a second does not amplify, nor the choice of steps."""
    scene = smooth.with_integrate(method=method, **STEPS[method])
    sol = rodgen.simulate(scene, model=model)
    p, y0 = model.parameters(**scene.parameters), scene.initial_state()
    made = rodgen.simulate_many(model, p, y0, method=method, keep=KEEP, **SPAN, **STEPS[method])
    assert len(made) == 1
    assert (made.t[0], made.nsteps[0], made.nfev[0]) == (1.0, sol.stats.nsteps, sol.stats.nfev)
    np.testing.assert_allclose(made.y[0], sol.y[-1], rtol=0, atol=1e-10)
    np.testing.assert_allclose(made.energy_error[0], sol.energy_error, rtol=1e-3, atol=1e-12)
    omega, t = sol.omega[:, 1], sol.t
    late, early = t >= 0.25, t <= 0.5
    expected = {
        "last(omega_1)": omega[-1],
        "min(omega_1)": omega.min(),
        "max(omega_1)": omega.max(),
        "mean(omega_1)": omega.mean(),
        "rms(omega_1)": np.sqrt(np.mean(omega**2)),
        "std(omega_1)": omega.std(),
        "time_of_max(omega_1)": t[omega.argmax()],
        "max(tip_x, from=0.25)": sol.tip[late, 0].max(),
        "min(tip_y, to=0.5)": sol.tip[early, 1].min(),
    }
    assert {*made.values} == {*KEEP}
    for text, value in expected.items():
        np.testing.assert_allclose(made[text][0], value, rtol=1e-9, atol=1e-9, err_msg=text)


@pytest.mark.parametrize("method", ["dop853", "rk4"])
def test_both_ways_agree(model: ModuleType, smooth: Scene, method: str) -> None:
    """Side by side, and one by one where the velocity of a point is asked for, which no lane
    has."""
    p, y = varied(model, smooth, 3)
    how = SPAN | STEPS[method] | {"method": method}
    beside = rodgen.simulate_many(model, p, y, keep=KEEP, **how)
    single = rodgen.simulate_many(model, p, y, keep=[*KEEP, "last(tip_vx)"], **how)
    np.testing.assert_array_equal(beside.nsteps, single.nsteps)
    np.testing.assert_allclose(beside.y, single.y, rtol=0, atol=1e-9)
    for text in KEEP:
        np.testing.assert_allclose(beside[text], single[text], rtol=1e-8, atol=1e-8, err_msg=text)
    assert np.isfinite(single["last(tip_vx)"]).all()


def test_break_points_of_each(missile: Scene, bundle: ModuleType) -> None:
    """A load that turns at another time for every rod: steps meet that time, as in a run."""
    times = np.array([0.3, 0.1234, 0.5, 0.3])
    p = np.tile(bundle.parameters(**missile.parameters), (len(times), 1))
    for name in ("ramp", "jump"):
        p[:, bundle.PARAMETERS.index(name)] = times
    made = rodgen.simulate_many(bundle, p, missile.initial_state(), keep=["last(tip_x)"], **SPAN)
    for rod, at in enumerate(map(float, times)):
        scene = missile.replace({"parameters.ramp": at, "parameters.jump": at})
        sol = rodgen.simulate(scene, model=bundle, method="dop853", **SPAN)
        assert (made.nsteps[rod], made.nfev[rod]) == (sol.stats.nsteps, sol.stats.nfev)
        np.testing.assert_allclose(made.y[rod], sol.y[-1], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(made.y[0], made.y[3])


# One by one --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("target", "how", "tip"),
    [
        *(("c", {"method": method}, TIP) for method in ("radau", "gauss", "rk45")),
        ("numpy", {"method": "rk4", "step": 0.01}, TIP),
        pytest.param("c", {"method": "dop853"}, "A*max(phi(0.5), 0.6)", marks=pytest.mark.slow),
    ],
)
def test_what_is_not_side_by_side_is_a_run_to_the_bit(
    smooth: Scene, target: str, how: dict[str, Any], tip: str
) -> None:
    """Implicit methods, methods and modules in Python, and a law that switches at an angle."""
    scene = smooth.replace({"loads.tip.x": tip})
    model = rodgen.build(scene, target)
    p, y0 = model.parameters(**scene.parameters), scene.initial_state()
    made = rodgen.simulate_many(model, p, y0, keep=["max(tip_x)"], **how, **SPAN)
    sol = rodgen.simulate(scene, model=model, **how)
    np.testing.assert_array_equal(made.y[0], sol.y[-1])
    assert made["max(tip_x)"][0] == sol.tip[:, 0].max()
    assert (made.nsteps[0], made.energy_error[0]) == (sol.stats.nsteps, sol.energy_error)


# Failures ----------------------------------------------------------------------------------------


# Side by side, and one by one.
WAYS = pytest.mark.parametrize("more", [[], ["last(tip_vx)"]], ids=["beside", "single"])


@WAYS
def test_a_run_that_fails_is_alone(missile: Scene, bundle: ModuleType, more: list[str]) -> None:
    """Its load stops being a number at a time in the span; those of the others, after its end."""
    p, y = varied(bundle, missile, 11)
    for name, value in (("root", 30.0), ("end", 7.0)):
        p[:, bundle.PARAMETERS.index(name)] = value
    bad = p.copy()
    bad[4, bundle.PARAMETERS.index("end")] = 0.5
    how = SPAN | {"method": "dop853", "keep": ["max(tip_x)", *more]}
    fine, made = (rodgen.simulate_many(bundle, each, y, **how) for each in (p, bad))
    others = np.arange(11) != 4
    assert made.status[4] == "failed"
    assert made.t[4] == pytest.approx(0.5, abs=1e-6)
    assert [*made.message] == [4]
    assert np.isnan(made["max(tip_x)"][4])
    assert np.isnan(made.energy_error[4])
    np.testing.assert_array_equal(made.y[others], fine.y[others])
    np.testing.assert_array_equal(made["max(tip_x)"][others], fine["max(tip_x)"][others])


def test_a_load_without_a_value_at_the_start_is_told(smooth: Scene) -> None:
    """Of one rod, of all rods by themselves, and of all that share it; the others run."""
    loads = {"loads.tip.x": "A/(t - B)", "parameters": {"A": 1e-3, "B": 3.0}}
    scene = smooth.replace(loads).with_integrate(**SPAN, method="dop853")
    found = rodgen.simulate_many(scene, {"parameters.B": [3.0, 0.0, 2.0]}, keep=["last(tip_x)"])
    assert found.status.tolist() == ["finished", "failed", "finished"]
    assert "must be finite from 0.0 s on" in found.message[1]
    assert np.isnan(found.values["last(tip_x)"]).tolist() == [False, True, False]
    assert found.t.tolist() == [1.0, 0.0, 1.0]
    at_pole = scene.replace({"parameters.B": 0.0})
    several = np.tile(scene.initial_state(), (2, 1))
    both = {"parameters.B": [0.0, 0.0]}
    for p, y0 in ((both, None), (None, several)):
        found = rodgen.simulate_many(at_pole, p, y0, keep=["last(tip_x)"])
        assert found.message == dict.fromkeys(range(2), found.message[0])


@WAYS
def test_budget(model: ModuleType, smooth: Scene, more: list[str]) -> None:
    p, y = varied(model, smooth, 5)
    whole = rodgen.simulate_many(model, p, y, **SPAN)
    most = int(whole.nsteps.min())
    made = rodgen.simulate_many(model, p, y, max_steps=most, keep=more, **SPAN)
    spent = whole.nsteps > most
    assert 0 < spent.sum() < 5
    np.testing.assert_array_equal(made.status == "failed", spent)
    assert (made.nsteps[spent] == most).all()
    assert (made.t[spent] < 1.0).all()
    assert all("max_steps" in said for said in made.message.values())


# What is given -----------------------------------------------------------------------------------


def test_parameters_by_name(model: ModuleType, smooth: Scene) -> None:
    y0, mass = smooth.initial_state(), np.array([1.0, 2.0, 3.0])
    p = np.array([model.parameters(**smooth.parameters | {"mass": m}) for m in mass])
    named = rodgen.simulate_many(model, smooth.parameters | {"mass": mass}, y0, **SPAN)
    same(rodgen.simulate_many(model, p, y0, **SPAN), named)
    assert len(rodgen.simulate_many(model, p[:0], y0, **SPAN)) == 0


BAD: list[tuple[str, str, Any]] = [
    *(("p", "p", value) for value in (np.zeros(3), np.zeros((2, 2, 2)), "thrust", {"thrust": 3.0})),
    *(("p.mass", "p", {"mass": value}) for value in (-1.0, [[1.0]])),
    ("p.length", "p", {"mass": 1.0}),
    *(("y0", "y0", np.zeros(shape)) for shape in (5, (3, 6))),
    ("y0[2]", "y0", [0.0, 0.0, np.inf, 0.0, 0.0, 0.0]),
    ("keep[0]", "keep", ["largest(phi_0)"]),
    ("keep[1]", "keep", ["max(phi_0)", "max(phi_9)"]),
    *(("keep[0]", "keep", value) for value in ("max(phi_0, until=3)", [3])),
    *(("workers", "workers", value) for value in (0, 1.5)),
    ("integrate.method", "method", "verlet"),
    ("method", "method", "auto"),
    ("integrate.step", "method", "rk4"),
    ("step", "step", 0.1),
    ("rtol", "rtol", -1.0),
    ("integrate.span", "span", [1.0, 0.0]),
    ("spam", "spam", 1.0),
]


def test_bad_input_is_refused(model: ModuleType, smooth: Scene) -> None:
    p = np.tile(model.parameters(**smooth.parameters), (2, 1))
    fine = {"p": p, "y0": smooth.initial_state()}
    for field, name, value in BAD:
        told = refused(rodgen.simulate_many, model, **fine | {name: value})
        assert (told.field, bool(told.allowed)) == (field, True)
    p[1, 3] = np.nan
    assert refused(rodgen.simulate_many, model, **fine).field == "p[1, 3]"
    for name in ("p", "y0"):
        assert refused(rodgen.simulate_many, model, **fine | {name: None}).field == name
    with pytest.raises(TypeError, match=r"^system"):
        rodgen.simulate_many("missile.toml", [], [])  # type: ignore[arg-type]


def test_many_runs_of_a_system_are_those_of_its_module(model: ModuleType, smooth: Scene) -> None:
    """With its own settings, and what differs by keys of its scene."""
    masses = [1.0, 1.5, 2.0]
    found = rodgen.simulate_many(smooth, {"rod.mass": masses}, keep=["last(tip_x)"])
    p = smooth.parameters | {"mass": masses}
    settings = smooth.integrate.model_dump(exclude_none=True, exclude={"method", "step"})
    same = rodgen.simulate_many(model, p, smooth.initial_state(), keep=["last(tip_x)"], **settings)
    np.testing.assert_array_equal(found.values["last(tip_x)"], same.values["last(tip_x)"])


# The loops ---------------------------------------------------------------------------------------


def test_every_explicit_method_goes_side_by_side(model: ModuleType) -> None:
    assert [name for name in METHODS if lane_runs.can_use_lanes(name)] == [*FIXED, "dop853"]
    assert {*native_batch.KEEPS} == {*REDUCTIONS}
    assert facts_of(model).model.LANES.states == len(model.STATE)


@pytest.mark.parametrize(
    "base", [{"x": "0.1*t", "angle": "0.3*sin(4*t)"}, {"angle": "0.3*max(0, t - 0.5)"}]
)
def test_rods_on_a_moving_base_go_side_by_side(base: dict[str, str]) -> None:
    """Those whose base has blows one after another."""
    rod = {"links": 2, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}
    table: dict[str, Any] = {"name": "held", "rod": rod | {"boundary": "cantilever"}, "base": base}
    table |= {"loads": {"gravity": {}, "viscous_drag": {"normal": 0.3}}}
    table["integrate"] = SPAN | {"method": "dop853", "rtol": 1e-11, "atol": 1e-13}
    system = rodgen.System(Scene.from_dict(table))
    masses = [1.0, 1.5, 2.0]
    keep = ["last(tip_x)", "last(kinetic_energy)", "last(work_base)", "max(energy_balance)"]
    many = rodgen.simulate_many(system, {"rod.mass": masses}, keep=keep)
    assert np.all(many.values["max(energy_balance)"] < 1e-9)
    for at, mass in enumerate(masses):
        one = rodgen.simulate(system.at({"rod.mass": mass}), progress=False)
        expected = one.tip[-1, 0], one.energy.kinetic[-1], one.work["base"][-1]
        found = [many.values[name][at] for name in keep[:3]]
        np.testing.assert_allclose(found, expected, rtol=1e-8)
