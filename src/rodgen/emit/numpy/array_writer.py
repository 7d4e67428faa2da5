"""Writer of statements as NumPy text."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from sympy import Expr, Symbol

from rodgen.derive.symbols import i
from rodgen.emit.analysis import Analysis
from rodgen.emit.laws import STATE
from rodgen.emit.printer import NUMPY, Printer
from rodgen.emit.statements import DIRECTION, PAIR, SCALAR, SUMS, TOTAL, Domain, Statement

# What a function may read of the state y; all but the arrays phi and omega are numbers.
INPUTS = ("x0", "y0", "phi", "vx0", "vy0", "omega")


class ArrayWriter:
    """Writer of NumPy text. Arrays are slices of what is stored; in a batch the index runs along
    the last axis, and a number that differs from state to state gets an axis for it. The directions
    of tangents are the last axis.

    given: arrays from outside that do not start at 0 or have not one value for every link;
    clocked: numbers that follow the time, which may differ from state to state.
    """

    def __init__(
        self,
        analysis: Analysis,
        statements: list[Statement],
        batch: bool,
        given: Mapping[str, Domain],
        clocked: Collection[str] = (),
    ):
        self._analysis, self._batch, self._given = analysis, batch, given
        self._varying = {name for name in INPUTS if name not in ("phi", "omega")} | {*clocked}
        for statement in statements:
            if not statement.domain.indices and self._is_varying(statement):
                self._varying.add(statement.name)

    def _is_varying(self, statement: Statement) -> bool:
        """Whether a number differs from state to state."""
        symbols = statement.expr.free_symbols
        elements = any(self._analysis.elements.get(symbol) for symbol in symbols)
        names = {*map(str, symbols)}
        added = any(name.startswith(STATE) for name in names)
        return statement.kind == TOTAL or elements or added or bool(names & self._varying)

    def write(self, statement: Statement) -> None:
        """Fill in the texts of a statement."""
        if statement.kind in SUMS:
            assert statement.terms is not None
            statement.code = self._text(statement.terms.expr, statement.terms.domain)
            return
        if not statement.ends:
            statement.code = self._text(statement.expr, statement.domain)
            return
        inner = statement.inner.count > 0
        statement.code = self._text(statement.expr, statement.inner) if inner else ""
        directions = SCALAR if not statement.domain.is_tangent else Domain((DIRECTION,))
        statement.end_codes = [
            (at - statement.domain.low, self._text(expr, directions))
            for at, expr in statement.ends.items()
        ]

    def _text(self, expr: Expr, over: Domain) -> str:
        printer = Printer(
            NUMPY,
            lambda symbol: self._symbol_text(symbol, over),
            lambda symbol: len(self._analysis.axes(symbol)),
        )
        return printer(expr)

    def _symbol_text(self, symbol: Symbol, over: Domain) -> str:
        """Text of a symbol in a statement over a domain."""
        element = self._analysis.read(symbol)
        if element is None or (not element.indices and element.base == str(symbol)):
            spread = self._batch and over.indices and str(symbol) in self._varying
            return f"{symbol}[..., None]" if spread else str(symbol)
        if element.indices == (DIRECTION,) and element.base == str(symbol):
            return str(symbol)
        lead = "..., " if self._batch and self._has_state_axis(element.base) else ""
        start, count = self._extent(element.base)
        low, high = (at - start for at in element.span(over))
        if not element.along:
            axis = ", None" if self._batch and over.indices else ""
            return f"{element.base}[{lead}{low}{axis}]"
        left, right = low or "", high + 1 if high + 1 < count else ""
        part = f"[{lead}{left}:{right}]" if (left, right) != ("", "") else ""
        across = over.indices == PAIR and element.indices == (i,)
        column = "[:, None]" if across or over.is_tangent > element.is_tangent else ""
        return f"{element.base}{part}{column}"

    def _extent(self, base: str) -> tuple[int, int]:
        """First index and length of an array."""
        made = self._analysis.statements.get(base) or self._analysis.constant(base)
        given = {**self._analysis.parameters, **self._given}
        domain = made.domain if made is not None else given.get(base.removeprefix("d_"))
        return (domain.low, domain.count) if domain is not None else (0, self._analysis.n_links)

    def _has_state_axis(self, base: str) -> bool:
        """Whether an array differs from state to state."""
        return base not in self._analysis.parameters and self._analysis.constant(base) is None
