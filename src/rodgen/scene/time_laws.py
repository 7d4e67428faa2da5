"""Functions of time, of the motion and of the bend of joints in a scene: their break points,
switches, pulses, half-periods and poles."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError, shorten
from rodgen.scene.contact_terms import DEPTH, ContactTerm
from rodgen.scene.expression import Difference, Expression
from rodgen.scene.rod_mesh import RodMesh
from rodgen.scene.spring_law import STIFFNESS
from rodgen.scene.spring_law import parse_spring_law as spring_law
from rodgen.scene.structure import Structure
from rodgen.scene.zeros import crossing_times

PLACES = (0.05, 0.5, 0.95)  # s at which a load along the rod is looked at
# rad: so close to a corner of its law a spring is on it. What a step makes of the wrong side of the
# corner is of the order of the square.
ON_A_CORNER = 1e-7
# Of the largest place of a base within the span: less is rounding, more a jump.
SAME = 1e-9
MANY = 101  # times at which its size is looked at
FEW = 5_000  # numbers that are computed with at once
MOST_FRONTS = 20_000  # break points of what moves along the rod, beyond which they are left out
SIGNALS, BENDS, CONTACTS = "signals", "bend", "contacts"  # values that switches may read
Values = Mapping[str, Any]


@dataclass(frozen=True)
class Switch:
    """Switching function: numbers that pass zero where a law of the motion is not smooth.

    law: of times (...) and of the values of sensors and states, of the bends of the joints with a
    spring, `bend`, and of contacts, `contacts`, by name: (..., count); cause: the
    field that may jump there, and where; empty if none does; reads: which of these values the law
    reads.
    """

    law: Callable[[NDArray[np.float64], Values], Any]
    count: int = 1
    cause: str = ""
    reads: str = SIGNALS


def _signal_switch(difference: Difference, cause: str) -> Switch:
    """Switch of an expression that follows sensors and states."""
    return Switch(lambda t, values: np.asarray(difference(t, values))[..., None], cause=cause)


def _spring_switch(
    difference: Difference, stiffness: tuple[float, ...], rest: tuple[float, ...]
) -> Switch:
    """Switch of the springs of all joints, zero where one is next to a corner of its law: lest the
    rounding of a rod that is at rest there be taken for a motion across it."""
    k = {STIFFNESS: np.array(stiffness)}
    off = np.array([0.0, -ON_A_CORNER, ON_A_CORNER])

    def law(t: NDArray[np.float64], values: Values) -> Any:
        d = values[BENDS] - np.array(rest)
        if d.size <= FEW:  # calls cost more than what they compute
            here, below, above = difference(d + off.reshape(-1, *(1,) * d.ndim), k)
        else:
            here, below, above = (difference(d + by, k) for by in off)
        return np.where(np.sign(below) * np.sign(above) > 0, here, 0.0)

    return Switch(law, len(stiffness), reads=BENDS)


def _contact_switches(contact: ContactTerm) -> Iterator[Switch]:
    """Yield the switches of a contact: where it touches, and where its push is not smooth, looked
    at while it is pressed."""

    def number(values: Values, what: str = DEPTH) -> Any:
        found = values[CONTACTS][f"{what}_{contact.name}"]
        return found if contact.joints else found[..., None]

    yield Switch(lambda t, values: number(values), contact.count, reads=CONTACTS)
    for what in contact.switches:

        def if_touching(t: Any, values: Values, what: str = what) -> Any:
            return np.where(number(values) > 0, number(values, what), 1.0)

        yield Switch(if_touching, contact.count, reads=CONTACTS)


@dataclass(frozen=True)
class TimeLaws:
    """The expressions of a scene from start to end [s].

    single: loads of one number, by time or by the motion; along: loads that may differ from link to
    link; rates: of states; masses: of links and bodies; mesh: where links are; spring: law of the
    springs, their stiffness, and the bends at which they are at rest; base: those of `single` that
    move what holds the rod; contacts: of the rod.
    """

    start: float
    end: float
    single: tuple[Expression, ...]
    along: tuple[Expression, ...]
    rates: tuple[Expression, ...]
    masses: tuple[Expression, ...]
    mesh: RodMesh
    spring: tuple[Expression, tuple[float, ...], tuple[float, ...]] | None = None
    base: tuple[Expression, ...] = ()
    contacts: tuple[ContactTerm, ...] = ()

    @classmethod
    def from_structure(
        cls,
        structure: Structure,
        numbers: Mapping[str, float],
        mesh: RodMesh,
        start: float,
        end: float,
        springs: tuple[tuple[float, ...], tuple[float, ...]] = ((), ()),
    ) -> Self:
        """Expressions of a structure, with values of their numbers by name; mesh: where links are;
        springs: stiffness and rest angles, where their law is not smooth."""

        def with_numbers(of: Mapping[str, Expression]) -> tuple[Expression, ...]:
            return tuple(e.with_values(numbers) for e in of.values())

        of = structure
        groups = of.open_expressions, of.open_along, of.open_rates, of.open_masses
        single, along, rates, masses = map(with_numbers, groups)
        spring = None
        if springs[0]:
            names = (name for name in structure.spring_law.names if name != STIFFNESS)
            law = spring_law(structure.spring, tuple((name, numbers[name]) for name in names))
            spring = law, *springs
        moving = {name: of for name, of in groups[0].items() if name in structure.base_parameters}
        base = with_numbers(moving)
        laws = single, along, rates, masses, mesh, spring, base
        return cls(start, end, *laws, structure.contacts)

    @property
    def expressions(self) -> tuple[Expression, ...]:
        """Loads, rates of states and masses."""
        return (*self.single, *self.along, *self.rates, *self.masses)

    @property
    def feedback(self) -> tuple[Expression, ...]:
        """Loads that follow the motion, and rates of states."""
        return (*(e for e in self.single if e.signals), *self.rates)

    @property
    def _spread(self) -> tuple[Expression, ...]:
        """Loads and masses along the rod, of s and t, which links sum up at quadrature points."""
        return (*self.along, *self.masses)

    @cached_property
    def loads(self) -> list[Expression]:
        """Loads that change with time, as functions of it; those along the rod at some places."""
        found = (
            replace(e, states=None, numbers=(*e.numbers, ("s", s)))
            for e in self.along
            for s in PLACES
        )
        return [*(e for e in self.single if not e.signals), *found]

    def breaks(self) -> list[float]:
        """Break points: times inside the span at which a load, the rate of a state or a mass is not
        smooth in t, ascending; of what acts along the rod, at the quadrature points of links.

        Raises InputError for jumps that no run can have.
        """
        self.check_jumps()
        found: list[float] = []
        every = [at for e in self.expressions for at in e.breaks(self.start, self.end)]
        for at in sorted([*every, *self._front_times]):
            # What two expressions compare may meet zero a rounding apart.
            if not found or at - found[-1] > 4 * np.spacing(abs(at)):
                found.append(at)
        return found

    def check_jumps(self) -> None:
        """Raise InputError for a mass with too many jumps to step onto, at each of which the energy
        of what leaves is accounted for; for a base that jumps from one place to another; and for
        one whose velocity jumps as a mass does."""
        self._check_masses()
        for e in self.base:
            check_motion(e, self.start, self.end)
        self._check_blows()

    def _check_masses(self) -> None:
        crowded = self.crowded_expressions()
        for e in self.masses:
            if e in crowded or not e.has_resolvable_kinks(self.start, self.end):
                allowed = (
                    f"a mass whose jumps can be found, at most {MOST_FRONTS} in the span and at "
                    "all points of the links: what leaves at each takes energy along; give a "
                    "shorter span, fewer links, or a smooth expression"
                )
                raise InputError(e.field, e.text, allowed)

    def _check_blows(self) -> None:
        """Raise InputError for a blow at the instant of a jump of a mass: what leaves before a blow
        takes other momentum along than what leaves after it."""
        for e, at, near in self._blows() if self.masses else ():
            for mass in self.masses:
                both = np.array([[at - near], [at + near]])
                sides = mass.evaluate(both, {"s": self.mesh.gauss_points().ravel()})
                if np.ptp(sides, axis=0).max() > SAME * np.abs(sides).max():
                    allowed = (
                        f"of a velocity that does not jump when a mass does ({mass.field}, at "
                        f"t = {at:.9g}): a slightly later time for one of them says which is first"
                    )
                    raise InputError(e.field, e.text, allowed)

    def check_base_is_smooth(self) -> None:
        """Raise InputError for a base whose velocity jumps: tangents of a motion do not know what
        that does to them."""
        for e, at, _ in self._blows():
            raise InputError(e.field, e.text, f"of a velocity without jumps (not at t = {at:.9g})")

    def _blows(self) -> Iterator[tuple[Expression, float, float]]:
        """Motions of the base whose velocity jumps, at what times, and how near by [s] the values
        on either side are found."""
        for e in self.base:
            fastest = np.abs(e.derivative(np.linspace(self.start, self.end, MANY), {})).max()
            for at in (self.start, *e.breaks(self.start, self.end), self.end):
                near = 16 * np.spacing(max(abs(at), self.end - self.start))
                before, after = (float(e.derivative(at + by, {})) for by in (-near, near))
                if abs(after - before) > SAME * max(fastest, abs(after), abs(before)):
                    yield e, at, near

    @cached_property
    def _front_times(self) -> tuple[float, ...]:
        """Times at which a break point that moves along the rod passes a quadrature point; none
        where they are too many."""
        found = (_passing_times(e, self.mesh, self.start, self.end) for e in self._spread)
        times = [at for some in found for at in some or ()]
        return tuple(times) if len(times) <= MOST_FRONTS else ()

    def crowded_expressions(self) -> list[Expression]:
        """Expressions whose break points along the rod are too many to step onto."""
        return [
            e
            for e in self._spread
            if (passing := _passing_times(e, self.mesh, self.start, self.end)) is None
            or (passing and not self._front_times)
        ]

    def switches(self) -> tuple[Switch, ...]:
        """Switching functions of all loads, rates and springs that are not smooth in the motion."""
        found, causes = dict[str, Difference](), dict[str, str]()
        for law in self.feedback:
            found |= law.switches()
            causes |= {
                at: f"{law.field} = {shorten(law.text)} where {at} passes zero"
                for at in law.jumps()
            }
        switches = [_signal_switch(one, causes.get(at, "")) for at, one in found.items()]
        if self.spring is not None:
            law, *springs = self.spring
            switches += (_spring_switch(one, *springs) for one in law.corners().values())
        switches += (switch for one in self.contacts for switch in _contact_switches(one))
        return tuple(switches)

    def pulses(self) -> list[tuple[float, float, float]]:
        """Begin, peak and end of loads' pulses that are shorter than the rest before, ascending."""
        return sorted(pulse for e in self.loads for pulse in e.pulses(self.start, self.end))

    def half_period(self) -> float:
        """Half-period [s] of the load that oscillates fastest; infinity where none oscillates."""
        return min((e.half_period(self.start, self.end) for e in self.loads), default=math.inf)

    def first_pole(self) -> tuple[float, Expression] | None:
        """First time in the span at which a load has a pole, and that load; None without."""
        found = [(at, e) for e in self.loads for at in e.poles(self.start, self.end)]
        return min(found, key=lambda pair: pair[0], default=None)


