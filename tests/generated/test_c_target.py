"""The C target: against 50-digit arithmetic, against NumPy, many rods at once, and with what it is
given."""

from __future__ import annotations

import ctypes
import re
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from types import ModuleType

import numpy as np
import pytest

from rodgen.check.module_check import _draw, check_module
from rodgen.emit.targets import available_parts, required_parts
from rodgen.loading.generated_module import call_module
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.native.native_batch import LANES, Lanes
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built
from tests.palette import (
    ALL,
    ALONG,
    ENDS,
    LAWS,
    LONG,
    PALETTE,
    PLACED,
    SMALL,
    STATES,
    TABLES,
    TIMED,
    short,
)
from tests.sets import sets

pytestmark = pytest.mark.compiler
Array = np.ndarray
# Rods that differ along their length or follow their motion, most of them long enough for joint
# forces that are cut into segments.
OTHERS = (
    Structure(3, "free", "uniform", ENDS, LAWS, states=STATES, tables=TABLES),
    Structure(12, "free", "uniform", ALONG, nonuniform=("stiffness", "bodies")),
    Structure(12, "free", "lumped", ENDS, nonuniform=("points",)),
    Structure(12, "free", "uniform", (*ENDS, "drag"), LAWS, states=STATES, tables=TABLES),
    Structure(12, "clamped", "uniform", ENDS, nonuniform=("bodies",)),
    Structure(12, "cantilever", "uniform", ALONG, nonuniform=("stiffness", "mass")),
    Structure(3, "cantilever", "lumped", ENDS, LAWS, states=STATES, tables=TABLES),
)
# Masses in time, and a body, with which the first coupling is made in the loop that eliminates it.
MASSES = (
    ("", -1, "mass_per_length_1*(mass_per_length_2 + s)*(1 + mass_per_length_3*t)"),
    ("e", 1, "body_e_mass_1 + t*body_e_mass_2"),
)
EMPTYING = Structure(3, "free", "uniform", ALL, (), ("bodies",), masses=MASSES)


def test_every_choice_is_among_the_structures() -> None:
    assert {(s.boundary, s.inertia) for s in PALETTE} == {*product(BOUNDARIES, INERTIAS)}
    assert {(term, term in s.terms) for s in SMALL for term in ALL} == {*product(ALL, (0, 1))}
    assert {s.n_links for s in SMALL} >= {1, 2, 3}
    assert {s.inertia for s in LONG} == set(INERTIAS)


def _each(*of: tuple[Structure, ...]) -> pytest.MarkDecorator:
    """Structures of `make test`, of `make check`, and of the night."""
    return pytest.mark.parametrize("structure", sets(*of), ids=short)


@_each((SMALL[6],), (), (*SMALL[:6], SMALL[7], *LONG, *OTHERS))
def test_module_equals_fifty_digit_arithmetic(built: Built, structure: Structure) -> None:
    # Rounding of some hundred operations, amplified by the condition of M: about 20 at n = 5, it
    # grows as n^3, to 6e4 at n = 50.
    worst = max(d.error for d in check_module(built(structure, "c"), states=1))
    assert worst < max(1e-12, 1e-13 * structure.n_links**1.5)


@_each(
    (SMALL[2], OTHERS[0]),
    (SMALL[0], SMALL[3], LONG[1], LONG[3], TIMED, PLACED, OTHERS[2]),
    (SMALL[1], *SMALL[4:], LONG[0], LONG[2], OTHERS[1], *OTHERS[3:], EMPTYING),
)
def test_targets_agree(built: Built, structure: Structure, request: pytest.FixtureRequest) -> None:
    """Rates, Jacobians and tangents; NumPy's are held against 50 digits. All else is one text."""
    if structure in LONG:
        request.getfixturevalue("flags_of_users")
    numpy, compiled = built(structure), built(structure, "c")
    values, y = _draw(numpy, 0.375, np.random.default_rng(7), 2.0, 2.0)
    p = numpy.parameters(**values)
    for function, digits in (("rhs", 1e-10), ("jac", 1e-9)):
        one, two = (getattr(module, function)(0.375, y, p) for module in (compiled, numpy))
        # Condition of M at n = 50 (6e4) times rounding; less for shorter rods.
        limit = digits * min(1.0, (structure.n_links / 20) ** 3 + 1e-2)
        np.testing.assert_allclose(one, two, rtol=0, atol=limit * np.abs(two).max())
    J = numpy.jac(0.375, y, p)
    # One direction, which has a function of its own, a few, and more than there are lanes.
    for count in (1, 2, 11):
        v = np.random.default_rng(count).standard_normal((count, len(y)))
        np.testing.assert_array_equal(numpy.tangents(0.375, y, p, v), v @ J.T)
        got = compiled.tangents(0.375, y, p, v)
        # Each row to the rounding of its terms; zeros hold the rounding of what cancels.
        size = np.abs(v) @ np.abs(J).T
        floor = 1e-3 * size.max(axis=1, keepdims=True)
        assert np.max(np.abs(got - v @ J.T) / np.maximum(size, floor)) < 1e-10
        # What comes out does not depend on the directions beside.
        np.testing.assert_array_equal(got[:2], compiled.tangents(0.375, y, p, v[:2]))


