"""The thesis's model of masses and springs, run."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, eigvals
from scipy.optimize import brentq

Array = NDArray[np.float64]

SEARCHED = (0.0, 200.0)  # EI/L^2, in which the critical force is looked for
GRID = 200  # forces at which pairs of frequencies are looked at before one is refined
SAME = 1e-7  # of the largest mu: below, an imaginary part is the rounding of a double root


@dataclass(frozen=True)
class MassSpring:
    """Points 0..n on a straight line; SI units, axial_stiffness is EA [N]."""

    links: int
    mass: float
    length: float
    bending_stiffness: float
    axial_stiffness: float

    @property
    def spacing(self) -> float:
        """Length l of a segment without force [m]."""
        return self.length / self.links

    @cached_property
    def masses(self) -> Array:
        """Masses of the points [kg], (n+1,)."""
        masses = np.full(self.links + 1, self.mass / self.links)
        masses[[0, -1]] /= 2
        return masses

    def pushes(self, force: float | Array) -> Array:
        """Compression of the segments [N] under steady thrust at the tail [N], (..., n): segment j
        pushes the mass of the points 0..j ahead of it."""
        return np.multiply.outer(force, np.cumsum(self.masses)[:-1] / self.mass)

    def segments(self, force: float | Array) -> Array:
        """Lengths [m] under steady thrust at the tail [N], (..., n)."""
        return np.asarray(self.spacing * (1 - self.pushes(force) / self.axial_stiffness))

    def straight(self, force: float | Array) -> Array:
        """Positions [m] in steady acceleration, axially compressed, (..., n+1, 2)."""
        lengths = self.segments(force)
        x = np.concatenate((np.zeros((*lengths.shape[:-1], 1)), np.cumsum(lengths, -1)), -1)
        return np.stack((x, np.zeros_like(x)), -1)

    def forces(self, r: Array, force: float | Array) -> Array:
        """Forces on the points [N], (..., n+1, 2), at positions r; force: thrust [N], (...)."""
        d = r[..., 1:, :] - r[..., :-1, :]
        dx, dy = d[..., 0], d[..., 1]
        lengths = np.hypot(dx, dy)
        tx, ty = dx / lengths, dy / lengths
        tension = self.axial_stiffness * (lengths / self.spacing - 1)
        # The angle between two segments, by which a rotary spring is bent.
        cross = tx[..., :-1] * ty[..., 1:] - ty[..., :-1] * tx[..., 1:]
        along = tx[..., :-1] * tx[..., 1:] + ty[..., :-1] * ty[..., 1:]
        moment = self.bending_stiffness / self.spacing * np.arctan2(cross, along)
        # A spring turns the segment before it on, the one behind it back; each such moment is a
        # couple of two forces across the segment: together forces on three points.
        couple = np.zeros_like(lengths)
        couple[..., :-1] += moment
        couple[..., 1:] -= moment
        across = couple / lengths
        inner = np.stack((tension * tx + across * ty, tension * ty - across * tx), -1)
        total = np.zeros_like(r)
        total[..., :-1, :] += inner
        total[..., 1:, :] -= inner
        total[..., -1, 0] -= force * tx[..., -1]
        total[..., -1, 1] -= force * ty[..., -1]
        return total

    def accelerations(self, r: Array, force: float | Array) -> Array:
        """Accelerations of the points [m/s^2], (..., n+1, 2)."""
        return self.forces(r, force) / self.masses[:, None]

    def across(self, force: float) -> Array:
        """The part of the linearisation across the rod [1/s^2], (n+1, n+1): w'' = A w.

        About the straight state that accelerates steadily; along the rod it is uncoupled, and
        stable. Written down from the linearised moments and forces, not differentiated from
        `forces`: the two are compared by a test.
        """
        n = self.links
        lengths = self.segments(force)
        turn = np.diff(np.eye(n + 1), axis=0) / lengths[:, None]  # angles of the segments
        bend = np.diff(turn, axis=0)
        pull = -self.bending_stiffness / self.spacing * bend.T @ bend
        pull += turn.T @ ((self.pushes(force) * lengths)[:, None] * turn)
        pull[-1] -= force * turn[-1]
        return pull / self.masses[:, None]

    def critical_load(self) -> float:
        """The least thrust [N] at which two frequencies meet and flutter sets in.

        mu = lambda^2 of two modes meets in a double root: (mu_1 - mu_2)^2 is smooth there and
        changes sign, so that the force is found to rounding. Raises ValueError where none of the
        searched forces is critical.
        """
        low, high = (bound * self.bending_stiffness / self.length**2 for bound in SEARCHED)
        before = low
        for at in np.linspace(low, high, GRID + 1)[1:]:
            if (pair := self._meeting(at)) is not None:
                return float(brentq(lambda p, k=pair: self._gap(p, k), before, at, xtol=1e-11))
            before = at
        raise ValueError(f"no flutter of the mass-spring model between {low:g} and {high:g} N")

    def _roots(self, force: float) -> NDArray[np.complex128]:
        """mu [1/s^2], ascending by real part, without the two of the rigid motions (zero)."""
        mu = np.asarray(eigvals(self.across(force)), dtype=complex)
        mu = mu[np.argsort(np.abs(mu))[2:]]
        return mu[np.lexsort((mu.imag, mu.real))]

    def _meeting(self, force: float) -> int | None:
        """Rank of the pair that has met below a force; None where all roots are real."""
        mu = self._roots(force)
        met = np.flatnonzero(np.abs(mu.imag) > SAME * np.abs(mu).max(initial=0.0))
        return int(met[-1]) - len(mu) if len(met) else None

    def _gap(self, force: float, rank: int) -> float:
        mu = self._roots(force)
        return float(((mu[rank] - mu[rank - 1]) ** 2).real)

    def fastest(self) -> float:
        """Largest natural frequency without thrust [rad/s]: of the axial or the rotary springs."""
        n = self.links
        stretch = np.diff(np.eye(n + 1), axis=0)
        axial = self.axial_stiffness / self.spacing * stretch.T @ stretch
        largest = eigh(axial, np.diag(self.masses), eigvals_only=True)[-1]
        return float(np.sqrt(max(largest, np.abs(self._roots(0.0)).max())))


SAFETY = 0.9  # of the largest stable step, 2/omega of the fastest motion
BEND = 1e-6  # of the length: amplitude at the start, far below what is not linear
FORCES, ROUNDS = 12, 2  # simulated side by side, as one array, and how often


class Growth(NamedTuple):
    """Amplitudes across the rod at the end over those at the start, one for every force, and the
    run time [s] of one simulated second of one rod, of those simulated together."""

    grown: Array
    seconds_per_second: float


def grow(model: MassSpring, forces: Array, span: float) -> Growth:
    """Simulate slightly bent rods under several forces [N] at once over a span [s].

    Velocities first, positions with the new ones (the thesis's semi-implicit Euler method), with
    the step that the axial springs allow.
    """
    step = SAFETY * 2 / model.fastest()
    steps = int(np.ceil(span / step))
    straight = model.straight(forces)
    r = straight.copy()
    # Bent like the first two modes together, so that both partners of a flutter are there.
    s = np.linspace(0, 1, model.links + 1)
    r[..., 1] += BEND * model.length * (np.cos(2 * np.pi * s) + np.cos(3 * np.pi * s))
    start = _bent(r)
    v = np.zeros_like(r)
    begin = time.perf_counter()
    inverse = step / model.masses[:, None]
    for _ in range(steps):
        v += inverse * model.forces(r, forces)
        r += step * v
    seconds = time.perf_counter() - begin
    return Growth(_bent(r) / start, seconds / (step * steps) / len(forces))


def _bent(r: Array) -> Array:
    """Distance of the points from the straight line through them [m], (...): root mean square.

    A rod that turns as a whole has not lost its shape; one that flutters has.
    """
    centred = r - r.mean(axis=-2, keepdims=True)
    return np.asarray(np.linalg.svd(centred, compute_uv=False)[..., -1] / np.sqrt(r.shape[-2]))


def simulated_critical_load(
    model: MassSpring, low: float, high: float, span: float, factor: float
) -> float:
    """The force [N] from which on a bend grows by `factor` within the span [s].

    Each round simulates FORCES forces between the bounds side by side and goes on between the two
    where the growth begins. Raises ValueError where it does not begin between the bounds.
    """
    for _ in range(ROUNDS):
        forces = np.linspace(low, high, FORCES)
        grown = ~(
            grow(model, forces, span).grown < factor
        )  # what is no number any more has grown as well
        first = int(np.argmax(grown))
        if not grown.any() or first == 0:
            raise ValueError(f"no growth by {factor:g} begins between {low:g} and {high:g} N")
        low, high = float(forces[first - 1]), float(forces[first])
    return (low + high) / 2
