"""Whether small motions about an equilibrium grow, and how."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.branch import MOST_DENSE, Rest
from rodgen.analyse.pencil import Cells, Pencil
from rodgen.analyse.system import System
from rodgen.integrate.stepper import Array

FLUTTER, DIVERGENCE = "flutter", "divergence"
# Shares of the largest eigenvalue down to which a matrix and its inverse have the others well:
# together they reach over twelve decades, of which 200 links take ten.
OF_MATRIX, OF_INVERSE = 1e-8, 1e-4
ROUNDING = 1e-14  # times links squared, of the other squared rates: the slowest is zero
DOUBLE = 1e-7  # times links, of a squared rate: imaginary parts that a double root may show


def instability(system: System, rest: Rest, p: Array) -> str | None:
    """What small motions without damping do: "divergence" where one grows without oscillating,
    "flutter" where one oscillates more and more, "" where none grows; None where that was not
    looked at, beyond 200 links.

    The slow motions come from the inverse, where they lose as many roundings as there are links,
    squared: the growth just above a critical load is told from zero to that, the slowest motion's
    alone.
    """
    if system.cells > MOST_DENSE:
        return None
    dense = Pencil.of(Cells.at(system, rest.phi, rest.force, p)).reduced()
    squares = np.concatenate(
        (
            _largest(np.linalg.solve(dense.M, -dense.K), OF_MATRIX),
            1 / _finite(_largest(_inverse(dense.K, dense.M), OF_INVERSE), system.cells),
        )
    )
    turned = np.abs(squares.imag) > DOUBLE * system.cells * np.abs(squares)
    if (~turned & (squares.real > 0)).any():
        return DIVERGENCE
    return FLUTTER if turned.any() else ""


def _inverse(K: Array, M: Array) -> Array:
    """-K^-1 M; of a singular K, exactly at the onset, nothing."""
    try:
        return np.asarray(np.linalg.solve(-K, M))
    except np.linalg.LinAlgError:
        return np.zeros((0, 0))


def _largest(matrix: Array, share: float) -> NDArray[Any]:
    """Eigenvalues that are larger than this share of the largest."""
    values = np.linalg.eigvals(matrix).astype(complex)
    size = np.abs(values)
    return np.asarray(values[size > share * size.max(initial=0.0)])


def _finite(inverse: NDArray[Any], cells: int) -> NDArray[Any]:
    """Without the one that is so much larger than the others that its sign is rounding."""
    size = np.abs(inverse)
    others = np.sort(size)[:-1].max(initial=0.0)
    return np.asarray(inverse[size * ROUNDING * cells**2 <= others]) if others else inverse
