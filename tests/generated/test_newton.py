"""The compiled solve of Newton's method against (sigma I - J)^-1 with J in 50 digits.

A wrong matrix leaves results right, and takes many more steps."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from rodgen.scene.structure import Structure
from tests.generated.conftest import Built, Written, write
from tests.generated.test_contacts import READ
from tests.palette import ALONG, PLACED, SMALL, TOUCHING, short
from tests.sets import sets

pytestmark = pytest.mark.compiler

# Every boundary, inertia and load, with and without drag; written for other tests as well.
HELD = [Structure(3, terms=ALONG), PLACED, SMALL[1], SMALL[2]]
# With every kind of sensor, on the first link, the last and between, beside held links too; with
# states that follow the motion, one another, or nothing of the rod; with and without drag.
FOLLOWED = (
    ("follower_force", "20 + 5 * x(0.4) * vy(1) - tanh(filtered)"),
    ("follower_angle", "gimbal + 0.1 * vx(0) * y(0.9)"),
)
ADDED = (
    ("gimbal", "(-2 * phi(0.3) - omega(0.7) - gimbal) / 0.05 + vx(0.5)"),
    ("filtered", "gimbal * filtered + sin(t) + omega(1) * phi(0) - y(0.2) * x(1)"),
)
TURNED = ("moment_size", "gimbal - 2 * omega(0.6) * y(1)")
LEANT = ("distributed_follower_angle", "gimbal + phi(1)")
# A wind, which the speed that drag divides by follows.
BLOWN = ("wind_x", "3 + phi(0.3) * vx(0.6)")
BORDERED = [
    Structure(3, "free", "uniform", ("follower", "drag"), (*FOLLOWED, BLOWN), states=ADDED),
    Structure(
        3, "cantilever", "lumped", ("follower", "moment@1"), (*FOLLOWED, TURNED), states=ADDED
    ),
    Structure(
        2,
        "free",
        "lumped",
        ("follower", "internal_damping", "distributed_follower@angle"),
        (*FOLLOWED, LEANT),
        states=ADDED,
    ),
    Structure(2, "pinned", "uniform", ("tip_load",), (("tip_force_y", "omega(1) * y(1)"),)),
    Structure(2, "clamped", "uniform", (), (), states=(("alone", "phi(1) - alone"),)),
]
# Links that differ, whose lengths weigh the direction of the rod at their joints.
UNEQUAL = Structure(
    4, "free", terms=("viscous_drag", "gravity"), nonuniform=("stiffness", "mass", "lengths")
)
# What pushes at single points and at all joints; with loads that follow the pushes.
PRESSED = [
    Structure(4, "clamped", terms=(*TOUCHING, "joint_stop@0+damping")),
    Structure(4, "free", terms=TOUCHING),
    READ,
]
# Of the size of the rates, so that neither sigma nor J alone decides.
REAL, PAIR = 7.5, 3.0 + 20.0j


def _compiled(files: dict[str, str], folder: Path) -> tuple[ctypes.CDLL, str]:
    """The library of a module and its stem, not optimised: a compilation of half a second."""
    stem = write(files, folder)
    compiler = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))))
    options = ["-std=c99", "-O0", "-shared", "-fPIC", "-w", "-o", "solve.so", f"{stem}.c", "-lm"]
    subprocess.run([compiler, *options], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "solve.so")), stem


@pytest.mark.parametrize(
    "structure",
    sets(
        [SMALL[3], SMALL[4], BORDERED[1], UNEQUAL, PRESSED[0]],
        [*HELD[:3], BORDERED[0], *PRESSED[1:]],
        [*HELD[3:], *BORDERED[2:]],
    ),
    ids=short,
)
def test_solve_is_that_of_the_exact_jacobian(
    built: Built, written: Written, point: type, structure: Structure, tmp_path: Path
) -> None:
    """At a state, to the digits that elimination without exchanges leaves."""
    at, files = point(built(structure)), written(structure, "c", "chain", ("newton",))
    J, size = at.exact_jacobian(), len(at.y)
    right = np.random.default_rng(2).standard_normal(3 * size)
    expected = (
        np.linalg.solve(REAL * np.eye(size) - J, right[:size]),
        np.linalg.solve(PAIR * np.eye(size) - J, right[size:].view(complex)),
    )
    library, stem = _compiled(files, tmp_path)
    memory = np.zeros(getattr(library, f"{stem}_newton_work")() // 8)
    arrays = (at.y, at.p, np.array([PAIR]), right[:size], right[size:], memory)
    y, p, pair, numbers, pairs, newton = (x.ctypes.data_as(ctypes.c_void_p) for x in arrays)
    getattr(library, f"{stem}_linearise")(ctypes.c_double(at.t), y, p, newton)
    getattr(library, f"{stem}_factor")(ctypes.c_double(REAL), pair, newton)
    getattr(library, f"{stem}_solve_real")(numbers, newton)
    getattr(library, f"{stem}_solve_complex")(pairs, newton)
    for got, exact in zip((right[:size], right[size:].view(complex)), expected, strict=True):
        np.testing.assert_allclose(got, exact, rtol=0, atol=1e-11 * np.abs(exact).max())
