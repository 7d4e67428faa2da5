"""The accelerations of a free uniform rod in 50-digit arithmetic, in O(n).

Newton's and Euler's laws for every link by hand, with the joint forces eliminated from joint to
joint; all loads of the thesis. Nothing is shared with what is generated, nor with the dense form
of rodgen.emit.by_hand, which takes over where the start is held or mass is lumped.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
from mpmath import mp, mpf
from numpy.typing import NDArray

from rodgen.emit.by_hand import ByHand

Array = NDArray[np.float64]
Number = Any  # of mpmath, which has no types
Pair = tuple[Number, Number]

DIGITS = 60  # ten for what the worst of the conditions takes
SCALARS = (
    *("mass", "length", "bending_stiffness", "follower_force", "follower_angle", "gravity"),
    *("internal_damping", "external_damping", "clamp_angle"),
)


def exact_rates(model: ModuleType, values: Mapping[str, Any], y: Array) -> list[Number]:
    """Second half of dy/dt (states/2,): of a free uniform rod in O(n), of others by the dense form.

    values: parameters by name, fin_factor a list, of a module with all the terms of the thesis.
    """
    with mpmath.workdps(DIGITS):
        if model.BOUNDARY == "free" and model.INERTIA == "uniform":
            return Rod(values, y).rates()
        return dense_rates(model, values, y)


def dense_rates(model: ModuleType, values: Mapping[str, Any], y: Array) -> list[Number]:
    """The same by the hand-assembled closed form and a dense solve."""
    with mpmath.workdps(DIGITS):
        rates: list[Number] = ByHand(model, dict(values), y).rhs()[len(y) // 2 :]
        return rates


class Rod:
    """A state of a free rod of uniform links. Forces are over the mass of a link."""

    def __init__(self, values: Mapping[str, Any], y: Array):
        self.value = {name: mpf(float(values[name])) for name in SCALARS if name in values}
        self.fins = [mpf(float(fin)) for fin in values["fin_factor"]]
        state = [mpf(float(at)) for at in y]
        self.n = n = len(y) // 2 - 2
        self.phi, self.omega = state[2 : n + 2], state[n + 4 :]
        self.v0 = (state[n + 2], state[n + 3])
        self.m, self.l = self.value["mass"] / n, self.value["length"] / n
        self.c, self.s = [mp.cos(a) for a in self.phi], [mp.sin(a) for a in self.phi]
        zero = mpf(0)
        # At the start and the end of every link, and the moment about its middle.
        self.at_start: list[Pair] = [(zero, zero)] * n
        self.at_end: list[Pair] = [(zero, zero)] * n
        self.moment = self._bending()
        self._loads()

    def rates(self) -> list[Number]:
        """Accelerations of joint 0 [m/s^2], then of the angles [1/s^2]."""
        joint = self._joint_forces()
        alpha: list[Number] = []
        for i in range(self.n):
            before, after = joint[i], joint[i + 1]
            start = _add(self.at_start[i], before, -1)
            end = _add(self.at_end[i], after)
            turning = self._across(i, _add(end, start, -1))
            alpha.append(6 * turning / self.l + 12 * self.moment[i] / (self.m * self.l**2))
        force = _add(_add(self.at_start[0], self.at_end[0]), joint[1])
        force = (force[0], force[1] - self.value.get("gravity", mpf(0)))
        half, square = self.l / 2, self.omega[0] ** 2
        x = force[0] + half * (square * self.c[0] + alpha[0] * self.s[0])
        y = force[1] + half * (square * self.s[0] - alpha[0] * self.c[0])
        return [x, y, *alpha]

    def _across(self, i: int, force: Pair) -> Number:
        return self.c[i] * force[1] - self.s[i] * force[0]

    def _bending(self) -> list[Number]:
        """Moments of springs and dampers on the links."""
        k = self.value["bending_stiffness"] / self.l
        d = self.value.get("internal_damping", mpf(0)) * self.m
        passed = [
            k * (b - a) + d * (w - v)
            for (a, b), (v, w) in zip(pairwise(self.phi), pairwise(self.omega), strict=True)
        ]
        return [a - b for a, b in zip([*passed, mpf(0)], [mpf(0), *passed], strict=True)]

    def _loads(self) -> None:
        thrust = self.value.get("follower_force", mpf(0)) / self.m
        angle = self.phi[-1] + self.value.get("follower_angle", mpf(0))
        self.at_end[-1] = (-thrust * mp.cos(angle), -thrust * mp.sin(angle))
        if self.value.get("external_damping"):
            self._drag()

    def _drag(self) -> None:
        """At every joint against its velocity, by the sine of the angle between velocity and rod;
        taken up by the link after the joint, at the tail by the last one."""
        vx, vy = self.v0
        for j in range(self.n + 1):
            links = [i for i in (j - 1, j) if 0 <= i < self.n]
            mean = mp.fsum(self.phi[i] for i in links) / len(links)
            speed = mp.sqrt(vx**2 + vy**2)
            share = abs(vy * mp.cos(mean) - vx * mp.sin(mean)) / speed if speed else mpf(0)
            d = self.value["external_damping"] * self.fins[j] * share * len(links) / 2
            if j < self.n:
                self.at_start[j] = _add(self.at_start[j], (vx, vy), -d)
                vx -= self.l * self.omega[j] * self.s[j]
                vy += self.l * self.omega[j] * self.c[j]
            else:
                self.at_end[-1] = _add(self.at_end[-1], (vx, vy), -d)

    def _joint_forces(self) -> list[Pair]:
        """With which the joints 0 to n pull the links before them; none at both ends."""
        zero: Pair = (mpf(0), mpf(0))
        blocks = [self._block(i) for i in range(self.n)]
        starts, ends = zip(*(self._ends(i) for i in range(self.n)), strict=True)
        passed: list[tuple[tuple[Number, ...], Pair]] = []  # force = q - G next force
        for j in range(1, self.n):
            # Start of link j and end of link j - 1 move alike: blocks of 1 + 3 n n and 1 - 3 n n.
            (a, b, d), (e, f, g) = blocks[j - 1], blocks[j]
            D = [a + e, b + f, b + f, d + g]
            r = _add(starts[j], ends[j - 1], -1)
            if passed:
                G, q = passed[-1]
                o, p, s = (a - 2, b, d - 2)  # what the force before does to the end
                D = [
                    D[0] - (o * G[0] + p * G[2]),
                    D[1] - (o * G[1] + p * G[3]),
                    D[2] - (p * G[0] + s * G[2]),
                    D[3] - (p * G[1] + s * G[3]),
                ]
                r = (r[0] - (o * q[0] + p * q[1]), r[1] - (p * q[0] + s * q[1]))
            det = D[0] * D[3] - D[1] * D[2]
            inverse = [D[3] / det, -D[1] / det, -D[2] / det, D[0] / det]
            next_ = (e - 2, f, f, g - 2)
            passed.append((_product(inverse, next_), _apply(inverse, r)))
        forces = [zero]
        for G, q in reversed(passed):
            forces.append(_add(q, _apply(G, forces[-1]), -1))
        return [zero, *reversed(forces)] if self.n > 1 else [zero, zero]

    def _block(self, i: int) -> tuple[Number, Number, Number]:
        """1 + 3 n n of the unit normal n of a link."""
        c, s = self.c[i], self.s[i]
        return 1 + 3 * s * s, -3 * s * c, 1 + 3 * c * c

    def _ends(self, i: int) -> tuple[Pair, Pair]:
        """Accelerations of start and end of a link without joint forces."""
        start, end = self.at_start[i], self.at_end[i]
        moment = 6 * self.moment[i] / (self.m * self.l)
        turning = 3 * self._across(i, _add(end, start, -1)) + moment
        square = self.l / 2 * self.omega[i] ** 2
        x, y = -turning * self.s[i] - square * self.c[i], turning * self.c[i] - square * self.s[i]
        middle = _add(start, end)
        middle = (middle[0], middle[1] - self.value.get("gravity", mpf(0)))
        return _add(middle, (x, y), -1), _add(middle, (x, y))


def _add(a: Pair, b: Pair, factor: Number = 1) -> Pair:
    return a[0] + factor * b[0], a[1] + factor * b[1]


def _product(a: Sequence[Number], b: Sequence[Number]) -> tuple[Number, ...]:
    return (
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    )


def _apply(a: Sequence[Number], x: Pair) -> Pair:
    return a[0] * x[0] + a[1] * x[1], a[2] * x[0] + a[3] * x[1]
