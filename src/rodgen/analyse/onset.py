"""The load at which stability is lost, to the last digits: Newton's method on the singularity."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.linalg.lapack import get_lapack_funcs
from scipy.sparse import block_array, csc_array, issparse
from scipy.sparse.linalg import splu

from rodgen.analyse.modal import ROUNDING
from rodgen.analyse.pencil import Dense, Linear, Parts
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.integrate.blocks import Matrix

At = Callable[[float], Linear]  # the equations linearised at a load
DIFFERENCE = 1e-4  # relative, of derivatives by the load: exact where S is linear in it
ITERATIONS = 30
SMALL = 1e-7  # relative change below which one that no longer shrinks is rounding
ROUNDED = 8.0  # times what rounding makes, within which a change that no longer shrinks is rounding
APART = 0.05  # by which an estimate may be wrong
ENTRY = 16 * ROUNDING  # of an entry of the matrices, which a few operations make
REAL = 1e-6  # of a vector whose imaginary part is left out of a border
DIGITS = (3, 12)  # the least and the most that are printed of a load


@dataclass(frozen=True)
class Onset:
    """force: the load [N]; s: the eigenvalue there [1/s]: zero for divergence, on the imaginary
    axis for flutter; error: of the load, what roundings of the matrices can do to it, or the last
    step of Newton's method if that is more; rate_error: the same of abs(s)."""

    force: float
    s: complex
    error: float = 0.0
    rate_error: float = 0.0


def onset(at: At, near: Onset, unit: float, linear: bool = False) -> Onset:
    """The onset next to an estimate, as closely as the matrices tell; unit: a size of the load
    that matters; linear: whether S is linear in the load.

    Divergence: S(0, P) is singular. Flutter of a damped rod: S(i omega, P) is, for two real
    unknowns. Flutter without damping, where two frequencies meet: S is, and stays so to first
    order as omega^2 changes. How far S is from singular says g of the bordered system
    S x + b g = 0, c x = 1, which is regular where S is singular, and whose derivatives are
    -y S' x (W. Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, SIAM 2000,
    ch. 3). Complex numbers of which the imaginary part is tiny keep the digits of either part, so
    that any damping will do. Raises AnalysisError.
    """
    damped = near.s != 0 and at(near.force).damped
    search = _Search(at, near, unit, damped, linear)
    if near.s == 0:
        (force,), (error,) = search.newton(search.divergence, np.array([near.force]))
        return Onset(force, 0j, error)
    rate = abs(near.s) if damped else abs(near.s) ** 2
    measure = search.flutter if damped else search.meeting
    (force, rate), (error, spread) = search.newton(measure, np.array([near.force, rate]))
    if damped:
        return Onset(force, 1j * rate, error, spread)
    omega = float(np.sqrt(rate))
    return Onset(force, 1j * omega, error, spread / (2 * omega))


def digits(value: float, error: float) -> str:
    """A value with the digits that an error leaves, twelve at most."""
    least, most = DIGITS
    if not value or not error:
        return f"{value:.{most}g}"
    known = int(np.floor(np.log10(abs(value) / error)))
    return f"{value:.{min(max(known, least), most)}g}"


def unfound(force: float) -> str:
    return f"Newton's method found no onset of instability within {APART:.0%} of {force:.9g} N"


Measured = tuple[Array, Array, Array]  # residuals (k,), derivatives (k, k), roundings (k,)


