"""Rates and what is observed of rods side by side, against the functions for one of them."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest

from rodgen.emit.targets import closed, offered
from rodgen.loading.module import asked
from rodgen.native.many import LANES, Lanes
from rodgen.scene.structure import Structure
from tests.generated.test_feedback import LAWS, STATES
from tests.palette import ALL, LONG, PLACED, SMALL, TIMED, short
from tests.physics.test_emptying import MASS, TWO

pytestmark = pytest.mark.compiler
Built = Callable[..., ModuleType]
Array = np.ndarray
FUNCTION = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 6)


def call(lanes: Lanes, name: str, t: Array, y: Array, p: Array, rows: int) -> Array:
    """What a function makes of rods (LANES, ...): (LANES, rows)."""
    out, work = np.empty((rows, LANES)), np.empty(lanes.part.size // 8 + 1)
    arrays = t, np.ascontiguousarray(y.T), p, np.ascontiguousarray(p.T), out, work
    FUNCTION(lanes.part.functions[name])(*(array.ctypes.data for array in arrays))
    return out.T


FEEDBACK = Structure(3, "cantilever", "lumped", ALL, LAWS, states=STATES)
EMPTYING = Structure(3, "free", "uniform", ALL, (), ("bodies",), masses=(("", -1, MASS), TWO[0]))
# A link without springs inside, held ones, loads in time, laws of the motion, masses in time.
FEW = (SMALL[1], SMALL[6], TIMED, FEEDBACK, EMPTYING)
CASES = [
    *FEW,
    *(pytest.param(each, marks=pytest.mark.nightly) for each in (*SMALL[2:6], PLACED, *LONG[:2])),
]


@pytest.mark.parametrize("structure", CASES, ids=short)
def test_each_rod_is_what_it_is_by_itself(built: Built, structure: Structure) -> None:
    model = built(structure, "c")
    lanes, rng = model.LANES, np.random.default_rng(5)
    y = rng.normal(size=(LANES, len(model.STATE)))
    p = rng.uniform(0.5, 1.5, size=(LANES, len(model.PARAMETERS)))
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
        kinetic, spring, gravity = map(float, asked(model, "energy", at, of, by))
        x, height = asked(model, "centre_of_gravity", at, of, by)
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


def test_batch_of_rods_with_bodies(built: Built) -> None:
    """Whose first coupling is made in the loop that eliminates it: the call before it must not
    matter."""
    model, rng = built(EMPTYING, "c"), np.random.default_rng(6)
    y = rng.normal(size=(2, LANES, len(model.STATE)))
    p = rng.uniform(0.5, 1.5, size=(2, LANES, len(model.PARAMETERS)))
    for states, values in zip(y, p, strict=True):
        single = np.array([model.rhs(0.3, *rod) for rod in zip(states, values, strict=True)])
        many = model.rhs_batch(0.3, states, values)
        np.testing.assert_allclose(many, single, rtol=0, atol=1e-12 * np.abs(single).max())


def test_nobody_has_it_who_does_not_ask() -> None:
    assert "lanes" in offered("c")
    assert "lanes" not in closed("c")
    assert "lanes" not in closed("c", steps=True)
