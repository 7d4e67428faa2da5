"""Semi-implicit Euler, order 1 (thesis 1.83): velocities first, positions with the new ones.

    v(t + h) = v + h a(t, q, v),    q(t + h) = q + h v(t + h)

Symplectic for a force that depends on the position alone and a constant mass matrix.
"""

import numpy as np

from rodgen.integrate.stepper import Array, Rhs

ORDER = 1


def advance(rhs: Rhs, t: float, y: Array, f: Array, h: float) -> Array:
    """The state after a step; f is the rate at (t, y)."""
    half = len(y) // 2
    v = y[half:] + h * f[half:]
    return np.concatenate((y[:half] + h * v, v))
