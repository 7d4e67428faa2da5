"""Continuum references of columns under a follower force, where frequencies meet in flutter.

p = P L^2 / EI is the load, Omega = omega L^2 sqrt(mu / EI) the frequency, mu = M / L; at flutter
Omega is a double root of the characteristic equation. Numbers as in `continuum`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from mpmath import mp
from numpy.polynomial import Legendre
from numpy.polynomial.legendre import leggauss

from rodgen.analyse.references.continuum import Quantity, Real, as_positive, with_digits
from rodgen.errors import AnalysisError, InputError

POLYNOMIALS = 30  # of the Galerkin method that starts the iteration: 9 digits of the lowest ten
LOADS = 1000  # up to which its values were compared with the exact roots
EXCESS = 20  # digits: a double root is as uncertain as the root of the error


class FlutterPoint(NamedTuple):
    """Onset of flutter: load p = P L^2 / EI and frequency Omega = omega L^2 sqrt(M / (L EI)) at
    which two natural frequencies have become one."""

    load: Real
    frequency: Real

    def dimensional(
        self, *, mass: float, length: float, bending_stiffness: float
    ) -> tuple[Real, Real]:
        """Force [N] and frequency [Hz] of a rod of mass M [kg], length L [m], stiffness EI."""
        M, L, EI = as_positive(mass=mass, length=length, bending_stiffness=bending_stiffness)
        unit = mp.sqrt(EI / (M * L**3)) / (2 * mp.pi)
        kind = float if isinstance(self.load, float) else mp.mpf
        return kind(self.load * EI / L**2), kind(self.frequency * unit)


def beck(*, digits: int | None = None) -> FlutterPoint:
    """Flutter of Beck's column: clamped at one end, the other under a tangential force.

    y'''' + p y'' - Omega^2 y = 0 with y = y' = 0 and y'' = y''' = 0 gives
    p^2 + 2 Omega^2 (1 + cos a cosh b) + p Omega sin a sinh b = 0, where a^2, b^2 =
    sqrt(p^2 / 4 + Omega^2) +- p / 2. M. Beck, ZAMP 3 (1952) 225-228.
    """

    def characteristic(p: Any, Omega: Any) -> Any:
        root = mp.sqrt(p**2 / 4 + Omega**2)
        a, b = mp.sqrt(root + p / 2), mp.sqrt(root - p / 2)
        product = p * Omega * mp.sin(a) * mp.sinh(b)
        return p**2 + 2 * Omega**2 * (1 + mp.cos(a) * mp.cosh(b)) + product

    return _solve_onset(characteristic, (20.0, 11.0), digits)


def leipholz(*, digits: int | None = None) -> FlutterPoint:
    """Flutter of Leipholz's column: clamped at one end, under a tangential force q all along it.

    y'''' + p z y'' - Omega^2 y = 0 with z = 1 - x, y'' = y''' = 0 at z = 0 and y = y' = 0 at z = 1;
    p = q L^3 / EI, the whole force over EI / L^2. H. Leipholz, Ingenieur-Archiv 32 (1963) 286-297.
    """
    return _solve_onset(_distributed_characteristic(1), (40.0, 11.0), digits)


def hauger(*, digits: int | None = None) -> FlutterPoint:
    """Flutter of Hauger's column: that of Leipholz under a force q (1 - x), none at the free end.

    y'''' + p z^2 y'' - Omega^2 y = 0; p = q L^3 / (2 EI), the whole force over EI / L^2.
    W. Hauger, Ingenieur-Archiv 35 (1966) 221-229.
    """
    return _solve_onset(_distributed_characteristic(2), (75.0, 13.0), digits)


def thrust(*, digits: int | None = None) -> FlutterPoint:
    """Flutter of a free beam under a tangential thrust P at its tail, the first that occurs.

    The thrust accelerates the beam, so the compression grows from 0 at the nose, xi = 0, to P:
    y'''' + p (xi y')' - Omega^2 y = 0. At the tail the shear force across the axis is
    -EI y''' - P y' and the thrust's own share, -P y', balances it: y'' = y''' = 0 at both ends.
    The static equations y''' + p xi y' = 0, y''(0) = y''(1) = y'(1) = 0 have y' = 0 as their only
    solution for every p: there is no divergence. T. R. Beal, AIAA Journal 3 (1965) 486-494.
    """
    return _solve_onset(_thrust_characteristic, (109.7, 23.1), digits)


def thrust_frequencies(
    load: Quantity, count: int, *, digits: int | None = None
) -> tuple[Real, ...]:
    """The lowest Omega of a free beam under the thrust p, rising, rigid motions not counted.

    Raises InputError for a load outside -LOADS to LOADS or more than 10 frequencies, AnalysisError
    where one of them is not real: beyond flutter.
    """
    if not 1 <= count <= 10:
        raise InputError("count", count, "a whole number from 1 to 10")
    if not abs(float(load)) <= LOADS:
        raise InputError("load", load, f"a number from {-LOADS} to {LOADS}")
    squares = _galerkin_squares(float(load))[:count]
    real = np.isreal(squares) & (squares.real > 0)
    if not real.all():
        raise AnalysisError(
            f"frequencies of a free beam under the thrust p = {float(load):g}: of the lowest "
            f"{count}, {count - int(real.sum())} are not real; "
            f"flutter begins at p = {thrust().load:.6g}"
        )

    def frequencies() -> tuple[Any, ...]:
        p = mp.mpf(load)
        starts = np.sqrt(squares.real)
        tolerance = mp.mpf(10) ** (EXCESS / 2 - mp.dps)
        return tuple(
            mp.findroot(lambda x: _thrust_characteristic(p, x), (x, x * (1 + 1e-8)), tol=tolerance)
            for x in map(float, starts)
        )

    return with_digits(frequencies, digits, EXCESS)


def _solve_onset(
    f: Callable[[Any, Any], Any], near: tuple[float, float], digits: int | None
) -> FlutterPoint:
    """Solve for f(p, Omega) = 0 and its derivative by Omega = 0, by Newton's method."""

    def onset() -> FlutterPoint:
        def both(p: Any, Omega: Any) -> tuple[Any, Any]:
            return f(p, Omega), mp.diff(lambda x: f(p, x), Omega)

        return FlutterPoint(*mp.findroot(both, near, tol=mp.mpf(10) ** (EXCESS - 2 * mp.dps)))

    return with_digits(onset, digits, EXCESS)


def _distributed_characteristic(power: int) -> Callable[[Any, Any], Any]:
    """Create the determinant of (y, y') at the clamp of two solutions of y'''' + p z^power y'' =
    Omega^2 y with y'' = y''' = 0 at the free end, by their power series in the way z from there."""

    def tip_series(p: Any, square: Any, first: int) -> tuple[Any, Any]:
        a = [mp.mpf(k == first) for k in range(4)]
        while len(a) < 8 or max(map(abs, a[-4:])) * len(a) > mp.eps * max(map(abs, a)):
            k = len(a) - 4
            bent = k + 2 - power  # of z^k in z^power y''
            curve = bent * (bent - 1) * a[bent] if bent > 1 else 0
            a.append((square * a[k] - p * curve) / ((k + 1) * (k + 2) * (k + 3) * (k + 4)))
        return mp.fsum(a), mp.fsum(k * c for k, c in enumerate(a))

    def characteristic(p: Any, Omega: Any) -> Any:
        (a, da), (b, db) = (tip_series(p, Omega**2, first) for first in (0, 1))
        return a * db - b * da

    return characteristic


def _thrust_characteristic(p: Any, Omega: Any) -> Any:
    """Determinant of (y'', y''') at the tail of the two solutions with y'' = y''' = 0 at the nose,
    without its factor Omega^4, the rigid motions."""
    (a2, a3), (b2, b3) = (_tail_derivatives(p, Omega**2, first) for first in (0, 1))
    return (a2 * b3 - a3 * b2) / Omega**4


def _tail_derivatives(p: Any, square: Any, first: int) -> tuple[Any, Any]:
    """Sum y''(1), y'''(1) of the power series sum a_k xi^k that starts with xi^first:
    (k+1)(k+2)(k+3)(k+4) a_{k+4} = Omega^2 a_k - p (k+1)^2 a_{k+1}, which converges everywhere."""
    a = [mp.mpf(k == first) for k in range(4)]
    second = third = mp.zero
    k, scale = 0, mp.one
    while k < 4 or max(map(abs, a)) * k**3 > mp.eps * scale:
        k += 1
        rise = (square * a[0] - p * k**2 * a[1]) / (k * (k + 1) * (k + 2) * (k + 3))
        a = [*a[1:], rise]
        second += (k + 3) * (k + 2) * rise
        third += (k + 3) * (k + 2) * (k + 1) * rise
        scale = max(scale, abs(third))
    return second, third


def _galerkin_squares(p: float) -> Any:
    """Squares Omega^2 by Galerkin's method with Legendre polynomials, those of rigid motions left
    out, in the order of their moduli."""
    x, weight = leggauss(POLYNOMIALS + 2)
    xi, weight = (x + 1) / 2, weight / 2
    basis = [Legendre.basis(k, domain=[0, 1]) * (2 * k + 1) ** 0.5 for k in range(POLYNOMIALS)]
    slope, bend = (np.array([b.deriv(d)(xi) for b in basis]) for d in (1, 2))
    ends = np.array([b(1.0) for b in basis]), np.array([b.deriv()(1.0) for b in basis])
    stiffness = (bend * weight) @ bend.T - p * (slope * (weight * xi)) @ slope.T
    values = np.linalg.eigvals(stiffness + p * np.outer(*ends))
    return values[np.argsort(np.abs(values))][2:]
