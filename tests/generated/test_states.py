"""Rates at many states at once, as SciPy's solvers give them, at those that are not finite, and
after many turns."""

from __future__ import annotations

import math
from types import ModuleType

import numpy as np
import pytest

import rodgen
from rodgen.emit.targets import FORMS
from rodgen.model.term import JOINTS, LINKS
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built
from tests.palette import SMALL, short

STRUCTURE = Structure(3, "clamped", terms=("follower", "gravity"))
VALUES = {"mass": 3.0, "length": 2.0, "bending_stiffness": 30.0, "follower_force": 5.0}
STATES = 6


@pytest.fixture(params=FORMS)
def rod(request: pytest.FixtureRequest) -> ModuleType:
    return rodgen.build(STRUCTURE, "numpy", request.param)


def _one_by_one(rod: ModuleType, states: np.ndarray, p: np.ndarray) -> np.ndarray:
    return np.reshape([rod.rhs(0.3, state, p) for state in states], states.shape)


def test_columns_are_states(rod: ModuleType) -> None:
    """Also where as many states as a state has values make the axes alike."""
    p, draw = rod.parameters(**VALUES), np.random.default_rng(1)
    for count in (0, 1, 4, STATES, 9):
        states = draw.normal(size=(count, STATES))
        rates = rod.rhs(0.3, states.T, p)
        np.testing.assert_array_equal(rates, _one_by_one(rod, states, p).T)


def test_states_lie_along_the_last_axis_otherwise(rod: ModuleType) -> None:
    p, draw = rod.parameters(**VALUES), np.random.default_rng(2)
    for shape in ((4,), (2, 3), (1, 1), (STATES, STATES)):
        y = draw.normal(size=(*shape, STATES))
        rates = rod.rhs(0.3, y, p)
        assert rates.shape == y.shape
        flat = _one_by_one(rod, y.reshape(-1, STATES), p)
        np.testing.assert_array_equal(rates.reshape(-1, STATES), flat)
    for shape in ((5, 4), (STATES, 2, 2), (2, STATES, 1), ()):
        with pytest.raises(ValueError, match=r"^y\b"):
            rod.rhs(0.0, np.zeros(shape), p)


@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("structure", [*SMALL[5:]], ids=short)
def test_what_is_not_finite_is_seen_in_the_rates(
    built: Built, point: type, target: str, structure: Structure
) -> None:
    at = point(built(structure, target))
    rod, half = at.module, len(at.y) // 2
    # Joints and links that never move have no use for what acts on them.
    still = range({"free": 0, "cantilever": 2}.get(rod.BOUNDARY, 1))
    rows = [one for one in structure.rows if one.is_array]
    held = [f"{one.name}_{s}" for one in rows if one.each == JOINTS for s in still]
    held += [f"{one.name}_0" for one in rows if one.each == LINKS and rod.BOUNDARY == "cantilever"]

    def put(values: np.ndarray, place: int, value: float) -> np.ndarray:
        changed = values.copy()
        changed[place] = value
        return changed

    for value in (math.nan, math.inf, -math.inf):
        with np.errstate(all="ignore"):
            for place, name in enumerate(rod.STATE):
                rates = rod.rhs(0.0, put(at.y, place, value), at.p)
                # Rates do not depend on where joint 0 is; what its angles do is in the
                # accelerations.
                seen = rates[half:] if name.startswith("phi") else rates
                assert name in ("x0", "y0") or not np.isfinite(seen).all(), name
            for place, name in enumerate(rod.PARAMETERS):
                finite = np.isfinite(rod.rhs(0.0, at.y, put(at.p, place, value))).all()
                # Infinite mass or length only make a rod slow: parameters() refuses them.
                slow = math.isinf(value) and name in ("mass", "length")
                assert name in held or slow or not finite, name


@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("structure", [SMALL[6], SMALL[7]], ids=short)
def test_many_turns_cost_only_the_digits_of_the_angles(
    built: Built, point: type, target: str, structure: Structure
) -> None:
    at = point(built(structure, target))
    angles = [place for place, name in enumerate(at.module.STATE) if name.startswith("phi")]
    for angle in (1e4, 1e6, 1e9, -1e12):
        y = at.y.copy()
        y[angles] += angle
        exact = np.array(at.exact_rhs(y), float)
        off = np.abs(at.module.rhs(at.t, y, at.p) - exact)
        # A unit in the last place of every angle, and of the sums of two that loads are taken at.
        J = np.abs(at.module.jac(at.t, y, at.p)[:, angles]).sum(axis=1)
        assert np.all(off <= 2 * np.spacing(abs(angle)) * J + 1e-13 * np.abs(exact).max())
