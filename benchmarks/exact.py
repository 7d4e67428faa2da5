"""The accelerations of a free uniform rod in 50-digit arithmetic, in O(n).

Newton and Euler for every link with the joint forces as unknowns, eliminated from the first joint
to the last; all loads of the thesis. Shares nothing with what is generated, and `verified` holds
it against the closed form of the mass matrix, solved densely.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
from mpmath import matrix, mp, mpf
from problem import ALL, VALUES, Vector, built, state

from rodgen.emit.by_hand import ByHand
from rodgen.emit.check import DIGITS


def exact_rhs(links: int, terms: tuple[str, ...], y: Vector) -> list[Any]:
    """dy/dt as mpmath numbers, for the values of `problem` and fin factors of one."""
    with mpmath.workdps(DIGITS):
        return _Rod(links, terms, y).rhs()


def error(dy: Vector, exact: list[Any]) -> float:
    """Largest error of the accelerations over their largest magnitude."""
    half = len(exact) // 2
    with mpmath.workdps(DIGITS):
        off = max(abs(mpf(float(a)) - e) for a, e in zip(dy[half:], exact[half:], strict=True))
        return float(off / max(abs(e) for e in exact[half:]))


@lru_cache(maxsize=1)
def verified(links: int = 20) -> float:
    """Largest relative difference from the dense closed form, in 50-digit arithmetic."""
    module: ModuleType = built(links, ALL)
    values: dict[str, Any] = {**VALUES, "fin_factor": np.ones(links + 1)}
    y = state(links, spread=1.0, speed=1.0)
    with mpmath.workdps(DIGITS):
        dense = ByHand(module, values, y).rhs()
        ours = exact_rhs(links, ALL, y)
        return float(mp.norm(matrix(ours) - matrix(dense), mp.inf) / mp.norm(dense, mp.inf))


class _Rod:
    """One state of a rod, link by link. Pairs are columns of two."""

    def __init__(self, links: int, terms: tuple[str, ...], y: Vector):
        self.n, self.terms = links, terms
        self.value: Mapping[str, Any] = {name: mpf(value) for name, value in VALUES.items()}
        self.m, self.l = self.value["mass"] / links, self.value["length"] / links
        self.J = self.m * self.l**2 / 12
        q = [mpf(float(value)) for value in y]
        half = links + 2
        self.u, self.phi, self.omega = q[half:], q[2:half], q[half + 2 :]
        self.e = [matrix([mp.cos(a), mp.sin(a)]) for a in self.phi]
        self.normal = [matrix([-e[1], e[0]]) for e in self.e]
        self.force = [matrix([0, 0]) for _ in self.phi]
        self.moment = [mpf(0) for _ in self.phi]

    def rhs(self) -> list[Any]:
        self.load()
        # What the ends of a link are accelerated by without joint forces, times m, beyond force.
        w = [
            6 / self.l * M * n - self.m * self.l / 2 * o**2 * e
            for M, n, o, e in zip(self.moment, self.normal, self.omega, self.e, strict=True)
        ]
        forces = self.joint_forces(w)
        alpha = [
            (M - self.l / 2 * _dot(n, before + after)) / self.J
            for M, n, before, after in zip(
                self.moment, self.normal, forces, forces[1:], strict=False
            )
        ]
        middle = (self.force[0] - forces[1]) / self.m
        turning = self.omega[0] ** 2 * self.e[0] - alpha[0] * self.normal[0]
        return [*self.u, *(middle + self.l / 2 * turning), *alpha]

    def joint_forces(self, w: list[Any]) -> list[Any]:
        """On the later link of every joint, from the earlier one; none at both ends."""
        E = [3 * n * n.T - mp.eye(2) for n in self.normal]
        passed: list[tuple[Any, Any]] = []  # force = q - G next force
        for j in range(1, self.n):
            D = E[j - 1] + E[j] + 4 * mp.eye(2)
            r = self.force[j - 1] - self.force[j] + w[j - 1] + w[j]
            if passed:
                D -= E[j - 1] * passed[-1][0]
                r -= E[j - 1] * passed[-1][1]
            inverse = D**-1
            passed.append((inverse * E[j], inverse * r))
        forces = [matrix([0, 0])]
        for G, q in reversed(passed):
            forces.append(q - G * forces[-1])
        return [matrix([0, 0]), *reversed(forces)]

    def load(self) -> None:
        """Forces at the middle of every link, and moments about it."""
        k, last = self.value["bending_stiffness"] / self.l, self.n - 1
        damping = self.value["internal_damping"] * self.m if "internal_damping" in self.terms else 0
        for i in range(last):
            bent, rate = self.phi[i + 1] - self.phi[i], self.omega[i + 1] - self.omega[i]
            self.moment[i] += k * bent + damping * rate
            self.moment[i + 1] -= k * bent + damping * rate
        if "follower" in self.terms:
            angle = self.phi[last] + self.value["follower_angle"]
            thrust = matrix([mp.cos(angle), mp.sin(angle)])
            self.push(last, 1, -self.value["follower_force"] * thrust)
        if "gravity" in self.terms:
            weight = self.m * self.value["gravity"]
            self.force = [force - matrix([0, weight]) for force in self.force]
        if "external_damping" in self.terms:
            self.drag()

    def drag(self) -> None:
        """-c_ext m |sin(angle of v - mean angle of the links)| v at every joint."""
        v = matrix(self.u[:2])
        for joint in range(self.n + 1):
            links = [i for i in (joint - 1, joint) if 0 <= i < self.n]
            angle = mp.fsum(self.phi[i] for i in links) / len(links)
            across = mp.sin(mp.atan2(v[1], v[0]) - angle)
            factor = self.value["external_damping"] * self.m * len(links) / 2 * abs(across)
            # A joint's load may go to either of its links: the joint force makes up for it.
            self.push(links[-1], 1 if joint == self.n else -1, -factor * v)
            if joint < self.n:
                v += self.l * self.omega[joint] * self.normal[joint]

    def push(self, link: int, end: int, force: Any) -> None:
        """A force on the end (1) or the start (-1) of a link."""
        self.force[link] += force
        self.moment[link] += end * self.l / 2 * _dot(self.normal[link], force)


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1]
