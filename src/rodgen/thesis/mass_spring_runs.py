"""The mass-spring model in motion: its critical force by simulation, and what a second costs."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from rodgen.thesis.mass_spring import Array, MassSpring

SAFETY = 0.9  # of the largest stable step, 2/omega of the fastest motion
BEND = 1e-6  # of the length: amplitude at the start, far below what is not linear
FORCES = 12  # simulated side by side, as one array


@dataclass(frozen=True)
class Growth:
    """Amplitudes across the rod [m] at the end of each of `forces` [N], over that at the start."""

    forces: Array
    grown: Array
    step: float
    steps: int
    seconds: float

    @property
    def seconds_per_second(self) -> float:
        """Run time [s] of one simulated second of one rod, of those simulated together."""
        return self.seconds / (self.step * self.steps) / len(self.forces)


@dataclass(frozen=True)
class Simulated:
    """A critical force [N] between two simulated ones, with what was done for it."""

    force: float
    low: float
    high: float
    span: float
    seconds: float


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
    inverse, push = step / model.masses[:, None], np.asarray(forces)
    for _ in range(steps):
        v += inverse * model.forces(r, push)
        r += step * v
    seconds = time.perf_counter() - begin
    return Growth(push, _bent(r) / start, step, steps, seconds)


def _bent(r: Array) -> Array:
    """How far the points lie from the straight line through them [m], (...): root mean square.

    A rod that turns as a whole has not lost its shape; one that flutters has.
    """
    centred = r - r.mean(axis=-2, keepdims=True)
    return np.asarray(np.linalg.svd(centred, compute_uv=False)[..., -1] / np.sqrt(r.shape[-2]))


def simulated_critical_force(
    model: MassSpring, low: float, high: float, span: float, factor: float, rounds: int = 2
) -> Simulated:
    """The force [N] from which on a bend grows by `factor` within the span [s].

    Each round simulates FORCES forces between the bounds side by side and goes on between the two
    where the growth begins. Raises ValueError where it does not begin between the bounds.
    """
    seconds = 0.0
    for _ in range(rounds):
        forces = np.linspace(low, high, FORCES)
        result = grow(model, forces, span)
        seconds += result.seconds
        grown = ~(result.grown < factor)  # what is no number any more has grown as well
        first = int(np.argmax(grown))
        if not grown.any() or first == 0:
            raise ValueError(f"no growth by {factor:g} begins between {low:g} and {high:g} N")
        low, high = float(forces[first - 1]), float(forces[first])
    return Simulated((low + high) / 2, low, high, span, seconds)