def test_directions_and_states_that_have_no_tangents(built: Built, point: type) -> None:
    for target in ("numpy", "c"):
        at = point(built(SMALL[2], target))
        tangents, size = at.module.tangents, len(at.y)
        for shape in ((3,), (size,), (2, 3), (1, 1, size)):
            with pytest.raises(ValueError, match=re.escape(str(shape))):
                tangents(at.t, at.y, at.p, np.ones(shape))
        assert tangents(at.t, at.y, at.p, np.empty((0, size))).shape == (0, size)
        at.y[0] = np.nan
        assert not np.isfinite(tangents(at.t, at.y, at.p, np.eye(size))).all()


# Many states ------------------------------------------------------------------------------------


@pytest.mark.usefixtures("flags_of_users")
@_each(
    (SMALL[6], LONG[1]),
    (SMALL[0], TIMED, OTHERS[1], EMPTYING),
    (SMALL[2], PLACED, OTHERS[0], *OTHERS[2:]),
)
def test_batch_is_row_by_row(built: Built, structure: Structure) -> None:
    """With no row, one, and around whole blocks of eight; with p for all and for each."""
    rod, draw = built(structure, "c"), np.random.default_rng(1)
    pairs = [_draw(rod, 0.3, draw, 1.0, 1.0) for _ in range(21)]
    states = np.array([y for _, y in pairs])
    every = np.array([rod.parameters(**values) for values, _ in pairs])
    for count, shared in product((0, 1, 7, 8, 9, 21), (True, False)):
        Y, P = states[:count], every[0] if shared else every[:count]
        rates = rod.rhs_batch(0.3, Y, P)
        one = [rod.rhs(0.3, y, P if shared else P[row]) for row, y in enumerate(Y)]
        expected = np.reshape(one, Y.shape)
        # One rod at a time is eliminated in another order: rounding times the condition of M.
        limit = 1e-11 * np.abs(expected).max(initial=0)
        np.testing.assert_allclose(rates, expected, rtol=0, atol=limit, err_msg=f"{count} rows")
        out = np.full_like(Y, np.nan)
        assert rod.rhs_batch(0.3, Y, P, out) is out
        np.testing.assert_array_equal(out, rates)


@pytest.fixture
def rod(built: Built, flags_of_users: None) -> ModuleType:
    return built(LONG[1], "c")


def test_rod_of_a_batch_does_not_see_its_neighbours(rod: ModuleType, point: type) -> None:
    Y = np.random.default_rng(1).standard_normal((11, len(rod.STATE)))
    p = point(rod).p
    before = rod.rhs_batch(0.0, Y, p)
    Y[4] = np.nan
    after = rod.rhs_batch(0.0, Y, p)
    assert np.isnan(after[4]).any()
    others = np.arange(11) != 4
    np.testing.assert_array_equal(after[others], before[others])


def test_batches_that_are_none_are_refused(rod: ModuleType, point: type) -> None:
    p, size = point(rod).p, len(rod.STATE)
    Y = np.zeros((3, size))
    for wrong in (np.zeros(size), np.zeros((3, size + 1)), np.zeros((2, 3, size))):
        with pytest.raises(ValueError, match=r"^Y\b"):
            rod.rhs_batch(0.0, wrong, p)
    for wrong in (p[:-1], np.tile(p, (2, 1)), np.tile(p, (3, 2))):
        with pytest.raises(ValueError, match=r"^P\b"):
            rod.rhs_batch(0.0, Y, wrong)
    with pytest.raises(ValueError, match=r"^out\b"):
        rod.rhs_batch(0.0, Y, p, Y)
    with pytest.raises(TypeError, match=r"^Y .*complex"):
        rod.rhs_batch(0.0, Y.astype(complex), p)


