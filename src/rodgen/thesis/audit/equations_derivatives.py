"""Equations 2.24 to 2.34 as printed: derivatives of E_k; claims in equations_motion."""

from __future__ import annotations

from collections.abc import Callable

from sympy import Expr, S, cos, sin

from rodgen.derive.symbols import k, l, m, vx0, vy0

from .equations_definitions import HALF
from .equations_energy import THIRD, weight
from .truth import ax0, ay0, domega, omega, phi, total


def others(n: int, s: int, term: Callable[[int], Expr]) -> Expr:
    """Sum over all links i but s of w_max(i,s) term(i): what 2.26, 2.29 and 2.31 should have."""
    return sum((weight(n, max(i, s)) * term(i) for i in range(n) if i != s), S.Zero)


def momentum_x(n: int) -> list[Expr]:
    """2.24."""
    turning = total(lambda i: omega[i] * sin(phi[i]) * weight(n, i), 0, n - 1)
    return [HALF * m * (2 * n * vx0 - l * turning)]


def momentum_y(n: int) -> list[Expr]:
    """2.25."""
    turning = total(lambda i: omega[i] * cos(phi[i]) * weight(n, i), 0, n - 1)
    return [HALF * m * (2 * n * vy0 + l * turning)]


def angular(n: int, s: int, others: Expr) -> Expr:
    """2.26 with the given sum over the other links."""
    own = 2 * l**2 * omega[s] * (THIRD + (n - s - 1))
    own += -l * vx0 * sin(phi[s]) * weight(n, s) + l * vy0 * cos(phi[s]) * weight(n, s)
    return HALF * m * (own + others)


def angular_momenta(n: int) -> list[Expr]:
    """2.26."""

    def printed(s: int) -> Expr:
        before = total(lambda i: omega[i] * cos(phi[s] - phi[i]), 0, s - 1)
        return 2 * l**2 * before + l**2 * omega[n - 1] * cos(phi[s] - phi[n - 1])

    return [angular(n, s, printed(s)) for s in range(n)]


def angular_momenta_right(n: int) -> list[Expr]:
    def every(s: int) -> Expr:
        return l**2 * others(n, s, lambda i: omega[i] * cos(phi[s] - phi[i]))

    return [angular(n, s, every(s)) for s in range(n)]


def force_x(n: int) -> list[Expr]:
    """2.27."""
    turning = total(lambda i: domega[i] * sin(phi[i]) * weight(n, i), 0, n - 1)
    radial = total(lambda i: omega[i] ** 2 * cos(phi[i]) * weight(n, i), 0, n - 1)
    return [HALF * m * (2 * n * ax0 - l * turning - l * radial)]


def force_y(n: int) -> list[Expr]:
    """2.28."""
    turning = total(lambda i: domega[i] * cos(phi[i]) * weight(n, i), 0, n - 1)
    radial = total(lambda i: omega[i] ** 2 * sin(phi[i]) * weight(n, i), 0, n - 1)
    return [HALF * m * (2 * n * ay0 + l * turning - l * radial)]


def moment(n: int, s: int, others: Expr) -> Expr:
    """2.29 with the given terms of the other links."""
    w = weight(n, s)
    own = 2 * l**2 * domega[s] * (THIRD + (n - s - 1)) - l * ax0 * sin(phi[s]) * w
    own += -l * vx0 * omega[s] * cos(phi[s]) * w + l * ay0 * cos(phi[s]) * w
    own += -l * vy0 * omega[s] * sin(phi[s]) * w
    return HALF * m * (own + others)


def moments(n: int) -> list[Expr]:
    """2.29, its loose index i read as n-1."""
    tail = n - 1

    def printed(s: int) -> Expr:
        out = 2 * l**2 * total(lambda i: domega[i] * cos(phi[s] - phi[i]), 0, s - 1)
        out -= (
            2
            * l**2
            * total(
                lambda i: (
                    omega[i] * omega[s] * sin(phi[s] - phi[i])
                    + omega[i] ** 2 * sin(phi[s] - phi[i])
                ),
                0,
                s - 1,
            )
        )
        out += l**2 * domega[tail] * cos(phi[s] - phi[tail])
        out -= l**2 * omega[s] * omega[tail] * sin(phi[tail] - phi[s])
        return out + l**2 * omega[tail] ** 2 * sin(phi[tail] - phi[s])

    return [moment(n, s, printed(s)) for s in range(n)]


def moments_right(n: int) -> list[Expr]:
    def term(s: int, i: int) -> Expr:
        turned = omega[i] * (omega[s] - omega[i]) * sin(phi[s] - phi[i])
        return domega[i] * cos(phi[s] - phi[i]) - turned

    def every(s: int) -> Expr:
        return l**2 * others(n, s, lambda i: term(s, i))

    return [moment(n, s, every(s)) for s in range(n)]


def slope(n: int, s: int, others: Expr) -> Expr:
    """2.31 with the given terms of the other links."""
    w = weight(n, s)
    own = -l * vx0 * omega[s] * cos(phi[s]) * w - l * vy0 * omega[s] * sin(phi[s]) * w
    return HALF * m * (own + others)


def slopes(n: int) -> list[Expr]:
    """2.31, for the links that 2.32 is not for."""
    tail = n - 1

    def printed(s: int) -> Expr:
        out = -2 * l**2 * total(lambda i: omega[i] * omega[s] * sin(phi[s] - phi[i]), 0, s - 1)
        out += 2 * l**2 * total(lambda i: omega[s] * omega[i] * sin(phi[i] - phi[s]), s + 1, n - 2)
        return out + l**2 * omega[s] * omega[tail] * sin(phi[tail] - phi[s])

    return [slope(n, s, printed(s)) for s in range(n - 1)]


def slopes_right(n: int) -> list[Expr]:
    def every(s: int) -> Expr:
        return -(l**2) * others(n, s, lambda i: omega[i] * omega[s] * sin(phi[s] - phi[i]))

    return [slope(n, s, every(s)) for s in range(n - 1)]


def last_slope(n: int) -> list[Expr]:
    """2.32."""
    w, a = omega[n - 1], phi[n - 1]
    inner = -l * vx0 * w * cos(a) - l * vy0 * w * sin(a)
    inner -= l**2 * total(lambda i: omega[i] * w * sin(a - phi[i]), 0, n - 2)
    return [HALF * m * inner]


def inner_bending(n: int) -> list[Expr]:
    """2.34, for the links between two springs."""
    return [k * (-phi[s - 1] + 2 * phi[s] - phi[s + 1]) for s in range(1, n - 1)]
