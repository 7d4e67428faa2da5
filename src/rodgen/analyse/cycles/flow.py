"""The motion from a state on, and how small changes of that state are carried along."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import ModuleType

import numpy as np

from rodgen.analyse.cycles.quotient import Quotient
from rodgen.analyse.errors import AnalysisError
from rodgen.integrate.stepper import Array, StepError
from rodgen.integrate.variations import Steps, Variations

RTOL, ATOL = 1e-11, 1e-14  # a period is to be right to 1e-8, a trivial multiplier as well
NUDGE = 1e-4  # of a parameter: central differences of it err by the square, 1e-8


@dataclass(frozen=True)
class Flow:
    """Motions of a module with parameters p, of the states that count in a quotient.

    rtol, atol: of the integration.
    """

    model: ModuleType
    p: Array
    quotient: Quotient
    rtol: float = field(default=RTOL, kw_only=True)
    atol: float = field(default=ATOL, kw_only=True)

    def at(self, p: Array) -> Flow:
        """With other parameters."""
        return replace(self, p=p)

    def rates(self, t: float, x: Array) -> Array:
        """Of the states that count (size,) at time t [s]."""
        f: Array = self.model.rhs(t, self.quotient.lifted(x), self.p)[self.quotient.kept]
        return f

    def carried(self, t: float, x: Array, span: float) -> Array:
        """The state (size,) after a span [s] from x at time t on. Raises AnalysisError."""
        return self._gone(t, x, span, np.zeros((len(x), 0)))[0]

    def with_tangents(
        self, t: float, x: Array, span: float, V: Array | None = None
    ) -> tuple[Array, Array]:
        """The state (size,) after a span [s], and what directions V (size, k), by default all, have
        become (size, k). Raises AnalysisError."""
        return self._gone(t, x, span, np.eye(len(x)) if V is None else V)

    def _gone(self, t: float, x: Array, span: float, V: Array) -> tuple[Array, Array]:
        kept = self.quotient.kept
        y = self.quotient.lifted(x)
        directions = np.zeros((V.shape[1], len(y)))
        directions[:, kept] = V.T
        steps = Steps(rtol=self.rtol, atol=self.atol)
        try:
            motion = Variations(self.model, self.p, t, y, directions, steps)
            motion.on(t + span)
        except StepError as error:
            raise AnalysisError(f"the motion cannot be followed: {error}") from None
        end, grown = motion.y[kept], motion.tangents[:, kept].T
        if not (np.isfinite(end).all() and np.isfinite(grown).all()):
            raise AnalysisError("the motion cannot be followed: it leaves the range of numbers")
        return end, grown
