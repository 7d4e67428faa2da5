"""What the air does to a rod, in modules: against 50-digit arithmetic, in wind and at heights."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from rodgen.check.module_check import check_module
from rodgen.model.rod import BOUNDARIES
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built
from tests.palette import AIR_LAWS, AIRBORNE, cases

UNEQUAL = ("stiffness", "mass", "lengths")
SENSED = tuple((repr(s), place) for s, place in ((0.1, "0+1/3"), (0.375, "1+1/2"), (1.0, "")))


def _structure(boundary: str, inertia: str, nonuniform: tuple[str, ...]) -> Structure:
    places = SENSED if "lengths" in nonuniform else ()
    return Structure(4, boundary, inertia, AIRBORNE, AIR_LAWS, nonuniform, sensor_places=places)


@cases(
    "boundary, inertia, nonuniform, target",
    *(BOUNDARIES, ("uniform", "lumped"), ((), UNEQUAL), ("numpy", "c")),
)
@pytest.mark.compiler
def test_air_equals_fifty_digit_arithmetic(
    built: Built, boundary: str, inertia: str, nonuniform: tuple[str, ...], target: str
) -> None:
    """Rates, energies, powers and forces."""
    module = built(_structure(boundary, inertia, nonuniform), target)
    found = list(check_module(module, states=3))
    assert {"rhs", "power", "forces"} <= {one.quantity for one in found}
    assert max(one.error for one in found) < 1e-12


@pytest.mark.parametrize("boundary", ["cantilever", "clamped"])
def test_air_on_a_moving_base_equals_fifty_digit_arithmetic(built: Built, boundary: str) -> None:
    """Points of a link that is held move with it."""
    moved = (("base_x", "base_x_1 * sin(t)"), ("base_angle", "base_angle_1 * cos(t)"))
    terms = (*AIRBORNE, "base@x+angle")
    structure = Structure(4, boundary, "uniform", terms, (*AIR_LAWS, *moved))
    assert max(one.error for one in check_module(built(structure, "numpy"), states=3)) < 1e-12


@pytest.mark.compiler
@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("boundary", ["free", "clamped"])
def test_jacobian_is_that_of_fifty_digits(
    built: Built, point: type, boundary: str, target: str
) -> None:
    point(built(_structure(boundary, "uniform", ()), target)).assert_jacobian(
        built(_structure(boundary, "uniform", ()), target).jac
    )


def test_air_at_rest_gives_no_force_and_no_warning(built: Built) -> None:
    """Nothing is divided by a speed of zero, and the forces grow with its square."""
    module = built(Structure(3, "free", "uniform", ("fins", "nose@0", "axial_drag@1")), "numpy")
    p = module.parameters(**dict.fromkeys(module.PARAMETERS, 1.5))
    y = np.zeros(len(module.STATE))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not module.rhs(0.0, y, p).any()
        slope = module.jac(0.0, y, p)
    assert np.isfinite(slope).all()
    assert np.abs(slope[5:, 5:]).max() < 1e-40