class _Search:
    """Newton's method next to an estimate, with scales and borders that are taken there."""

    def __init__(self, at: At, near: Onset, unit: float, damped: bool, linear: bool):
        self.at, self.near, self.linear = at, near, linear
        self._by_force: Parts | None = None
        self.size = max(abs(near.force), unit)
        whole = at(near.force)
        # Full matrices are sums over rows and columns of as many rounded terms, of which the sizes
        # are known or not.
        known = whole.terms is not None if isinstance(whole, Dense) else False
        terms = whole.size ** (1 if known else 2) if isinstance(whole, Dense) else 1
        self.entry = ENTRY * terms
        self.s = 1j * abs(near.s) if damped else 0.0
        self.square = -(abs(near.s) ** 2)
        here = Parts.of(whole)
        self.scales = here.scales(abs(near.s))
        here = here.scaled(self.scales)
        self.b, self.c = _borders(here.at(self.s) if damped else here.at_square(self.square))

    def newton(
        self, measure: Callable[[Array], Measured], start: Array
    ) -> tuple[list[float], list[float]]:
        """The zero of a measure, and the errors of its unknowns."""
        x, before = start, np.inf
        scale = np.concatenate(([self.size], np.abs(start[1:])))
        for _ in range(ITERATIONS):
            residual, slopes, rounding = measure(x)
            slopes = slopes * scale
            rows = np.abs(slopes).max(axis=1)
            inverse = np.linalg.inv(slopes / rows[:, None]) / rows
            change = -inverse @ residual
            x = x + change * scale
            moved = float(np.abs(change).max())
            if not abs(x[0] - start[0]) < APART * self.size:
                break
            noise = np.abs(inverse) @ rounding + self.entry
            if (np.abs(residual) <= rounding).all():
                return x.tolist(), (noise * scale).tolist()
            rounded = (np.abs(change) <= ROUNDED * noise).all()
            if (moved < SMALL or rounded) and moved >= before / 4:
                return x.tolist(), (np.maximum(noise, np.abs(change)) * scale).tolist()
            before = moved
        raise AnalysisError(unfound(self.near.force))

    def _parts(self, force: float) -> tuple[Parts, Parts]:
        """At a load, and their derivative by it."""
        here = self._scaled(force)
        if self._by_force is None or not self.linear:
            step = DIFFERENCE * self.size
            up, down = self._scaled(force + step), self._scaled(force - step)
            self._by_force = up.less(down, 2 * step)
        return here, self._by_force

    def _scaled(self, force: float) -> Parts:
        return Parts.of(self.at(float(force))).scaled(self.scales)

    def divergence(self, values: Array) -> Measured:
        """g(P)."""
        here, by_force = self._parts(values[0])
        made = _Bordered(here.at_square(0.0), self.b, self.c)
        rounding = made.size_of(here.sizes(0.0) + abs(values[0]) * by_force.sizes(0.0))
        slope = made.by(by_force.at_square(0.0))
        return np.array([made.g]), np.array([[slope]]), self.entry * np.array([rounding])

    def flutter(self, values: Array) -> Measured:
        """Real and imaginary part of g(P, omega)."""
        (here, by_force), omega = self._parts(values[0]), values[1]
        s = 1j * omega
        made = _Bordered(here.at(s), self.b, self.c)
        slopes = made.by(by_force.at(s)), 1j * made.by(here.slope(s))
        rounding = made.roundings(here, by_force, values[0], omega)
        return (
            np.array([made.g.real, made.g.imag]),
            np.array([[one.real for one in slopes], [one.imag for one in slopes]]),
            self.entry * np.array(rounding),
        )

    def meeting(self, values: Array) -> Measured:
        """g and its derivative by the square of the rate, (P, omega^2)."""
        (here, by_force), square = self._parts(values[0]), -values[1]
        made = _Bordered(here.at_square(square), self.b, self.c)
        P_slope, turned = by_force.at_square(square), made.moved(here.S2)
        slope = made.by(here.S2)
        mixed = made.between(P_slope, turned) + made.between(here.S2, made.moved(P_slope))
        curve = 2 * made.between(here.S2, turned)
        sizes = here.sizes(abs(square) ** 0.5) + abs(values[0]) * by_force.sizes(0.0)
        rounding = made.size_of(sizes), made.size_of(abs(here.S2))
        return (
            np.array([made.g, slope]),
            np.array([[made.by(P_slope), -slope], [mixed, -curve]]),
            self.entry * np.array(rounding),
        )


def _borders(S: Any) -> tuple[Matrix, Matrix]:
    """Estimates of the left and the right null vector of S, by inverse iteration."""
    b = c = np.cos(np.arange(S.shape[0]) ** 2 / 7.0)
    factors = _Factors(S)
    for _ in range(2):
        b, c = (_unit(z) for z in (factors.solve(b, transposed=True), factors.solve(c)))
    return b.conj(), c.conj()


