"""rodgen's right-hand side and exact Jacobian in C, for methods that are given them."""

from __future__ import annotations

from rodgen.judge.peers.stretches import Stretch
from rodgen.judge.precision.contestant import Array, Deadline
from rodgen.judge.precision.job import Job

EVERY = 256  # calls between two looks at the deadline


class Asked:
    """The rod of a job, and how often it was asked."""

    def __init__(self, job: Job):
        self.model, self.p = job.model, job.p
        self.rates = self.jacobians = 0
        self.stretch = Stretch(*job.span, job.times, 0)

    def begin(self) -> None:
        """Count from here."""
        self.rates = self.jacobians = 0

    def rhs(self, t: float, y: Array, out: Array | None = None) -> Array:
        """New rates each time, or in an array that is given."""
        self.rates += 1
        if self.rates % EVERY == 0:
            Deadline.look()
        rates: Array = self.model.rhs(self.stretch.inside(t), y, self.p, out)
        return rates

    def jac(self, t: float, y: Array) -> Array:
        """The exact Jacobian, dense."""
        self.jacobians += 1
        Deadline.look()
        jacobian: Array = self.model.jac(self.stretch.inside(t), y, self.p)
        return jacobian
