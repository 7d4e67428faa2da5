"""Newton's method for an equilibrium, and load stepping along its branch.

One state under the whole load is sought, which one to three runs of Newton's method find, through
changes of stability too; load steps locate nothing on their way. Folds, special points and other
branches are those of `continuation`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rodgen.analyse.equilibrium_equations import Balance, equilibrium_equations, stability_signature
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.analyse.support_springs import SoftSprings, SupportSprings
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.progress import report_stage

ITERATIONS = 40  # of Newton's method for one load
FARTHEST = 0.2  # rad of a correction that is taken, else the step is halved
SMALL = 1e-8  # of the way: what changes its stability over it does so on this branch
LEAST = 1e-10  # of the way, the smallest step
SMOOTH = 0.02  # of a step, on which a motion may become unstable
KINKED = 16.0  # times that, in the smallest steps
BENT = 0.5  # of a step, that a branch may bend away from its tangent in it
ASIDE = 2.0**-10  # of the way: a difference, of what is linear in it
FOLDED = 1e-3  # of the stiffness at the start: a branch that turns back after LEAST more of the way
OTHERS = "`rodgen static --all` finds those of other branches, a damped run the one it rests in"
CONTRACTED = 0.75  # of a correction, that the next one may be: else it leads elsewhere
EPS = float(np.finfo(float).eps)
ROUNDINGS = 16.0  # for every link, of the largest force of a support
NEAR = 1e-3  # rad: a correction below it may be rounding of such forces
NOISE = 1e-9  # rad: a correction below it that no longer shrinks is rounding


@dataclass
class Iterate:
    """Iterate of Newton's method for an equilibrium; change: the last correction of an angle [rad],
    or of the position of joint 0 over the length; pull: predicted forces of supports (k, 2) [N]."""

    at: Unknowns
    iterations: int = 0
    change: float = np.inf
    pull: Array | None = None

    def correct(self, rod: SteadyRod, p: Array, by: Unknowns, times: float = 1.0) -> None:
        """Correct the iterate, and predict the forces of its supports."""
        springs = SupportSprings.of(rod, p)
        self.pull = springs.predict_forces(self.at, by, times) if len(springs.links) else None
        self.at = self.at.add(by, times)

    def is_rounding(self, rod: SteadyRod, residual: Array) -> bool:
        """Whether a residual is rounding of the forces of supports."""
        if self.pull is None:
            return False
        forces = float(np.abs(self.pull).max()) * max(1.0, rod.scene.rod.length)
        return float(np.abs(residual).max()) <= ROUNDINGS * EPS * rod.n_moving * forces

    def springs(self, rod: SteadyRod, p: Array) -> SoftSprings | None:
        """Supports that pull by their predicted forces; None before any prediction."""
        return None if self.pull is None else SupportSprings.of(rod, p).soften(self.at, self.pull)


class FoldError(AnalysisError):
    """A branch turns back before the whole load."""


class Loading(NamedTuple):
    """Parameters of the module, and the residual to be reached instead of zero: moments, or
    accelerations and rates, that keep their value however the rod moves."""

    p: Array
    bend: Array | float = 0.0

    def equations(self, rod: SteadyRod, rest: Iterate) -> Balance:
        """Equilibrium equations at an iterate."""
        return equilibrium_equations(rod, rest.at, self.p, self.bend, rest.springs(rod, self.p))


def step_to_equilibrium(
    rod: SteadyRod, rest: Iterate, at: Callable[[float], Loading], way: str = "the load"
) -> tuple[Iterate, tuple[float, ...]]:
    """Follow the branch that begins with ``rest`` to its end; return the equilibrium there and the
    fractions of the way that were stepped through. at: loading at every fraction; way: its name.

    A step is taken where Newton's method converges without a large correction of the prediction
    by the tangent and its last change, and the branch turns little; where stability changes over
    the step, the branch has to be next to straight. Else the step is halved, so that no other
    branch is jumped to. Raises AnalysisError where the branch ends.
    """
    done, step, first = 0.0, 1.0, rest
    stages: list[float] = []
    here = at(0.0).equations(rod, rest)
    signature, slope = stability_signature(here), _tangent(here, at(ASIDE).equations(rod, rest))
    last, length = slope, np.inf  # the tangent before, and the step from there
    while done < 1:
        report_stage(f"{done:.3g} of {way}")
        fraction = min(done + step, 1.0)
        ahead = fraction - done
        trial = Iterate(rest.at, rest.iterations, pull=rest.pull)
        if slope is not None:
            trial.correct(rod, at(done).p, slope, ahead)
        guess = trial.at
        if slope is not None and last is not None:
            # As far again as over the step before, but never so far that it turns back.
            turned = _largest_angle_difference(slope, last)
            share = min(1.0, ahead / length, _largest(slope.phi) / turned if turned else 1.0)
            trial.at = guess.add(slope.add(last, -1.0), share * ahead / 2)
        taken, tangent = newton(rod, trial, at(fraction), passing=fraction < 1), None
        if taken:
            here = at(fraction).equations(rod, trial)
            tangent = _tangent(here, at(fraction + ASIDE).equations(rod, trial))
        bent, smooth = False, step < SMALL
        if slope is not None and tangent is not None:
            # Where branches meet, the other one is next to the tangent, but leads elsewhere.
            way_on = _largest_angle_difference(guess, rest.at)
            aside, turned = (
                _largest_angle_difference(trial.at, guess),
                _largest_angle_difference(tangent, slope) * ahead,
            )
            away, least = max(aside, turned / 2), FARTHEST * ahead
            smooth = smooth or away <= SMOOTH * way_on + NOISE
            # At a kink the tangent jumps, by no more in shorter steps; between branches by more.
            most = BENT * max(way_on, least) * (KINKED if step < SMALL else 1.0)
            bent = taken and away > most and 1 - done >= SMALL
            taken = taken and not bent
        found = stability_signature(here) if taken else signature
        if taken and (found == signature or smooth):
            last, length = slope, ahead
            rest, done, signature, slope = trial, fraction, found, tangent
            stages.append(fraction)
            step *= 2
        else:
            rest.iterations = trial.iterations
            step /= 2
        if step < LEAST:
            stiff, stiff_first = (
                _least_stiffness(at(f).equations(rod, r)) for f, r in ((done, rest), (0.0, first))
            )
            if stiff < FOLDED * stiff_first:
                raise FoldError(
                    f"no equilibrium beyond {done:.6g} of {way} on the branch of the unloaded rod, "
                    f"which turns back there: {OTHERS}"
                )
            why = "the branch bends too sharply" if bent else "Newton's method failed"
            raise AnalysisError(
                f"no equilibrium found beyond {done:.6g} of {way}: {why} from there for every "
                f"step down to {LEAST:g} of it ({rest.iterations} iterations)"
            )
    return rest, tuple(stages)


def newton(rod: SteadyRod, rest: Iterate, loading: Loading, passing: bool = False) -> bool:
    """Iterate in place; return whether it converged. Corrections stay below FARTHEST and shrink;
    passing: the state is only passed, and may need one more correction."""
    before = FARTHEST / CONTRACTED
    for _ in range(ITERATIONS):
        try:
            here = loading.equations(rod, rest)
            by = here.solve(-here.residual)
        except AnalysisError:
            return False
        change = max(_largest(by.phi), _largest(by.position) / rod.scene.rod.length)
        rest.iterations += 1
        rounded = change < NOISE or (change < NEAR and rest.is_rounding(rod, here.residual))
        settled = change <= 4 * EPS or (rounded and change >= before / 2)
        settled = settled or (passing and change * (change / before) ** 2 <= 4 * EPS)
        if not (settled or change < CONTRACTED * before):
            return False
        # Added states that no load depends on may come to rest later than the rod.
        settled = settled and _largest(by.added) <= NOISE * (1 + _largest(rest.at.added))
        rest.correct(rod, loading.p, by)
        rest.change = change
        if settled:
            return True
        before = change
    return False


def _tangent(here: Balance, further: Balance) -> Unknowns | None:
    """Derivative of an equilibrium along the way, from its equations here and ASIDE further; None
    where it does not exist."""
    try:
        return here.solve((here.residual - further.residual) / ASIDE)
    except AnalysisError:
        return None


def _largest_angle_difference(one: Unknowns, other: Unknowns) -> float:
    return _largest(one.phi - other.phi)


def _least_stiffness(here: Balance) -> float:
    """Smallest singular value of the stiffness, zero at a fold."""
    return float(np.linalg.svd(here.dense_pencil().S0, compute_uv=False).min(initial=np.inf))


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))
