"""Elements of arrays as plain symbols, which SymPy shares and sorts like any other.

``phi[i-1]`` becomes the symbol of that name; the table knows that it reads the array phi one
before the index i.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Symbol

from rodgen.emit.statements import DIRECTION, Domain


@dataclass(frozen=True)
class Element:
    """base[index + offset]; base[offset] where there is no index; the whole matrix for a pair."""

    base: str
    indices: tuple[Symbol, ...]
    offset: int

    @property
    def along(self) -> tuple[Symbol, ...]:
        """The indices without that of the directions."""
        return tuple(index for index in self.indices if index != DIRECTION)

    @property
    def tangent(self) -> bool:
        """Whether an element has directions."""
        return DIRECTION in self.indices

    def span(self, over: Domain) -> tuple[int, int]:
        """First and last index that are read when a statement runs over a domain."""
        if not self.along:
            return self.offset, self.offset
        return over.low + self.offset, over.high + self.offset


class Elements:
    """The symbols that stand for elements of arrays."""

    def __init__(self) -> None:
        self._of: dict[Symbol, Element] = {}

    def symbol(self, base: str, at: Expr) -> Symbol:
        """The symbol of base[at], where at is a position or an index with an offset."""
        indices = tuple(at.free_symbols)
        offset = int(at - sum(indices)) if indices else int(at)
        return self._register(f"{base}[{at}]", Element(base, indices, offset))

    def tangent(self, symbol: Symbol, base: str) -> Symbol:
        """The symbol of the tangent of an element, in an array of its own."""
        of = self._of[symbol]
        tangent = Element(base, (*of.indices, DIRECTION), of.offset)
        return self._register(f"d_{symbol}", tangent)

    def matrix(self, base: str, pair: tuple[Symbol, Symbol]) -> Symbol:
        """The symbol of an entry of a matrix over all pairs."""
        return self._register(f"{base}[{pair[0]},{pair[1]}]", Element(base, pair, 0))

    def _register(self, name: str, element: Element) -> Symbol:
        symbol = Symbol(name, real=True)
        self._of[symbol] = element
        return symbol

    def get(self, symbol: Symbol) -> Element | None:
        """What a symbol reads, if it stands for an element."""
        return self._of.get(symbol)
