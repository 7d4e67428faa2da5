"""Writer of statements as loops in C.

A quantity that only its own loop reads is a local of the loop; everything else is an array. In a
function for several lanes at once (states of several rods, or directions of tangents), what
differs from lane to lane has an axis for the lanes, innermost.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from sympy import Abs, Expr, Max, Min, Symbol, cos, sin

from rodgen.emit.analysis import Analysis
from rodgen.emit.c.fusion import Fusion, Lanes, Loop
from rodgen.emit.printer import ATOM, NAMES, PRODUCT, Dialect, Printer
from rodgen.emit.statements import PREFIX, SCALAR, TOTAL, VALUE, Domain, Statement
from rodgen.native.native_batch import LANES
from rodgen.scene.grammar import CUBIC, LINEAR, SLOPE, Language


def _power(base: str, exponent: str, strength: int) -> tuple[str, int]:
    if exponent == "2":
        return f"square({base})", ATOM
    if exponent == "3" and strength == ATOM:
        return f"{base}*square({base})", PRODUCT
    return f"pow({base}, {exponent})", ATOM


# With least and greatest of two numbers, as they are not-a-number where one of them is.
SCENE = Language(
    prefix="",
    names={"min": "least", "max": "greatest", "abs": "fabs"},
    choice="({0} ? {1} : {2})",
    power="pow({0}, {1})",
    list="(const double[]){{{0}}}",
    part="p + {start}{first}",
    tables={
        kind: f"{kind}({{0}}, {{1}}, {{2}}, {{3}})"
        for kind in (LINEAR, CUBIC, LINEAR + SLOPE, CUBIC + SLOPE, CUBIC + SLOPE + SLOPE)
    },
)
EQUATIONS = Dialect(
    functions=NAMES | {sin: "sine", cos: "cosine", Abs: "fabs", Min: "fmin", Max: "fmax"},
    root="sqrt",
    choice="({condition} ? {value} : {other})",
    power=_power,
    fraction="{p}.0/{q}",
    language=SCENE,
)


@dataclass(frozen=True)
class Code:
    """Text of a function: its loops by phase, its arrays as (name, length, whether it has lanes),
    what it reads from outside, the loop whose rows are eliminated, and the locals of that."""

    phases: tuple[tuple[Loop, ...], ...]
    fields: tuple[tuple[str, int, bool], ...]
    reads: frozenset[str]
    system: Loop | None
    locals: frozenset[str]

    @property
    def lines(self) -> Iterator[str]:
        """The text of all loops, line by line."""
        loops = [loop for phase in self.phases for loop in phase]
        for loop in [*loops, self.system] if self.system is not None else loops:
            yield from (text for text, _ in (*loop.ahead_lines, *loop.lines))

    @property
    def bytes(self) -> int:
        """Memory that the arrays take [bytes]."""
        return sum(8 * count * (LANES if laned else 1) for _, count, laned in self.fields)


class LoopWriter:
    """Writer of the statements of one function.

    given: arrays of the function that are filled from outside, with their ranges; lanes: which
    names differ from lane to lane; keep: names that are read from outside; padding: arrays with
    elements before their first, and their least length; system: quantities that are eliminated
    row by row, in the loop that computes them if that is one; clock: how the time is written.
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
        clock: str = "t",
    ):
        self._clock = clock
        self._analysis, self._given, self._lanes = analysis, given, lanes
        self._padding = padding or {}
        self._loops = Fusion(analysis, phases, lanes, keep, system)
        self._arrays = self._loops.arrays

    def write(self) -> Code:
        """Write all loops."""
        loops = self._loops
        groups, system = loops.groups, loops.system
        for group in groups:
            for st in group.ahead:
                self._write_statement(st, group, group.ahead_lines)
            for st in group.members:
                self._write_statement(st, group, group.lines)
        bounds = [*loops.first, len(groups)]
        phases = tuple(tuple(groups[a:b]) for a, b in pairwise(bounds))
        members = [st for group in groups for st in (*group.ahead, *group.members)]
        reads = {name for st in members for name, _ in loops.reads(st)} - loops.place.keys()
        arrays = [(name, *of) for name, of in self._arrays.items()]
        arrays += [
            (name, domain.count, self._lanes(name))
            for name, domain in self._given.items()
            if domain.count > 0
        ]
        fields = [(a, max(count, self._padding.get(a, (0, 0))[1]), of) for a, count, of in arrays]
        fields = [field for field in fields if field[1] > 0]
        if system is not None:
            phases = (tuple(g for g in phases[0] if g is not system), *phases[1:])
        made = system.members if system is not None else []
        local = frozenset(st.name for st in made) - self._arrays.keys()
        return Code(phases, tuple(fields), frozenset(reads), system, local)

    def _write_statement(self, st: Statement, group: Loop, lines: list[tuple[str, bool]]) -> None:
        laned = self._lanes(st.name)
        lane = "[w]" if laned else ""
        if st.kind == PREFIX:
            assert st.terms is not None
            if not group.is_loop:  # over one link: before it there is nothing
                lines.append((f"x->{st.name}[0]{lane} = 0.0;", laned))
                return
            total = f"total_{st.name}"
            group.totals.append(total)
            start = self._analysis.statements[st.name].domain.low
            offset = _offset_text(1 - start)
            text = self._text(st.terms.expr, st.terms.domain)
            lines.append((f"{total}{lane} += {text};", laned))
            lines.append((f"x->{st.name}[i{offset}]{lane} = {total}{lane};", laned))
            return
        if st.kind == TOTAL:
            terms = str(st.expr)
            count = self._analysis.statements[terms].count
            if count < 1:
                group.numbers += [st.name] if laned else []
                lines.append((f"{'' if laned else 'const double '}{st.name}{lane} = 0.0;", laned))
            elif laned:
                lines.append((f"double {st.name}[LANES];", False))
                lines.append((f"totals(x->{terms}, {count}, {st.name});", False))
            else:
                lines.append((f"const double {st.name} = total(x->{terms}, {count});", False))
            return
        if st.kind == VALUE and st.domain.along and not group.is_loop:
            return  # there are none, such as springs inside of one link
        over = st.domain if group.is_loop else SCALAR
        text = self._text(st.expr, over)
        if st.kind.startswith("at "):
            line = f"x->{st.name}[{st.domain.low - self._first_index(st.name)}]{lane} = {text};"
        elif not group.is_loop:
            line = f"{st.name}[w] = {text};" if laned else f"const double {st.name} = {text};"
            group.numbers += [st.name] if laned else []
        elif st.name in self._arrays:
            line = f"x->{st.name}[i{_offset_text(-self._first_index(st.name))}]{lane} = {text};"
        else:
            line = f"const double {st.name} = {text};"
        lines.append((line, laned))

    def _text(self, expr: Expr, over: Domain) -> str:
        inside = bool(over.along)
        printer = Printer(
            EQUATIONS,
            lambda symbol: self._symbol_text(symbol, inside),
            lambda symbol: len(self._analysis.axes(symbol)),
            "w * stride + " if self._lanes("phi") else "",
            self._clock,
        )
        return printer(expr)

    def _symbol_text(self, symbol: Symbol, inside: bool) -> str:
        """Text of a symbol in a line."""
        element = self._analysis.read(symbol)
        name, offset = self._loops.source(symbol)
        lane = "[w]" if self._lanes(name) else ""
        if element is None or (not element.along and element.base == str(symbol)):
            return f"{name}{lane}"
        low = self._first_index(name)
        field = f"x->{name}" if name in self._arrays or name in self._given else name
        if not element.along:
            return f"{field}[{element.offset - low}]{lane}"
        if name in self._loops.place and name not in self._arrays:
            return name
        assert inside
        assert offset is not None
        return f"{field}[i{_offset_text(offset - low)}]{lane}"

    def _first_index(self, name: str) -> int:
        """First index of an array."""
        made = self._analysis.statements.get(name)
        given = {**self._analysis.parameters, **self._given}
        domain = made.domain if made is not None else given.get(name)
        before, _ = self._padding.get(name, (0, 0))
        return domain.low - before if domain is not None else 0


def _offset_text(number: int) -> str:
    return f" {'+' if number > 0 else '-'} {abs(number)}" if number else ""
