"""The Runge-Kutta method as the thesis's Java has it (4.1.3, appendix A), order 1.

With q positions, v velocities, a(q, v) accelerations at the time t at which the step starts:

    a1 = a(q, v)
    a2 = a(q + h v2, v2),  v2 = v + h/2 a1
    a3 = a(q + h v3, v3),  v3 = v + h/2 a2
    a4 = a(q + h v4, v4),  v4 = v + h a3
    v(t + h) = v + h/6 (a1 + 2 a2 + 2 a3 + a4),    q(t + h) = q + h v(t + h)

Halved accelerations are carried over the whole step, positions by velocities that are updated
already: no stage is at a midpoint, and (1.84), of order 4, is another method (see rk4). A free
oscillation of frequency omega is damped as by the ratio 5/12 h omega.
"""

import numpy as np

from rodgen.integrate.stepper import Array, Rhs

ORDER = 1


def advance(rhs: Rhs, t: float, y: Array, f: Array, h: float) -> Array:
    """The state after a step; f is the rate at (t, y). Three evaluations more."""
    half = len(y) // 2
    q, v, a1 = y[:half], y[half:], f[half:]

    def moved(a: Array) -> Array:
        new = v + h * a
        return np.concatenate((q + h * new, new))

    a2 = rhs(t, moved(a1 / 2))[half:]
    a3 = rhs(t, moved(a2 / 2))[half:]
    a4 = rhs(t, moved(a3))[half:]
    return moved((a1 + 2 * (a2 + a3) + a4) / 6)
