"""Stability of a periodic motion under periodic loads: Floquet multipliers.

Tangents of the state are integrated over the segments of a period; the multipliers are the
eigenvalues of the product of their maps. Products of many maps lose what is small, and all digits
where a map grows much. So the eigenvalues are found as m-th powers of those of a block-cyclic
matrix of the m maps (T. F. Fairgrieve, A. D. Jepson, SIAM J. Numer. Anal. 28 (1991) 1446; K. Lust,
Int. J. Bifurcation Chaos 11 (2001) 2389).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike

from rodgen.analyse.analysis_guard import (
    FLOQUET,
    check_analysis_memory,
    check_positive,
    check_whole_number,
    guard_analysis,
)
from rodgen.analyse.chaos.metrics import zero_exponents
from rodgen.analyse.cycles.elimination import Complex, multiplier_difference
from rodgen.analyse.cycles.symmetry import load_period
from rodgen.analyse.statics import static_equilibrium
from rodgen.arrays import Array
from rodgen.display import Plottable
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.stepper import StepError
from rodgen.integrate.stretches import with_span
from rodgen.integrate.variations import PARTS, StepSettings, Variations
from rodgen.model.terms import TERMS
from rodgen.result import ASKED, FLAG, USUAL, Result, Row, StudyStorage, omit_from_tables
from rodgen.scene import Scene
from rodgen.system import System

SEGMENTS = 4  # of a period
FIRST, MOST = 8, 2**16  # steps in a period at least, at first and at most
ENOUGH = 1e-8  # what doubling these may change of the larger multipliers, relative to the largest
SAME = 1e-11  # of a map, that is found: multipliers that meet are known to the root of its error
MEETING = 1e-5
RTOL, ATOL = 1e-11, 1e-13
LOOKS = 64  # times in a period at which the angles are looked at
ITERATIONS = 12  # of Newton's method
CLOSED, FAR = 1e-9, 30.0  # of the state: a motion is periodic, and is none that Newton reaches


@dataclass(frozen=True, eq=False, repr=False)
class Floquet(Result, Plottable):
    """Multipliers of a periodic motion, the largest first.

    multipliers (k,): factors by which small changes of the state grow in a period; period: of the
    motion [s]; y: the state (states,) at the start of the span, in SI units, to which the motion
    returns; amplitude: half of the range of an angle in a period, the largest of all links [rad], 0
    at rest; error: of the larger multipliers, relative to the largest, dimensionless; closed: how
    far the motion is from its start after a period, over 1 + its largest number, dimensionless;
    places: indices in y of the numbers whose changes are followed (without the place of a rod that
    flies).

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.from_dict({
    ...     "name": "shaken",
    ...     "rod": {
    ...         "links": 1, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0,
    ...         "boundary": "clamped",
    ...     },
    ...     "loads": {"tip": {"x": "-1 + 0.5*cos(2*t)"}},
    ...     "integrate": {"span": [0, 3.141592653589793]},
    ... })
    >>> found = rodgen.floquet(scene)
    >>> found.multipliers.shape, found.stable
    ((2,), True)
    >>> round(found.modulus, 6), 0 < found.argument < 3.142
    (1.0, True)
    """

    multipliers: Complex
    period: float
    y: Array = field(repr=False)
    amplitude: float
    error: float
    closed: float
    places: tuple[int, ...] = field(repr=False)

    ROWS = (
        Row("period", "period", "s", ".12g", kept=ASKED),
        Row("amplitude", "amplitude of the angles", "rad", ".8g", kept=ASKED),
        Row("modulus", "largest multiplier", text=lambda found: found._largest, kept=USUAL),
        Row("argument", "angle of the multiplier", "rad", text=omit_from_tables, kept=ASKED),
        Row("growth", "growth", "1/s", ".6g", kept=USUAL),
        Row(
            "moduli",
            "moduli of the multipliers",
            text=omit_from_tables,
            kept=StudyStorage(several=4),
        ),
        Row("multipliers", "multipliers", text=omit_from_tables),
        Row("error", "error", format=".1e", kept=ASKED),
        Row("stable", "stable", kept=FLAG),
        Row("y", "a state on it", text=omit_from_tables),
    )

    @property
    def moduli(self) -> Array:
        """Absolute values of the multipliers, the largest first, dimensionless."""
        return np.abs(self.multipliers)

    @property
    def _largest(self) -> str:
        return f"{self.modulus:.10g}, at {self.argument:.6g} rad"

    def __repr__(self) -> str:
        how = "stable" if self.stable else "unstable"
        largest = f"largest multiplier {self.modulus:.6g}"
        return f"<Floquet: period {self.period:.8g} s, {largest}; {how}>"

    @property
    def modulus(self) -> float:
        """Absolute value of the largest multiplier, dimensionless."""
        return float(np.abs(self.multipliers[0]))

    @property
    def argument(self) -> float:
        """Angle of the largest multiplier in the complex plane [rad], from 0 to pi: at 0 a change
        grows with the period, at pi with twice the period."""
        return float(abs(np.angle(self.multipliers[0])))

    @property
    def growth(self) -> float:
        """Rate [1/s] at which the largest change grows."""
        return math.log(max(self.modulus, 1e-300)) / self.period

    @property
    def stable(self) -> bool:
        """Whether no small change grows, within the error; multipliers of a motion without damping
        that meet on the unit circle are as far from it as the root of the maps' error."""
        return self.modulus <= 1 + max(10 * self.error, MEETING)


