"""What a rod runs against, in modules: against 50-digit arithmetic, pressed and apart."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from rodgen.check.module_check import _draw, check_module
from rodgen.model.rod import BOUNDARIES
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built
from tests.palette import TOUCHING, cases, short
from tests.sets import sets

UNEQUAL = ("stiffness", "mass", "lengths")
ROOT = Structure(4, "clamped", "uniform", (*TOUCHING, "joint_stop@0+damping"))
# A stop and a limit of a joint that loads and states follow, beside what laws follow anyway.
READ = Structure(
    4,
    "free",
    "uniform",
    ("tip_load", "stop@2+1/4+damping", "stop@1", "joint_stop@2+damping", "wall"),
    (("tip_force_x", "tanh(stop(1)) + slow"), ("tip_force_y", "vx(0.4) * joint_stop(0) - stop(0)")),
    states=(("slow", "stop(0) - slow"),),
)


@cases(
    "boundary, inertia, nonuniform, target",
    *(BOUNDARIES, ("uniform", "lumped"), ((), UNEQUAL), ("numpy", "c")),
)
@pytest.mark.compiler
def test_contacts_equal_fifty_digit_arithmetic(
    built: Built, boundary: str, inertia: str, nonuniform: tuple[str, ...], target: str
) -> None:
    """Rates, energies, powers, forces, depths and pushes, at states of which some are pressed."""
    structure = Structure(4, boundary, inertia, TOUCHING, nonuniform=nonuniform)
    found = list(check_module(built(structure, target), states=3))
    assert "contacts" in {one.quantity for one in found}
    # Depths are differences of places of some metres; bending moments of angles of some radians.
    assert max(one.error for one in found) < 1e-12


@pytest.mark.compiler
@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("structure", [ROOT, READ], ids=short)
def test_jacobian_is_that_of_fifty_digits(
    built: Built, point: type, structure: Structure, target: str
) -> None:
    module = built(structure, target)
    assert max(one.error for one in check_module(module, states=2)) < 1e-12
    point(module).assert_jacobian(module.jac)


@pytest.mark.parametrize("structure", sets([ROOT], [READ]), ids=short)
def test_what_is_apart_gives_no_warning(built: Built, structure: Structure) -> None:
    """No power of a negative depth is taken, nor one divided by no depth."""
    module = built(structure, "numpy")
    values, y = _draw(module, 0.0, np.random.default_rng(3), 1.0, 1.0)
    for gap in (100.0, 0.0):
        gaps = dict.fromkeys((name for name in values if name.endswith("_gap")), gap)
        p = module.parameters(**values | gaps)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert np.isfinite(module.rhs(0.0, y, p)).all()
            assert np.isfinite(module.jac(0.0, np.zeros_like(y), p)).all()
            module.contacts(0.0, y, p)


def test_a_contact_pushes_and_never_pulls(built: Built) -> None:
    """F = k d^e max(0, 1 + c d') while d > 0, of one link before a stop to the right of its tail:
    by the depth, and by how fast it leaves."""
    module = built(Structure(1, "pinned", "uniform", ("stop@exponent+damping",)), "numpy")
    numbers = {"mass": 1.0, "length": 2.0, "stop_direction": 0.0, "stop_gap": 1.5, "stop_x": 0.0}
    law = {"stop_stiffness": 40.0, "stop_exponent": 1.5, "stop_damping": 0.5, "stop_y": 0.0}
    bending = {"bending_stiffness": 0.0} if "bending_stiffness" in module.PARAMETERS else {}
    p = module.parameters(**numbers, **law, **bending)
    angles, rates = np.array([0.0, 0.3, 0.3, 0.3, 1.0]), np.array([0.0, 0.0, -2.0, 4.0, 0.0])
    found = module.contacts(0.0, np.stack((angles, rates), axis=-1), p)
    depth = 2.0 * np.cos(angles) - 1.5
    speed = -2.0 * np.sin(angles) * rates
    np.testing.assert_allclose(found["depth_stop"], depth, rtol=1e-14)
    opened = np.maximum(0.0, 1.0 + 0.5 * speed)
    expected = np.where(depth > 0, 40.0 * np.abs(depth) ** 1.5 * opened, 0.0)
    np.testing.assert_allclose(found["push_stop"], expected, rtol=1e-14, atol=1e-300)
    assert found["push_stop"][3] == 0.0 < depth[3]  # it leaves faster than the stop follows
