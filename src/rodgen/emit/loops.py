"""Statements to C: grouped into as few loops as their order allows, then written.

A quantity that only its own loop reads is a local of the loop; everything else is an array. In a
function for several lanes at once (states of several rods, or directions of tangents), what
differs from lane to lane has an axis for the lanes, innermost.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

from sympy import Expr, Mul, Symbol

from rodgen.emit.analysis import Analysis
from rodgen.emit.printer import C, Printer
from rodgen.emit.statements import CASES, PREFIX, SCALAR, SUMS, TOTAL, Domain, Statement

LANES = 8
# Element of an array of the function, of one that is read through a pointer, or of a lane.
Lanes = Callable[[str], bool]


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
    def loops(self) -> bool:
        return self.low <= self.high

    @property
    def laned(self) -> bool:
        """Whether any line differs from lane to lane."""
        return any(laned for _, laned in self.lines)


@dataclass(frozen=True)
class Code:
    """A function, written: its loops by phase, its arrays as (name, length, whether it has lanes),
    what it reads from outside, the loop whose rows are eliminated, and the locals of that."""

    phases: tuple[tuple[Loop, ...], ...]
    fields: tuple[tuple[str, int, bool], ...]
    reads: frozenset[str]
    system: Loop | None
    locals: frozenset[str]

    @property
    def bytes(self) -> int:
        """Memory that the arrays take."""
        return sum(8 * count * (LANES if laned else 1) for _, count, laned in self.fields)


class LoopWriter:
    """Writes the statements of one function.

    given: arrays of the function that are filled from outside, with their ranges; lanes: which
    names differ from lane to lane; keep: names that are read from outside; padding: arrays with
    elements before their first, and their least length; system: quantities that are eliminated
    row by row, in the loop that computes them if that is one.
    """

    def __init__(
        self,
        analysis: Analysis,
        phases: Iterable[Iterable[Statement]],
        given: Mapping[str, Domain],
        lanes: Lanes,
        keep: Iterable[str],
        padding: Mapping[str, tuple[int, int]] | None = None,
        system: Iterable[str] = (),
    ):
        self._analysis, self._given, self._lanes = analysis, given, lanes
        self._keep, self._padding = set(keep), padding or {}
        self._place: dict[str, int] = {}
        self._groups: list[Loop] = []
        self._first: list[int] = []
        self._floor = 0
        rows: set[str] = set()
        self._factors: dict[Expr, Symbol] = {}
        self._reads: dict[Expr, dict[str, list[int | None]]] = {}
        for given_phase in phases:
            phase = [part for st in given_phase for part in self._hoisted(st)]
            self._first.append(len(self._groups))
            self._floor = len(self._groups)
            rows = rows or self._rows(set(system), phase)
            for st in phase:
                if st.name not in rows:
                    self._put(st)
            made = [st for st in phase if st.name in rows]
            if made:
                self._floor = len(self._groups)
            for st in made:
                self._put(st)
        self.system = self._groups[self._place[min(rows)]] if rows else None
        self._keep -= rows
        self._sink()
        if self.system is not None and self._lanes("phi"):
            self._take_along(self.system)
        self._arrays = self._find_arrays()

    def code(self) -> Code:
        """All loops with their lines."""
        for group in self._groups:
            for st in group.ahead:
                self._write(st, group, group.ahead_lines)
            for st in group.members:
                self._write(st, group, group.lines)
        bounds = [*self._first, len(self._groups)]
        phases = tuple(tuple(self._groups[a:b]) for a, b in pairwise(bounds))
        members = [st for group in self._groups for st in (*group.ahead, *group.members)]
        reads = set().union(*(self._uses(st) for st in members)) - self._place.keys()
        arrays = [(name, *of) for name, of in self._arrays.items()]
        arrays += [
            (name, domain.count, self._lanes(name))
            for name, domain in self._given.items()
            if domain.count > 0
        ]
        fields = [(a, max(count, self._padding.get(a, (0, 0))[1]), of) for a, count, of in arrays]
        if self.system is not None:
            phases = (tuple(g for g in phases[0] if g is not self.system), *phases[1:])
        made = self.system.members if self.system is not None else []
        local = frozenset(st.name for st in made) - self._arrays.keys()
        return Code(phases, tuple(fields), frozenset(reads), self.system, local)

    def _uses(self, st: Statement) -> set[str]:
        expr = st.terms.expr if st.terms is not None else st.expr
        return {self._base(symbol)[0] for symbol in expr.free_symbols}

    def _hoisted(self, st: Statement) -> Iterator[Statement]:
        """A statement along the chain after the factors that are the same at every index, each as
        a statement of its own: in lanes, no compiler takes them out of the loop."""
        if st.kind in SUMS:
            assert st.terms is not None
            st.terms.expr = yield from self._outside(st.terms.expr)
        elif st.domain.along and (st.kind != CASES or st.inner.count > 0):
            st.expr = yield from self._outside(st.expr)
        yield st

    def _outside(self, expr: Expr) -> Generator[Statement, None, Expr]:
        if not expr.args or not self._analysis.axes(expr):
            return expr
        args = []
        for arg in expr.args:
            args.append((yield from self._outside(arg)))
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

    # Grouping ---------------------------------------------------------------------------------

    def _put(self, st: Statement) -> None:
        """Find a place for a statement, after all that it uses."""
        if st.kind == CASES:
            inner = Statement(st.name, "inside", st.inner, st.expr)
            places = [self._into(inner)] if st.inner.count > 0 else []
            for at, expr in st.ends.items():
                single = Domain(st.domain.indices[1:], at, at)
                places.append(self._into(Statement(st.name, f"at {at}", single, expr)))
            self._place[st.name] = max(places)
        elif st.kind == PREFIX:
            self._place[st.name] = self._into(st)
        elif st.kind == TOTAL:
            # Terms first, as an array: added up in lanes, they need not wait for one another.
            assert st.terms is not None
            terms = st.terms
            self._place[terms.name] = self._into(terms)
            added = Statement(st.name, TOTAL, SCALAR, Symbol(terms.name, real=True))
            self._place[st.name] = self._into(added)
        elif st.kind in SUMS:
            # Only the dense form has them, which is NumPy's.
            raise NotImplementedError(f"no loop for {st.kind} sums")
        else:
            self._place[st.name] = self._into(st)

    def _span(self, st: Statement) -> tuple[int, int]:
        """Range of the loop that a statement needs; empty outside of loops."""
        if st.kind == PREFIX:
            assert st.terms is not None
            return st.terms.domain.low, st.terms.domain.high
        if not st.domain.along or st.kind.startswith("at "):
            return 0, -1
        return st.domain.low, st.domain.high

    def _into(self, st: Statement) -> int:
        """Put a statement into the first group that takes it."""
        span = self._span(st)
        expr = st.terms.expr if st.terms is not None else st.expr
        first = self._floor
        for symbol in expr.free_symbols:
            name, offset = self._base(symbol)
            if name not in self._place:
                continue
            place = self._place[name]
            group = self._groups[place]
            same = (group.low, group.high) == span and offset == 0
            made = [m for m in group.members if m.name == name]
            joins = same and len(made) == 1 and made[0].kind == "value" and group.loops
            outside = not group.loops and span == (0, -1)
            first = max(first, place if joins or outside else place + 1)
        for place in range(first, len(self._groups)):
            if (self._groups[place].low, self._groups[place].high) == span:
                if self._groups[place].loops and (st.kind == PREFIX) != self._sums(place):
                    continue
                self._groups[place].members.append(st)
                return place
        self._groups.append(Loop(*span, members=[st]))
        return len(self._groups) - 1

    def _rows(self, names: set[str], phase: list[Statement]) -> set[str]:
        """The quantities that are eliminated row by row and what they alone are made of, where one
        loop can make them all; else nothing. Couplings that begin one row earlier are made with
        the links."""
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
        for st in reversed(phase):
            if st.name in rows or st.kind != "value" or self._span(st) != span:
                continue
            readers = [
                (other.name, self._base(symbol)[1])
                for other in phase
                for expr in self._expressions(other)
                for symbol in expr.free_symbols
                if self._base(symbol)[0] == st.name
            ]
            if readers and all(name in rows and offset == 0 for name, offset in readers):
                rows.add(st.name)
        return rows

    def _expressions(self, st: Statement) -> Iterator[Expr]:
        """All that a statement computes, the terms of a sum included."""
        if st.terms is not None:
            yield st.terms.expr
        yield from (expr for expr, _ in st.parts())

    def _readers(self, name: str) -> list[tuple[int, int | None]]:
        """Groups that read a quantity, each with the offset."""
        found = []
        for place, group in enumerate(self._groups):
            for st in (*group.ahead, *group.members):
                expr = st.terms.expr if st.terms is not None else st.expr
                found += [(place, offset) for offset in self._read(expr).get(name, ())]
        return found

    def _read(self, expr: Expr) -> dict[str, list[int | None]]:
        """Quantities that an expression reads, each with its offsets."""
        known = self._reads.get(expr)
        if known is None:
            known = self._reads[expr] = {}
            for symbol in expr.free_symbols:
                name, offset = self._base(symbol)
                known.setdefault(name, []).append(offset)
        return known

    def _sink(self) -> None:
        """Move what only one later loop reads into that loop, where it costs no array; not what
        is made of other locals, which would become arrays instead."""
        for place in reversed(range(len(self._groups))):
            group = self._groups[place]
            for st in reversed(group.members):
                readers = self._readers(st.name)
                if st.kind != "value" or not group.loops or st.name in self._keep or not readers:
                    continue
                (first, offset), *more = readers
                target = self._groups[first]
                alike = (target.low, target.high) == (group.low, group.high) and first > place
                if offset != 0 or any(r != (first, 0) for r in more) or not alike:
                    continue
                bases = [self._base(symbol) for symbol in st.expr.free_symbols]
                if any(self._place.get(base) == place for base, _ in bases):
                    continue
                group.members.remove(st)
                target.members.insert(0, st)
                self._place[st.name] = first

    def _take_along(self, system: Loop) -> None:
        """Take loops over the links into that of the rows between them, in lanes: there no loop
        over the index is vectorised, and long chains of operations overlap with short ones."""
        here = self._groups.index(system)
        later = self._first[1]
        for place in reversed(range(here)):
            group = self._groups[place]
            if (group.low, group.high) != (system.low - 1, system.high):
                continue
            readers = [r for st in group.members for r in self._readers(st.name)]
            fits = all(
                reader == place or reader >= later or (reader == here and offset in (0, -1))
                for reader, offset in readers
            )
            if fits and all(st.kind == "value" for st in group.members):
                system.ahead = group.members + system.ahead
                group.members = []
                for st in system.ahead:
                    self._place[st.name] = here
        # Places number what is left.
        self._groups = [g if g.members or g is system else Loop() for g in self._groups]

    def _sums(self, place: int) -> bool:
        """Whether a group adds up, link by link."""
        return any(st.kind == PREFIX for st in self._groups[place].members)

    def _base(self, symbol: Symbol) -> tuple[str, int | None]:
        """The quantity that a symbol reads, and how far from the index."""
        element = self._analysis.read(symbol)
        if element is None:
            return str(symbol), 0
        return element.base, element.offset if element.along else None

    def _find_arrays(self) -> dict[str, tuple[int, bool]]:
        """Quantities along the chain that more than their own loop reads."""
        needed = set(self._keep)
        for place, group in enumerate(self._groups):
            for st in (*group.ahead, *group.members):
                if st.kind != "value":
                    needed.add(st.name)
                expr = st.terms.expr if st.terms is not None else st.expr
                for symbol in expr.free_symbols:
                    name, offset = self._base(symbol)
                    if self._place.get(name) != place or offset != 0:
                        needed.add(name)
        out = {}
        for st in self._analysis.statements.values():
            if st.name in needed and st.name in self._place and st.domain.along:
                out[st.name] = st.count, self._lanes(st.name)
        return out

    # Writing ----------------------------------------------------------------------------------

    def _write(self, st: Statement, group: Loop, lines: list[tuple[str, bool]]) -> None:
        laned = self._lanes(st.name)
        lane = "[w]" if laned else ""
        if st.kind == PREFIX:
            assert st.terms is not None
            total = f"total_{st.name}"
            group.totals.append(total)
            start = self._analysis.statements[st.name].domain.low
            offset = _offset(1 - start)
            text = self._text(st.terms.expr, st.terms.domain)
            lines.append((f"{total}{lane} += {text};", laned))
            lines.append((f"x->{st.name}[i{offset}]{lane} = {total}{lane};", laned))
            return
        if st.kind == TOTAL:
            terms = str(st.expr)
            count = self._arrays[terms][0]
            lines.append((f"const double {st.name} = total(x->{terms}, {count});", laned))
            return
        over = st.domain if group.loops else SCALAR
        text = self._text(st.expr, over)
        if st.kind.startswith("at "):
            line = f"x->{st.name}[{st.domain.low - self._low(st.name)}]{lane} = {text};"
        elif not group.loops:
            line = f"{st.name}[w] = {text};" if laned else f"const double {st.name} = {text};"
            group.numbers += [st.name] if laned else []
        elif st.name in self._arrays:
            line = f"x->{st.name}[i{_offset(-self._low(st.name))}]{lane} = {text};"
        else:
            line = f"const double {st.name} = {text};"
        lines.append((line, laned))

    def _text(self, expr: Expr, over: Domain) -> str:
        inside = bool(over.along)
        printer = Printer(
            C,
            lambda symbol: self._name(symbol, inside),
            lambda symbol: len(self._analysis.axes(symbol)),
        )
        return printer(expr)

    def _name(self, symbol: Symbol, inside: bool) -> str:
        """How a symbol is written in a line."""
        element = self._analysis.read(symbol)
        name, offset = self._base(symbol)
        lane = "[w]" if self._lanes(name) else ""
        if element is None or (not element.along and element.base == str(symbol)):
            return f"{name}{lane}"
        low = self._low(name)
        field = f"x->{name}" if name in self._arrays or name in self._given else name
        if not element.along:
            return f"{field}[{element.offset - low}]{lane}"
        if name in self._place and name not in self._arrays:
            return name
        assert inside
        assert offset is not None
        return f"{field}[i{_offset(offset - low)}]{lane}"

    def _low(self, name: str) -> int:
        """First index of an array."""
        made = self._analysis.statements.get(name)
        domain = made.domain if made is not None else self._given.get(name)
        before, _ = self._padding.get(name, (0, 0))
        return domain.low - before if domain is not None else 0


def _offset(number: int) -> str:
    return f" {'+' if number > 0 else '-'} {abs(number)}" if number else ""