@guard_analysis
def floquet(
    system: System | Scene,
    *,
    period: float | None = None,
    y: ArrayLike | None = None,
    segments: int = SEGMENTS,
    model: ModuleType | None = None,
) -> Floquet:
    """Return the multipliers of the periodic motion of a scene under its periodic loads.

    Rest is such a motion, too. The place of a free rod is left out if its motion does not depend on
    it.

    Parameters
    ----------
    system
        The scene, or a System.
    period
        Period [s]. By default it is found from the sines in the loads.
    y
        A state (states,) near the motion, in SI units. By default it is rest, in the shape of the
        initial state if the scene has one, else in equilibrium.
    segments
        Number of parts of the period. Tangents begin anew in each.
    model
        A module that `build` has made before.

    Returns
    -------
    Floquet
        Multipliers (k,), the largest first, and their error.

    Raises
    ------
    InputError
        For values that cannot be used.
    AnalysisError
        If there is no periodic motion.

    Examples
    --------
    A pendulum whose weight pulsates with twice its frequency: its rest is unstable.

    >>> import rodgen
    >>> scene = rodgen.Scene.from_dict({
    ...     "name": "shaken",
    ...     "rod": {"links": 1, "length": 1.0, "mass": 3.0, "bending_stiffness": 0.0,
    ...             "boundary": "pinned"},
    ...     "loads": {"tip": {"y": "-1 - 0.5*cos(2*t)"}},
    ...     "initial": {"phi": -1.5707963267948966},
    ... })
    >>> bool(abs(rodgen.floquet(scene).multipliers[0]) > 1)
    True
    """
    system = System.of(system)
    check_analysis_memory(FLOQUET, system)
    segments = check_whole_number(segments, "segments", 1, 1000)
    model = model if model is not None else system.model(parts=PARTS)
    seconds = _period(system, model, period)
    map_ = _PeriodMap(system, model, seconds, segments)
    for guess in _initial_guesses(system, y):
        try:
            y, multipliers, error, closed = map_.fixed_point(guess)
            amplitude = map_.amplitude(y, system.structure.angle_slice)
            return Floquet(multipliers, seconds, y, amplitude, error, closed, map_.places)
        except (AnalysisError, StepError) as error:
            why = error
    raise AnalysisError(f"{system.name}: no motion of period {seconds:.6g} s was found: {why}")


def _period(system: System, model: ModuleType, given: float | None) -> float:
    if given is not None:
        return check_positive(given, "period", "seconds above 0")
    try:
        found = load_period(system, model)
    except AnalysisError:
        allowed = "given in seconds: none is found from the sines of the time in the loads"
        raise InputError("period", given, allowed) from None
    if not found:
        raise InputError("period", given, "given in seconds: no load changes with the time")
    return found


def _initial_guesses(system: System, y: ArrayLike | None) -> Iterator[Array]:
    """Initial guesses of a state on the motion."""
    given = system.y0
    if y is not None:
        state = np.array(y, dtype=float)
        if state.shape != given.shape:
            raise InputError("y", f"of shape {state.shape}", f"a state, ({len(given)},)")
        yield state
        return
    half = (len(given) - len(system.structure.state_names)) // 2
    still = given.copy()
    still[half : 2 * half] = 0.0
    yield still
    with suppress(InputError, AnalysisError):
        yield static_equilibrium(system).y


