"""Loop fusion: the statements of a function, grouped into as few loops as their order allows.

In lanes, what is the same at every index is taken out of the loop first, and loops over the links
join that of the rows between them.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass, field

from sympy import Expr, Mul, Symbol

from rodgen.emit.analysis import Analysis
from rodgen.emit.statements import CASES, PREFIX, SCALAR, SUMS, TOTAL, Domain, Statement

# Whether a name differs from lane to lane.
Lanes = Callable[[str], bool]
# A group that reads a quantity, and how far from the index; None at a fixed place.
Reader = tuple[int, int | None]


@dataclass
class Loop:
    """Lines over low <= i <= high, or lines outside of any loop (low > high).

    lines: text, and whether it differs from lane to lane; totals: running sums that start at 0;
    numbers: those that have lanes, arrays along nothing else; ahead: what is made in the same loop
    but from low - 1 on, for the rows on both sides.
    """

    low: int = 0
    high: int = -1
    members: list[Statement] = field(default_factory=list)
    ahead: list[Statement] = field(default_factory=list)
    lines: list[tuple[str, bool]] = field(default_factory=list)
    ahead_lines: list[tuple[str, bool]] = field(default_factory=list)
    totals: list[str] = field(default_factory=list)
    numbers: list[str] = field(default_factory=list)

    @property
    def is_loop(self) -> bool:
        return self.low <= self.high

    @property
    def has_total(self) -> bool:
        """Whether any line is a sum over the chain."""
        return any(st.kind == TOTAL for st in self.members)

    @property
    def has_lanes(self) -> bool:
        """Whether any line differs from lane to lane."""
        return any(laned for _, laned in self.lines)


class Fusion:
    """The loops of one function.

    lanes: which names differ from lane to lane; keep: names that are read from outside; system:
    quantities that are eliminated row by row, in the loop that computes them if that is one.
    """

    def __init__(
        self,
        analysis: Analysis,
        phases: Iterable[Iterable[Statement]],
        lanes: Lanes,
        keep: Iterable[str],
        system: Iterable[str] = (),
    ):
        self._analysis, self._lanes, self._keep = analysis, lanes, set(keep)
        self.place: dict[str, int] = {}
        self.groups: list[Loop] = []
        self.first: list[int] = []  # group of every phase
        self._floor = 0
        rows: set[str] = set()
        self._factors: dict[Expr, Symbol] = {}
        self._known: dict[Expr, list[tuple[str, int | None]]] = {}
        for given_phase in phases:
            phase = [part for st in given_phase for part in self._hoist_factors(st)]
            self.first.append(len(self.groups))
            self._floor = len(self.groups)
            rows = rows or self._elimination_rows(set(system), phase)
            for st in phase:
                if st.name not in rows:
                    self._place_statement(st)
            made = [st for st in phase if st.name in rows]
            if made:
                self._floor = len(self.groups)
            for st in made:
                self._place_statement(st)
        self.system = self.groups[self.place[min(rows)]] if rows else None
        self._keep -= rows
        self._readers = self._find_readers()
        self._sink()
        if self.system is not None and lanes("phi"):
            self._merge_loops(self.system)
        self.arrays = self._find_arrays()

    def source(self, symbol: Symbol) -> tuple[str, int | None]:
        """Name of the quantity that a symbol reads, and its offset (None: at a fixed place)."""
        element = self._analysis.read(symbol)
        if element is None:
            return str(symbol), 0
        return element.base, element.offset if element.along else None

    def reads(self, st: Statement) -> list[tuple[str, int | None]]:
        """Quantities that a statement reads, and how far from the index."""
        return self._read(st.terms.expr if st.terms is not None else st.expr)

    def _read(self, expr: Expr) -> list[tuple[str, int | None]]:
        if expr not in self._known:
            self._known[expr] = [self.source(symbol) for symbol in expr.free_symbols]
        return self._known[expr]

    def _hoist_factors(self, st: Statement) -> Iterator[Statement]:
        """Yield the factors of a statement along the chain that are the same at every index, as
        statements, then the statement itself: in lanes, no compiler takes them out of the loop."""
        if st.kind in SUMS:
            assert st.terms is not None
            st.terms.expr = yield from self._hoist_from(st.terms.expr)
        elif st.domain.along and (st.kind != CASES or st.inner.count > 0):
            st.expr = yield from self._hoist_from(st.expr)
        yield st

    def _hoist_from(self, expr: Expr) -> Generator[Statement, None, Expr]:
        if not expr.args or not self._analysis.axes(expr):
            return expr
        args = []
        for arg in expr.args:
            args.append((yield from self._hoist_from(arg)))
        if expr.is_Mul:
            fixed = [a for a in args if not self._analysis.axes(a)]
            product = Mul(*fixed)
            if product.free_symbols and not (product.is_Symbol or (-product).is_Symbol):
                if product not in self._factors:
                    name = f"b{len(self._factors)}"
                    self._factors[product] = Symbol(name, real=True)
                    number = Statement(name, "value", SCALAR, product)
                    self._analysis.statements[name] = number
                    yield number
                rest = [a for a in args if self._analysis.axes(a)]
                return Mul(self._factors[product], *rest)
        return expr.func(*args)

    def _place_statement(self, st: Statement) -> None:
        """Find a place for a statement, after all that it uses."""
        if st.kind == CASES:
            inner = Statement(st.name, "inside", st.inner, st.expr)
            places = [self._join_group(inner)] if st.inner.count > 0 else []
            for at, expr in st.ends.items():
                single = Domain(st.domain.indices[1:], at, at)
                # Inside, a single position is written over.
                after = places[0] + 1 if st.inner.low <= at <= st.inner.high else 0
                places.append(self._join_group(Statement(st.name, f"at {at}", single, expr), after))
            self.place[st.name] = max(places)
        elif st.kind == PREFIX:
            self.place[st.name] = self._join_group(st)
        elif st.kind == TOTAL:
            # Terms first, as an array: added up in lanes, they need not wait for one another.
            assert st.terms is not None
            terms = st.terms
            self.place[terms.name] = self._join_group(terms)
            added = Statement(st.name, TOTAL, SCALAR, Symbol(terms.name, real=True))
            self.place[st.name] = self._join_group(added)
        elif st.kind in SUMS:
            # Only the dense form has them, which is NumPy's.
            raise NotImplementedError(f"no loop for {st.kind} sums")
        else:
            self.place[st.name] = self._join_group(st)

    def _span(self, st: Statement) -> tuple[int, int]:
        """Range of the loop that a statement needs; empty outside of loops."""
        if st.kind == PREFIX:
            assert st.terms is not None
            return st.terms.domain.low, st.terms.domain.high
        if not st.domain.along or st.kind.startswith("at "):
            return 0, -1
        return st.domain.low, st.domain.high

    def _join_group(self, st: Statement, after: int = 0) -> int:
        """Put a statement into the first group that takes it, at a place or after it."""
        span = self._span(st)
        first = max(self._floor, after)
        for name, offset in self.reads(st):
            if name not in self.place:
                continue
            place = self.place[name]
            group = self.groups[place]
            same = (group.low, group.high) == span and offset == 0
            made = [m for m in group.members if m.name == name]
            joins = same and len(made) == 1 and made[0].kind == "value" and group.is_loop
            outside = not group.is_loop and span == (0, -1)
            first = max(first, place if joins or outside else place + 1)
        for place in range(first, len(self.groups)):
            group = self.groups[place]
            adds_up = any(member.kind == PREFIX for member in group.members)
            alike = not group.is_loop or (st.kind == PREFIX) == adds_up
            if (group.low, group.high) == span and alike:
                group.members.append(st)
                return place
        self.groups.append(Loop(*span, members=[st]))
        return len(self.groups) - 1

    def _elimination_rows(self, names: set[str], phase: list[Statement]) -> set[str]:
        """Names of the quantities that are eliminated row by row, and of all that only these read,
        where one loop can compute them; else none. Couplings that begin one row earlier are
        computed with the links."""
        made = {st.name: st for st in phase}
        wanted = [made[name] for name in names if name in made]
        if not wanted or any(st.kind != "value" for st in wanted):
            return set()
        low = max(self._span(st)[0] for st in wanted)
        rows = {st.name for st in wanted if self._span(st)[0] == low}
        alike = len({self._span(st) for st in wanted}) == 1
        if not alike and not all(self._lanes(name) for name in names):
            return set()
        span = self._span(made[min(rows)])
        readers: dict[str, set[tuple[str, int | None]]] = defaultdict(set)
        for st in phase:
            for expr in self._expressions(st):
                for name, offset in self._read(expr):
                    readers[name].add((st.name, offset))
        for st in reversed(phase):
            if st.name in rows or st.kind != "value" or self._span(st) != span:
                continue
            by = readers[st.name]
            if by and all(name in rows and offset == 0 for name, offset in by):
                rows.add(st.name)
        return rows

    def _expressions(self, st: Statement) -> Iterator[Expr]:
        """All that a statement computes, the terms of a sum included."""
        if st.terms is not None:
            yield st.terms.expr
        yield from (expr for expr, _ in st.parts())

    def _find_readers(self) -> dict[str, Counter[Reader]]:
        """Numbers of reads of every quantity, by group and offset."""
        found: dict[str, Counter[Reader]] = defaultdict(Counter)
        for place, group in enumerate(self.groups):
            for st in group.members:
                for name, offset in self.reads(st):
                    found[name][place, offset] += 1
        return found

    def _move(self, st: Statement, place: int, target: int) -> None:
        """Record that a statement has moved from one group to another."""
        for name, offset in self.reads(st):
            readers = self._readers[name]
            readers[target, offset] += 1
            readers[place, offset] -= 1
            if not readers[place, offset]:
                del readers[place, offset]
        self.place[st.name] = target

    def _sink(self) -> None:
        """Move what only one later loop reads into that loop, where it costs no array; not what is
        made of other locals, which would become arrays instead."""
        for place in reversed(range(len(self.groups))):
            group = self.groups[place]
            for st in reversed(group.members):
                readers = self._readers[st.name]
                alone = st.kind == "value" and group.is_loop and st.name not in self._keep
                if not alone or len(readers) != 1:
                    continue
                ((reader, offset),) = readers
                target = self.groups[reader]
                alike = (target.low, target.high) == (group.low, group.high) and reader > place
                if offset != 0 or not alike:
                    continue
                if any(self.place.get(name) == place for name, _ in self.reads(st)):
                    continue
                group.members.remove(st)
                target.members.insert(0, st)
                self._move(st, place, reader)

    def _merge_loops(self, system: Loop) -> None:
        """Merge loops over the links into that of the rows between them, in lanes: there no loop
        over the index is vectorised, and long chains of operations overlap with short ones."""
        here = self.groups.index(system)
        later = self.first[1]
        for place in reversed(range(here)):
            group = self.groups[place]
            if (group.low, group.high) != (system.low - 1, system.high):
                continue
            fits = all(
                reader == place or reader >= later or (reader == here and offset in (0, -1))
                for st in group.members
                for reader, offset in self._readers[st.name]
            )
            if fits and all(st.kind == "value" for st in group.members):
                for st in group.members:
                    self._move(st, place, here)
                system.ahead = group.members + system.ahead
                group.members = []
        # Places number what is left.
        self.groups = [g if g.members or g is system else Loop() for g in self.groups]

    def _find_arrays(self) -> dict[str, tuple[int, bool]]:
        """Quantities along the chain that more than their own loop reads."""
        needed = set(self._keep)
        for place, group in enumerate(self.groups):
            # What is made ahead is made in lines of their own, which the rows do not see into.
            made = {st.name for st in group.ahead}
            needed |= made & {name for st in group.members for name, _ in self.reads(st)}
            for st in (*group.ahead, *group.members):
                if st.kind != "value":
                    needed.add(st.name)
                for name, offset in self.reads(st):
                    if self.place.get(name) != place or offset != 0:
                        needed.add(name)
        out = {}
        for st in self._analysis.statements.values():
            if st.name in needed and st.name in self.place and st.domain.along:
                out[st.name] = st.count, self._lanes(st.name)
        return out
