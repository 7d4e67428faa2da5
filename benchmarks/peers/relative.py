"""States in relative angles, as the libraries for robots hold them, and back."""

from __future__ import annotations

import numpy as np
from problem import Vector


def relative(half: Vector) -> Vector:
    """x, y, phi_0, phi_1, ... to x, y, phi_0, phi_1 - phi_0, ...; rates and accelerations too."""
    return np.concatenate([half[:3], np.diff(half[2:])])


def absolute(half: Vector) -> Vector:
    """The inverse of `relative`."""
    return np.concatenate([half[:2], np.cumsum(half[2:])])
