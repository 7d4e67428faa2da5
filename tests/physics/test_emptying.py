"""Masses that change with time, held against the rocket equation and laws of energy."""

from __future__ import annotations

from itertools import cycle, product
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import rodgen
from rodgen.check.module_check import check_module
from rodgen.emit.targets import FORMS
from rodgen.integrate.events import EventDetector
from rodgen.integrate.methods.method_choice import make_integrator
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.stretches import evaluation_bounds
from rodgen.loading import build
from rodgen.loading.generated_module import call_module
from rodgen.scene import Scene
from rodgen.scene.structure import Structure
from rodgen.system.freezing import masses_at
from tests.palette import ALONG, ENDS
from tests.sets import sets
from tests.told import refused

TANK: dict[str, Any] = {"name": "tank", "at": 0.6, "mass": "8*exp(-t/2)", "inertia": 0.3}
NOSE: dict[str, Any] = {"name": "nose", "at": 0.0, "mass": 1.0, "offset": [0.0, 0.1]}
ROD: dict[str, Any] = {"links": 4, "length": 2.0, "bending_stiffness": 100.0}
ROD |= {"mass_per_length": "mu*(1 - 0.1*t)*(1 + s)"}
TABLES: dict[str, Any] = {
    "name": "rocket",
    "parameters": {"mu": 10.0},
    "rod": ROD,
    "bodies": [TANK],
    "loads": {"follower": {"force": 50.0}, "gravity": {"g": 0.0}},
    "integrate": {"span": [0.0, 4.0], "rtol": 1e-10, "atol": 1e-11},
}
BENDS: dict[str, Any] = {
    "loads": {"follower": {"force": 50.0, "angle": 0.1}, "gravity": {}},
    "initial": {"phi": "0.3*sin(4*s)", "omega": "2*s"},
}
# Empty but for 1 kg from 1.5 s on: a kink, which is a break point.
DRAINED = TANK | {"mass": "max(4 - 2*t, 1)"}


def _scene(**tables: Any) -> Scene:
    return Scene.from_dict(TABLES | tables)


@pytest.mark.parametrize("target", sets(["c"], nightly=["numpy"]))
def test_rocket_equation(target: str) -> None:
    """A straight rod under a thrust along it: v = integral of P/m(t) dt, m the mass of all."""

    def speed(t: float) -> float:  # m = 35 kg - 5 kg/s t, from 1.5 s on 32 kg - 3 kg/s t
        first = 10 * np.log(35 / (35 - 5 * min(t, 1.5)))
        return float(first + 50 / 3 * np.log(27.5 / (32 - 3 * max(t, 1.5))))

    sol = rodgen.simulate(_scene(bodies=[DRAINED, NOSE | {"offset": [0.0, 0.0]}]), target=target)
    assert -sol.y[-1][6] == pytest.approx(speed(4.0), rel=1e-10)
    # What leaves takes half the square of the velocity of its place along.
    taken = [
        -rate * quad(lambda t: speed(t) ** 2 / 2, *span)[0]
        for rate, span in ((5, (0.0, 1.5)), (3, (1.5, 4.0)))
    ]
    assert sol.work["emptying"][-1] == pytest.approx(sum(taken), rel=1e-9)
    assert sol.energy_error < 1e-9


def test_a_rod_that_bends_and_turns_keeps_its_balance() -> None:
    scene = _scene(bodies=[DRAINED | {"offset": [0.0, 0.2]}, NOSE], **BENDS)
    assert scene.breaks() == [1.5]
    how = {"method": "dop853", "rtol": 1e-8, "span": [0.0, 2.0], "output_every": 1.0}
    sol = rodgen.simulate(scene, target="numpy", **how)
    # The tolerance of the run, of the energies that are exchanged.
    assert sol.energy_error < 1e-6 * abs(sol.work["follower"]).max()
    at, h = (sol.y[1], sol.model.parameters(**scene.parameters)), 1e-4
    power = call_module(sol.model, "power", 1.0, 1.0, *at)["emptying"]
    lost = [sum(call_module(sol.model, "energy", 1.0 + k * h, *at)) for k in (-1, 1)]
    # h^2, and rounding over h
    assert power == pytest.approx((lost[1] - lost[0]) / (2 * h), rel=1e-6)


