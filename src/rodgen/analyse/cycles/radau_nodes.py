"""Collocation methods at the nodes of Radau IIA: implicit Runge-Kutta methods of order 2 s - 1 for
s stages, the last at the end of the step, in which stiff motions decay.

E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.5. Gauss nodes have one
order more, but carry a motion that decays at once on, with or without a change of sign: for a stiff
rod they give multipliers that do not exist.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import Polynomial

from rodgen.arrays import Array


@dataclass(frozen=True, eq=False)
class Nodes:
    """A collocation method. c (s,): nodes as shares of a step; A (s, s): integrals, up to each
    node, of the polynomial through rates; degree: s, of the states; order: at ends of steps."""

    c: Array
    A: Array

    @property
    def degree(self) -> int:
        return len(self.c)

    @property
    def order(self) -> int:
        return 2 * len(self.c) - 1

    def interpolation_weights(self, shares: Array) -> Array:
        """Weights (K, s + 1) of the states at the start and at the nodes, to interpolate at shares
        (K,) of the step."""
        return _lagrange(np.append(0.0, self.c), shares)

    @property
    def derivative_weights(self) -> Array:
        """Weights (s + 1,) of the states at the start and at the nodes, for the highest derivative
        of their polynomial, by the share of the step, over the factorial of its degree."""
        at = np.append(0.0, self.c)
        apart = at[:, None] - at + np.eye(len(at))
        return 1 / np.asarray(apart.prod(axis=1))


@lru_cache
def radau(stages: int) -> Nodes:
    """Radau IIA method with so many stages."""
    # The zeros of the derivative of order s - 1 of x^(s-1) (x - 1)^s.
    x = Polynomial([0.0, 1.0])
    c = np.sort((x ** (stages - 1) * (x - 1) ** stages).deriv(stages - 1).roots().real)
    c[-1] = 1.0
    powers = np.arange(stages)
    left = np.vander(c, stages, increasing=True)
    A = (c[:, None] ** (powers + 1) / (powers + 1)) @ np.linalg.inv(left)
    return Nodes(c, A)


def _lagrange(at: Array, shares: Array) -> Array:
    """Values (K, nodes) at shares (K,) of the Lagrange polynomials: 1 at one node, 0 at others."""
    made = np.ones((len(shares), len(at)))
    for j, node in enumerate(at):
        for other in np.delete(at, j):
            made[:, j] *= (shares - other) / (node - other)
    return made
