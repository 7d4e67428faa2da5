"""Continuum references of a straight rod: limits of a chain of n links as n grows.

Each is solved from its characteristic equation in mpmath. Without ``digits`` a result is a float,
right to its last digit or two; with it an mpf of that many digits. Lengths, masses and stiffnesses
are taken as they are given: an mpf or a string, ``"0.1"``, where a float is not exact enough.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

from mpmath import mp

from rodgen.analyse.analysis_guard import check_whole_number
from rodgen.errors import InputError

T = TypeVar("T")
Real = Any  # float, or mpf where digits are asked for
Quantity = Any  # a number or a string of one

FLOAT = 17  # digits that tell one float from the next
GUARD = 15  # digits of work beyond those of a result


def with_digits(compute: Callable[[], T], digits: int | None, extra: int = 0) -> T:
    """Evaluate compute() with guard digits; return a number, or a tuple of numbers, as floats or
    with ``digits`` as mpf. extra: further guard digits that the problem is known to lose."""
    if digits is not None:
        check_whole_number(digits, "digits", 1, 1000)
    with mp.workdps((digits or FLOAT) + GUARD + extra):
        result: Any = compute()
    with mp.workdps(digits or FLOAT):
        finish: Any = float if digits is None else mp.mpf.__pos__
        kept: Any = tuple(map(finish, result)) if isinstance(result, tuple) else finish(result)
        made: T = type(result)(*kept) if hasattr(result, "_fields") else kept
        return made


def as_finite(name: str, given: Quantity) -> Any:
    """Convert a quantity to mpf. Raises InputError for one that is not a finite number."""
    try:
        value = mp.mpf(given)
    except (TypeError, ValueError):
        value = mp.nan
    if not mp.isfinite(value):
        raise InputError(name, given, "a finite number")
    return value


def as_positive(**quantities: Quantity) -> list[Any]:
    """Convert quantities to mpf. Raises InputError for one that is not finite and positive."""
    values = [as_finite(name, given) for name, given in quantities.items()]
    for value, (name, given) in zip(values, quantities.items(), strict=True):
        if not value > 0:
            raise InputError(name, given, "a finite number greater than 0")
    return values


# Divided by cosh, so that nothing overflows; root k lies between (k + shift) pi and the next.
_CHARACTERISTIC: dict[str, tuple[Callable[[Any], Any], int]] = {
    "free": (lambda x: mp.cos(x) - mp.sech(x), 0),
    "clamped": (lambda x: mp.cos(x) + mp.sech(x), -1),
    "pinned": (lambda x: mp.sin(x) - mp.tanh(x) * mp.cos(x), 0),
}


def wave_number(boundary: str, k: int, *, digits: int | None = None) -> Real:
    """Wave number beta_k L of bending mode k = 1, 2, ... of a uniform Euler-Bernoulli beam; rigid
    motions are not counted.

    boundary: "free", both ends free, cos x cosh x = 1; "clamped" or "cantilever",
    cos x cosh x = -1; "pinned", the other end free, tan x = tanh x. Raises InputError for another
    boundary or k < 1. R. D. Blevins, Formulas for Natural Frequency and
    Mode Shape, 1979, table 8-1.
    """
    name = "clamped" if boundary == "cantilever" else boundary
    if name not in _CHARACTERISTIC:
        raise InputError("boundary", boundary, '"free", "clamped", "cantilever" or "pinned"')
    check_whole_number(k, "k", 1)
    f, shift = _CHARACTERISTIC[name]

    def root() -> Any:
        # f has opposite signs at neighbouring multiples of pi, and one root between them.
        ends = ((k + shift) * mp.pi, (k + shift + 1) * mp.pi)
        return mp.findroot(f, ends, solver="anderson", tol=mp.eps**1.8)

    return with_digits(root, digits)


def natural_frequency(
    boundary: str,
    k: int,
    *,
    mass: Quantity,
    length: Quantity,
    bending_stiffness: Quantity,
    digits: int | None = None,
) -> Real:
    """Natural frequency [Hz] of bending mode k of a uniform beam of mass M [kg], length L [m] and
    bending stiffness EI [N m^2]: (beta L)^2 / (2 pi) sqrt(EI / (M L^3))."""

    def frequency() -> Any:
        M, L, EI = as_positive(mass=mass, length=length, bending_stiffness=bending_stiffness)
        beta = wave_number(boundary, k, digits=mp.dps)
        return beta**2 / (2 * mp.pi) * mp.sqrt(EI / (M * L**3))

    return with_digits(frequency, digits)


def chain_frequency(
    k: int, *, length: Quantity, gravity: Quantity = 9.81, digits: int | None = None
) -> Real:
    """Natural frequency [Hz] of mode k = 1, 2, ... of a hanging chain (EI = 0, upper end held) of
    length L [m] under gravity [m/s^2]: J0(2 omega sqrt(L/g)) = 0. D. Bernoulli 1732; see
    G. N. Watson, A Treatise on the Theory of Bessel Functions, 1922, chapter 1."""
    check_whole_number(k, "k", 1)

    def frequency() -> Any:
        L, g = as_positive(length=length, gravity=gravity)
        return mp.besseljzero(0, k) / (4 * mp.pi) * mp.sqrt(g / L)

    return with_digits(frequency, digits)


class Deflection(NamedTuple):
    """Small displacement of a cantilever's tip across the rod, in the direction of the load [m],
    and its slope [rad]."""

    deflection: Real
    slope: Real


def linear_tip_force(
    *, force: Quantity, length: Quantity, bending_stiffness: Quantity, digits: int | None = None
) -> Deflection:
    """Tip of a cantilever under a force F [N] across it: F L^3 / (3 EI), F L^2 / (2 EI)."""

    def tip() -> Deflection:
        L, EI = as_positive(length=length, bending_stiffness=bending_stiffness)
        F = as_finite("force", force)
        return Deflection(F * L**3 / (3 * EI), F * L**2 / (2 * EI))

    return with_digits(tip, digits)


def linear_own_weight(
    *, load: Quantity, length: Quantity, bending_stiffness: Quantity, digits: int | None = None
) -> Deflection:
    """Tip of a cantilever under a uniform load q [N/m] across it, of its own weight M g / L:
    q L^4 / (8 EI), q L^3 / (6 EI)."""

    def tip() -> Deflection:
        L, EI = as_positive(length=length, bending_stiffness=bending_stiffness)
        q = as_finite("load", load)
        return Deflection(q * L**4 / (8 * EI), q * L**3 / (6 * EI))

    return with_digits(tip, digits)
