"""Branches of equilibria: Newton's method, and how it follows a branch as loads change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.pencil import Cells, Pencil, solve, sparse
from rodgen.analyse.system import System
from rodgen.integrate.stepper import Array

ITERATIONS = 40  # of Newton's method for one load
FARTHEST = 0.2  # rad of a correction that is taken, else the step is halved
SMALL = 1e-4  # of the way: what changes its stability over it does so on this branch
LEAST = 1e-6  # of the way, the smallest step
NOISE = 1e-9  # rad: a correction below it that no longer shrinks is rounding
MOST_DENSE = 200  # links up to which all eigenvalues are looked at for stability


@dataclass
class Rest:
    """Angles (cells,) [rad] and joint forces (cells, 2) over the mass of a link [m/s^2] on their
    way to an equilibrium."""

    phi: Array
    force: Array
    iterations: int = 0
    change: float = np.inf


class Loading(NamedTuple):
    """Parameters of the module, and what the residual (cells, 3) is to be instead of zero: moments
    that keep their value however the rod moves."""

    p: Array
    bend: Array | float = 0.0

    def cells(self, system: System, rest: Rest) -> Cells:
        """The equations of rest, in which an equilibrium has no residual."""
        cells = Cells.at(system, rest.phi, rest.force, self.p)
        return replace(cells, residual=cells.residual - self.bend)


def follow(
    system: System, rest: Rest, at: Callable[[float], Loading], way: str = "the load"
) -> tuple[Rest, tuple[float, ...]]:
    """The equilibrium at the end of the branch that begins with ``rest``, and the fractions of the
    way that were stepped through; at: the loading at every fraction; way: what they are of.

    A step is taken where Newton's method converges without a large correction from the tangent,
    and where no motion has become unstable or stable on the way: else it is halved, so that no
    other branch is jumped to. A change that remains over the smallest step is one of this branch.
    Raises AnalysisError where the branch ends.
    """
    done, step = 0.0, 1.0
    stages: list[float] = []
    signature = _signature(system, rest, at(0.0))
    slope = None
    while done < 1:
        fraction = min(done + step, 1.0)
        trial = Rest(rest.phi.copy(), rest.force.copy(), rest.iterations)
        if slope is not None:
            trial.phi = trial.phi + (fraction - done) * slope[0]
            trial.force = trial.force + (fraction - done) * slope[1]
        taken = newton(system, trial, at(fraction))
        found = _signature(system, trial, at(fraction)) if taken else signature
        if taken and (found == signature or step < SMALL):
            change = fraction - done
            slope = ((trial.phi - rest.phi) / change, (trial.force - rest.force) / change)
            rest, done, signature = trial, fraction, found
            stages.append(fraction)
            step *= 2
        else:
            rest.iterations = trial.iterations
            step /= 2
        if step < LEAST:
            raise AnalysisError(
                f"no equilibrium found beyond {done:.6g} of {way}: Newton's method failed from "
                f"there for every step down to {LEAST:g} of it ({rest.iterations} iterations)"
            )
    return rest, tuple(stages)


def newton(system: System, rest: Rest, loading: Loading) -> bool:
    """Iterate in place, with corrections below FARTHEST that shrink; whether it converged."""
    before = FARTHEST
    for _ in range(ITERATIONS):
        cells = loading.cells(system, rest)
        try:
            z = solve(cells.statics, -cells.residual.ravel()).reshape(-1, 3)
        except AnalysisError:
            return False
        change = float(np.abs(z[:, 0]).max())
        rest.iterations += 1
        settled = change <= 4 * np.finfo(float).eps or (change < NOISE and change >= before / 2)
        if not (settled or change < before):
            return False
        rest.phi = rest.phi + z[:, 0]
        rest.force = rest.force + z[:, 1:]
        rest.change = change
        if settled:
            return True
        before = change
    return False


def _signature(system: System, rest: Rest, loading: Loading) -> int:
    """How many motions are unstable without damping; beyond MOST_DENSE links the sign of the
    determinant of the stiffness, which tells odd changes alone."""
    cells = loading.cells(system, rest)
    if system.cells <= MOST_DENSE:
        dense = Pencil.of(cells).reduced()
        return int((np.linalg.eigvals(np.linalg.solve(dense.M, -dense.K)).real > 0).sum())
    factors = splu(sparse(cells.statics))
    signs = np.sign(factors.U.diagonal()).prod()
    return int(signs * _parity(factors.perm_r) * _parity(factors.perm_c))


def _parity(order: NDArray[Any]) -> int:
    """1 for an even permutation, -1 for an odd one."""
    left, cycles = np.ones(len(order), dtype=bool), 0
    for first in range(len(order)):
        cycles += bool(left[first])
        at = first
        while left[at]:
            left[at] = False
            at = int(order[at])
    return 1 if (len(order) - cycles) % 2 == 0 else -1
