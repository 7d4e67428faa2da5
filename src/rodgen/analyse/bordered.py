"""Bordered systems: how far a matrix is from singular, and how that changes with the matrix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import block_array, csc_array, issparse
from scipy.sparse.linalg import splu

from rodgen.analyse.motions import ROUNDING
from rodgen.analyse.pencil import Dense, Held, Matrix, Pencil, sparse
from rodgen.integrate.stepper import Array

REAL = 1e-6  # of a vector whose imaginary part is left out of a border
Scales = tuple[Array, Array]


@dataclass(frozen=True)
class Parts:
    """S0, S1 and S2 of S0 + s S1 + s^2 S2, dense or sparse."""

    S0: Any
    S1: Any
    S2: Any

    @classmethod
    def of(cls, linear: Pencil | Dense | Held) -> Parts:
        """From the linearised equations."""
        if isinstance(linear, Dense):
            return cls(*linear.parts)
        parts = linear.S0, linear.S1, linear.S2
        return cls(*map(sparse, parts)) if isinstance(linear, Pencil) else cls(*parts)

    def at(self, s: complex) -> Any:
        """S(s)."""
        return self.S0 + s * self.S1 + s * s * self.S2

    def at_square(self, square: float) -> Any:
        """S0 + s^2 S2, real: without damping."""
        return self.S0 + square * self.S2

    def slope(self, s: complex) -> Any:
        """S'(s)."""
        return self.S1 + 2 * s * self.S2

    def sizes(self, rate: float) -> Any:
        """Absolute values of S0 and S2 at a rate, which rounding goes with."""
        return abs(self.S0) + rate**2 * abs(self.S2)

    def less(self, other: Parts, step: float) -> Parts:
        """The difference over a step."""
        pairs = zip(self, other, strict=True)
        return Parts(*((one - two) / step for one, two in pairs))

    def __iter__(self) -> Any:
        return iter((self.S0, self.S1, self.S2))

    def scales(self, rate: float) -> Scales:
        """Factors of rows and columns that make the largest entry of each about one."""
        sizes = self.sizes(rate) + rate * abs(self.S1)
        rows = 1 / _largest(sizes, 1)
        return rows, 1 / _largest(_product(sizes, (rows, np.ones(len(rows)))), 0)

    def scaled(self, scales: Scales) -> Parts:
        """With rows and columns times their factors."""
        return Parts(*(_product(part, scales) for part in self))

    def borders(self, S: Any) -> tuple[Matrix, Matrix]:
        """Estimates of the left and the right null vector of S, by inverse iteration."""
        b = c = np.cos(np.arange(S.shape[0]) ** 2 / 7.0)
        factors = _Factors(S)
        for _ in range(2):
            b, c = (_unit(z) for z in (factors.solve(b, transposed=True), factors.solve(c)))
        return b.conj(), c.conj()


def _product(part: Any, scales: Scales) -> Any:
    rows, columns = scales
    if issparse(part):
        return csc_array(part.multiply(rows[:, None]).multiply(columns[None, :]))
    return rows[:, None] * part * columns


def _largest(sizes: Any, axis: int) -> Array:
    most = sizes.max(axis=axis)
    return np.asarray(most.toarray() if issparse(most) else most).ravel()


def _unit(z: Matrix) -> Matrix:
    """Of length one and as real as can be."""
    largest = z[np.argmax(np.abs(z))]
    z = z / largest
    if np.abs(z.imag).max() < REAL:
        z = z.real
    return np.asarray(z / np.linalg.norm(z))


class _Factors:
    """L U of a matrix; of one that is singular, next to it."""

    def __init__(self, S: Any):
        self.complex = np.iscomplexobj(S)
        self.sparse = issparse(S)
        if not self.sparse:
            pivoted, order = lu_factor(S, check_finite=False)
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
            made = lu_solve(self.factors, right, trans=int(transposed), check_finite=False)
            return np.asarray(made)
        if self.complex:
            right = right.astype(complex)
        return np.asarray(self.factors.solve(right, "T" if transposed else "N"))


class Bordered:
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