@lru_cache(maxsize=64)
def _passing_times(
    e: Expression, mesh: RodMesh, start: float, end: float
) -> tuple[float, ...] | None:
    """Times at which an expression of s and t is not smooth at a quadrature point of a link; None
    where they are too many to be found."""
    places = mesh.gauss_points().ravel()
    found: set[float] = set()
    for difference in e.switches().values():

        def difference_at(t: Any, s: Any, difference: Difference = difference) -> Any:
            return difference(t, {"s": s})

        times = crossing_times(difference_at, places, start, end)
        if times is None:
            return None
        found.update(times)
    return tuple(sorted(at for at in found if start < at < end))


@lru_cache(maxsize=64)
def check_motion(e: Expression, start: float, end: float) -> None:
    """Raise InputError for a motion of the base that cannot be within a span [s]: one that jumps,
    one whose place, velocity or acceleration is not finite, or a table of straight lines, whose
    corners are blows."""
    if e.has_linear_table:
        allowed = 'without tables of straight lines: interp(t, ..., "cubic") has an acceleration'
        raise InputError(e.field, e.text, allowed)
    times = np.linspace(start, end, MANY)
    ends = (start, *e.breaks(start, end), *e.poles(start, end), end)
    _check_derivatives(e, np.unique([*times, *ends]))
    largest = float(np.abs(e(times)).max())
    for at in ends:
        near = 16 * np.spacing(max(abs(at), abs(end - start)))
        sides = e(np.array([max(start, at - near), at, min(end, at + near)]))
        if np.ptp(sides) > SAME * max(largest, np.abs(sides).max()):
            allowed = f"without jumps: {shorten(e.text)} jumps at t = {at:.9g}"
            raise InputError(e.field, e.text, allowed)


def _check_derivatives(e: Expression, times: NDArray[np.float64]) -> None:
    """Raise InputError for a motion of which a derivative is not finite at one of some times."""
    for order, what in enumerate(("value", "velocity", "acceleration")):
        found = np.broadcast_to(e.derivative(times, {}, order), times.shape)
        wrong = times[~np.isfinite(found)]
        if len(wrong):
            raise InputError(e.field, e.text, f"of a finite {what} (not at t = {wrong[0]:.9g})")
