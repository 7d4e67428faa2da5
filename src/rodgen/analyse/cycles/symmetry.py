"""Symmetries of motions: cycles are sought up to rigid motions of the whole rod; and the period
with which its loads repeat, if they have not come to rest.

Where nothing depends on the place of joint 0, nor (without drag) on its velocity, these are left
out of the reduced state. Where loads turn with the rod, or there are none, turning the whole rod
turns the motion, and a motion that comes back turned by an angle is a cycle: a relative periodic
motion. Symmetries are found from the derivatives of the rates, not from the names of the loads.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.model.rod import BOUNDARIES
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.system import System

PLACES = 3  # states at which the derivatives are looked at
ASIDE = 0.1  # rad, and rad/s, beside the motion: there no symmetry is by chance
SAME = 1e-9  # of the sizes of what is compared: roundings

# Of the period of the loads.
TAIL = 0.1  # share of the span at its end in which loads have to be what they stay
TIMES = 48  # in it, at which they are compared
SAME_PERIOD = 1e-10  # of the rates: roundings of t times a frequency
MOST_TURNS = 60  # of one load while another makes a whole number as well
PARTS = (6, 5, 4, 3, 2)  # of a common period that may be one already: sin(t)**2
SWINGS = ("sin", "cos", "tan")


@dataclass(frozen=True)
class SymmetryReduction:
    """Reduction of a state. kept: indices of the reduced states; turns: whether turning the rod
    turns its motion; angles, velocity: where among those kept the angles and the velocity of joint
    0 are (the latter empty if left out); positions: how many of them are angles or places; led:
    where among those kept the rates of these are; origin: a state (states,) that gives the
    others."""

    kept: NDArray[np.intp]
    turns: bool
    angles: NDArray[np.intp]
    velocity: NDArray[np.intp]
    positions: int
    led: NDArray[np.intp]
    origin: Array = field(repr=False)

    @classmethod
    def of(cls, model: ModuleType, p: Array, t: float, y: Array) -> SymmetryReduction:
        """Find the symmetries of a module with parameters p about a state y (states,) at t [s]."""
        base = 2 * BOUNDARIES[model.BOUNDARY].translates
        half = (len(y) - len(getattr(model, "STATES", ()))) // 2
        random = np.random.default_rng(1)
        near = [y + ASIDE * random.standard_normal(len(y)) for _ in range(PLACES)]
        J = [model.jac(t, one, p) for one in near]
        out = list[int]()
        for first in (0, half) if base else ():
            pair = np.array([first, first + 1])
            # Places are led by velocities: only what is kept must not follow them.
            rows = np.setdiff1d(np.arange(len(y)), [*out, *pair.tolist()])
            if any(one[np.ix_(rows, pair)].any() for one in J):
                break
            out += pair.tolist()
        kept = np.setdiff1d(np.arange(len(y)), out)
        angles = np.flatnonzero((kept >= base) & (kept < half))
        velocity = np.flatnonzero((kept >= half) & (kept < half + base))
        positions = int((kept < half).sum())
        led = np.searchsorted(kept, kept[:positions] + half)
        made = cls(kept, False, angles, velocity, positions, led, y.copy())
        placed = base > 0 and 0 in kept
        turns = not placed and all(
            made._is_equivariant(model.rhs(t, one, p), matrix, one)
            for one, matrix in zip(near, J, strict=True)
        )
        return replace(made, turns=turns)

    def _is_equivariant(self, f: Array, J: Array, y: Array) -> bool:
        """Whether rates f with the derivatives J turn with the state, to first order."""
        way = self.turning(y[self.kept])
        there = J[np.ix_(self.kept, self.kept)]
        change, f = there @ way - self._quarter_turn(f[self.kept]), f[self.kept]
        sizes = np.abs(there) @ np.abs(way) + np.abs(self._quarter_turn(f))
        return bool((np.abs(change) <= SAME * np.maximum(sizes, 1e-6 * sizes.max())).all())

    def _quarter_turn(self, x: Array) -> Array:
        """Velocities of joint 0 turned by a right angle, and zeros."""
        made = np.zeros_like(x)
        if len(self.velocity):
            vx, vy = self.velocity
            made[..., vx], made[..., vy] = -x[..., vy], x[..., vx]
        return made

    @property
    def size(self) -> int:
        """Number of reduced states."""
        return len(self.kept)

    def turning(self, x: Array) -> Array:
        """Derivative of the reduced states (size,) by the angle by which the rod is turned."""
        way = self._quarter_turn(x)
        way[..., self.angles] = 1.0
        return way

    def rotate(self, x: Array, angle: float) -> Array:
        """Turn reduced states x (..., size) with the rod by an angle [rad]."""
        made = x.copy()
        made[..., self.angles] += angle
        if len(self.velocity):
            across = self._quarter_turn(x)
            at = self.velocity
            made[..., at] = np.cos(angle) * x[..., at] + np.sin(angle) * across[..., at]
        return made

    def rotate_columns(self, V: Array, angle: float) -> Array:
        """Turn directions V (size, k) by an angle [rad]."""
        if not len(self.velocity):
            return V
        made = V.copy()
        at = self.velocity
        made[at] = np.cos(angle) * V[at] + np.sin(angle) * self._quarter_turn(V.T).T[at]
        return made

    def lift(self, x: Array) -> Array:
        """Expand reduced states to whole ones (..., states)."""
        made = np.broadcast_to(self.origin, (*x.shape[:-1], len(self.origin))).copy()
        made[..., self.kept] = x
        return made


def load_period(system: System, model: ModuleType) -> float:
    """Find the period [s] with which a system's loads repeat at the end of its span; 0 where they
    no longer change there.

    It follows from the arguments of sin, cos and tan, and is checked with the rates themselves.
    Raises InputError for masses that change and a base whose velocity jumps, AnalysisError for
    loads that do neither.
    """
    scene, p = system.scene, system.p
    changing = scene.distribution.changing_masses
    if changing:
        field = changing[0][-1].field
        raise InputError(
            field, changing[0][-1].text, "a number: no motion repeats while it changes"
        )
    scene.time_laws.check_base_is_smooth()
    start, end = scene.integrate.span
    random = np.random.default_rng(2)
    times = end - TAIL * (end - start) * random.random(TIMES)
    y = system.y0
    y = y + 0.1 * random.standard_normal(len(y))

    def rates(at: Array) -> Array:
        return np.array([model.rhs(float(t), y, p) for t in at])

    here = rates(times)
    size = np.abs(here).max()

    def is_period(period: float) -> bool:
        return bool(np.abs(rates(times + period) - here).max() <= SAME_PERIOD * size)

    if np.abs(here - here[0]).max() <= SAME_PERIOD * size:
        return 0.0
    found = _common_multiple(_periods(scene, end))
    for part in PARTS if found else ():
        if is_period(found / part):
            return found / part
    if found and is_period(found):
        return found
    texts = [e.text for e in (*scene.expressions.values(), *scene.state_rates.values())]
    raise AnalysisError(
        f"no cycle: the loads ({'; '.join(texts)}) neither come to rest nor are seen to repeat "
        f"in the last tenth of the span, up to {end:g} s"
    )


def _periods(scene: Scene, end: float) -> Iterator[float]:
    """Periods [s] of sin, cos and tan in the expressions of a scene."""
    for e in (*scene.expressions.values(), *scene.state_rates.values()):
        for node in ast.walk(ast.parse(e.text, mode="eval")):
            name = getattr(node, "func", None)
            if isinstance(node, ast.Call) and isinstance(name, ast.Name) and name.id in SWINGS:
                slope = _argument_rate(ast.unparse(node.args[0]), e, end)
                if slope:
                    yield 2 * math.pi / slope


def _argument_rate(text: str, of: Expression, end: float) -> float:
    """Rate of an argument [1/s], without its sign; 0 if it is not linear in t alone."""
    try:
        argument = Expression(text, of.variable, of.field, of.numbers)
        values = [float(argument(t)) for t in (end, end + 1.0, end + 2.0)]
    except (InputError, TypeError, NameError, KeyError):
        return 0.0
    slope = values[1] - values[0]
    even = abs(values[2] - values[1] - slope) <= 1e-9 * max(abs(slope), 1e-9)
    return abs(slope) if even and math.isfinite(slope) else 0.0


def _common_multiple(periods: Iterable[float]) -> float:
    """Least common multiple of periods; 0 where there is none."""
    common = 0.0
    for period in periods:
        if not common:
            common = period
            continue
        ratio = Fraction(common / period).limit_denominator(MOST_TURNS)
        if not ratio or abs(float(ratio) * period - common) > 1e-9 * common:
            return 0.0
        common *= ratio.denominator
    return common
