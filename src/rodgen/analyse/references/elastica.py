"""Continuum references of large deflections: the tip of a cantilever that bends like an elastica.

The rod, of length 1, leaves its clamp along x, the load keeps its direction: along y, where
theta(s) rises from 0 at the clamp to theta_1 < pi/2 at the tip, or against x. Numbers as in
`continuum`.
"""

from __future__ import annotations

from math import log10, pi
from typing import Any, NamedTuple

import numpy as np
from mpmath import mp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rodgen.analyse.references.continuum import Quantity, Real, with_digits
from rodgen.errors import InputError

LARGEST = 1000  # load; the tip is then vertical to 8 digits
EXCESS = 20  # digits: a column is bent by the root of what its load has more than Euler's


class Tip(NamedTuple):
    """Position of the tip, in lengths of the rod: x along the undeformed rod, y along the load; and
    its angle against the undeformed rod [rad]."""

    x: Real
    y: Real
    angle: Real


def tip_force(load: Quantity, *, digits: int | None = None) -> Tip:
    """Cantilever under a dead force F at its tip, across the undeformed rod; load: F L^2 / EI.

    theta'' = -load cos(theta), theta(0) = theta'(1) = 0. With k^2 = (1 + sin theta_1) / 2 and
    k sin(phi) = sqrt(1/2): sqrt(load) = K(k) - F(phi, k), x = sqrt(2 sin(theta_1) / load),
    y = 1 - 2 (E(k) - E(phi, k)) / sqrt(load). K. E. Bisshopp and D. C. Drucker, Quarterly of
    Applied Mathematics 3 (1945) 272-275. Raises InputError for a load below 0 or above LARGEST.
    """
    size = _check_load(load)

    def tip() -> Tip:
        alpha = mp.mpf(load)
        if not alpha:
            return _straight_tip()

        def amplitude(short: Any) -> tuple[Any, Any]:
            m = mp.cos(short / 2) ** 2  # short: what theta_1 lacks to a right angle
            return m, mp.asin(mp.sqrt(1 / (2 * m)))

        def excess(q: Any) -> Any:
            m, phi = amplitude(mp.exp(-q))
            return (mp.ellipk(m) - mp.ellipf(phi, m)) ** 2 - alpha

        # short decays like exp(-sqrt(load)): its logarithm is what varies slowly.
        ends = (-mp.log(mp.pi / 2 - alpha / (4 + alpha)), mp.sqrt(alpha) + 3)
        short = mp.exp(-mp.findroot(excess, ends, solver="anderson", tol=_residual_tolerance(size)))
        m, phi = amplitude(short)
        sag = 2 * (mp.ellipe(m) - mp.ellipe(phi, m)) / mp.sqrt(alpha)
        return Tip(mp.sqrt(2 * mp.cos(short) / alpha), 1 - sag, mp.pi / 2 - short)

    return with_digits(tip, digits, _lost_digits(size))


def own_weight(load: Quantity, *, digits: int | None = None) -> Tip:
    """Cantilever under its own weight, clamped horizontally; load: M g L^2 / EI; y points down.

    theta'' = -load (1 - s) cos(theta), theta(0) = theta'(1) = 0: the heavy elastica, by shooting
    from the tip with Taylor series. Of the equilibria that large loads allow, the one without
    theta beyond pi/2. F. V. Rohde, Quarterly of Applied Mathematics 11 (1953) 337-338. Raises
    InputError for a load below 0 or above LARGEST.
    """
    size = _check_load(load)
    start = _shoot(size) if size else 0.0

    def tip() -> Tip:
        end = mp.cbrt(mp.mpf(load))
        if not end:
            return _straight_tip()

        def excess(q: Any) -> Any:
            return _integrate_to_clamp(mp.exp(-q), end)[0] - mp.pi / 2

        q = mp.findroot(excess, (start, start + 1e-6), tol=_residual_tolerance(size))
        _, x, y = _integrate_to_clamp(mp.exp(-q), end)
        return Tip(x / end, y / end, mp.pi / 2 - mp.exp(-q))

    return with_digits(tip, digits, _lost_digits(size))


