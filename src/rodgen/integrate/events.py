"""Detection of events: a state or a derived quantity crosses a value.

A step ends far from where the crossing is. So the run hands over blocks of step ends, `crossings`
finds the steps in which something crosses, and `locate` finds the time along the dense output of
one of them.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.stepper import BOUNCES, BounceError, ChatterError, Interpolant
from rodgen.loading.generated_module import structure_of
from rodgen.model.quantities import find_quantity
from rodgen.scene.expression import Expression
from rodgen.scene.integration import EventTable
from rodgen.scene.time_laws import SIGNALS, Switch

STATES = ""  # in place of a quantity: the state itself
# What laws of the motion switch at, in place of an event.
SWITCHING = EventTable.model_construct(
    quantity="", value=0.0, direction="either", action="", name=""
)
SENSES = {"rising": (-1,), "falling": (1,), "either": (-1, 1)}  # signs before the crossing
BETWEEN = np.arange(1, 8)[:, None] / 8  # of a step: binary fractions
# Cubic through two states and their rates, as their difference and h f at either end.
CUBIC = np.hstack(
    (BETWEEN**2 * (3 - 2 * BETWEEN), BETWEEN * (1 - BETWEEN) ** 2, BETWEEN**3 - BETWEEN**2)
)
# Where the dense output is looked at before a root is sought: the points between, whichever share
# of the step it is, are among them.
ALONG = np.unique([i / whole for whole in range(1, 9) for i in range(whole + 1)])
OFTEN, SHORT = 1000, 1e-6  # cuts, and the share of the way that each is to bring
PAUSE = 1e-3  # share of the way that is not cut when they bring less; doubled every time
ALONG_RATES = 1e-9  # share of the way on which rates are held against what is switched by
NEARER = 1 - 2.0**-10  # share of the way to a switch that a run goes to stay before it
TRIES, STEP = 5, 2.0**-20  # to pass what is switched at; share of a step in a difference
EARLY = 1e-9  # share of a step, before what is switched at
NEXT = 64  # roundings of the time within which laws switch at once
ROUNDING = 1e-12  # of the quantity's size in a step: what is closer to the value is on it

Signs = NDArray[np.bool_]
Bracket = tuple[int, tuple[float, float]]  # number of what crosses, and the times between which
Found = tuple[int, int, tuple[float, float]]  # step of a block, and the same


class EventDetector:
    """Detector of events of a scene along its run and, numbered after them, of switches of laws.

    A quantity crosses its value when it reaches it: rising from below to at least the value,
    falling from above to at most the value. To leave the value is no crossing, so one that starts
    on it has to come back to it, and a step end exactly on it counts once, for the step that
    arrives there. One that touches the value and turns back has reached it. What is not finite
    neither crosses nor is crossed to.
    """

    def __init__(
        self,
        events: Sequence[EventTable],
        model: ModuleType,
        p: Array,
        switches: Sequence[Switch] = (),
        moment: float = 0.0,
    ):
        """moment: time [s] within which a thousand touches end the run."""
        self._switches, self._first = tuple(switches), len(events)
        columns = [(at, column) for at, one in enumerate(switches) for column in range(one.count)]
        self.events = (*events, *(SWITCHING for _ in columns))
        self.model, self.p = model, p
        self._value = np.array([event.value for event in self.events], dtype=float)
        self._from = tuple(
            np.array([sign in SENSES[event.direction] for event in self.events], dtype=bool)
            for sign in (-1, 1)
        )
        self._places = [self._place(event.quantity) for event in events]
        self._places += [(SIGNALS, place) for place in columns]
        self.happened: list[tuple[int, float, Array]] = []
        self._moment, self._latest = moment, dict[int, deque[float]]()

    @cached_property
    def _has_feedback(self) -> bool:
        """Whether the module has sensors or loads that follow the motion."""
        return structure_of(self.model).has_feedback

    @cached_property
    def _touch_events(self) -> tuple[EventTable, ...]:
        """Events of touching."""
        every = structure_of(self.model).contact_events if self._touches else ()
        return tuple(event for event in every if event.direction == "rising")

    @cached_property
    def _touches(self) -> bool:
        """Whether the rod has contacts."""
        return bool(structure_of(self.model).contacts)

    @cached_property
    def _time_laws(self) -> dict[str, Expression]:
        """Loads of the rod that change with time."""
        return structure_of(self.model).time_dependent_loads(self.p)

    def is_switch(self, number: int) -> bool:
        """Whether a number is that of a switch of a law, not of an event of the scene."""
        return number >= self._first

    def cause(self, number: int) -> str:
        """Law that switches at this number, and where, if it may jump there; else empty."""
        return self._switches[self._places[number][1][0]].cause if self.is_switch(number) else ""

    def locate_all(self, found: Iterable[Bracket], at: Interpolant) -> list[tuple[float, int]]:
        """Times and numbers of the events that the dense output has, by time; at one and the same
        time, those that end the run come last. at: as in `locate`."""
        located = [(self.locate(number, *span, at), number) for number, span in found]
        there = [pair for pair in located if not math.isnan(pair[0])]
        return sorted(there, key=lambda pair: (pair[0], self.events[pair[1]].action == "stop"))

    def events_at_jump(self, t: float, before: Array, after: Array) -> list[int]:
        """Numbers of the events whose value a jump of the state passes at a time [s], from one
        state (S,) to another; those that end the run come last."""
        if not self._first:
            return []
        sides = self.values(np.stack((before, after)), np.array([t, t])) - self._value
        up, down = self._from
        low, high = sides
        passed = ((low < 0) & (high >= 0) & up) | ((low > 0) & (high <= 0) & down)
        found = np.flatnonzero(passed[: self._first]).tolist()
        return sorted(found, key=lambda number: self.events[number].action == "stop")

    def record_event(self, number: int, t: float, y: Array) -> bool:
        """Keep an event at time t [s] in state y (S,); True if it ends the run. Raises BounceError
        for touching without end."""
        self.happened.append((number, t, y.copy()))
        if self.events[number] in self._touch_events:
            latest = self._latest.setdefault(number, deque(maxlen=BOUNCES))
            latest.append(t)
            if len(latest) == BOUNCES and t - latest[0] <= self._moment:
                raise BounceError(self.events[number].name)
        return self.events[number].action == "stop"

    def _place(self, name: str) -> tuple[str, Any]:
        """Quantity that a number of this name belongs to, or the state, and the index in its last
        axes."""
        if name in self.model.STATE:
            return STATES, (..., self.model.STATE.index(name))
        try:
            quantity, at = find_quantity(name)
        except KeyError:  # of a number by its own name
            return name, (...,)
        return quantity.name, (..., *at)

    def values(
        self, y: Array, t: Array | None = None, numbers: Sequence[int] | None = None
    ) -> Array:
        """Quantities (..., E) of states (..., S), in the order of the events, at times (...) where
        laws of the motion are among them; numbers: of those that are computed, by default all."""
        values = np.empty((*y.shape[:-1], len(self.events)))
        motion = MotionSlice(self.model, self.p, y, t, timed=self._time_laws)
        switches = dict[int, Array]()
        if self._switches:
            motion.has_feedback = self._has_feedback
        with np.errstate(all="ignore"):  # of a state that is not finite
            for number in range(len(self.events)) if numbers is None else numbers:
                name, at = self._places[number]
                if name == SIGNALS:
                    switch, column = at
                    if switch not in switches:
                        of = self._switches[switch]
                        found = motion.values(of.reads)
                        known = found if of.reads == SIGNALS else {of.reads: found}
                        switches[switch] = of.law(motion.t, known)
                    values[..., number] = switches[switch][..., column]
                else:
                    values[..., number] = (y if name == STATES else motion.values(name))[at]
        return values

    def crossings(
        self, t: Array, y: Array, f: Array | None = None, on: Collection[int] = ()
    ) -> list[Found]:
        """Find steps in which an event happens: (k, number of the event, (t_low, t_high)), by time.

        t (K,), y (K, S): step ends, the first of a block being the last of the block before;
        f (K, S): their rates. The crossing lies between rows k and k + 1, and (t_low, t_high) is
        that step, or the share of it that belongs to one of several crossings in it. At a break
        point of the loads, where the rates jump, give the row twice, once with either rates.

        Seen are: every crossing that shows at the step ends; with f also those that show at seven
        points inside the step, of the cubic through its ends with their rates. Not seen are pairs
        of crossings (there and back) that fall between two of these points, an eighth of the step
        apart, and pairs so shallow that the cubic, off by the fourth power of the step, does not
        have them. `locate` tells what only the cubic has. Without f no pair within a step is seen.
        on: numbers of events whose value the first row is on, but for rounding.
        """
        if len(t) < 2 or not self.events:
            return []
        ends = self.values(y, t)[:, None] - self._value
        ends[0, :, list(on)] = 0.0
        g = ends[:-1] if f is None else np.concatenate((ends[:-1], self._inside(t, y, f, ends)), 1)
        g = np.concatenate((g, ends[1:]), axis=1)  # (K-1, points, E): from row k to row k + 1
        g[np.isinf(g)] = np.nan
        up, down = self._from
        low, high = g[:, :-1], g[:, 1:]
        crossed: Signs = ((low < 0) & (high >= 0) & up) | ((low > 0) & (high <= 0) & down)
        return self._brackets(t, g, crossed)

    def _inside(self, t: Array, y: Array, f: Array, ends: Array) -> Array:
        """Differences to the values at the points between the rows, (K-1, points, E)."""
        if all(name == STATES for name, _ in self._places):  # no need of the other states
            columns = [at[-1] for _, at in self._places]
            quantities = _cubic(t, y[:, columns], f[:, columns])
        else:
            times = t[:-1, None] + np.diff(t)[:, None] * BETWEEN[:, 0]
            quantities = self.values(_cubic(t, y, f), times)
        inside = quantities - self._value
        # Of points that are not finite nothing is known: as if they were not there.
        return np.where(np.isfinite(inside), inside, ends[:-1])

    def _brackets(self, t: Array, g: Array, crossed: Signs) -> list[Found]:
        """Bracket the crossings in each step, cut between them where there are several."""
        points = g.shape[1] - 1
        found = []
        for k, number in np.argwhere(crossed.any(axis=1)).tolist():
            at = np.flatnonzero(crossed[k, :, number])
            # A step that starts on the value starts with what is no crossing.
            first = int(at[0]) if g[k, 0, number] == 0 else 0
            cuts = np.concatenate(([first], (at[:-1] + 2 + at[1:]) // 2, [points]))
            times = t[k] + (t[k + 1] - t[k]) * (cuts / points)
            times[-1] = t[k + 1]
            before, after = np.abs(g[k, at, number]), np.abs(g[k, at + 1, number])
            about = at + before / (before + after)
            for i, share in enumerate(about.tolist()):
                found.append((k, share, number, (float(times[i]), float(times[i + 1]))))
        return [(k, number, bracket) for k, _, number, bracket in sorted(found)]

    def first_switch(
        self, found: Iterable[Bracket], start: float, at: Interpolant
    ) -> tuple[float, dict[int, float]] | None:
        """Time just before the first switch of a law in a step, and the numbers of all that switch
        then, each with its sign before. found: what crosses in the step; start: of the step [s];
        at: as in `locate`. None where nothing switches, or next to the start alone."""
        located = [(self.locate(number, *span, at), number) for number, span in found]
        least = start + NEXT * float(np.spacing(abs(start)))
        times = [when for when, _ in located if when > least]
        if not times:
            return None
        first = min(times)
        beside = NEXT * float(np.spacing(abs(first)))
        signs = np.sign(self.values(at(np.array([start])), np.array([start])))[0]
        sides = {n: float(signs[n]) for when, n in located if when - first <= beside}
        # Stages at the end of a step are not to see what comes behind.
        early = first - max(beside, EARLY * (first - start))
        return max(early, min(least, first)), sides

    def time_to_switch(
        self, sides: Mapping[int, float], t: float, y: Array, f: Array, h: float
    ) -> float:
        """Time [s] after t, where the rates are f, until laws of these numbers have switched;
        sides: their signs before; h: the last step. 0 where they have switched, or where the motion
        turns back."""
        on = STEP * h
        here = self.values(np.stack((y, y + on * f)), np.array([t, t + on]))
        most = 0.0
        for number, side in sides.items():
            value, slope = here[0, number] * side, (here[1, number] - here[0, number]) * side / on
            if value >= 0 and slope < 0:
                least = NEXT * float(np.spacing(abs(t)))
                most = max(most, least - 2 * value / slope)
        return most

    def time_to_sliding(self, number: int, t: float, y: Array, way: float) -> float:
        """Time [s] to a switch next to which a run is, if the rates on both sides of it drive the
        run back there, so that no motion follows (a sliding mode: A. F. Filippov, Differential
        Equations with Discontinuous Righthand Sides, 1988); else infinity. way: length of the
        stretch [s]."""

        def rates(time: float, state: Array) -> tuple[Array, float, float]:
            """Rates, the value whose zero is the switch, and its slope."""
            f: Array = self.model.rhs(time, state, self.p)
            on = ALONG_RATES * way
            states, times = np.stack((state, state + on * f)), np.array([time, time + on])
            here, there = self.values(states, times, [number])[:, number]
            return f, here, (there - here) / on

        f, value, slope = rates(t, y)
        if not value * slope < 0:
            return math.inf
        left = -value / slope
        across = 2 * left + ALONG_RATES * way
        _, beyond, slope_beyond = rates(t + across, y + across * f)
        back = value * beyond < 0 and beyond * slope_beyond < 0
        return left if back else math.inf

    def locate(self, number: int, t_low: float, t_high: float, at: Interpolant) -> float:
        """Time of the first crossing of an event from t_low to t_high along the dense output.

        at: states (K, S) at times (K,). The time is one at which the value is reached or passed,
        within rounding of the first; a run that goes on from there does not meet it again.
        Not-a-number where the dense output, looked at in 23 points, has no such crossing.
        """
        value = self._value[number]

        def differences(times: Array) -> Array:
            found: Array = self.values(at(times), times, [number])[:, number] - value
            return found

        def difference(time: float) -> float:
            return float(differences(np.array([time]))[0])

        times = t_low + (t_high - t_low) * ALONG
        times[-1] = t_high
        g = differences(times)
        signs = SENSES[self.events[number].direction]
        before, after = np.sign(g[:-1]), np.sign(g[1:])
        crossed = np.flatnonzero(np.isin(before, signs) & (before * after <= 0))
        if not len(crossed):
            return self._root_at_end(times, g, signs)
        low, high = times[crossed[0]], times[crossed[0] + 1]
        ulp = float(np.spacing(max(abs(low), abs(high))))
        root = float(
            scipy.optimize.brentq(difference, low, high, xtol=4 * ulp, rtol=4 * np.finfo(float).eps)
        )
        while root < high and difference(root) * before[crossed[0]] > 0:
            root, ulp = min(root + ulp, float(high)), 2 * ulp
        return root

    def _root_at_end(self, times: Array, g: Array, signs: tuple[int, ...]) -> float:
        """Time of an end that is on the value but for rounding, on the wrong side of it."""
        near = ROUNDING * np.nanmax(np.abs(g), initial=0.0)
        if abs(g[0]) <= near and -np.sign(g[-1]) in signs:
            return float(times[0])
        if abs(g[-1]) <= near and np.sign(g[0]) in signs:
            return float(times[-1])
        return math.nan


def _cubic(t: Array, y: Array, f: Array) -> Array:
    """Cubic states (K-1, points, S) at the points between rows; constant ones to the last bit."""
    h = np.diff(t)[:, None]
    with np.errstate(all="ignore"):  # of rates that are not finite
        parts = np.stack((np.diff(y, axis=0), h * f[:-1], h * f[1:]), axis=1)
        inside: Array = y[:-1, None] + CUBIC @ parts
    return inside


@dataclass
class SwitchProgress:
    """Progress of a run across the switches of its laws of motion.

    goal: end of the stretch [s]; begun: its start; towards: switches that the run steps onto at
    present, by number, with the sign before; on, at: those it has passed last, and when [s]; cuts:
    steps cut since a time (since) [s]; tried: how often it went a little further. Where steps are
    cut again and again on a tiny part of the way, by laws that have corners there, as of springs
    that rest on one, none is cut for a while (up to a time, calm); pauses: how often that was.
    """

    goal: float = math.nan
    begun: float = math.nan
    towards: dict[int, float] = field(default_factory=dict)
    on: frozenset[int] = frozenset()
    at: float = math.nan
    since: float = math.nan
    calm: float = -math.inf
    cuts: int = 0
    tried: int = 0
    pauses: int = 0

    def __post_init__(self) -> None:
        if math.isnan(self.since):
            self.since = self.begun

    def find_crossings(
        self, watch: EventDetector, t: Array, y: Array, f: Array | None
    ) -> list[Found]:
        """Crossings in a block of steps, as EventDetector.crossings has them, without those that
        the run is on its way to or has had too often. Raises ChatterError where a law that jumps
        has."""
        found = watch.crossings(t, y, f, self.on if t[0] == self.at else ())
        if found and self.cuts >= OFTEN:
            way, now = self.goal - self.begun, float(t[0])
            if now - self.since < OFTEN * SHORT * way:
                if cause := watch.cause(found[0][1]):
                    raise ChatterError(cause)
                self.calm, self.pauses = now + PAUSE * 2**self.pauses * way, self.pauses + 1
            self.since, self.cuts = max(now, self.calm), 0
        calm = t[0] < self.calm
        return [
            crossing
            for crossing in found
            if not (watch.is_switch(crossing[1]) and (calm or crossing[1] in self.towards))
        ]

    def head_for(self, sides: dict[int, float]) -> None:
        """Step onto the switches of these numbers; sides: their signs before."""
        self.towards, self.cuts, self.tried = sides, self.cuts + 1, 0

    def next_goal(self, watch: EventDetector, t: float, y: Array, f: Array, h: float) -> float:
        """Time [s] by which the run has certainly passed the switches it was to step onto, as
        EventDetector.time_to_switch has it; t itself where it has, or where that was tried too
        often. Raises ChatterError where no motion passes them."""
        self.tried += 1
        way = self.goal - self.begun
        for number in self.towards:
            if not (cause := watch.cause(number)):
                continue
            left = watch.time_to_sliding(number, t, y, way)
            if left <= SHORT * way or (left < math.inf and self.tried > TRIES):
                raise ChatterError(cause)
            if left < math.inf:
                return t + left * NEARER
        return t + (watch.time_to_switch(self.towards, t, y, f, h) if self.tried <= TRIES else 0.0)

    def arrive(self, t: float) -> None:
        """Note that the run is at the switch, at a time [s]."""
        self.on, self.at, self.towards = frozenset(self.towards), t, {}

    def state(self) -> dict[str, NDArray[Any]]:
        """Arrays to restore it from, see `of`."""
        times = [self.goal, self.begun, self.at, self.since, self.calm]
        towards = np.array(list(self.towards.items()), dtype=float).reshape(-1, 2)
        counts = [self.cuts, self.tried, self.pauses]
        return {
            "switching": np.array([*times, *counts]),
            "towards": towards,
            "on": np.array(sorted(self.on), dtype="i8"),
        }

    @classmethod
    def of(cls, state: Mapping[str, NDArray[Any]]) -> SwitchProgress:
        """Restore it from the arrays of `state`."""
        goal, begun, *times = state["switching"].tolist()
        towards = {int(number): side for number, side in state["towards"].tolist()}
        on = frozenset(state["on"].tolist())
        return cls(goal, begun, towards, on, *times[:3], *map(int, times[3:]))
