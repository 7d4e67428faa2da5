"""What a scene is given as functions of time, of the motion, and of the bend of its joints: where
that is not smooth, swings or has a pole."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError, short
from rodgen.scene.expression import Difference, Expression
from rodgen.scene.law import points
from rodgen.scene.spring import STIFFNESS
from rodgen.scene.spring import law as spring_law
from rodgen.scene.structure import Structure
from rodgen.scene.zeros import met

PLACES = (0.05, 0.5, 0.95)  # s at which a load along the rod is looked at
# rad: so close to a corner of its law a spring is on it. What a step makes of the wrong side of the
# corner is of the order of the square.
ON_A_CORNER = 1e-7
FEW = 5_000  # numbers that are computed with at once
MOST_FRONTS = 20_000  # break points of what moves along the rod, beyond which they are left out
BENDS = "bend"
Values = Mapping[str, Any]


@dataclass(frozen=True)
class Switch:
    """What a law of the motion switches by, in numbers that pass zero.

    law: of times (...) and of the values of sensors, states and the bends of the joints with a
    spring, `bend`, by name: (..., count); cause: the field that switches, and where, if it is one
    that may jump there.
    """

    law: Callable[[NDArray[np.float64], Values], Any]
    count: int = 1
    cause: str = ""


def _signalled(difference: Difference, cause: str) -> Switch:
    """Of what follows sensors and states."""
    return Switch(lambda t, values: np.asarray(difference(t, values))[..., None], cause=cause)


def _sprung(difference: Difference, stiffness: tuple[float, ...]) -> Switch:
    """Of the springs of all joints, zero where one is next to a corner of its law: lest the
    rounding of a rod that is at rest there be taken for a motion across it."""
    k = {STIFFNESS: np.array(stiffness)}
    off = np.array([0.0, -ON_A_CORNER, ON_A_CORNER])

    def law(t: NDArray[np.float64], values: Values) -> Any:
        d = values[BENDS]
        if d.size <= FEW:  # calls cost more than what they compute
            here, below, above = difference(d + off.reshape(-1, *(1,) * d.ndim), k)
        else:
            here, below, above = (difference(d + by, k) for by in off)
        return np.where(np.sign(below) * np.sign(above) > 0, here, 0.0)

    return Switch(law, len(stiffness))


@dataclass(frozen=True)
class Course:
    """The expressions of a scene from start to end [s].

    all: of loads, rates of states and masses; timed: loads of time alone; along: loads that may
    differ from link to link; fed: what follows the motion; spread: loads and masses along the rod,
    of s and t, which the links sum up at points of their own; links: how many there are; spring:
    the law of the springs, and their stiffness; masses: those of all.
    """

    start: float
    end: float
    all: tuple[Expression, ...]
    timed: tuple[Expression, ...]
    along: tuple[Expression, ...]
    fed: tuple[Expression, ...]
    spread: tuple[Expression, ...] = ()
    links: int = 0
    spring: tuple[Expression, tuple[float, ...]] | None = None
    masses: tuple[Expression, ...] = ()

    @classmethod
    def of(
        cls,
        structure: Structure,
        numbers: Mapping[str, float],
        start: float,
        end: float,
        stiffness: tuple[float, ...] = (),
    ) -> Self:
        """Those of a structure, with values of the numbers in them by name; stiffness: of the
        springs, where their law is not smooth."""

        def known(of: Mapping[str, Expression]) -> tuple[Expression, ...]:
            return tuple(e.with_values(numbers) for e in of.values())

        loads = known(structure.open_expressions)
        rates = tuple(
            replace(e, field=f"states.{name}.rate").with_values(numbers)
            for name, e in structure.open_rates.items()
        )
        along, masses = known(structure.open_along), known(structure.open_masses)
        fed = (*(e for e in loads if e.signals), *rates)
        timed = tuple(e for e in loads if not e.signals)
        every, spread = (*loads, *along, *rates, *masses), (*along, *masses)
        spring = None
        if stiffness:
            names = (name for name in structure.spring_law.names if name != STIFFNESS)
            law = spring_law(structure.spring, tuple((name, numbers[name]) for name in names))
            spring = law, stiffness
        return cls(start, end, every, timed, along, fed, spread, structure.links, spring, masses)

    @cached_property
    def loads(self) -> list[Expression]:
        """Loads that change with time, each as a function of it: along the rod, at some places."""
        found = (
            replace(e, states=None, numbers=(*e.numbers, ("s", s)))
            for e in self.along
            for s in PLACES
        )
        return [*self.timed, *found]

    def breaks(self) -> list[float]:
        """Times inside the span at which a load, the rate of a state or a mass is not smooth in t,
        ascending: along the rod, at one of the points at which a link sums it up.

        Raises InputError for a mass that jumps more often than can be stepped onto: what leaves at
        a jump is accounted for there.
        """
        self.check_masses()
        found: list[float] = []
        every = [at for e in self.all for at in e.breaks(self.start, self.end)]
        for at in sorted([*every, *self._fronts]):
            # What two expressions compare may meet zero a rounding apart.
            if not found or at - found[-1] > 4 * np.spacing(abs(at)):
                found.append(at)
        return found

    def check_masses(self) -> None:
        """Raise InputError for a mass whose jumps are too many to be found."""
        crowded = self.crowded()
        for e in self.masses:
            if e in crowded or not e.kinks_are_found(self.start, self.end):
                allowed = (
                    f"a mass whose jumps can be found, at most {MOST_FRONTS} in the span and at "
                    "all points of the links: what leaves at each takes energy along; give a "
                    "shorter span, fewer links, or a smooth expression"
                )
                raise InputError(e.field, e.text, allowed)

    @cached_property
    def _fronts(self) -> tuple[float, ...]:
        """When a front, at which what acts along the rod is not smooth, passes a point; none where
        they are too many."""
        found = (_passing(e, self.links, self.start, self.end) for e in self.spread)
        times = [at for some in found for at in some or ()]
        return tuple(times) if len(times) <= MOST_FRONTS else ()

    def crowded(self) -> list[Expression]:
        """What has more fronts along the rod than are stepped onto."""
        return [
            e
            for e in self.spread
            if (passing := _passing(e, self.links, self.start, self.end)) is None
            or (passing and not self._fronts)
        ]

    def switches(self) -> tuple[Switch, ...]:
        """What passes zero where a load, the rate of a state or the moment of a spring is not
        smooth as it follows the motion."""
        found, causes = dict[str, Difference](), dict[str, str]()
        for law in self.fed:
            found |= law.switches()
            causes |= {
                at: f"{law.field} = {short(law.text)} where {at} passes zero" for at in law.jumps()
            }
        switches = [_signalled(one, causes.get(at, "")) for at, one in found.items()]
        if self.spring is not None:
            law, stiffness = self.spring
            switches += (_sprung(one, stiffness) for one in law.corners().values())
        return tuple(switches)

    def pulses(self) -> list[tuple[float, float, float]]:
        """Begin, peak and end of what a load does after a rest that is longer, ascending."""
        return sorted(pulse for e in self.loads for pulse in e.pulses(self.start, self.end))

    def swing(self) -> float:
        """Half a period [s] of the load that swings fastest; infinity where none swings."""
        return min((e.swing(self.start, self.end) for e in self.loads), default=math.inf)

    def pole(self) -> tuple[float, Expression] | None:
        """The first time in the span at which a load grows beyond all bounds, and that load."""
        found = [(at, e) for e in self.loads for at in e.poles(self.start, self.end)]
        return min(found, key=lambda pair: pair[0], default=None)


@lru_cache(maxsize=64)
def _passing(e: Expression, links: int, start: float, end: float) -> tuple[float, ...] | None:
    """Times at which what an expression of s and t compares meets zero at points of the links; None
    where they are too many to be found."""
    places = points(links).ravel()
    found: set[float] = set()
    for difference in e.switches().values():

        def along(t: Any, s: Any, difference: Difference = difference) -> Any:
            return difference(t, {"s": s})

        times = met(along, places, start, end)
        if times is None:
            return None
        found.update(times)
    return tuple(sorted(at for at in found if start < at < end))
