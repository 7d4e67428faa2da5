"""A generated module against the hand-assembled form in 50-digit arithmetic.

The closed form is assembled entry by entry and solved by mpmath, so nothing is shared with the
module but its parameters and states.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
from mpmath import mp, mpf

from rodgen.derive.chain import BOUNDARIES
from rodgen.derive.closed_form import ClosedForm, joint_drag, joint_velocity

DIGITS = 50
LIMIT = 1e-10  # relative; about a thousand times what n = 50 reaches


@dataclass(frozen=True)
class Deviation:
    """Largest relative error of one quantity over the states of one kind."""

    quantity: str
    states: str
    error: float


def check_module(module: ModuleType, states: int = 3, seed: int = 1) -> Iterator[Deviation]:
    """Compare rhs, energy and power at random states near to and far from straight.

    The error of a vector is its largest absolute error over its largest magnitude; that of an
    energy or a power is taken relative to the largest magnitude among its parts.
    """
    draw = np.random.default_rng(seed)
    for kind, spread, speed in (("near straight", 1e-3, 1e-2), ("far from straight", 3.0, 3.0)):
        worst: dict[str, float] = {}
        for _ in range(states):
            values = _parameters(module, draw)
            y = _state(module, draw, spread, speed)
            for quantity, error in _compare(module, values, y):
                worst[quantity] = max(worst.get(quantity, 0.0), error)
        for quantity, error in worst.items():
            yield Deviation(quantity, kind, error)


def _parameters(module: ModuleType, draw: np.random.Generator) -> dict[str, Any]:
    names = [name for name in module.PARAMETERS if not name.startswith("fin_factor")]
    values: dict[str, Any] = {name: float(draw.uniform(0.5, 5.0)) for name in names}
    values["bending_stiffness"] *= 20.0
    if "external_damping" in module.TERMS:
        values["fin_factor"] = draw.uniform(0.5, 5.0, module.N + 1)
    return values


def _state(
    module: ModuleType, draw: np.random.Generator, spread: float, speed: float
) -> np.ndarray:
    half = len(module.STATE) // 2
    angle = draw.uniform(-3, 3)
    y = np.empty(2 * half)
    y[:half] = angle + spread * draw.standard_normal(half)
    y[half:] = speed * draw.standard_normal(half)
    return y


def _compare(
    module: ModuleType, values: dict[str, Any], y: np.ndarray
) -> Iterator[tuple[str, float]]:
    with mpmath.workdps(DIGITS):
        exact = _Exact(module, values, y)
        p = module.parameters(**values)
        yield "rhs", _vector_error(module.rhs(0.0, y, p), exact.rhs())
        yield "energy", _vector_error(module.energy(y, p), exact.energy())
        if hasattr(module, "power"):
            power = module.power(0.0, y, p)
            by_hand = exact.power()
            yield "power", _vector_error([power[t] for t in power], [by_hand[t] for t in power])


def _vector_error(got: Sequence[Any], exact: Sequence[Any]) -> float:
    largest = max(abs(e) for e in exact)
    if not all(np.isfinite(float(g)) for g in got):
        return float("inf")
    off = max(abs(mpf(float(g)) - e) for g, e in zip(got, exact, strict=True))
    return float(off / largest) if largest else float(off)


class _Exact:
    """The hand-assembled equations of a module at one state, in mpmath numbers."""

    def __init__(self, module: ModuleType, values: dict[str, Any], y: np.ndarray):
        self.n, self.terms = module.N, module.TERMS
        hold = BOUNDARIES[module.BOUNDARY]
        number = {k: mpf(float(v)) for k, v in values.items() if k != "fin_factor"}
        self.number = number
        self.fins = [mpf(float(f)) for f in values.get("fin_factor", [])]
        self.m, self.l = number["mass"] / self.n, number["length"] / self.n
        self.k = number["bending_stiffness"] / self.l
        half, base = len(y) // 2, 2 * hold.translates
        q, u = [mpf(float(v)) for v in y[:half]], [mpf(float(v)) for v in y[half:]]
        held = hold.first
        self.u, self.hold = u, hold
        self.origin = (q[0], q[1]) if base else (mpf(0), mpf(0))
        self.v0 = (u[0], u[1]) if base else (mpf(0), mpf(0))
        self.phi = [number["clamp_angle"]] * held + q[base:] if held else q[base:]
        self.omega = [mpf(0)] * held + u[base:]
        self.closed = ClosedForm(
            self.n,
            self.m,
            self.l,
            self.k,
            self.phi,
            mp.cos,
            mp.sin,
            mpf(1) / 2,
            lambda term, low, high: mp.fsum(term(q) for q in range(low, high + 1)),
            hold.translates,
            hold.first,
        )

    def rhs(self) -> list[Any]:
        closed, moving = self.closed, self.omega[self.hold.first :]
        total = _times(closed.Q(), [w**2 for w in moving])
        total = _add(total, _times(closed.K(), self.phi), -1)
        for load in self.loads().values():
            total = _add(total, load)
        rates = mp.lu_solve(mp.matrix(closed.M()), mp.matrix(total))
        return [*self.u, *rates]

    def loads(self) -> dict[str, list[Any]]:
        """Generalised forces by term."""
        number, closed = self.number, self.closed
        out: dict[str, list[Any]] = {}
        if "follower" in self.terms:
            out["follower"] = closed.F(number["follower_force"], number["follower_angle"])
        if "gravity" in self.terms:
            out["gravity"] = closed.A(number["gravity"])
        if "internal_damping" in self.terms:
            moving = self.omega[self.hold.first :]
            matrix = closed.D_i(number["internal_damping"])
            out["internal_damping"] = [-e for e in _times(matrix, moving)]
        if "external_damping" in self.terms:
            out["external_damping"] = [-e for e in closed.D_e(self.drag())]
        return out

    def drag(self) -> tuple[dict[int, Any], dict[int, Any]]:
        D: tuple[dict[int, Any], dict[int, Any]] = ({}, {})
        for s in range(self.closed.first_joint, self.n + 1):
            links = [self.phi[q] for q in (s - 1, s) if 0 <= q < self.n]
            mass = self.m * len(links) / 2
            v = joint_velocity(s, self.l, self.phi, self.omega, self.v0, mp)
            angle = sum(links) / len(links)
            force = joint_drag(self.number["external_damping"], self.fins[s], mass, v, angle, mp)
            D[0][s], D[1][s] = force
        return D

    def energy(self) -> list[Any]:
        kinetic = _dot(self.u, _times(self.closed.M(), self.u)) / 2
        bends = [b - a for a, b in zip(self.phi, self.phi[1:], strict=False)]
        spring = mp.fsum(self.k * b**2 / 2 for b in bends)
        gravity, height = mpf(0), self.origin[1]
        for angle in self.phi:
            gravity += self.m * (height + self.l * mp.sin(angle) / 2)
            height += self.l * mp.sin(angle)
        g = self.number.get("gravity", mpf(0)) if "gravity" in self.terms else mpf(0)
        return [kinetic, spring, gravity * g]

    def power(self) -> dict[str, Any]:
        return {term: _dot(force, self.u) for term, force in self.loads().items()}


def _times(matrix: list[list[Any]], vector: Sequence[Any]) -> list[Any]:
    return [_dot(row, vector) for row in matrix]


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return mp.fsum(x * y for x, y in zip(a, b, strict=True))


def _add(a: Sequence[Any], b: Sequence[Any], factor: int = 1) -> list[Any]:
    return [x + factor * y for x, y in zip(a, b, strict=True)]
