"""The equilibrium at the end of a branch: Newton's method, the way to it, and which motions grow.

What is asked for is one state under the whole load, which one to three runs of Newton's method
find, through changes of stability too: `follow` steps in the load and locates nothing on its way.
Folds, special points and other branches are those of `continuation`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.balance import MOST_DENSE, Balance, balance
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.pencil import Dense, first_order
from rodgen.analyse.system import System, Unknowns
from rodgen.integrate.stepper import Array

ITERATIONS = 40  # of Newton's method for one load
FARTHEST = 0.2  # rad of a correction that is taken, else the step is halved
SMALL = 1e-4  # of the way: what changes its stability over it does so on this branch
LEAST = 1e-6  # of the way, the smallest step
NOISE = 1e-9  # rad: a correction below it that no longer shrinks is rounding
FLUTTER, DIVERGENCE = "flutter", "divergence"
# Shares of the largest eigenvalue down to which a matrix and its inverse have the others well:
# together they reach over twelve decades, of which 200 links take ten.
OF_MATRIX, OF_INVERSE = 1e-8, 1e-4
ROUNDING = 1e-13  # times links squared, of the other squared rates: the slowest is zero
GROWTH, SLOWEST = 1e-7, 1e-12  # of a rate, and of the largest: less growth may be rounding
DOUBLE = 1e-7  # times links, of a squared rate: imaginary parts that a double root may show


@dataclass
class Rest:
    """A rod on its way to an equilibrium; change: the last correction of an angle [rad], or of the
    position of joint 0 over the length."""

    at: Unknowns
    iterations: int = 0
    change: float = np.inf


class Loading(NamedTuple):
    """Parameters of the module, and what the residual of rest is to be instead of zero: moments,
    or accelerations and rates, that keep their value however the rod moves."""

    p: Array
    bend: Array | float = 0.0

    def balance(self, system: System, rest: Rest) -> Balance:
        """The equations of rest, in which an equilibrium has no residual."""
        return balance(system, rest.at, self.p, self.bend)


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
    signature = at(0.0).balance(system, rest).signature()
    slope = None
    while done < 1:
        fraction = min(done + step, 1.0)
        trial = Rest(rest.at, rest.iterations)
        if slope is not None:
            trial.at = trial.at.moved(slope, fraction - done)
        taken = newton(system, trial, at(fraction))
        found = at(fraction).balance(system, trial).signature() if taken else signature
        if taken and (found == signature or step < SMALL):
            change = Unknowns(*(np.zeros_like(part) for part in rest.at))
            change = change.moved(trial.at).moved(rest.at, -1.0)
            slope = Unknowns(*(part / (fraction - done) for part in change))
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
        try:
            here = loading.balance(system, rest)
            by = here.solved(-here.residual)
        except AnalysisError:
            return False
        change = max(_largest(by.phi), _largest(by.position) / system.scene.rod.length)
        rest.iterations += 1
        settled = change <= 4 * np.finfo(float).eps or (change < NOISE and change >= before / 2)
        if not (settled or change < before):
            return False
        # What no load follows may come to rest later than the rod.
        settled = settled and _largest(by.added) <= NOISE * (1 + _largest(rest.at.added))
        rest.at = rest.at.moved(by)
        rest.change = change
        if settled:
            return True
        before = change
    return False


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


def instability(system: System, rest: Rest, p: Array) -> str | None:
    """What small motions do: "divergence" where one grows without oscillating, "flutter" where one
    oscillates more and more, "" where none grows; None where that was not looked at, beyond 200
    links. Damping counts only where loads follow the motion or states are added.

    The slow motions come from the inverse, where they lose as many roundings as there are links,
    squared: the growth just above a critical load is told from zero to that, the slowest motion's
    alone.
    """
    if system.cells > MOST_DENSE:
        return None
    dense = balance(system, rest.at, p).dense()
    if dense.added or dense.damped:
        return _growing(dense)
    squares = np.concatenate(
        (
            _beyond(np.linalg.solve(dense.M, -dense.K), OF_MATRIX),
            1 / _beyond(_inverse(dense.K, dense.M), OF_INVERSE, ROUNDING * system.cells**2),
        )
    )
    turned = np.abs(squares.imag) > DOUBLE * system.cells * np.abs(squares)
    if (~turned & (squares.real > 0)).any():
        return DIVERGENCE
    return FLUTTER if turned.any() else ""


def _growing(dense: Dense) -> str:
    """By what follows rates as well; growth that rounding may make is none."""
    s = np.linalg.eigvals(first_order(*dense.parts, dense.added)).astype(complex)
    size = np.abs(s)
    grows = s.real > GROWTH * size + SLOWEST * size.max(initial=0.0)
    if (grows & (np.abs(s.imag) <= GROWTH * size)).any():
        return DIVERGENCE
    return FLUTTER if grows.any() else ""


def _inverse(K: Array, M: Array) -> Array:
    """-K^-1 M; of a singular K, exactly at the onset, nothing."""
    try:
        return np.asarray(np.linalg.solve(-K, M))
    except np.linalg.LinAlgError:
        return np.zeros((0, 0))


def _beyond(matrix: Array, share: float, rounded: float = 0.0) -> NDArray[Any]:
    """Eigenvalues that are larger than this share of the largest; none, where that is so much
    larger than all others that its sign is rounding, which spoils them too."""
    values = np.linalg.eigvals(matrix).astype(complex)
    size = np.abs(values)
    largest, others = size.max(initial=0.0), np.sort(size)[:-1].max(initial=0.0)
    if 0 < others < rounded * largest:
        return values[:0]
    return np.asarray(values[size > share * largest])
