"""Equations for an eigenvalue s of (S0 + s S1 + s^2 S2) z = 0 on the imaginary axis, with its
frequency and the numbers that the matrices depend on as unknowns.

Divergence: S(0) is singular. Flutter of a damped rod: S(i omega) is, for two real unknowns. Flutter
without damping, where two frequencies meet: S is, and stays so to first order as omega^2 changes.
The distance of S from a singular matrix is measured by g of the bordered system S x + b g = 0, c x
= 1, which is regular where S is singular; derivatives of g are -y S' x (W. Govaerts, Numerical
Methods for Bifurcations of Dynamical Equilibria, SIAM 2000, ch. 3).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.bordered import BorderedMatrix, Matrix
from rodgen.analyse.pencil import MatrixPencil
from rodgen.arrays import Array

STEPS = 2  # in which a border comes next to both null vectors


class Border(NamedTuple):
    """Border of a nearly singular matrix: a real column b and a real row c (size,)."""

    column: Array
    row: Array

    @classmethod
    def of(cls, S: Matrix, before: Border | None = None) -> Border:
        """Border a matrix by its approximate null vectors. With the border before, signs are kept,
        so that the sign of the bordered determinant does not change."""
        column = row = np.cos(np.arange(S.shape[0]) ** 2 / 7.0)
        made = cls(column, row) if before is None else before
        for _ in range(STEPS):
            near = NearSingular(S, made)
            made = cls(*(_make_real(vector) for vector in (near.left, near.right)))
        return made


def _make_real(vector: NDArray[Any]) -> Array:
    """Rotate a complex vector to be as real as possible; return its real part, of unit length."""
    turned = vector * np.exp(-0.5j * np.angle((vector * vector).sum()))
    return np.asarray(turned.real / np.linalg.norm(turned.real))


class NearSingular:
    """Bordered system of a nearly singular matrix S: S x + b g = 0, c x = 1, and y S + g c = 0, y b
    = 1, with g zero where S is singular; left: y, right: x (size,)."""

    def __init__(self, S: Matrix, border: Border):
        self._bordered = BorderedMatrix(S, border.row[None], border.column[:, None])
        last = np.zeros(len(border.row) + 1)
        last[-1] = 1.0
        self.right = self._bordered.solve(last)[:-1]
        self.left = self._bordered.solve(last, transposed=True)[:-1]
        self.g = -(self.left @ (S @ self.right))  # its errors are squares of those of x and y

    def derivative(self, change: Matrix, right: NDArray[Any] | None = None) -> Any:
        """Derivative of g by a change of S; right: another x."""
        return -(self.left @ (change @ (self.right if right is None else right)))

    def absolute_sum(self, sizes: Matrix) -> float:
        """Sum of the absolute terms of g, for the absolute entries of S."""
        return float(np.abs(self.left) @ (sizes @ np.abs(self.right)))

    def right_derivative(self, change: Matrix) -> NDArray[Any]:
        """Derivative of x by a change of S."""
        return self._bordered.solve(np.append(-(change @ self.right), 0.0))[:-1]


class CrossingEquations(NamedTuple):
    """Residual of a crossing and its derivatives. residual (k,): zero where an eigenvalue crosses;
    by_omega (k, 1), for divergence (k, 0); by_numbers (k, numbers); near: the matrix."""

    residual: Array
    by_omega: Array
    by_numbers: Array
    near: NearSingular


class CrossingKind(ABC):
    """Interface of the ways in which an eigenvalue crosses the imaginary axis."""

    @abstractmethod
    def singular_matrix(self, here: MatrixPencil, omega: float) -> Matrix:
        """Matrix that is singular at the crossing."""

    @abstractmethod
    def equations(
        self, here: MatrixPencil, slopes: Sequence[MatrixPencil], border: Border, omega: float
    ) -> CrossingEquations:
        """Set up the equations of the crossing. slopes: derivatives of the linearised equations by
        every number; border: of the nearly singular matrix."""

    @abstractmethod
    def term_sums(self, near: NearSingular, sizes: MatrixPencil, omega: float) -> list[float]:
        """Sums of absolute terms of each residual; sizes: absolute entries, or sums of terms."""


class Divergence(CrossingKind):
    """An eigenvalue that is zero: a motion that does not oscillate."""

    def singular_matrix(self, here: MatrixPencil, omega: float) -> Matrix:
        return here.S0

    def equations(
        self, here: MatrixPencil, slopes: Sequence[MatrixPencil], border: Border, omega: float
    ) -> CrossingEquations:
        near = NearSingular(here.S0, border)
        by = [near.derivative(slope.S0) for slope in slopes]
        return CrossingEquations(np.array([near.g]), np.zeros((1, 0)), np.array([by]), near)

    def term_sums(self, near: NearSingular, sizes: MatrixPencil, omega: float) -> list[float]:
        return [near.absolute_sum(sizes.S0)]


class Flutter(CrossingKind):
    """An eigenvalue i omega of a damped rod: real and imaginary part of g are zero."""

    def singular_matrix(self, here: MatrixPencil, omega: float) -> Matrix:
        return here.at(1j * omega)

    def equations(
        self, here: MatrixPencil, slopes: Sequence[MatrixPencil], border: Border, omega: float
    ) -> CrossingEquations:
        s = 1j * omega
        near = NearSingular(here.at(s), border)
        by = np.array([near.derivative(slope.at(s)) for slope in slopes])
        by_omega = 1j * near.derivative(here.derivative(s))
        residual, rates = (np.array([z.real, z.imag]) for z in (near.g, by_omega))
        return CrossingEquations(residual, rates[:, None], np.array([by.real, by.imag]), near)

    def term_sums(self, near: NearSingular, sizes: MatrixPencil, omega: float) -> list[float]:
        """Sums of absolute terms, for the real and the imaginary part apart: a tiny one keeps its
        digits beside the other, so that damping may be arbitrarily weak."""
        stiff, drag = sizes.S0 + omega**2 * sizes.S2, omega * sizes.S1
        (x, u), (y, v) = ((np.abs(z.real), np.abs(z.imag)) for z in (near.right, near.left))
        real = y @ (stiff @ x) + v @ (stiff @ u) + y @ (drag @ u) + v @ (drag @ x)
        imaginary = y @ (stiff @ u) + v @ (stiff @ x) + y @ (drag @ x) + v @ (drag @ u)
        return [float(real), float(imaginary)]


class UndampedFlutter(CrossingKind):
    """Two undamped frequencies that meet: g and its derivative by omega^2 are zero."""

    def singular_matrix(self, here: MatrixPencil, omega: float) -> Matrix:
        return here.at_square(-(omega**2))

    def equations(
        self, here: MatrixPencil, slopes: Sequence[MatrixPencil], border: Border, omega: float
    ) -> CrossingEquations:
        square = -(omega**2)
        near = NearSingular(here.at_square(square), border)
        turned, first = near.right_derivative(here.S2), -near.derivative(here.S2)
        by, mixed = [], []
        for slope in slopes:
            change = slope.at_square(square)
            by.append(near.derivative(change))
            second = near.derivative(slope.S2) + near.derivative(change, turned)
            mixed.append(-(second + near.derivative(here.S2, near.right_derivative(change))))
        by_omega = 2 * omega * np.array([[first], [2 * near.derivative(here.S2, turned)]])
        return CrossingEquations(np.array([near.g, first]), by_omega, np.array([by, mixed]), near)

    def term_sums(self, near: NearSingular, sizes: MatrixPencil, omega: float) -> list[float]:
        return [near.absolute_sum(sizes.at_square(omega**2)), near.absolute_sum(sizes.S2)]


def crossing_kind(oscillates: bool, damped: bool) -> CrossingKind:
    """Choose the kind of crossing, for a motion that oscillates or not, of a damped rod or not."""
    if not oscillates:
        return Divergence()
    return Flutter() if damped else UndampedFlutter()
