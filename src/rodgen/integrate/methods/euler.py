"""Euler's method, order 1 (thesis 1.75): y(t + h) = y + h f(t, y)."""

from rodgen.integrate.stepper import Array, Rhs

ORDER = 1


def advance(rhs: Rhs, t: float, y: Array, f: Array, h: float) -> Array:
    """The state after a step; f is the rate at (t, y)."""
    return y + h * f
