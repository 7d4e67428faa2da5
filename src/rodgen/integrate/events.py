"""Where a state or a derived quantity crosses a value: seen between step ends, then located.

A step ends far from where the crossing is. So the run hands over blocks of step ends, `crossings`
finds the steps in which something crosses, and `locate` finds the time along the dense output of
one of them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from rodgen.integrate.stepper import Array, Interpolant
from rodgen.scene.tables import Event

# The module's function that has a derived quantity, and where in its last axes; () is their sum.
DERIVED: dict[str, tuple[str, tuple[int, ...]]] = {
    "tip_x": ("joints", (-1, 0)),
    "tip_y": ("joints", (-1, 1)),
    "centre_of_gravity_x": ("centre_of_gravity", (0,)),
    "centre_of_gravity_y": ("centre_of_gravity", (1,)),
    "kinetic_energy": ("energy", (0,)),
    "spring_energy": ("energy", (1,)),
    "gravity_energy": ("energy", (2,)),
    "total_energy": ("energy", ()),
    "inertia_x": ("inertia", (0,)),
    "inertia_y": ("inertia", (1,)),
    "product_xy": ("inertia", (2,)),
}
STATES = ""  # in place of a function: the state itself
SENSES = {"rising": (-1,), "falling": (1,), "either": (-1, 1)}  # signs before the crossing
BETWEEN = np.arange(1, 8)[:, None] / 8  # of a step: binary fractions
# Cubic through two states and their rates, as their difference and h f at either end.
CUBIC = np.hstack(
    (BETWEEN**2 * (3 - 2 * BETWEEN), BETWEEN * (1 - BETWEEN) ** 2, BETWEEN**3 - BETWEEN**2)
)
# Where the dense output is looked at before a root is sought: the points between, whichever share
# of the step it is, are among them.
ALONG = np.unique([i / whole for whole in range(1, 9) for i in range(whole + 1)])
ROUNDING = 1e-12  # of the quantity's size in a step: what is closer to the value is on it

Signs = NDArray[np.bool_]
Found = tuple[int, int, tuple[float, float]]


class Watch:
    """The events of a scene along its run.

    A quantity crosses its value when it reaches it: rising from below to at least the value,
    falling from above to at most the value. To leave the value is no crossing, so one that starts
    on it has to come back to it, and a step end exactly on it counts once, for the step that
    arrives there. One that touches the value and turns back has reached it. What is not finite
    neither crosses nor is crossed to.
    """

    def __init__(self, events: Sequence[Event], model: ModuleType, p: Array):
        self.events, self.model, self.p = tuple(events), model, p
        self._value = np.array([event.value for event in events], dtype=float)
        self._from = tuple(
            np.array([sign in SENSES[event.direction] for event in events], dtype=bool)
            for sign in (-1, 1)
        )
        self._asked = self._sources(range(len(self.events)))
        self.happened: list[tuple[int, float, Array]] = []

    def in_order(self, located: Iterable[tuple[float, int]]) -> list[tuple[float, int]]:
        """Times and numbers of those that are there (not not-a-number), by time; at one and the
        same time, those that end the run last."""
        there = [pair for pair in located if not math.isnan(pair[0])]
        return sorted(there, key=lambda pair: (pair[0], self.events[pair[1]].action == "stop"))

    def happens(self, number: int, t: float, y: Array) -> bool:
        """Keep an event at time t [s] in state y (S,); True if it ends the run."""
        self.happened.append((number, t, y.copy()))
        return self.events[number].action == "stop"

    def _sources(self, numbers: Iterable[int]) -> dict[str, list[tuple[int, Any]]]:
        """Functions that have these quantities; for each, the events and their places in it."""
        asked: dict[str, list[tuple[int, Any]]] = {}
        for number in numbers:
            name = self.events[number].quantity
            if name in DERIVED:
                function, place = DERIVED[name]
            elif joint := re.fullmatch(r"joint_([0-9]+)_([xy])", name):
                function, place = "joints", (int(joint[1]), "xy".index(joint[2]))
            else:
                function, place = STATES, (self.model.STATE.index(name),)
            asked.setdefault(function, []).append((number, place))
        return asked

    def values(self, y: Array) -> Array:
        """Quantities (..., E) of states (..., S), in the order of the events."""
        return self._values(y, self._asked)

    def _values(self, y: Array, asked: dict[str, list[tuple[int, Any]]]) -> Array:
        values = np.empty((*y.shape[:-1], len(self.events)))
        for function, events in asked.items():
            with np.errstate(all="ignore"):  # of a state that is not finite
                whole = y if function == STATES else getattr(self.model, function)(y, self.p)
            if isinstance(whole, tuple):
                whole = np.stack(np.broadcast_arrays(*whole), -1)
            for number, place in events:
                values[..., number] = whole[(..., *place)] if place else whole.sum(-1)
        return values

    def crossings(self, t: Array, y: Array, f: Array | None = None) -> list[Found]:
        """Steps in which an event happens: (k, number of the event, (t_low, t_high)), by time.

        t (K,), y (K, S): step ends, the first of a block being the last of the block before;
        f (K, S): their rates. The crossing lies between rows k and k + 1, and (t_low, t_high) is
        that step, or the share of it that belongs to one of several crossings in it. At a break
        point of the loads, where the rates jump, give the row twice, once with either rates.

        Seen are: every crossing that shows at the step ends; with f also those that show at seven
        points inside the step, of the cubic through its ends with their rates. Not seen are pairs
        of crossings (there and back) that fall between two of these points, an eighth of the step
        apart, and pairs so shallow that the cubic, off by the fourth power of the step, does not
        have them. What only the cubic has, `locate` tells. Without f no pair within a step is
        seen.
        """
        if len(t) < 2 or not self.events:
            return []
        ends = self.values(y)[:, None] - self._value
        g = ends[:-1] if f is None else np.concatenate((ends[:-1], self._inside(t, y, f, ends)), 1)
        g = np.concatenate((g, ends[1:]), axis=1)  # (K-1, points, E): from row k to row k + 1
        g[np.isinf(g)] = np.nan
        up, down = self._from
        low, high = g[:, :-1], g[:, 1:]
        crossed: Signs = ((low < 0) & (high >= 0) & up) | ((low > 0) & (high <= 0) & down)
        if not crossed.any():
            return []
        return self._brackets(t, g, crossed)

    def _inside(self, t: Array, y: Array, f: Array, ends: Array) -> Array:
        """Differences to the values at the points between the rows, (K-1, points, E)."""
        if self._asked.keys() == {STATES}:  # no need of the other states
            columns = [place for _, (place,) in self._asked[STATES]]
            quantities = _cubic(t, y[:, columns], f[:, columns])
        else:
            quantities = self.values(_cubic(t, y, f))
        inside = quantities - self._value
        # Of points that are not finite nothing is known: as if they were not there.
        return np.where(np.isfinite(inside), inside, ends[:-1])

    def _brackets(self, t: Array, g: Array, crossed: Signs) -> list[Found]:
        """Steps with crossings, cut between these where there are several."""
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
            for i, place in enumerate(about.tolist()):
                found.append((k, place, number, (float(times[i]), float(times[i + 1]))))
        return [(k, number, bracket) for k, _, number, bracket in sorted(found)]

    def locate(self, number: int, t_low: float, t_high: float, at: Interpolant) -> float:
        """Time of the first crossing of an event from t_low to t_high along the dense output.

        at: states (K, S) at times (K,). The time is one at which the value is reached or passed,
        within rounding of the first; a run that goes on from there does not meet it again.
        Not-a-number where the dense output has no such crossing, seen at 23 points.
        """
        asked, value = self._sources([number]), self._value[number]

        def differences(times: Array) -> Array:
            found: Array = self._values(at(times), asked)[:, number] - value
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
            return self._at_an_end(times, g, signs)
        low, high = times[crossed[0]], times[crossed[0] + 1]
        ulp = float(np.spacing(max(abs(low), abs(high))))
        root = float(brentq(difference, low, high, xtol=4 * ulp, rtol=4 * np.finfo(float).eps))
        while root < high and difference(root) * before[crossed[0]] > 0:
            root, ulp = min(root + ulp, float(high)), 2 * ulp
        return root

    def _at_an_end(self, times: Array, g: Array, signs: tuple[int, ...]) -> float:
        """An end that is on the value but for rounding, on the wrong side of it."""
        near = ROUNDING * np.nanmax(np.abs(g), initial=0.0)
        if abs(g[0]) <= near and -np.sign(g[-1]) in signs:
            return float(times[0])
        if abs(g[-1]) <= near and np.sign(g[0]) in signs:
            return float(times[-1])
        return math.nan


def _cubic(t: Array, y: Array, f: Array) -> Array:
    """States (K-1, points, S) at the points between rows; constant ones to the last bit."""
    h = np.diff(t)[:, None]
    with np.errstate(all="ignore"):  # of rates that are not finite
        parts = np.stack((np.diff(y, axis=0), h * f[:-1], h * f[1:]), axis=1)
        inside: Array = y[:-1, None] + CUBIC @ parts
    return inside
