"""The force at which stability is lost, to the last digits: Newton's method on the singularity."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import brentq

from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.pencil import Dense, Held, Matrix, Pencil
from rodgen.integrate.stepper import Array

Linear = Pencil | Dense | Held
At = Callable[[float], Linear]  # the equations linearised at a force
DIFFERENCE = 1e-4  # relative: errors are its square
ITERATIONS = 30
SMALL = 1e-7  # relative change below which one that no longer shrinks is rounding
START = 1e-4  # the share of the force in which an onset is looked for first
APART = 0.05  # by which an estimate may be wrong


@dataclass(frozen=True)
class Onset:
    """force [N]; s: the eigenvalue there [1/s]: zero for divergence, on the imaginary axis for
    flutter; error: of the force, estimated from Newton's last steps [N]."""

    force: float
    s: complex
    error: float = 0.0


def onset(at: At, near: Onset) -> Onset:
    """The onset next to an estimate, to about ten digits or more.

    Divergence: S(0, P) is singular. Flutter of a damped rod: S(i omega, P) is, for two real
    unknowns. Flutter without damping, where two frequencies meet: S is, and stays so to first
    order as omega^2 changes. How far S is from singular says g of the bordered system
    S x + b g = 0, c x = 1, whose derivatives are -y S' x (W. Govaerts, Numerical Methods for
    Bifurcations of Dynamical Equilibria, SIAM 2000, ch. 3). Raises AnalysisError.
    """
    damped = at(near.force).damped
    if near.s == 0:
        start, measure = np.array([near.force]), _of_divergence
    elif damped:
        start, measure = np.array([near.force, abs(near.s)]), _of_damped_flutter
    else:
        start, measure = np.array([near.force, abs(near.s) ** 2]), _of_meeting
    borders = _borders(at(near.force), near.s)
    values, error = _newton(lambda x: measure(at, x, borders), start)
    if near.s == 0:
        return Onset(float(values[0]), 0j, error)
    rate = values[1] if damped else np.sqrt(values[1])
    return Onset(float(values[0]), 1j * float(rate), error)


def turning_onset(at: At, near: Onset) -> Onset:
    """Where a pinned rod, its turning damped from outside, begins to turn on its own.

    With r the turning, K r = 0 under every force, and l K = 0, the other small eigenvalue is
    -(l C r)/(l M r): zero where l C r is.
    """

    def drag(force: float) -> float:
        here = at(force)
        assert isinstance(here, Dense)
        turn = null_space(here.K, rcond=1e-9)[:, :1]
        left = null_space(here.K.T, rcond=1e-9)[:, :1]
        return float((left.T @ here.C @ turn / (left.T @ here.M @ turn))[0, 0])

    apart = START
    while apart < APART:  # not farther than needed: the stiffness may be singular close by
        low, high = near.force * (1 - apart), near.force * (1 + apart)
        with suppress(ValueError, IndexError):
            force = float(brentq(drag, low, high, xtol=1e-12 * near.force))
            return Onset(force, 0j, 1e-12 * abs(force))
        apart *= 2
    raise AnalysisError(_unfound(near.force))


def _unfound(force: float) -> str:
    return f"Newton's method found no onset of instability within {APART:.0%} of {force:.9g} N"


def _newton(measure: Callable[[Array], Array], start: Array) -> tuple[Array, float]:
    """Zero of a measure, with central differences wide against rounding; the last change of the
    first unknown is its error."""
    x, before = start, np.inf
    for _ in range(ITERATIONS):
        steps = np.diag(DIFFERENCE * x)
        slopes = [(measure(x + d) - measure(x - d)) / (2 * DIFFERENCE) for d in steps]
        change = x * np.linalg.solve(np.column_stack(slopes), -measure(x))
        x = x + change
        moved = float(np.abs(change / x).max())
        if not abs(x[0] / start[0] - 1) < APART:
            break
        if moved < SMALL and moved >= before / 4:
            return x, float(min(abs(change[0]), before * abs(x[0])))
        before = moved
    raise AnalysisError(_unfound(float(start[0])))


Borders = tuple[Matrix, Matrix]


def _of_divergence(at: At, values: Array, borders: Borders) -> Array:
    here = at(values[0])
    return np.array([_bordered(here, here.at_square(0.0), borders)[0]])


def _of_damped_flutter(at: At, values: Array, borders: Borders) -> Array:
    here = at(values[0])
    g = _bordered(here, here.at(1j * values[1]), borders)[0]
    return np.array([g.real, g.imag])


def _of_meeting(at: At, values: Array, borders: Borders) -> Array:
    here = at(values[0])
    g, x, y = _bordered(here, here.at_square(-values[1]), borders)
    return np.array([g, values[1] * (y @ here.inertia(x))])


def _bordered(here: Linear, S: Matrix, borders: Borders) -> tuple[Any, Matrix, Matrix]:
    """g, x and y; by solutions with S itself, whose errors along the null vector cancel."""
    b, c = borders
    x, y = here.solve(S, b), here.solve(S, c, transposed=True)
    g = -1 / (c @ x)
    return g, -g * x, -g * y


def _borders(here: Linear, s: complex) -> Borders:
    """Estimates of the left and the right null vector, by inverse iteration."""
    oscillates = here.damped and s != 0
    S = here.at(s) if oscillates else here.at_square(-(abs(s) ** 2))
    b = c = np.cos(np.arange(here.size) ** 2 / 7.0)
    for _ in range(2):
        b, c = here.solve(S, b, transposed=True), here.solve(S, c)
        b, c = b / np.linalg.norm(b), c / np.linalg.norm(c)
    return (b.conj(), c.conj()) if oscillates else (b, c)