def _unit(z: Matrix) -> Matrix:
    """Of length one and as real as can be."""
    largest = z[np.argmax(np.abs(z))]
    z = z / largest
    if np.abs(z.imag).max() < REAL:
        z = z.real
    return np.asarray(z / np.linalg.norm(z))


@lru_cache(maxsize=2)
def _lapack(is_complex: bool) -> tuple[Any, Any]:
    """What factors full matrices and what solves with the factors: SciPy's own functions look at
    what they are given for longer than it takes to factor small ones."""
    found = get_lapack_funcs(("getrf", "getrs"), dtype=complex if is_complex else float)
    return found[0], found[1]


class _Factors:
    """L U of a matrix; of one that is singular, next to it."""

    def __init__(self, S: Any):
        self.complex = np.iscomplexobj(S)
        self.sparse = issparse(S)
        if not self.sparse:
            factor, self._solve = _lapack(self.complex)
            pivoted, order, _ = factor(S)
            zero = np.flatnonzero(np.diag(pivoted) == 0)
            pivoted[zero, zero] = ROUNDING * np.abs(S).max()
            self.factors: Any = pivoted, order
            return
        try:
            self.factors = splu(csc_array(S))
        except RuntimeError:
            nudge = csc_array(np.eye(S.shape[0]) * ROUNDING * abs(S).max())
            self.factors = splu(csc_array(S + nudge))

    def solve(self, right: Matrix, transposed: bool = False) -> Matrix:
        if not self.sparse:
            if np.iscomplexobj(right) and not self.complex:
                real, imaginary = (
                    self.solve(part, transposed) for part in (right.real, right.imag)
                )
                return real + 1j * imaginary
            made, _ = self._solve(*self.factors, right, trans=int(transposed))
            return np.asarray(made)
        if self.complex:
            right = right.astype(complex)
        return np.asarray(self.factors.solve(right, "T" if transposed else "N"))


class _Bordered:
    """S x + b g = 0, c x = 1, and y S + g c = 0, y b = 1: g is zero where S is singular."""

    def __init__(self, S: Any, b: Matrix, c: Matrix):
        if issparse(S):
            whole = csc_array(block_array([[S, b[:, None]], [c[None, :], None]]))
        else:
            whole = np.block([[S, b[:, None]], [c[None, :], np.zeros((1, 1))]])
        self._factors = _Factors(whole)
        last = np.zeros(len(b) + 1)
        last[-1] = 1.0
        self.x = self._factors.solve(last)[:-1]
        self.y = self._factors.solve(last, transposed=True)[:-1]
        self.g = -(self.y @ (S @ self.x))  # its errors are squares of those of x and y

    def by(self, change: Any) -> Any:
        """The derivative of g by a change of S."""
        return -(self.y @ (change @ self.x))

    def moved(self, change: Any) -> Matrix:
        """The derivative of x by a change of S."""
        return self._factors.solve(np.append(-(change @ self.x), 0.0))[:-1]

    def between(self, change: Any, x: Matrix) -> Any:
        """-y S' x of another x."""
        return -(self.y @ (change @ x))

    def size_of(self, sizes: Any) -> float:
        """Of g where every entry of S counts with its absolute value."""
        return float(np.abs(self.y) @ (sizes @ np.abs(self.x)))

    def roundings(
        self, here: Parts, by_force: Parts, force: float, rate: float
    ) -> tuple[float, float]:
        """Of the real and of the imaginary part of g, which a weak damping keeps apart."""
        sizes = here.sizes(rate) + abs(force) * by_force.sizes(0.0)
        drag = rate * (abs(here.S1) + abs(force) * abs(by_force.S1))
        (x, u), (y, v) = ((np.abs(z.real), np.abs(z.imag)) for z in (self.x, self.y))
        real = y @ (sizes @ x) + v @ (sizes @ u) + y @ (drag @ u) + v @ (drag @ x)
        imaginary = y @ (sizes @ u) + v @ (sizes @ x) + y @ (drag @ x) + v @ (drag @ u)
        return float(real), float(imaginary)