def axial_force(load: Quantity, *, digits: int | None = None) -> Tip:
    """Column: cantilever under a dead force F at its tip, along the undeformed rod and towards its
    clamp; load: F L^2 / EI. Beyond Euler's load, pi^2 / 4, the bent state, else the straight one.

    theta'' = -load sin(theta), theta(0) = theta'(1) = 0. With k = sin(theta_1 / 2):
    sqrt(load) = K(k), x = 2 E(k) / K(k) - 1, y = 2 k / K(k). L. Euler, De curvis elasticis (1744);
    S. P. Timoshenko and J. M. Gere, Theory of Elastic Stability (1961), 2.7. Raises InputError for
    a load below 0 or above LARGEST.
    """
    size = _check_load(load)

    def tip() -> Tip:
        root, euler = mp.sqrt(mp.mpf(load)), mp.pi / 2
        if root <= euler:
            return _straight_tip()

        # 1 - k^2 decays like exp(-2 sqrt(load)), k^2 grows from 0 like load: both are kept.
        def excess(q: Any) -> Any:
            return mp.ellipk(-mp.expm1(-q)) - root

        q = mp.findroot(excess, (0, 2 * root), solver="anderson", tol=_residual_tolerance(size))
        m = -mp.expm1(-q)
        k = mp.sqrt(m)
        return Tip(2 * mp.ellipe(m) / root - 1, 2 * k / root, 2 * mp.asin(k))

    return with_digits(tip, digits, _lost_digits(size) + EXCESS)


def _shoot(load: float) -> float:
    """Shoot for -log of what theta_1 lacks to a right angle under own weight, in floats.

    With t = (1 - s) load^(1/3) and psi = pi/2 - theta: psi'' = t sin(psi), psi'(0) = 0, and the t
    at which psi first is pi/2, that of the clamp, falls as psi(0) rises. So the wanted root is the
    only one.
    """
    end = load ** (1 / 3)

    def clamp(t: float, w: Any) -> float:
        return float(w[0] - pi / 2)

    # An attribute of the function is how SciPy is told that its event ends the integration.
    clamp.terminal = True  # type: ignore[attr-defined]

    def excess(q: float) -> float:
        psi = np.exp(-q)
        run = solve_ivp(
            lambda t, w: (w[1], t * np.sin(w[0])),
            (0, 2 * end + 5),
            (psi, 0.0),
            "DOP853",
            events=clamp,
            rtol=1e-11,
            atol=1e-12 * psi,
        )
        return float(run.t[-1] - end)

    low = -np.log(pi / 2 - load / (12 + load))
    return float(brentq(excess, low, load**0.5 + 3, xtol=1e-12))


def _integrate_to_clamp(psi: Any, end: Any) -> tuple[Any, Any, Any]:
    """Integrate psi'' = t sin(psi), psi'(0) = 0, with sin(psi) and cos(psi), to t = end."""
    order = int(1.2 * mp.dps) + 10
    steps = int(mp.ceil(end / mp.mpf("0.4")))
    h, rate, x, y = end / steps, mp.zero, mp.zero, mp.zero
    for step in range(steps):
        p, s, c = _taylor_coefficients(psi, rate, step * h, order)
        powers = [h**k for k in range(order + 1)]
        psi = mp.fdot(p, powers)
        rate = mp.fdot((k * p[k], powers[k - 1]) for k in range(1, order))
        x += mp.fdot((s[k], powers[k + 1] / (k + 1)) for k in range(order))
        y += mp.fdot((c[k], powers[k + 1] / (k + 1)) for k in range(order))
    return psi, x, y


def _taylor_coefficients(
    psi: Any, rate: Any, t: Any, order: int
) -> tuple[list[Any], list[Any], list[Any]]:
    """Taylor coefficients of psi, sin(psi), cos(psi) about t, by the recurrences of
    sin' = psi' cos, cos' = -psi' sin and psi'' = t sin(psi)."""
    p, s, c, slopes = [psi, rate], [mp.sin(psi)], [mp.cos(psi)], [rate]
    for k in range(1, order):
        before = s[k - 2] if k > 1 else 0
        p.append((t * s[k - 1] + before) / (k * (k + 1)))
        s.append(mp.fdot(slopes, reversed(c)) / k)
        c.append(-mp.fdot(slopes, reversed(s[:k])) / k)
        slopes.append((k + 1) * p[k + 1])
    return p[:order], s, c


def _check_load(load: Quantity) -> float:
    try:
        size = float(load)
    except (TypeError, ValueError):
        size = -1.0
    if not 0 <= size <= LARGEST:
        raise InputError("load", load, f"a number from 0 to {LARGEST:g}")
    return size


def _lost_digits(load: float) -> int:
    """Digits that cancel: in 1 - x and theta of a small load, in pi/2 - theta of a large one."""
    return int(2 * abs(log10(load)) + load**0.5) if load else 0


def _residual_tolerance(load: float) -> Any:
    """Tolerance of the square of a remainder, which is about as large as a small load."""
    return (mp.mpf(10) ** (8 + _lost_digits(load) - mp.dps) * min(load, 1)) ** 2


def _straight_tip() -> Tip:
    return Tip(mp.one, mp.zero, mp.zero)
