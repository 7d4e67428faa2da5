"""How the marks of a picture stand."""

from __future__ import annotations

import numpy as np
from matplotlib.lines import Line2D


def turned(line: Line2D) -> float:
    """Angle by which the marks of a line are turned [rad]."""
    start, end = line._marker.get_transform().transform([[0.0, 0.0], [1.0, 0.0]])
    return float(np.arctan2(*(end - start)[::-1]))
