"""Exact evaluation at random rational points, for chains too long to compare symbolically.

Angles are taken from Pythagorean triples, so that cosine and sine are rational and every number
below is exact: an entry agrees or it does not, no tolerance is involved.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from sympy import Eq, Expr, IndexedBase, Sum, Symbol

from ..closed_form import Arithmetic, ClosedForm, link_masses
from ..comparison import POINTS, Comparison, DisagreementError
from ..general import GeneralEquations
from ..generic_chain import AtSprings
from ..link_properties import joint_stiffness, link_length, link_parameters, rest_angle
from ..loads import TERMS
from ..loads.joint_law import JointLaw
from ..loads.kinds import JointMoment, Load
from ..symbols import ALPHA, PARAMETERS, i, j, joint_moment, k, l, later, m, n, omega, phi, s
from . import exact
from .exact import evaluate, pythagorean

ENTRIES = 10_000  # of M and of Q, at most
ROWS = 200  # of the vectors and of banded matrices, at most
SUMMED = 200_000  # links in all sums of M and Q, at most
REACH = 2_000  # longest sum over joints that is evaluated

EXACT = Arithmetic(
    exact.cos,
    exact.sin,
    Fraction(1, 2),
    lambda term, low, high: sum(term(q) for q in range(low, high + 1)),
)

# label of an entry, derived expression, indices at which it is evaluated, value of the closed form
Entry = tuple[str, Expr, dict[Any, int], Any]


def prove_at_points(
    links: int,
    boundary: str,
    inertia: str,
    terms: Sequence[str] = TERMS,
    nonuniform: Sequence[str] = (),
) -> Iterator[Comparison]:
    """Compare entries of derivation 2 at n links with the closed form; raises DisagreementError."""
    equations = GeneralEquations(boundary, inertia, tuple(terms), tuple(nonuniform))
    return _Points(equations, links).compare()


class _Points:
    """A random state of a chain in exact numbers, and the closed form there."""

    def __init__(self, derived: GeneralEquations, links: int):
        self.derived, self.draw = derived, random.Random(1)
        palette = [pythagorean(self._rational()) for _ in range(30)]
        directions = [self.draw.choice(palette) for _ in range(links)]
        numbers, angles = {m, l, k}, set[Symbol]()
        self.values: dict[Any, Any] = {n: links, phi: directions}
        for load in derived.loads.values():
            numbers |= {*load.parameters} - {*load.angles}
            angles |= {*load.angles}
            for base in load.per_link:
                self.values[base] = [self._rational() for _ in range(links)]
            for base in load.force_arrays:
                self.values[base] = [self.draw.randint(-99, 99) for _ in range(links + 1)]
        self.values |= {x: self._rational() for x in sorted(numbers, key=str)}
        self.values |= {x: self.draw.choice(palette) for x in sorted(angles, key=str)}
        self.values[ALPHA] = self.draw.choice(palette)
        sizes = (self.values[m], self.values[l], self.values[k])
        lumped = derived.inertia == "lumped"
        of_joints = []
        for what, base in (("stiffness", joint_stiffness), ("rest", rest_angle)):
            found = [self._rational() for _ in range(links + 1)]
            of_joints.append(found if what in derived.nonuniform else None)
            self.values[base] = found
        for name in link_parameters(derived.nonuniform):
            self.values[PARAMETERS[name]] = [self._rational() for _ in range(links)]
        of = {str(base): values for base, values in self.values.items()}.__getitem__
        masses = link_masses(derived.nonuniform, of, lumped, EXACT.half)
        of_rod = (links, *sizes, directions, derived.boundary_condition, EXACT)
        lengths = self.values.get(link_length)
        self.closed = ClosedForm(*of_rod, lumped, of_joints[0], masses, of_joints[1], lengths)
        moving = self.closed.links
        self.rows = sorted(
            {*self.draw.sample(moving, min(len(moving), ROWS)), moving[-1], moving[0]}
        )
        # Where links differ, an entry sums over all behind it, and is one of links i < j.
        most = ENTRIES if masses is None else SUMMED // links
        few = len(moving) ** 2 <= most
        every = ((a, b) for a in moving for b in moving if a != b)
        pairs = every if few else (self._pair(moving) for _ in range(most))
        self.pairs = [pair for pair in pairs if masses is None or pair[0] < pair[1]]

    def _rational(self) -> Fraction:
        return Fraction(self.draw.randint(1, 99), self.draw.randint(1, 99))

    def _pair(self, moving: range) -> tuple[int, int]:
        a, b = self.draw.sample(moving, 2)
        return a, b

    def compare(self) -> Iterator[Comparison]:
        """Yield the comparisons of M, Q, K and all loads."""
        derived, closed = self.derived, self.closed
        yield self._compare_entries("M", self._mass_entries())
        yield self._compare_entries("Q", self._velocity_entries())
        joined = derived.boundary_condition.spring_joints(closed.n)
        if joined:
            stiffness = closed.spring_stiffness
            entries = self._bending_entries(derived.springs, phi, stiffness, ALPHA)
            yield self._compare_entries("K", entries)
            if "rest" in derived.nonuniform:
                yield self._compare_entries("r", self._rest_entries())
        for load in derived.loads.values():
            if isinstance(load, JointMoment):
                if joined:
                    damping = partial(load.coefficient_by_hand, closed, self._value)
                    turning = derived.base_motion.angle[1] or None
                    entries = self._bending_entries(load.moments(derived), omega, damping, turning)
                    yield self._compare_entries(load.letter, entries)
            else:
                yield self._compare_entries(load.letter, self._load_entries(load))

    def _value(self, of: Any) -> Any:
        """A parameter, an array or an expression in exact numbers."""
        return self.values[of] if of in self.values else evaluate(of, self.values)

    def _compare_entries(self, name: str, entries: Iterable[Entry]) -> Comparison:
        count = 0
        for label, expression, at, by_hand in entries:
            value = evaluate(expression, {**self.values, **at})
            if value != by_hand:
                raise DisagreementError(POINTS, f"{name}[{label}]", value, by_hand)
            count += 1
        return Comparison(name, POINTS, count)

    def _mass_entries(self) -> Iterator[Entry]:
        derived, closed = self.derived, self.closed
        yield from self._pair_entries(derived.mass_link_link, closed.M_link_link)
        for a in self.rows:
            yield f"phi_{a},phi_{a}", derived.mass_link, {i: a}, closed.M_link(a)
        if derived.boundary_condition.translates:
            yield "x0,x0", derived.mass_base, {}, closed.M_base()
            yield from self._column_entries(derived.mass_base_link, closed.M_base_link)

    def _velocity_entries(self) -> Iterator[Entry]:
        derived, closed = self.derived, self.closed
        yield from self._pair_entries(derived.velocity_link_link, closed.Q_link_link)
        if derived.boundary_condition.translates:
            yield from self._column_entries(derived.velocity_base_link, closed.Q_base_link)

    def _pair_entries(
        self, expression: Expr, by_hand: Callable[[int, int, int], Any]
    ) -> Iterator[Entry]:
        for a, b in self.pairs:
            at = {i: a, j: b, later: max(a, b)}
            yield f"phi_{a},phi_{b}", expression, at, by_hand(a, b, max(a, b))

    def _column_entries(
        self, expressions: Sequence[Expr], by_hand: Callable[[int], Sequence[Any]]
    ) -> Iterator[Entry]:
        for a in self.rows:
            for axis, expression, hand in zip("xy", expressions, by_hand(a), strict=True):
                yield f"{axis}0,phi_{a}", expression, {i: a}, hand

    def _load_entries(self, load: Load) -> Iterator[Entry]:
        work, closed = load.generalised_forces(self.derived), self.closed
        if isinstance(load, JointLaw):
            for a in self.rows:
                here = self._moment_on_link(a, load.moments(self.derived), omega)
                yield f"phi_{a}", here, {i: a}, load.link_by_hand(closed, a, self._value)
            return
        assert work is not None
        sums = any(e.has(Sum) for e in (*work.base, work.link))
        if self.derived.boundary_condition.translates and (not sums or closed.n <= REACH):
            by_hand = load.base_by_hand(closed, self._value)
            for axis, expression, value in zip("xy", work.base, by_hand, strict=True):
                yield f"{axis}0", expression, {}, value
        for a in self.rows:
            if not sums or closed.n - a <= REACH:
                yield f"phi_{a}", work.link, {i: a}, load.link_by_hand(closed, a, self._value)

    def _bending_entries(
        self,
        moments: AtSprings,
        of: IndexedBase,
        factor: Callable[[int, int], Any],
        clamp: Symbol | None = None,
    ) -> Iterator[Entry]:
        """Coefficients of the three links that bend a link, from the moments at its ends; factor:
        coefficient of a joint of a size in the closed form; clamp: angle or rate before the first
        link and behind the last, unless it is zero."""
        last = self.closed.n - 1
        for a in self.rows:
            here = self._moment_on_link(a, moments, of)
            ends = self.closed.joint_sizes(a)
            row = self.closed.bending_row(factor(a, ends[0]), factor(a + 1, ends[1]))
            behind = clamp if a == last and self.closed.tail_size else of[i + 1]
            neighbours = (of[i - 1] if a else clamp, of[i], behind)
            by_hand: dict[Any, Any] = {}
            for neighbour, hand in zip(neighbours, row, strict=True):
                by_hand[neighbour] = by_hand.get(neighbour, 0) + hand
            for neighbour, hand in by_hand.items():
                if neighbour is not None:
                    yield f"phi_{a},{neighbour}", -here.diff(neighbour), {i: a}, hand

    def _moment_on_link(self, a: int, moments: AtSprings, of: IndexedBase) -> Expr:
        """Moment on link a of the joints at its ends, with i for its number."""
        inner, root, tail = moments
        last = self.closed.n - 1
        work = self.derived.link_moment.subs(n, self.closed.n)
        start = inner.subs(s, i) if a else root.xreplace({of[0]: of[i]})
        here = work.subs({Eq(i, at): at == a for at in (0, last)})
        end = inner.subs(s, i + 1) if a < last else tail.subs(n, i + 1)
        return here.xreplace({joint_moment[i]: start, joint_moment[i + 1]: end})

    def _rest_entries(self) -> Iterator[Entry]:
        """Moments on links where all angles are zero."""
        by_hand = self.closed.rest()[2 * self.derived.boundary_condition.translates :]
        for a in self.rows:
            here = self._moment_on_link(a, self.derived.springs, phi)
            held = self.derived.base_motion.clamp_angle.free_symbols
            angles = dict.fromkeys((phi[i - 1], phi[i], phi[i + 1], *held), 0)
            hand = by_hand[a - self.closed.links[0]]
            yield f"phi_{a}", here.xreplace(angles), {i: a}, hand
