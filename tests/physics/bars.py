"""A bar of one link, and a pulse that strikes its tail."""

from __future__ import annotations

import math
from typing import Any

from rodgen.scene import Scene

# On a tail, within some 0.03 s at t = 7.3 s: an impulse of 0.05 N s.
PULSE = {"y": f"{0.05 / (0.01 * math.sqrt(math.pi))!r}*exp(-((t - 7.3)/0.01)**2)"}


def bar(boundary: str = "free", **tables: Any) -> Scene:
    """One link of 2 m and 3 kg."""
    rod = {"links": 1, "length": 2.0, "bending_stiffness": 1.0, "mass": 3.0, "boundary": boundary}
    return Scene.from_dict({"name": "bar", "rod": rod, **tables})
