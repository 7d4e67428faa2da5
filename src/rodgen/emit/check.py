"""A generated module against the hand-assembled form in 50-digit arithmetic.

The closed form is assembled entry by entry and solved by mpmath, so nothing is shared with the
module but its parameters and states.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
from mpmath import mp, mpf

from rodgen.derive.chain import BOUNDARIES
from rodgen.derive.closed_form import Arithmetic, ClosedForm, joint_drag
from rodgen.scene.expression import Expression

DIGITS = 50
LIMIT = 1e-10  # relative; about a thousand times what n = 50 reaches
FIFTY_DIGITS = Arithmetic(
    mp.cos,
    mp.sin,
    mpf(1) / 2,
    lambda term, low, high: mp.fsum(term(q) for q in range(low, high + 1)),
)


@dataclass(frozen=True)
class Deviation:
    """Largest relative error of one quantity over the states of one kind."""

    quantity: str
    states: str
    error: float


def check_module(module: ModuleType, states: int = 3, seed: int = 1) -> Iterator[Deviation]:
    """Compare all that a module computes at random states near to and far from straight.

    The error of a vector is its largest absolute error over its largest magnitude; that of
    energies or powers is taken relative to the largest among them.
    """
    draw = np.random.default_rng(seed)
    for kind, spread, speed in (("near straight", 1e-3, 1e-2), ("far from straight", 3.0, 3.0)):
        worst: dict[str, float] = {}
        for _ in range(states):
            values = _parameters(module, draw)
            y = _state(module, draw, spread, speed)
            t = float(draw.uniform(0.0, 1.0))
            for quantity, error in _compare(module, values, t, y):
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
    module: ModuleType, values: dict[str, Any], t: float, y: np.ndarray
) -> Iterator[tuple[str, float]]:
    """Every quantity of a module at one state, with its relative error."""
    timed = {
        name: float(Expression(text, "t")(t))
        for name, text in getattr(module, "EXPRESSIONS", {}).items()
    }
    p = module.parameters(**values)
    with mpmath.workdps(DIGITS):
        exact = _Exact(module, values | timed, y)
        yield "rhs", _vector_error(module.rhs(t, y, p), exact.rhs())
        mass = [entry for row in exact.closed.M() for entry in row]
        yield "mass matrix", _vector_error(module.mass_matrix(y, p).ravel(), mass)
        yield "energy", _vector_error(module.energy(y, p), exact.energy())
        if hasattr(module, "power"):
            power, by_hand = module.power(t, y, p), exact.power()
            yield "power", _vector_error([power[x] for x in power], [by_hand[x] for x in power])
        joints = [c for joint in exact.joints() for c in joint]
        yield "joints", _vector_error(module.joints(y, p).ravel(), joints)
        centre = exact.centre_of_gravity()
        yield "centre of gravity", _vector_error(module.centre_of_gravity(y, p), centre)
        yield "inertia", _vector_error(module.inertia(y, p), exact.inertia())


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
        # Every angle that a spring knows, with the stiffness between it and the next.
        root = [number["clamp_angle"]] if hold.root else []
        self.bent = root + self.phi
        self.stiffness = [hold.root * self.k] * len(root) + [self.k] * (self.n - 1)
        self.omega = [mpf(0)] * held + u[base:]
        sizes = (self.m, self.l, self.k)
        self.lumped = module.INERTIA == "lumped"
        self.closed = ClosedForm(self.n, *sizes, self.phi, hold, FIFTY_DIGITS, self.lumped)

    def rhs(self) -> list[Any]:
        closed, moving = self.closed, self.omega[self.hold.first :]
        total = _times(closed.Q(), [w**2 for w in moving])
        total = _add(total, _times(closed.K(), self.bent), -1)
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
        if "tip_load" in self.terms:
            out["tip_load"] = closed.T((number["tip_force_x"], number["tip_force_y"]))
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
        velocities = self._running(self.v0, self.closed.velocity_step, self.omega)
        for s in range(self.hold.first_joint, self.n + 1):
            links = [self.phi[q] for q in (s - 1, s) if 0 <= q < self.n]
            mass = self.m * len(links) / 2
            angle = sum(links) / len(links)
            c_ext = self.number["external_damping"]
            force = joint_drag(c_ext, self.fins[s], mass, velocities[s], angle, mp)
            D[0][s], D[1][s] = force
        return D

    def energy(self) -> list[Any]:
        kinetic = _dot(self.u, _times(self.closed.M(), self.u)) / 2
        bends = [b - a for a, b in pairwise(self.bent)]
        spring = mp.fsum(k * b**2 / 2 for k, b in zip(self.stiffness, bends, strict=True))
        heavy = "gravity" in self.terms
        height = self.centre_of_gravity()[1]
        gravity = self.n * self.m * self.number["gravity"] * height if heavy else mpf(0)
        return [kinetic, spring, gravity]

    def joints(self) -> list[tuple[Any, Any]]:
        """Positions of the joints."""
        return self._running(self.origin, self.closed.joint_step)

    def centre_of_gravity(self) -> tuple[Any, Any]:
        """Mean of the middles of the links."""
        x, y = zip(*self._middles(), strict=True)
        return mp.fsum(x) / self.n, mp.fsum(y) / self.n

    def inertia(self) -> list[Any]:
        """Moments and product of inertia: those of thin links or of two halves at the ends of
        massless ones, and of their middles (Steiner)."""
        X, Y = self.centre_of_gravity()
        own = self.m * self.l**2 / (4 if self.lumped else 12)
        x, y, xy = mpf(0), mpf(0), mpf(0)
        for (a, b), angle in zip(self._middles(), self.phi, strict=True):
            c, s = mp.cos(angle), mp.sin(angle)
            x += own * s**2 + self.m * (b - Y) ** 2
            y += own * c**2 + self.m * (a - X) ** 2
            xy += own * s * c + self.m * (a - X) * (b - Y)
        return [x, y, xy]

    def _middles(self) -> list[tuple[Any, Any]]:
        joints = self.joints()
        return [((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in pairwise(joints)]

    def _running(
        self, start: tuple[Any, Any], step: Any, *of_link: Sequence[Any]
    ) -> list[tuple[Any, Any]]:
        """Joint by joint from the start, with the step of every link."""
        values = [start]
        for link in range(self.n):
            dx, dy = step(link, *(of[link] for of in of_link))
            values.append((values[-1][0] + dx, values[-1][1] + dy))
        return values

    def power(self) -> dict[str, Any]:
        return {term: _dot(force, self.u) for term, force in self.loads().items()}


def _times(matrix: list[list[Any]], vector: Sequence[Any]) -> list[Any]:
    return [_dot(row, vector) for row in matrix]


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return mp.fsum(x * y for x, y in zip(a, b, strict=True))


def _add(a: Sequence[Any], b: Sequence[Any], factor: int = 1) -> list[Any]:
    return [x + factor * y for x, y in zip(a, b, strict=True)]
