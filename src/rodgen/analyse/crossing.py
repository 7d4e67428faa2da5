"""Where an eigenvalue s of (S0 + s S1 + s^2 S2) z = 0 crosses the imaginary axis, as equations in
its rate and in the numbers that the matrices depend on.

Divergence: S(0) is singular. Flutter of a damped rod: S(i omega) is, for two real unknowns. Flutter
without damping, where two frequencies meet: S is, and stays so to first order as omega^2 changes.
How far S is from singular says g of the bordered system S x + b g = 0, c x = 1, which is regular
where S is singular, and whose derivatives are -y S' x (W. Govaerts, Numerical Methods for
Bifurcations of Dynamical Equilibria, SIAM 2000, ch. 3).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.bordered import Bordered, Matrix
from rodgen.analyse.pencil import Parts
from rodgen.arrays import Array

STEPS = 2  # in which a border comes next to both null vectors


class Border(NamedTuple):
    """A real column b and a real row c (size,) beside a matrix that may be singular."""

    column: Array
    row: Array

    @classmethod
    def of(cls, S: Matrix, before: Border | None = None) -> Border:
        """Of a matrix: next to its null vectors. From one before it keeps the signs, so that the
        border changes no sign of a determinant."""
        column = row = np.cos(np.arange(S.shape[0]) ** 2 / 7.0)
        made = cls(column, row) if before is None else before
        for _ in range(STEPS):
            near = NearSingular(S, made)
            made = cls(*(_as_real(vector) for vector in (near.left, near.right)))
        return made


def _as_real(vector: NDArray[Any]) -> Array:
    """The real part of a vector, turned by a right angle at most so that it is the largest, of
    length one."""
    turned = vector * np.exp(-0.5j * np.angle((vector * vector).sum()))
    return np.asarray(turned.real / np.linalg.norm(turned.real))


class NearSingular:
    """A matrix S next to a singular one: S x + b g = 0, c x = 1, and y S + g c = 0, y b = 1, with g
    zero where S is singular; left: y, right: x (size,)."""

    def __init__(self, S: Matrix, border: Border):
        self._bordered = Bordered(S, border.row[None], border.column[:, None])
        last = np.zeros(len(border.row) + 1)
        last[-1] = 1.0
        self.right = self._bordered.solve(last)[:-1]
        self.left = self._bordered.solve(last, transposed=True)[:-1]
        self.g = -(self.left @ (S @ self.right))  # its errors are squares of those of x and y

    def by(self, change: Matrix, right: NDArray[Any] | None = None) -> Any:
        """The derivative of g by a change of S; right: another x."""
        return -(self.left @ (change @ (self.right if right is None else right)))

    def size(self, sizes: Matrix) -> float:
        """Of g where every entry of S counts with its absolute value."""
        return float(np.abs(self.left) @ (sizes @ np.abs(self.right)))

    def moved(self, change: Matrix) -> NDArray[Any]:
        """The derivative of x by a change of S."""
        return self._bordered.solve(np.append(-(change @ self.right), 0.0))[:-1]


class CrossingEquations(NamedTuple):
    """residual (k,): zero where an eigenvalue crosses; its derivatives by omega (k, 1), of
    divergence none (k, 0), and by every number (k, numbers); near: the matrix."""

    residual: Array
    by_omega: Array
    by_numbers: Array
    near: NearSingular


class CrossingKind(ABC):
    """How an eigenvalue crosses."""

    @abstractmethod
    def singular(self, here: Parts, omega: float) -> Matrix:
        """What of the linearised equations is singular there."""

    @abstractmethod
    def equations(
        self, here: Parts, slopes: Sequence[Parts], border: Border, omega: float
    ) -> CrossingEquations:
        """Equations of the crossing. slopes: derivatives of the linearised ones by every number;
        border: of what is next to singular."""

    @abstractmethod
    def roundings(self, near: NearSingular, sizes: Parts, omega: float) -> list[float]:
        """Of the residual, for absolute values of all entries, or of what they are sums of."""


class Divergence(CrossingKind):
    """An eigenvalue that is zero: a motion that does not oscillate."""

    def singular(self, here: Parts, omega: float) -> Matrix:
        return here.S0

    def equations(
        self, here: Parts, slopes: Sequence[Parts], border: Border, omega: float
    ) -> CrossingEquations:
        near = NearSingular(here.S0, border)
        by = [near.by(slope.S0) for slope in slopes]
        return CrossingEquations(np.array([near.g]), np.zeros((1, 0)), np.array([by]), near)

    def roundings(self, near: NearSingular, sizes: Parts, omega: float) -> list[float]:
        return [near.size(sizes.S0)]


class Flutter(CrossingKind):
    """An eigenvalue i omega of a damped rod: real and imaginary part of g are zero."""

    def singular(self, here: Parts, omega: float) -> Matrix:
        return here.at(1j * omega)

    def equations(
        self, here: Parts, slopes: Sequence[Parts], border: Border, omega: float
    ) -> CrossingEquations:
        s = 1j * omega
        near = NearSingular(here.at(s), border)
        by = np.array([near.by(slope.at(s)) for slope in slopes])
        by_omega = 1j * near.by(here.slope(s))
        residual, rates = (np.array([z.real, z.imag]) for z in (near.g, by_omega))
        return CrossingEquations(residual, rates[:, None], np.array([by.real, by.imag]), near)

    def roundings(self, near: NearSingular, sizes: Parts, omega: float) -> list[float]:
        """Complex numbers of which the imaginary part is tiny keep the digits of either part, so
        that any damping will do."""
        stiff, drag = sizes.S0 + omega**2 * sizes.S2, omega * sizes.S1
        (x, u), (y, v) = ((np.abs(z.real), np.abs(z.imag)) for z in (near.right, near.left))
        real = y @ (stiff @ x) + v @ (stiff @ u) + y @ (drag @ u) + v @ (drag @ x)
        imaginary = y @ (stiff @ u) + v @ (stiff @ x) + y @ (drag @ x) + v @ (drag @ u)
        return [float(real), float(imaginary)]


class Meeting(CrossingKind):
    """Two frequencies that meet without damping: g is zero, and its derivative by omega^2."""

    def singular(self, here: Parts, omega: float) -> Matrix:
        return here.at_square(-(omega**2))

    def equations(
        self, here: Parts, slopes: Sequence[Parts], border: Border, omega: float
    ) -> CrossingEquations:
        square = -(omega**2)
        near = NearSingular(here.at_square(square), border)
        turned, first = near.moved(here.S2), -near.by(here.S2)
        by, mixed = [], []
        for slope in slopes:
            change = slope.at_square(square)
            by.append(near.by(change))
            second = near.by(slope.S2) + near.by(change, turned)
            mixed.append(-(second + near.by(here.S2, near.moved(change))))
        by_omega = 2 * omega * np.array([[first], [2 * near.by(here.S2, turned)]])
        return CrossingEquations(np.array([near.g, first]), by_omega, np.array([by, mixed]), near)

    def roundings(self, near: NearSingular, sizes: Parts, omega: float) -> list[float]:
        return [near.size(sizes.at_square(omega**2)), near.size(sizes.S2)]


def kind_of(oscillates: bool, damped: bool) -> CrossingKind:
    """How an eigenvalue crosses, of a motion that oscillates or not, of a rod that is damped or
    not."""
    if not oscillates:
        return Divergence()
    return Flutter() if damped else Meeting()
