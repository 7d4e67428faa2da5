"""Flow of a module: the motion from a state on, the tangents that it carries along, and what it
conserves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np

from rodgen.analyse.cycles.symmetry import SymmetryReduction
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.integrate.stability import dominant, step_limit
from rodgen.integrate.stepper import StepError
from rodgen.integrate.variations import StepSettings, Variations

# A period is to be right to 1e-8, a trivial multiplier as well. Radau's errors are a hundredth of
# what it is allowed, measured on stiff cycles of 20 to 200 links.
TOLERANCES = {"dop853": (1e-11, 1e-14), "radau": (1e-9, 1e-12)}
MANY = 7_000  # steps of dop853 in a period, beyond which those of radau are fewer and cheaper
NUDGE = 1e-5  # of differences of the gradient of what is conserved: errors are its square
ABSENT = 0.3  # damping ratio from which the fastest motion, gone before the cycle, stays away


@dataclass(frozen=True)
class Flow:
    """Flow of a module with parameters p on the reduced states of a quotient; method: of the steps,
    one of TOLERANCES."""

    model: ModuleType
    p: Array
    quotient: SymmetryReduction
    method: str = "dop853"

    def choose_method(self, t: float, x: Array, period: float) -> Flow:
        """Choose the cheaper method about a state, for a period [s]: steps of dop853 are as short
        as the fastest motion asks for, though it may have died out."""
        if not hasattr(self.model, "VARIATIONS"):
            return self
        fastest = dominant(self.model, t, self.quotient.lift(x), self.p)
        steps = period / step_limit("dop853", fastest.value, fastest.partner)
        stiff = fastest.damping > ABSENT and steps > MANY
        return replace(self, method="radau" if stiff else "dop853")

    def rates(self, t: float, x: Array) -> Array:
        """Rates of the reduced states (size,) at time t [s]."""
        f: Array = self.model.rhs(t, self.quotient.lift(x), self.p)[self.quotient.kept]
        return f

    def jacobian(self, t: float, x: Array) -> Array:
        """Derivatives of the rates (size, size) at a state (size,)."""
        J: Array = self.derivatives(np.array([t]), x[None])[1][0]
        return J

    def derivatives(self, t: Array, X: Array) -> tuple[Array, Array]:
        """Rates (K, size) of states X (K, size) at times t (K,) [s], and their derivatives
        (K, size, size)."""
        kept, model, p = self.quotient.kept, self.model, self.p
        states = list(zip(t.tolist(), self.quotient.lift(X), strict=True))
        f = np.array([model.rhs(at, y, p) for at, y in states])[:, kept]
        J = np.array([model.jac(at, y, p) for at, y in states])
        return f, J if len(kept) == J.shape[1] else J[:, kept[:, None], kept]

    def state_after(self, t: float, x: Array, span: float) -> Array:
        """State (size,) after a span [s], from x at time t on. Raises AnalysisError."""
        return self.state_and_tangents_after(t, x, span, np.zeros((len(x), 0)))[0]

    def segment_states(self, t: float, x: Array, period: float, segments: int) -> Array:
        """States (segments, size) at the starts of equal segments of a period [s], from x at time t
        on. Raises AnalysisError."""
        states, share = [x], period / segments
        for i in range(segments - 1):
            states.append(self.state_after(t + i * share, states[-1], share))
        return np.array(states)

    def state_and_tangents_after(
        self, t: float, x: Array, span: float, V: Array | None = None
    ) -> tuple[Array, Array]:
        """State (size,) after a span [s], and the directions V (size, k), by default all, carried
        along with it (size, k). Raises AnalysisError."""
        V, kept = np.eye(len(x)) if V is None else V, self.quotient.kept
        y = self.quotient.lift(x)
        directions = np.zeros((V.shape[1], len(y)))
        directions[:, kept] = V.T
        rtol, atol = TOLERANCES[self.method]
        steps = StepSettings(self.method, rtol=rtol, atol=atol)
        try:
            motion = Variations(self.model, self.p, t, y, directions, steps)
            motion.advance_to(t + span)
        except StepError as error:
            raise AnalysisError(f"the motion cannot be followed: {error}") from None
        end, grown = motion.y[kept], motion.tangents[:, kept].T
        if not (np.isfinite(end).all() and np.isfinite(grown).all()):
            raise AnalysisError("the motion cannot be followed: it leaves the range of numbers")
        return end, grown


@dataclass(frozen=True)
class ConservedQuantities:
    """Conserved quantities of a flow without dissipation: energy and, where the rod may be turned,
    angular momentum; of a free rod relative to its centre of gravity."""

    flow: Flow

    def values(self, x: Array) -> Array:
        """Energy [J] and, where the rod may be turned, angular momentum [kg m^2/s], (k,)."""
        flow, q = self.flow, self.flow.quotient
        y = q.lift(x)
        half = len(y) // 2
        mass = flow.model.mass_matrix(y, flow.p)
        inner = np.setdiff1d(np.arange(half), q.kept[: q.positions])
        own = q.kept[: q.positions]
        if len(inner):  # joint 0 moves so that the centre of gravity rests
            lean = np.linalg.solve(mass[np.ix_(inner, inner)], mass[np.ix_(inner, own)])
            mass = mass[np.ix_(own, own)] - mass[np.ix_(own, inner)] @ lean
        u = x[q.positions :]
        at_rest = y.copy()
        at_rest[half:] = 0.0
        _, spring, gravity = flow.model.energy(at_rest, flow.p)
        potential = spring if len(inner) else spring + gravity
        energy = 0.5 * float(u @ mass @ u) + float(potential)
        turned = [float(q.turning(x)[: q.positions] @ mass @ u)] if q.turns else []
        return np.array([energy, *turned])

    def gradients(self, x: Array) -> Array:
        """Derivatives of the conserved quantities by the state (k, size)."""
        columns = []
        for k in range(len(x)):
            d = np.zeros(len(x))
            d[k] = NUDGE * max(1.0, float(np.abs(x).max()))
            columns.append((self.values(x + d) - self.values(x - d)) / (2 * d[k]))
        return np.array(columns).T
