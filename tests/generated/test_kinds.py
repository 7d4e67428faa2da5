"""Modules of rods whose loads are functions of time, follow the motion by sensors or stand at
points of their own, and of rods that differ along their length."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest

import rodgen
from rodgen.check.module_check import _draw, check_module
from rodgen.derive.proofs import comparisons
from rodgen.emit.targets import FORMS
from rodgen.loading.generated_module import call_module
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built, rarely
from tests.palette import (
    ALL,
    ALONG,
    ENDS,
    LAWS,
    NONUNIFORM,
    PLACED,
    STATES,
    TABLES,
    TIMED,
    can_move,
    carries,
    cases,
    loads_of,
)

TARGETS = pytest.mark.parametrize(
    "target", [("numpy", "chain"), ("numpy", "dense"), ("c", "chain")], ids="-".join
)


def _exact(module: ModuleType) -> bool:
    """Whether a module equals 50-digit arithmetic but for the rounding of some hundred operations,
    amplified by the condition of M."""
    return max(d.error for d in check_module(module, states=1)) < 1e-12


# Loads in time, and that follow the motion --------------------------------------------------------


@TARGETS
def test_expressions_in_time_are_part_of_the_code(built: Built, target: tuple[str, str]) -> None:
    module = built(TIMED, *target)
    read = {name: Expression(text, "t") for name, text in TIMED.expressions}
    assert not read.keys() & {*module.PARAMETERS}
    assert {name: e.canonical for name, e in read.items()} == module.EXPRESSIONS
    assert max(d.error for d in check_module(module, states=2)) < 1e-13
    plain = built(Structure(4, "clamped", terms=ENDS), *target)
    given = {"mass": 2.0, "length": 1.0, "bending_stiffness": 5.0, "internal_damping": 0.1}
    given |= {"external_damping": 0.3}
    y = np.random.default_rng(1).normal(size=8)
    p = module.parameters(**given)
    times = [-0.3, 0.0, 0.25, 0.7, np.nextafter(0.7, 1), 1.9, 3.0]
    for t in times:
        q = plain.parameters(**given, **{name: e(t) for name, e in read.items()})
        for function in ("rhs", "jac"):
            one, two = getattr(module, function)(t, y, p), getattr(plain, function)(t, y, q)
            # libm's functions and NumPy's may differ by a unit in the last place.
            np.testing.assert_allclose(one, two, rtol=0, atol=1e-13 * np.abs(two).max())
    both = module.power(np.array(times), np.stack([y] * len(times)), p)
    for term in ("follower", "tip_load"):
        one = [module.power(t, y, p)[term] for t in times]
        np.testing.assert_allclose(both[term], one, rtol=1e-14)


@TARGETS
def test_force_that_is_no_number_is_seen_in_the_rates(
    built: Built, target: tuple[str, str]
) -> None:
    text = "max(sqrt(0.5 - t), min(1/(t - 0.25), 3))"
    structure = Structure(3, "pinned", "lumped", ("tip_load",), (("tip_force_y", text),))
    module = built(structure, *target)
    p = module.parameters(mass=1.0, length=1.0, bending_stiffness=1.0)
    with np.errstate(all="ignore"):
        assert np.isfinite(module.rhs(0.4, np.zeros(6), p)).all()
        assert np.isnan(module.rhs(0.6, np.zeros(6), p)).any()


@pytest.mark.parametrize(
    ("boundary", "inertia", "links", "form", "nonuniform"),
    [
        ("clamped", "uniform", 4, "chain", ("stiffness", "bodies")),
        pytest.param("free", "lumped", 5, "dense", ("points",), marks=pytest.mark.slow),
        pytest.param("free", "uniform", 1, "chain", (), marks=pytest.mark.slow),
        pytest.param("cantilever", "uniform", 2, "dense", (), marks=pytest.mark.slow),
        pytest.param("pinned", "lumped", 8, "chain", (), marks=pytest.mark.slow),
    ],
)
def test_module_with_feedback_equals_fifty_digit_arithmetic(
    built: Built, boundary: str, inertia: str, links: int, form: str, nonuniform: tuple[str, ...]
) -> None:
    terms = ALL if links == 2 else ENDS
    structure = Structure(links, boundary, inertia, terms, LAWS, nonuniform, STATES, tables=TABLES)
    assert _exact(built(structure, "numpy", form))


def test_signals_are_what_laws_follow(built: Built) -> None:
    """Along leading axes, and by two routes: positions of the joints, and differences of them."""
    module = built(Structure(4, "free", "uniform", ENDS, LAWS, states=STATES, tables=TABLES))
    values, y = _draw(module, 0.3, np.random.default_rng(1), 0.5, 0.5)
    p, h = module.parameters(**values), 1e-6
    moved = y + h * np.concatenate((y[6:12], np.zeros(8)))
    found = module.signals(0.3, np.stack((y, moved)), p)
    joints = module.joints(np.stack((y, moved)), p)
    at = joints[:, 2] + 0.4 * (joints[:, 3] - joints[:, 2])  # s = 0.6 of four links
    assert found["vx(0.6)"][0] == pytest.approx((at[1, 0] - at[0, 0]) / h, abs=1e-5)
    np.testing.assert_allclose(found["y(1.0)"], joints[:, -1, 1], rtol=1e-12)
    # Beyond its bounds the angle of the thrust is one of them.
    c, angle = values["c"], found["follower_angle"]
    assert (np.abs(angle) <= c * (1 + 1e-12)).all()


# Several loads of one kind ------------------------------------------------------------------------

# At joint 0 and inside the first link, at the tail and at the end of the last link but one; with a
# couple on each of these links, and what a load along the rod may have beside.
PLACES = {
    1: ("follower@0", "follower@0+1/2", "moment@0"),
    2: ("follower@0+2/3", "follower@1", "follower", "moment@0+2/3", "moment"),
    4: ("follower@0", "follower@2+1/7", "follower", "distributed_follower@angle", "moment@2"),
}


@cases(
    "boundary, links, inertia, explicit",
    *(BOUNDARIES, PLACES, INERTIAS, (True, False)),
    where=can_move,
)
def test_all_derivations_agree(boundary: str, links: int, inertia: str, explicit: bool) -> None:
    places = PLACES[links]
    held = [c.name for c in comparisons(links, boundary, inertia, places, explicit, links)]
    assert sum(map(held.count, ("F", "F_q", "C"))) == 2 * len(places)
    assert "accelerations" in held


@rarely("boundary, links, inertia, form", BOUNDARIES, PLACES, INERTIAS, FORMS, where=can_move)
def test_module_of_loads_at_points_equals_fifty_digit_arithmetic(
    built: Built, boundary: str, links: int, inertia: str, form: str
) -> None:
    assert _exact(built(Structure(links, boundary, inertia, PLACES[links]), "numpy", form))


def test_loads_at_points_have_the_jacobian_of_the_closed_form(built: Built, point: type) -> None:
    at = point(built(PLACED))
    at.assert_jacobian(at.module.jac)


def test_what_may_follow_the_motion_is_exact_to_its_jacobian(built: Built, point: type) -> None:
    """A couple, a pressure that swings and a viscous medium, whose rates are smooth functions: the
    Jacobian in 50 digits is exact to rounding. The work of what changes is counted, and of a couple
    that is a number the potential."""
    expressions = (
        ("distributed_follower_angle", "a + sin(t)"),
        ("viscous_drag_wind_y", "w*t"),
        ("moment_size", "-b*omega(0.7) + filtered"),
    )
    terms = ("distributed_follower@angle", "viscous_drag", "moment@1+1/3", "moment")
    states = (("filtered", "phi(0.3) - filtered"),)
    at = point(built(Structure(3, "clamped", "uniform", terms, expressions, states=states)))
    assert _exact(at.module)
    exact = at.exact_jacobian()
    found = at.module.jac(at.t, at.y, at.p)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-12 * np.abs(exact).max())
    works = {"distributed_follower", "viscous_drag", "moment"}
    assert set(at.module.power(at.t, at.y, at.p)) == works


# Gravity as a vector, with a component in time, and downwards by a law of time or of the motion; of
# links that are alike, carry bodies, are points, and lose mass.
SIDEWAYS, PULSED = ("gravity@acceleration",), (("gravity", "a + b*sin(w*t)"),)
SWUNG = (("gravity_x", "a*sin(w*t)"),)
LEAKING = (("tank", 1, "a*exp(-t)"),)
HEAVY = {
    "vector": Structure(3, "free", "uniform", SIDEWAYS),
    "points": Structure(3, "pinned", "lumped", SIDEWAYS, nonuniform=("points",)),
    "swung": Structure(3, "clamped", "uniform", SIDEWAYS, SWUNG, ("bodies",)),
    "pulsed": Structure(3, "cantilever", "lumped", ("gravity",), PULSED),
    "felt": Structure(3, "free", "uniform", ("gravity",), (("gravity", "a + phi(0.3)*omega(1)"),)),
    "leaking": Structure(3, "free", "uniform", ("gravity",), PULSED, ("bodies",), masses=LEAKING),
    "leaking vector": Structure(
        3, "pinned", "uniform", SIDEWAYS, nonuniform=("bodies",), masses=LEAKING
    ),
}


@pytest.mark.parametrize("target", [("numpy", "chain"), ("c", "chain")], ids="-".join)
@pytest.mark.parametrize("name", HEAVY)
def test_gravity_in_time_does_work_and_another_has_a_potential(
    built: Built, point: type, name: str, target: tuple[str, str]
) -> None:
    """What leaves takes energy along only where gravity has a potential: the check compares the
    power of what leaves as well."""
    at = point(built(HEAVY[name], *target))
    assert _exact(at.module)
    at.assert_jacobian(at.module.jac)
    timed, leaks = bool(HEAVY[name].expressions), ["emptying"] * bool(HEAVY[name].masses)
    power = at.module.power(at.t, at.y, at.p) if timed or leaks else ()
    assert [*power] == ["gravity"] * timed + leaks
    assert bool(call_module(at.module, "energy", at.t, at.y, at.p)[2]) == (not timed)


# Laws of a base: its place and its turn, smooth in time, and what stands on it.
LED = (
    ("base_x", "a*cos(w*t)"),
    ("base_y", "b*t + a*exp(-t)*sin(w*t)"),
    ("base_angle", "b*sin(w*t)"),
)
CARRIED = ("material_damping", "viscous_drag", "foundation", "follower@0+1/3")


@pytest.mark.parametrize("target", [("numpy", "chain"), ("c", "chain")], ids="-".join)
@pytest.mark.parametrize(
    ("boundary", "inertia", "moves"),
    [("pinned", "lumped", 2), ("clamped", "uniform", 3), ("cantilever", "uniform", 3)],
)
def test_module_on_a_moving_base_equals_fifty_digit_arithmetic(
    built: Built, point: type, boundary: str, inertia: str, moves: int, target: tuple[str, str]
) -> None:
    """And its Jacobian: none of these terms has a kink, so that of 50 digits is exact."""
    base = "base@" + "+".join(name.removeprefix("base_") for name, _ in LED[:moves])
    structure = Structure(3, boundary, inertia, ("gravity", *CARRIED, base), LED[:moves])
    at = point(built(structure, *target))
    assert _exact(at.module)
    exact, found = at.exact_jacobian(), at.module.jac(at.t, at.y, at.p)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-12 * np.abs(exact).max())


@pytest.mark.slow
@pytest.mark.compiler
def test_work_of_a_force_on_the_first_link_of_a_free_rod(make_scene: Callable[..., Scene]) -> None:
    """No link before it turns its point: a sum over none."""
    scene = make_scene(1, "free", ("follower",), span=[0.0, 0.1])
    sol = rodgen.simulate(scene.replace({"loads.follower.at": 0.0}), target="c")
    assert np.ptp(sol.work["follower"]) > 0.01  # J
    assert sol.energy_error < 1e-9  # of a rigid link, whose motion is smooth


# Rods that differ along their length --------------------------------------------------------------


@rarely(
    "boundary, links, inertia, form, terms, nonuniform",
    *(BOUNDARIES, (1, 2, 5), INERTIAS, FORMS, (ENDS, ALONG), NONUNIFORM),
    where=carries,
)
def test_module_of_a_nonuniform_rod_equals_fifty_digit_arithmetic(
    built: Built,
    boundary: str,
    links: int,
    inertia: str,
    form: str,
    terms: tuple[str, ...],
    nonuniform: tuple[str, ...],
) -> None:
    structure = Structure(links, boundary, inertia, loads_of(terms, nonuniform), (), nonuniform)
    assert _exact(built(structure, "numpy", form))
