"""The classical Runge-Kutta method, order 4 (W. Kutta 1901; thesis 1.84)."""

from rodgen.integrate.stepper import Array, Rhs

ORDER = 4


def advance(rhs: Rhs, t: float, y: Array, f: Array, h: float) -> Array:
    """The state after a step; f is the rate at (t, y)."""
    k2 = rhs(t + h / 2, y + h / 2 * f)
    k3 = rhs(t + h / 2, y + h / 2 * k2)
    k4 = rhs(t + h, y + h * k3)
    return y + h / 6 * (f + 2 * (k2 + k3) + k4)