# What comes in and where it goes ----------------------------------------------------------------


@pytest.mark.slow
def test_threads_do_not_disturb_each_other(rod: ModuleType, point: type) -> None:
    """cffi lets go of the interpreter: two calls run at the same time."""
    at = point(rod)
    states = np.random.default_rng(5).standard_normal((2, len(at.y)))
    expected = [rod.rhs(0.0, y, at.p) for y in states]
    jacobians = [rod.jac(0.0, y, at.p) for y in states]

    def work(which: int) -> bool:
        y = states[which]
        same = all(np.array_equal(rod.rhs(0.0, y, at.p), expected[which]) for _ in range(5000))
        return same and all(
            np.array_equal(rod.jac(0.0, y, at.p), jacobians[which]) for _ in range(100)
        )

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, [0, 1, 0, 1]))


def test_angles_without_digits_after_the_point_give_no_numbers(
    rod: ModuleType, point: type
) -> None:
    at = point(rod)
    for angle in (1e16, -1e16, 1e300):
        at.y[2] = angle
        assert np.isnan(rod.rhs(0.0, at.y, at.p)).any()


# Rods side by side ------------------------------------------------------------------------------

FUNCTION = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 6)


def call(lanes: Lanes, name: str, t: Array, y: Array, p: Array, rows: int) -> Array:
    """What a function makes of rods (LANES, ...): (LANES, rows)."""
    out, work = np.empty((rows, LANES)), np.empty(lanes.part.size // 8 + 1)
    arrays = t, np.ascontiguousarray(y.T), p, np.ascontiguousarray(p.T), out, work
    FUNCTION(lanes.part.functions[name])(*(array.ctypes.data for array in arrays))
    return out.T


# Held links, laws of the motion, masses in time; a link without springs inside, loads in time.
@_each((SMALL[6],), (EMPTYING, OTHERS[-1], SMALL[1], TIMED), (*SMALL[2:6], PLACED, *LONG[:2]))
def test_each_rod_is_what_it_is_by_itself(built: Built, structure: Structure) -> None:
    model = built(structure, "c")
    lanes, rng = model.LANES, np.random.default_rng(5)
    y = rng.normal(size=(LANES, len(model.STATE)))
    p = rng.uniform(0.5, 1.5, size=(LANES, len(model.PARAMETERS)))
    for name, rows in structure.tables:
        first = structure.indices[name]
        p[:, first : first + rows].sort(axis=1)
    t = rng.uniform(0.1, 0.6, size=LANES)
    rates = call(lanes, "flow", t, y, p, lanes.states + len(lanes.works))
    seen = call(lanes, "observed", t, y, p, len(lanes.observed))
    for rod in range(LANES):
        at, of, by = float(t[rod]), y[rod], p[rod]
        power = model.power(at, of, by) if lanes.works else {}
        expected = [*model.rhs(at, of, by), *(float(power[term]) for term in lanes.works)]
        # Of two orders of the same operations, through systems of condition 1e3 at most.
        scale = np.abs(expected).max()
        np.testing.assert_allclose(rates[rod], expected, rtol=0, atol=1e-12 * scale)
        kinetic, spring, gravity = map(float, call_module(model, "energy", at, of, by))
        x, height = call_module(model, "centre_of_gravity", at, of, by)
        joints, moments = model.joints(of, by), model.bending_moments(of, by)
        known = {"kinetic_energy": kinetic, "spring_energy": spring, "gravity_energy": gravity}
        known |= {"centre_of_gravity_x": x, "centre_of_gravity_y": height}
        for joint in range(model.N + 1):
            known[f"joint_{joint}_x"], known[f"joint_{joint}_y"] = joints[joint]
            known[f"bending_moment_{joint}"] = moments[joint]
        expected = [known[name] for name in lanes.observed]
        np.testing.assert_allclose(seen[rod], expected, rtol=1e-12, atol=1e-12)
        unseen = known.keys() - {*lanes.observed}
        assert all(known[name] == 0.0 for name in unseen)


def test_nobody_has_it_who_does_not_ask() -> None:
    assert "lanes" in available_parts("c")
    assert "lanes" not in required_parts("c")
    assert "lanes" not in required_parts("c", steps=True)
