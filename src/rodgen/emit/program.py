"""Functions of a module as programs: analysed, then written as NumPy text."""

from __future__ import annotations

from collections.abc import Mapping

from sympy import Expr, IndexedBase, Symbol

from rodgen.derive.general import Array
from rodgen.derive.symbols import i, s
from rodgen.emit.analysis import Analysis
from rodgen.emit.printer import NumpyPrinter
from rodgen.emit.statements import PAIR, SCALAR, SUMS, TOTAL, Constant, Domain, Program, Statement

# What a function may read of the state y; all but the arrays phi and omega are numbers.
INPUTS = ("x0", "y0", "phi", "vx0", "vy0", "omega")
FINS = "fin_factor"  # one for every joint, not for every link, and the same in every state


class Compiler:
    """Compiles the functions of one structure; constants are shared by all of them."""

    def __init__(self, links: int, first: int, arrays: Mapping[IndexedBase, Array]):
        self.links, self.arrays = links, arrays
        self.link = Domain((i,), first, links - 1)
        self.pair = Domain(PAIR, first, links - 1)
        self.spring = Domain((s,), 1, links - 1)
        self._constants: dict[tuple[Expr, Domain], Constant] = {}

    @property
    def constants(self) -> list[Constant]:
        """Constants of the functions compiled so far."""
        return list(self._constants.values())

    def compile(self, outputs: Mapping[str, tuple[Domain, Expr]], batch: bool = False) -> Program:
        """The program that computes the outputs; batch: for states along leading axes."""
        analysis = Analysis(self.links, self.link, self.arrays, self._constants)
        statements = analysis.run(outputs)
        writer = _Writer(analysis, statements, batch)
        for statement in statements:
            writer.write(statement)
        summed = {st.terms.name for st in statements if st.terms}
        kept = [st for st in statements if st.name not in summed]
        reads = set().union(*map(analysis.uses, statements)) if statements else set()
        made = {st.name for st in statements} | {c.name for c in self.constants}
        cost = sum(st.operations() for st in statements)
        return Program(kept, tuple(outputs), frozenset(reads - made), cost)


class _Writer:
    """NumPy text of statements. Arrays are slices of what is stored; in a batch the index runs
    along the last axis, and a number that differs from state to state gets an axis for it."""

    def __init__(self, analysis: Analysis, statements: list[Statement], batch: bool):
        self._analysis, self._batch = analysis, batch
        self._varying = {name for name in INPUTS if name not in ("phi", "omega")}
        for statement in statements:
            if not statement.domain.indices and self._varies(statement):
                self._varying.add(statement.name)

    def _varies(self, statement: Statement) -> bool:
        """Whether a number differs from state to state."""
        symbols = statement.expr.free_symbols
        elements = any(self._analysis.elements.get(symbol) for symbol in symbols)
        return statement.kind == TOTAL or elements or bool({*map(str, symbols)} & self._varying)

    def write(self, statement: Statement) -> None:
        """Fill in the texts of a statement."""
        if statement.kind in SUMS:
            assert statement.terms is not None
            statement.code = self._text(statement.terms.expr, statement.terms.domain)
            return
        texts = [(over, self._text(expr, over)) for expr, over in statement.parts()]
        inside = [text for over, text in texts if over is not SCALAR or not statement.ends]
        statement.code = inside[0] if inside else ""
        ends = [text for over, text in texts if over is SCALAR]
        if statement.ends:
            positions = [at - statement.domain.low for at in statement.ends]
            statement.end_codes = list(zip(positions, ends, strict=True))

    def _text(self, expr: Expr, over: Domain) -> str:
        printer = NumpyPrinter(
            lambda symbol: self._name(symbol, over),
            lambda symbol: len(self._analysis.axes(symbol)),
        )
        return printer(expr)

    def _name(self, symbol: Symbol, over: Domain) -> str:
        """How a symbol is written in a statement over a domain."""
        element = self._analysis.read(symbol)
        if element is None:
            spread = self._batch and over.indices and str(symbol) in self._varying
            return f"{symbol}[..., None]" if spread else str(symbol)
        lead = "..., " if self._batch and self._in_every_state(element.base) else ""
        start, count = self._extent(element.base)
        low, high = (at - start for at in element.span(over))
        if not element.indices:
            axis = ", None" if self._batch and over.indices else ""
            return f"{element.base}[{lead}{low}{axis}]"
        left, right = low or "", high + 1 if high + 1 < count else ""
        part = f"[{lead}{left}:{right}]" if (left, right) != ("", "") else ""
        column = "[:, None]" if over.indices == PAIR and element.indices == (i,) else ""
        return f"{element.base}{part}{column}"

    def _extent(self, base: str) -> tuple[int, int]:
        """First index and length of an array."""
        made = self._analysis.statements.get(base) or self._analysis.constant(base)
        if made is not None:
            return made.domain.low, made.domain.count
        return 0, self._analysis.links + (base == FINS)

    def _in_every_state(self, base: str) -> bool:
        return base != FINS and self._analysis.constant(base) is None
