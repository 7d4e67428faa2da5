"""The hand-assembled equations at one state, and what follows from them, in 50-digit numbers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from types import ModuleType
from typing import Any

import numpy as np
from mpmath import mp, mpf

from rodgen.derive.chain import BOUNDARIES
from rodgen.derive.closed_form import Arithmetic, ClosedForm, joint_drag, link_sizes

FIFTY_DIGITS = Arithmetic(
    mp.cos,
    mp.sin,
    mpf(1) / 2,
    lambda term, low, high: mp.fsum(term(q) for q in range(low, high + 1)),
)


class ByHand:
    """The hand-assembled equations of a module at one state, in mpmath numbers of the present
    precision."""

    def __init__(self, module: ModuleType, values: dict[str, Any], y: np.ndarray):
        self.n, self.terms = module.N, module.TERMS
        hold = BOUNDARIES[module.BOUNDARY]
        number = {k: mpf(float(v)) for k, v in values.items() if k != "fin_factor"}
        self.number = number
        self.fins = [mpf(float(f)) for f in values.get("fin_factor", [])]
        M, L, EI = (number[name] for name in ("mass", "length", "bending_stiffness"))
        self.m, self.l, self.k = sizes = link_sizes(M, L, EI, self.n)
        half, base = len(y) // 2, 2 * hold.translates
        q, u = [mpf(float(v)) for v in y[:half]], [mpf(float(v)) for v in y[half:]]
        held = hold.first
        self.u, self.hold = u, hold
        self.origin = (q[0], q[1]) if base else (mpf(0), mpf(0))
        self.v0 = (u[0], u[1]) if base else (mpf(0), mpf(0))
        self.phi = [number["clamp_angle"]] * held + q[base:] if held else q[base:]
        self.omega = [mpf(0)] * held + u[base:]
        self.lumped = module.INERTIA == "lumped"
        self.closed = ClosedForm(self.n, *sizes, self.phi, hold, FIFTY_DIGITS, self.lumped)
        # Every angle that a spring knows, with the stiffness between it and the next.
        root = [number["clamp_angle"]] if hold.root else []
        self.bent = root + self.phi
        self.stiffness = [self.closed.root * self.k] * len(root) + [self.k] * (self.n - 1)

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

    def moments(self) -> list[Any]:
        """Of the spring in every joint; zero where there is none."""
        bends = [b - a for a, b in pairwise(self.bent)]
        inner = [k * b for k, b in zip(self.stiffness, bends, strict=True)]
        return [*([mpf(0)] * (self.n - len(inner))), *inner, mpf(0)]

    def forces(self) -> dict[str, list[tuple[Any, Any]]]:
        """Of every load on every joint."""
        number, none = self.number, [(mpf(0), mpf(0))]
        out = {}
        if "follower" in self.terms:
            along = self.phi[-1] + number["follower_angle"]
            P = number["follower_force"]
            out["follower"] = none * self.n + [(-P * mp.cos(along), -P * mp.sin(along))]
        if "tip_load" in self.terms:
            tip = number["tip_force_x"], number["tip_force_y"]
            out["tip_load"] = none * self.n + [tip]
        if "external_damping" in self.terms:
            x, y = self.drag()
            moving = [(-x[s], -y[s]) for s in range(self.hold.first_joint, self.n + 1)]
            out["external_damping"] = none * self.hold.first_joint + moving
        return out

    def point_force(self, link: int, share: float, force: tuple[float, float]) -> list[Any]:
        """Force times the derivative of its point by every coordinate: all of a link before, and
        a share of its own."""
        fx, fy = map(mpf, force)
        arms = [mpf(1)] * link + [mpf(share)] + [mpf(0)] * (self.n - link - 1)
        turning = [
            arm * self.l * (fy * mp.cos(angle) - fx * mp.sin(angle))
            for arm, angle in zip(arms, self.phi, strict=True)
        ]
        return [*([fx, fy] if self.hold.translates else []), *turning[self.hold.first :]]

    def power(self) -> dict[str, Any]:
        return {term: _dot(force, self.u) for term, force in self.loads().items()}


def _times(matrix: list[list[Any]], vector: Sequence[Any]) -> list[Any]:
    return [_dot(row, vector) for row in matrix]


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return mp.fsum(x * y for x, y in zip(a, b, strict=True))


def _add(a: Sequence[Any], b: Sequence[Any], factor: int = 1) -> list[Any]:
    return [x + factor * y for x, y in zip(a, b, strict=True)]
