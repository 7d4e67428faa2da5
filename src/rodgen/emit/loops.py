"""Statements to C: grouped into as few loops as their order allows, then written.

A quantity that only its own loop reads is a local of the loop; everything else is an array. In a
function for several lanes at once (states of several rods, or directions of tangents), what
differs from lane to lane has an axis for the lanes, innermost.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

from sympy import Expr, Symbol

from rodgen.emit.analysis import Analysis
from rodgen.emit.printer import C, Printer
from rodgen.emit.statements import CASES, PREFIX, SCALAR, SUMS, Domain, Statement

LANES = 8
# Element of an array of the function, of one that is read through a pointer, or of a lane.
Lanes = Callable[[str], bool]


@dataclass
class Loop:
    """Lines over low <= i <= high, or lines outside of any loop (low > high).

    lines: text, and whether it differs from lane to lane; totals: running sums that start at 0.
    """

    low: int = 0
    high: int = -1
    members: list[Statement] = field(default_factory=list)
    lines: list[tuple[str, bool]] = field(default_factory=list)
    totals: list[str] = field(default_factory=list)

    @property
    def numbers(self) -> list[str]:
        """Numbers that have lanes: arrays along nothing else."""
        return [st.name for st in self.members if not st.domain.along and st.kind == "value"]

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
    and what it reads from outside."""

    phases: tuple[tuple[Loop, ...], ...]
    fields: tuple[tuple[str, int, bool], ...]
    reads: frozenset[str]

    @property
    def bytes(self) -> int:
        """Memory that the arrays take."""
        return sum(8 * count * (LANES if laned else 1) for _, count, laned in self.fields)


class LoopWriter:
    """Writes the statements of one function.

    given: arrays of the function that are filled from outside, with their ranges; lanes: which
    names differ from lane to lane; keep: names that are read from outside; padding: arrays with
    elements before their first, and their least length.
    """

    def __init__(
        self,
        analysis: Analysis,
        phases: Iterable[Iterable[Statement]],
        given: Mapping[str, Domain],
        lanes: Lanes,
        keep: Iterable[str],
        padding: Mapping[str, tuple[int, int]] | None = None,
    ):
        self._analysis, self._given, self._lanes = analysis, given, lanes
        self._keep, self._padding = set(keep), padding or {}
        self._place: dict[str, int] = {}
        self._groups: list[Loop] = []
        self._first: list[int] = []
        for phase in phases:
            self._first.append(len(self._groups))
            for st in phase:
                self._put(st)
        self._arrays = self._find_arrays()

    def code(self) -> Code:
        """All loops with their lines."""
        for group in self._groups:
            for st in group.members:
                self._write(st, group)
        bounds = [*self._first, len(self._groups)]
        phases = tuple(tuple(self._groups[a:b]) for a, b in pairwise(bounds))
        members = [st for group in self._groups for st in group.members]
        reads = set().union(*(self._uses(st) for st in members)) - self._place.keys()
        arrays = [(name, *of) for name, of in self._arrays.items()]
        arrays += [
            (name, domain.count, self._lanes(name))
            for name, domain in self._given.items()
            if domain.count > 0
        ]
        fields = [(a, max(count, self._padding.get(a, (0, 0))[1]), of) for a, count, of in arrays]
        return Code(phases, tuple(fields), frozenset(reads))

    def _uses(self, st: Statement) -> set[str]:
        expr = st.terms.expr if st.terms is not None else st.expr
        return {self._base(symbol)[0] for symbol in expr.free_symbols}

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
        elif st.kind in SUMS:
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
        first = self._first[-1]
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
            for st in group.members:
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

    def _write(self, st: Statement, group: Loop) -> None:
        laned = self._lanes(st.name)
        lane = "[w]" if laned else ""
        if st.kind == PREFIX:
            assert st.terms is not None
            total = f"total_{st.name}"
            group.totals.append(total)
            start = self._analysis.statements[st.name].domain.low
            offset = _offset(1 - start)
            text = self._text(st.terms.expr, st.terms.domain)
            group.lines.append((f"{total}{lane} += {text};", laned))
            group.lines.append((f"x->{st.name}[i{offset}]{lane} = {total}{lane};", laned))
            return
        over = st.domain if group.loops else SCALAR
        text = self._text(st.expr, over)
        if st.kind.startswith("at "):
            line = f"x->{st.name}[{st.domain.low - self._low(st.name)}]{lane} = {text};"
        elif not group.loops:
            line = f"{st.name}[w] = {text};" if laned else f"const double {st.name} = {text};"
        elif st.name in self._arrays:
            line = f"x->{st.name}[i{_offset(-self._low(st.name))}]{lane} = {text};"
        else:
            line = f"const double {st.name} = {text};"
        group.lines.append((line, laned))

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
