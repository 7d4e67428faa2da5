"""Motions that grow about the states of a branch: how many, and where one begins or ceases to."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rodgen.analyse.curves.curve import BRANCH, Point, Special, corrected
from rodgen.analyse.curves.special_points import on_chord
from rodgen.analyse.eigen import Complex, Modal, Motions, all_shapes, lowest_shapes
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.family import RIGID
from rodgen.analyse.neutral import Neutral
from rodgen.analyse.onset import Onset, onset
from rodgen.analyse.pencil import Dense, Linear, Parts, Pencil
from rodgen.analyse.steady import Steady, linearised
from rodgen.integrate.stepper import Array

if TYPE_CHECKING:
    from rodgen.analyse.branches.equilibria import Equilibria

HOPF = "hopf"
MODES = 24  # of the rod at the start of a branch, in which its motions are counted
MOST_DENSE = 200  # links up to which all modes may be looked at
CLOSE = 1e-5  # of the way between two points, to which a crossing is narrowed
REAL = 1e-6  # of the modulus: an imaginary part below it is rounding


class Growing:
    """Small motions in the lowest modes of a steady state, or in all of them."""

    def __init__(self, start: Steady, every: bool = False):
        self.start = start
        self.every = every or start.system.cells <= MODES
        linear = linearised(start)
        self.added = len(start.system.scene.states)
        self.dragged = isinstance(linear, Dense)
        squares, self.basis = _modes(start, linear, self.every)
        rates = np.sqrt(np.abs(squares))
        elastic = rates[rates > RIGID * rates.max(initial=0.0)]
        if not len(elastic):
            raise AnalysisError("nothing holds the rod in the state at which a branch begins")
        self.lowest = float(elastic.min())
        self.frequencies = np.maximum(rates, self.lowest)
        held = self.dragged or not start.system.base
        self.rigid = 0.0 if held else RIGID * self.lowest

    def motions(self, state: Steady) -> Motions:
        """The motions about a state; those that move or turn the whole rod do not grow."""
        linear, basis = linearised(state), self.basis
        if isinstance(linear, Pencil) and self.start.turns_freely:
            basis = _without_turning(linear, basis)
        K, C, M = (part[None] for part in linear.on(basis).parts)
        modal = Modal(K, C, M, self.frequencies, added=self.added)
        if self.dragged:
            modal = replace(modal, neutral=Neutral.of(modal.by_rates()))
        found = modal.motions()
        s, growth = found.s[0], found.growth[0]
        return Motions(s, np.where(np.abs(s) <= self.rigid, 0.0, growth))

    def count(self, state: Steady) -> int:
        """How many directions are unstable: one of a motion that diverges, two of one that
        flutters."""
        return len(grown(self.motions(state)))


def grown(found: Motions) -> Complex:
    """The eigenvalues that grow; of undamped motions, of which one of every pair is known, with
    their conjugates."""
    s = found.s[found.growth > 0]
    turned = s[np.abs(s.imag) > REAL * np.abs(s)]
    if (turned.imag < 0).any() or not len(turned):
        return s
    return np.concatenate((s, turned.conj()))


def _modes(start: Steady, linear: Linear, every: bool) -> tuple[Array, Array]:
    """Squared frequencies and shapes (coordinates, k), the slowest first."""
    if isinstance(linear, Pencil) and linear.cells > MOST_DENSE:
        return lowest_shapes(linear, MODES, start.turning if start.turns_freely else None)
    assert isinstance(linear, Pencil | Dense)
    squares, found = all_shapes(linear.reduced())
    order = np.argsort(np.abs(squares), kind="stable")
    if isinstance(linear, Pencil):  # turning alone, which every load leaves as it is
        order = order[int(start.turns_freely) :]
    order = order[: None if every else MODES]
    return squares[order], found[:, order]


def _without_turning(linear: Pencil, basis: Array) -> Array:
    """Shapes whose inertia does no work on turning alone: K and C do none on it and it none on
    them, so that the others are found without it, whatever basis they are found in."""
    turning = np.ones((linear.cells, 1))
    momenta = linear.eliminated(turning)[2]
    return np.asarray(basis - turning @ (momenta.T @ basis) / momenta.sum())


def crossing(problem: Equilibria, a: Point, b: Point) -> list[Special]:
    """Where motions begin or cease to oscillate more and more between two points of a branch, to
    all digits; of a free rod also where they begin to diverge, which no determinant tells there."""
    free = len(a.u) == 1
    found: list[Special] = []
    low, share = a, 0.0
    while low.unstable != b.unstable and share < 1 and len(found) < 8:
        left, right, upper = share, 1.0, b
        while right - left > CLOSE:
            middle = (left + right) / 2
            point = on_chord(problem, a, b, middle)
            if point.unstable == low.unstable:
                left = middle
            else:
                right, upper = middle, point
        beside = low if left == share else on_chord(problem, a, b, left)
        s = _crosses(problem, beside, upper)
        if s.imag > 0 or free:
            found.append(_solved(problem, upper, s))
        low, share = upper, right
    return found


def _crosses(problem: Equilibria, a: Point, b: Point) -> complex:
    """The eigenvalue that grows beside one point and not beside the other."""
    growing = problem.growing
    assert growing is not None
    one, two = (grown(growing.motions(problem.steady(point.u))) for point in (a, b))
    here, there = (one, two) if len(one) > len(two) else (two, one)
    if not len(here):
        return 0j
    near = np.abs(here[:, None] - there[None, :]).min(axis=1, initial=np.inf)
    s = here[np.argmax(near / np.abs(here))]
    return 0j if abs(s.imag) <= abs(s.real) else complex(1j * abs(s.imag))


def _solved(problem: Equilibria, near: Point, s: complex) -> Special:
    """The crossing next to a point, by Newton's method on the linearised equations along the
    branch."""
    last = np.append(np.zeros(len(near.u) - 1), 1.0)
    slope = near.tangent / near.tangent[-1]

    def state(value: float) -> Array:
        guess = near.u + (problem.scaled(value) - near.u[-1]) * slope
        return corrected(problem, guess, last).u

    def at(value: float) -> Linear:
        here = problem.steady(state(value))
        linear = linearised(here)
        if not s and isinstance(linear, Pencil) and here.turns_freely:
            return Parts.without_turning(linear, here.turning)
        return linear

    kind = HOPF if s else BRANCH
    value = problem.value(near.u)
    try:
        found = onset(at, Onset(value, s), problem.variable.unit)
    except AnalysisError as error:
        note = f"known to about {CLOSE:g} of a step only: {error}"
        return Special(kind, near.u, frequency=s.imag / (2 * np.pi), note=note)
    return Special(kind, state(found.force), frequency=found.s.imag / (2 * np.pi))
