"""A rod for analyses, and its small motions by another route: generated modules linearise
derivation 3, these are differences of the hand-assembled closed form in 50-digit arithmetic."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from rodgen.check.by_hand import ByHand
from rodgen.scene import Scene

DIGITS = 50
ROD = {"length": 5.0, "bending_stiffness": 100.0, "mass": 50.0}
NUDGE = 2.0**-60  # central differences: errors of 1e-36 and of 1e-32


@pytest.fixture
def rod() -> Callable[..., Scene]:
    """Scene of the rod of ROD: rod(links, boundary, loads, key of [rod]=...)."""

    def make(links: int, boundary: str, loads: dict[str, Any] | None = None, **keys: Any) -> Scene:
        table = {"name": "rod", "rod": ROD | {"links": links, "boundary": boundary} | keys}
        return Scene.from_dict(table | {"loads": loads or {}})

    return make


@pytest.fixture
def exact_rates() -> Callable[[Scene], list[Any]]:
    """Eigenvalues s [1/s] of the small motions about the initial state of a scene, of a straight
    rod at rest, but for the zeros of rigid motions."""

    def rates(scene: Scene) -> list[Any]:
        rod, y = scene.rod, scene.initial_state()
        structure = scene.structure
        module: Any = SimpleNamespace(
            N=rod.links, BOUNDARY=rod.boundary, INERTIA=rod.inertia, TERMS=structure.terms
        )
        with mp.workdps(DIGITS):
            J = mp.matrix(len(y))
            for j, step in enumerate(NUDGE * np.eye(len(y))):
                up, down = (ByHand(module, scene.parameters, y + d).rhs() for d in (step, -step))
                for i, (a, b) in enumerate(zip(up, down, strict=True)):
                    J[i, j] = (a - b) / (2 * mp.mpf(NUDGE))
            return [s for s in mp.eig(J, left=False, right=False) if abs(s) > 1e-12]

    return rates