class _PeriodMap:
    """Map of a state and of its tangents over a period."""

    def __init__(self, system: System, model: ModuleType, period: float, segments: int):
        self.period, self._model = period, model
        self._start = system.settings.span[0]
        self._times = self._start + period * np.linspace(0.0, 1.0, segments + 1)
        self._p = system.p
        steps = StepSettings.of(with_span(system.scene, self._start, self._start + period))
        self._steps = replace(steps, method="dop853", step=0.0, rtol=RTOL, atol=ATOL)
        states = len(system.y0)
        self.places = _relevant_states(system.scene, model, states)

    def integrate(self, y: Array, least: int) -> tuple[Array, list[Array], int]:
        """Integrate over a period, in at least so many steps. Returns the state at the end, the
        maps (k, k) of the segments, and how many steps were taken."""
        longest = min(self._steps.longest, self.period / least)
        on = Variations(
            *(self._model, self._p, self._start, y, np.eye(len(y))),
            replace(self._steps, longest=longest),
        )
        maps = []
        for end in self._times[1:]:
            on.advance_to(end)
            maps.append(on.tangents.T[np.ix_(self.places, self.places)])
            on.tangents = np.eye(len(y))
        return on.y, maps, on.counts[0]

    def amplitude(self, y: Array, angles: slice) -> float:
        """Half of the largest range of the angles in the period that begins with a state."""
        none = np.empty((0, len(y)))
        on = Variations(self._model, self._p, self._start, y, none, self._steps)
        seen = [y[angles]]
        for t in self._start + self.period * np.linspace(0.0, 1.0, LOOKS + 1)[1:]:
            on.advance_to(t)
            seen.append(on.y[angles])
        return float(np.ptp(seen, axis=0).max(initial=0.0)) / 2

    def resolve_multipliers(self, y: Array, maps: list[Array], steps: int) -> tuple[Complex, float]:
        """Multipliers with steps short enough for tangents, and the change of the larger ones from
        steps twice as long. About a motion at rest, no error tells how long steps should be, and
        fast motions that are quiet allow them to be as long as is stable."""
        found = product_eigenvalues(maps)
        while steps < MOST:
            steps *= 2
            before = maps
            _, maps, _ = self.integrate(y, steps)
            finer = product_eigenvalues(maps)
            off = multiplier_difference(finer, found)
            changes = (
                np.abs(b - a).max() / np.abs(a).max() for a, b in zip(maps, before, strict=True)
            )
            if off < ENOUGH or max(changes) < SAME:
                return finer, off
            found = finer
        raise AnalysisError(f"{steps} steps are too few for a period")

    def fixed_point(self, y: Array) -> tuple[Array, Complex, float, float]:
        """Find the state that returns after a period, by Newton's method; with its multipliers,
        their error, and its closing error."""
        y, places = y.copy(), list(self.places)
        off = math.inf
        for _ in range(ITERATIONS):
            after, maps, steps = self.integrate(y, FIRST)
            less = (after - y)[places]
            scale = 1.0 + float(np.abs(y[places]).max(initial=0.0))
            off = float(np.abs(less).max(initial=0.0)) / scale
            if off < CLOSED:
                return y, *self.resolve_multipliers(y, maps, steps), off
            if not off < FAR:
                break
            whole = np.linalg.multi_dot([*maps[::-1], np.eye(len(places))])
            y[places] += np.linalg.lstsq(np.eye(len(places)) - whole, less, rcond=1e-12)[0]
        raise AnalysisError(f"Newton's method does not converge (still {off:.1e} apart)")


def _relevant_states(scene: Scene, model: ModuleType, states: int) -> tuple[int, ...]:
    """Indices of the states that the motion depends on: without joint 0 of a free rod whose
    equations do not depend on its place."""
    places = range(states)
    damped = any(TERMS[name].follows_velocity for name in scene.structure.loads)
    if (
        not scene.boundary_condition.translates
        or damped
        or "place" not in zero_exponents(scene, model)
    ):
        return tuple(places)
    half = (states - len(scene.states)) // 2
    return tuple(at for at in places if at not in (0, 1, half, half + 1))


def product_eigenvalues(maps: Sequence[Array]) -> Complex:
    """Eigenvalues (k,) of the product of maps (k, k), the last one leftmost, the largest first:
    m-th powers of those of the block-cyclic matrix that has the m maps as its blocks."""
    count, size = len(maps), len(maps[0])
    if count == 1:
        found = np.linalg.eigvals(maps[0]).astype(complex)
        return found[np.argsort(-np.abs(found), kind="stable")]
    # Of one size: then what is small in one map stands out against what is large in another.
    sizes = np.array([np.linalg.norm(one) for one in maps])
    whole = np.zeros((count * size, count * size))
    for at, one in enumerate(maps):
        to = (at + 1) % count
        whole[to * size : (to + 1) * size, at * size : (at + 1) * size] = one / sizes[at]
    powers = np.linalg.eigvals(whole) ** count * float(np.prod(sizes))
    left = list(powers[np.argsort(-np.abs(powers), kind="stable")])
    found = np.empty(size, dtype=complex)
    for at in range(size):  # each of them occurs once for every map
        near = np.argsort(np.abs(np.array(left) - left[0]), kind="stable")[:count]
        found[at] = np.mean([left[k] for k in near])
        left = [one for k, one in enumerate(left) if k not in set(near.tolist())]
    return found
