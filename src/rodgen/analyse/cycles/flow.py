"""The motion from a state on, and how small changes of that state are carried along."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np

from rodgen.analyse.cycles.quotient import Quotient
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.integrate.stability import dominant, limit
from rodgen.integrate.stepper import StepError
from rodgen.integrate.variations import Steps, Variations

# A period is to be right to 1e-8, a trivial multiplier as well. Radau's errors are a hundredth of
# what it is allowed, measured on stiff cycles of 20 to 200 links.
TOLERANCES = {"dop853": (1e-11, 1e-14), "radau": (1e-9, 1e-12)}
MANY = 7_000  # steps of dop853 in a period, beyond which those of radau are fewer and cheaper
ABSENT = 0.3  # damping ratio from which the fastest motion, gone before the cycle, stays away


@dataclass(frozen=True)
class Flow:
    """Motions of a module with parameters p, of the states that count in a quotient; method: of
    the steps, one of TOLERANCES."""

    model: ModuleType
    p: Array
    quotient: Quotient
    method: str = "dop853"

    def suited(self, t: float, x: Array, period: float) -> Flow:
        """With the steps that cost less about a state, over a period [s]: those of dop853 are as
        short as the fastest motion asks for, though it may have died out."""
        if not hasattr(self.model, "VARIATIONS"):
            return self
        fastest = dominant(self.model, t, self.quotient.lifted(x), self.p)
        steps = period / limit("dop853", fastest.value, fastest.partner)
        stiff = fastest.damping > ABSENT and steps > MANY
        return replace(self, method="radau" if stiff else "dop853")

    def rates(self, t: float, x: Array) -> Array:
        """Of the states that count (size,) at time t [s]."""
        f: Array = self.model.rhs(t, self.quotient.lifted(x), self.p)[self.quotient.kept]
        return f

    def jacobian(self, t: float, x: Array) -> Array:
        """Derivatives of the rates (size, size) at a state (size,)."""
        J: Array = self.derivatives(np.array([t]), x[None])[1][0]
        return J

    def derivatives(self, t: Array, X: Array) -> tuple[Array, Array]:
        """Rates (K, size) of states X (K, size) at times t (K,) [s], and their derivatives
        (K, size, size)."""
        kept, model, p = self.quotient.kept, self.model, self.p
        states = list(zip(t.tolist(), self.quotient.lifted(X), strict=True))
        f = np.array([model.rhs(at, y, p) for at, y in states])[:, kept]
        J = np.array([model.jac(at, y, p) for at, y in states])
        return f, J if len(kept) == J.shape[1] else J[:, kept[:, None], kept]

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
        rtol, atol = TOLERANCES[self.method]
        steps = Steps(self.method, rtol=rtol, atol=atol)
        try:
            motion = Variations(self.model, self.p, t, y, directions, steps)
            motion.on(t + span)
        except StepError as error:
            raise AnalysisError(f"the motion cannot be followed: {error}") from None
        end, grown = motion.y[kept], motion.tangents[:, kept].T
        if not (np.isfinite(end).all() and np.isfinite(grown).all()):
            raise AnalysisError("the motion cannot be followed: it leaves the range of numbers")
        return end, grown