MASS = "mass_per_length_1*(mass_per_length_2 + s)*(1 + mass_per_length_3*t)"
TWO = (("e", 1, "body_e_mass_1 + t*body_e_mass_2"), ("f", 2, "body_f_mass_1*exp(-t)"))
EMPTY = ("e", 1, "body_e_mass_1 + max(0, -t)*body_e_mass_2")
CURVE = [TANK | {"mass": "interp(t, [0, 1, 4], [8, 3, 1], 'cubic')"}, NOSE]
EMPTYING = (
    Structure(3, "free", "uniform", ENDS, (), ("bodies",), masses=(("", -1, MASS), TWO[0])),
    Structure(3, "cantilever", "uniform", ALONG, (), ("bodies",), masses=TWO),
    Structure(4, "clamped", "uniform", ALONG, (), ("stiffness", "mass"), masses=(("", -1, MASS),)),
    Structure(3, "pinned", "lumped", ENDS, (), ("points",), masses=(("", -1, MASS), TWO[0])),
    Structure(2, "pinned", "uniform", ("gravity",), (), ("bodies",), masses=(EMPTY,)),
)
CHECKED = list(zip(EMPTYING, cycle(FORMS), strict=False))


@pytest.mark.parametrize(("structure", "form"), sets([], slow=CHECKED[1:4:2], nightly=CHECKED))
def test_module_equals_fifty_digit_arithmetic(structure: Structure, form: str) -> None:
    """Parts of links are put together by another route: numbers in place of arrays in SymPy."""
    assert max(d.error for d in check_module(build(structure, "numpy", form), states=2)) < 1e-12


@pytest.mark.nightly
def test_implicit_steps_are_explicit_ones_and_energy_is_kept() -> None:
    """The slope of a table is in the power of what leaves."""
    runs = [rodgen.simulate(_scene(bodies=CURVE), method=method) for method in ("dop853", "radau")]
    np.testing.assert_allclose(runs[1].y[-1], runs[0].y[-1], atol=1e-7)
    assert max(run.energy_error for run in runs) < 1e-7 * abs(runs[0].work["follower"]).max()


@pytest.mark.slow
def test_analyses_take_the_masses_of_a_time() -> None:
    """And damping goes by the masses of the start: in runs and in what analyses make of the scene
    at a time."""
    loads = {"internal_damping": {"coefficient": 0.05}, "external_damping": {"coefficient": 0.3}}
    rod = ROD | {"boundary": "clamped", "mass_per_length": "10*(1 - 0.2*t)"}
    scene = _scene(rod=rod, bodies=[], loads=loads)
    for analysis in (rodgen.natural_modes, rodgen.static_equilibrium):
        told = refused(analysis, scene)
        assert told.field == "t"
        assert "rod.mass_per_length" in told.allowed
    # 10 kg/m at the start, 6 kg/m at 2 s.
    held = scene.replace(masses_at(scene, 2.0)).loads
    assert held.value("internal_damping") == pytest.approx(0.05 / 0.6)
    assert held.value("external_damping") == pytest.approx(0.3 / 0.6)
    inner = _scene(rod=rod, bodies=[TANK], loads={"internal_damping": {"coefficient": 0.05}})
    model = build(inner)
    p = model.parameters(**inner.parameters)
    rates = np.linalg.eigvals(model.jac(2.0, np.zeros(8), p))
    found = rodgen.natural_modes(inner, 3, t=2.0)
    for growth, frequency in zip(found.growth, found.frequencies, strict=True):
        assert np.abs(rates - complex(growth, 2 * np.pi * frequency)).min() < 1e-9


@pytest.mark.parametrize(
    ("tables", "field", "at"),
    [
        ({"bodies": [TANK | {"mass": "3 - t"}]}, "bodies[0].mass", [3.0]),
        ({"rod": ROD | {"mass_per_length": "2 - t*s"}}, "rod.mass_per_length", [1.0, 2.0]),
        ({"rod": ROD | {"mass_per_length": "1 + phi(0.5)"}}, "rod.mass_per_length", []),
        ({"bodies": [TANK | {"mass": "1 + s"}]}, "bodies[0].mass", []),
        ({"rod": ROD | {"bending_stiffness": "1 + t"}}, "rod.bending_stiffness", []),
        ({"parameters": {"mu": 1.0, "body_tank_mass_1": 2.0}}, "parameters.body_tank_mass_1", []),
    ],
)
def test_what_no_tank_does_is_refused(tables: dict[str, Any], field: str, at: list[float]) -> None:
    """Where it is none in place and time is told."""
    told = refused(_scene, **tables)
    assert told.field == field
    assert set(at) <= set(told.numbers)


# Jumps -------------------------------------------------------------------------------------------

# A tank that is dropped, and a front that passes the points of the links, one by one or at a time.
JUMPS: dict[str, Any] = {
    "parameters": {"slow": 1.0, "late": 0.0},
    "rod": ROD | {"mass_per_length": "4 if slow*s < t - late else 9"},
    "bodies": [TANK | {"mass": "9 if t < 0.25 else 4"}],
    "integrate": {"span": [0.0, 1.0], "output_every": 0.05},
}
# The tolerance of the run, or the error of steps of 1 ms, of the 200 J that the thrust brings.
HOW: dict[str, tuple[dict[str, float], float]] = {
    "dop853": ({"rtol": 1e-10, "atol": 1e-11}, 1e-7),
    "gauss": ({"rtol": 1e-8, "atol": 1e-10}, 1e-5),
    "radau": ({"rtol": 1e-8, "atol": 1e-10}, 1e-5),
    "rk4": ({"step": 1e-3}, 1e-4),
}


