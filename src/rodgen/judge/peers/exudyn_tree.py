"""Exudyn: its kinematic tree of a scene, by its implicit and explicit methods."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rodgen.judge.peers import loads
from rodgen.judge.peers.agreement import agreed
from rodgen.judge.peers.deadline import stopped
from rodgen.judge.peers.exudyn_model import Rod
from rodgen.judge.peers.settings import fastest, stable, steps
from rodgen.judge.peers.stretches import Stretch, integrated, runs
from rodgen.judge.peers.tree import KNOWN
from rodgen.judge.precision.contestant import Array, Contestant, Finish, NotModelledError
from rodgen.judge.precision.job import SAMPLES, Job

LARGEST = 100  # links: mass matrices are full, and derivatives are made by differences
LARGEST_EXPLICIT = 200


def generalized_alpha(job: Job, quick: bool) -> Iterator[Contestant]:
    """The generalized-alpha method, Exudyn's own choice, with its spectral radius of 0.9."""
    first, last = job.span
    check(job, LARGEST)
    longest = (last - first) / SAMPLES
    return _fixed(job, "generalized-alpha", "GeneralizedAlpha", 2.0, longest, quick)


def rk44(job: Job, quick: bool) -> Iterator[Contestant]:
    """The classical Runge-Kutta method of fourth order."""
    check(job, LARGEST_EXPLICIT)
    return _fixed(job, "RK44", "RK44", 4.0, stable(2.8, fastest(job).rate), quick)


def check(job: Job, most: int) -> None:
    """Raise NotModelledError for what Exudyn cannot model, or not in time."""
    loads.refuse("Exudyn", job.scene, KNOWN)
    if job.scene.rod.links > most:
        raise NotModelledError(f"Exudyn: full matrices, too slow for more than {most} links")


def _fixed(
    job: Job, method: str, solver: str, order: float, limit: float, quick: bool
) -> Iterator[Contestant]:
    rod = Rod(job)
    off = agreed(job, rod.accelerations)

    def contestant(step: float) -> Contestant:
        return Contestant(
            "Exudyn",
            method,
            "Exudyn",
            "step",
            step,
            lambda: _integrate(job, rod, solver, step),
            order=order,
            agreed=off,
        )

    return (contestant(step) for step in steps(job, limit, quick))


def _integrate(job: Job, rod: Rod, solver: str, step: float) -> Finish:
    rod.steps = 0

    def over(stretch: Stretch, y: Array) -> Array:
        rod.enter(stretch, y)
        return np.concatenate([run(before, times) for before, times in runs(stretch)])

    def run(before: float, times: Array) -> Array:
        each = max(1, int(np.ceil((times[0] - before) / step * (1 - 1e-9))))
        return rod.run(solver, before, times, each)

    with stopped():
        y = integrated(job, over)
    if not np.isfinite(y).all():
        raise ArithmeticError("states that are no numbers")
    return Finish(y, {"steps": rod.steps})
