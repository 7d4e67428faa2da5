"""Rods of three links whose pivot or clamp is moved, and settings of their runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rodgen.scene import Scene

TIGHT = {"method": "dop853", "rtol": 1e-12, "atol": 1e-13, "span": [0.0, 2.0], "output_every": 0.1}
LOOSE = TIGHT | {"rtol": 1e-8, "atol": 1e-10, "span": [0.0, 1.0]}
TARGETS = ["numpy", pytest.param("c", marks=pytest.mark.compiler)]
HELD = ["pinned", "clamped", "cantilever"]


def moved_rod(base: dict[str, Any] | None, boundary: str = "pinned", **tables: Any) -> Scene:
    """One of 1.5 m and 2 kg that swings under gravity; tables: of the scene, in their place."""
    rod = {"links": 3, "length": 1.5, "mass": 2.0, "bending_stiffness": 4.0, "boundary": boundary}
    table: dict[str, Any] = {"name": "rod", "rod": rod, "loads": {"gravity": {}}}
    table |= {"integrate": TIGHT, "initial": {"phi": "0.3*s - 1", "omega": "1 + s"}}
    table |= {} if base is None else {"base": base}
    rod |= tables.pop("rod", {})
    return Scene.from_dict(table | tables)


def largest(values: NDArray[np.float64]) -> float:
    """Return the largest absolute value."""
    return float(np.abs(values).max())