@pytest.mark.parametrize(
    ("method", "target"), sets([("dop853", "c")], nightly=product(HOW, ["c", "numpy"]))
)
def test_what_is_dropped_has_the_velocity_of_its_place(method: str, target: str) -> None:
    """A straight rod under a thrust along it, of which all moves alike: m v' = P between the jumps,
    and each mass dm takes dm v^2/2."""
    together = {"parameters": {"slow": 0.0, "late": 0.7}}
    masses = [TANK | {"mass": "9 if t < 0.5 else 4"}]
    scene = _scene(**JUMPS | together | {"bodies": masses})
    settings = HOW[method][0]
    sol = rodgen.simulate(scene, target=target, method=method, **settings)
    ends, mass, v, taken = (0.5, 0.7, 1.0), (27.0, 22.0, 12.0, 12.0), 0.0, 0.0
    for start, end, now, then in zip((0.0, *ends), ends, mass, mass[1:], strict=False):
        v += 50 / now * (end - start)
        taken += (then - now) * v**2 / 2
    assert -sol.y[-1][6] == pytest.approx(v, rel=1e-9)
    assert sol.work["emptying"][-1] == pytest.approx(taken, rel=1e-9)
    at = np.searchsorted(sol.t, 0.5)
    # At the jump itself the law says what is left: its work is done.
    assert sol.work["emptying"][at] == pytest.approx(-5 * (25 / 27) ** 2 / 2, rel=1e-9)
    assert sol.work["emptying"][at - 1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("method", sets(["dop853"], nightly=["rk4"]))
def test_many_runs_account_for_jumps(method: str) -> None:
    """In lanes, where every rod jumps at a time of its own, as one by one, with steps of C."""
    scene = _scene(**JUMPS, **BENDS)
    model, settings = build(scene, "c"), {"method": method, **HOW[method][0]}
    p = np.tile(model.parameters(**scene.parameters), (3, 1))
    p[:, model.PARAMETERS.index("body_tank_mass_2")] = 0.25, 0.3, 2.0
    keep = ["last(total_energy)", "last(work_emptying)", "max(kinetic_energy)"]
    span = {"span": [0.0, 1.0], "output_every": 0.05}
    beside, single = (
        rodgen.simulate_many(
            model, p, scene.initial_state(), keep=[*keep, *more], **span, **settings
        )
        for more in ([], ["last(tip_vx)"])
    )
    assert max(beside.energy_error) < HOW[method][1]
    assert max(single.energy_error) < HOW[method][1]
    for name in keep:
        np.testing.assert_allclose(beside[name], single[name], rtol=1e-7)
    np.testing.assert_allclose(beside.work["emptying"], single.work["emptying"], rtol=1e-7)
    np.testing.assert_allclose(beside.work["emptying"], beside["last(work_emptying)"], rtol=1e-12)


def test_a_run_that_goes_on_at_a_jump_is_what_it_would_have_been() -> None:
    """To the bit: put down at a jump and taken up."""
    scene = _scene(**JUMPS, **BENDS).with_integrate(method="dop853", rtol=1e-10, atol=1e-11)
    model = build(scene, "c")
    p = model.parameters(**scene.parameters)
    works = []
    for stops in ((), (0.25,)):
        run = make_integrator(model, p, scene.integrate, 0.0, scene.initial_state())
        for end in scene.breaks():
            run.begin(end, *evaluation_bounds(run.t, end), np.inf)
            recorder, watch = (
                Recorder(np.empty(0), len(run.y), model.WORKS),
                EventDetector([], model, p),
            )
            while not run.advance(recorder, watch, 1000):
                pass
            if end in stops:
                state = run.state()
                run = make_integrator(model, p, scene.integrate, 0.0, scene.initial_state())
                run.restore(state)
        works.append(run.works(recorder))
    np.testing.assert_array_equal(*works)


@pytest.mark.parametrize(
    "mass", sets(["4 if s < abs(sin(3000*t)) else 9"], nightly=["4 if sin(1e6*t) < 0 else 9"])
)
def test_jumps_that_are_too_many_are_refused(mass: str) -> None:
    scene = _scene(rod=ROD | {"mass_per_length": mass})
    assert refused(rodgen.simulate, scene, target="numpy").field == "rod.mass_per_length"
