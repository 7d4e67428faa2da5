"""Statements over domains, of which generated functions are made, in their order; and their
tangents, derivatives of each quantity along many directions of the state or of other numbers.

What they read of arrays are plain symbols, which SymPy shares and sorts like any other:
``phi[i-1]`` is the symbol of that name, and a table knows that it reads the array phi one before
the index i. Tangents follow by forward differentiation, statement by statement; the partial
derivatives are SymPy's.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field

from sympy import Add, Expr, Piecewise, S, Symbol

from rodgen.derive.symbols import i, j
from rodgen.emit.laws import STATE, LawFunction

# Every pair of links, for a matrix.
PAIR = (i, j)
# The axis of a tangent: the directions in which is differentiated.
DIRECTION = Symbol("direction", integer=True)
VALUE, CASES, PREFIX, SUFFIX, TOTAL = "value", "cases", "prefix", "suffix", "total"
SUMS = (PREFIX, SUFFIX, TOTAL)

# What a tangent may start from: unknowns of a system that is solved in between, and by default the
# state, of which added states have names of their own.
SOLVED = ("lambda_x", "lambda_y", "tension")
OF_STATE = ("x0", "y0", "phi", "omega", "vx0", "vy0")


class Axes:
    """Axes of a quantity: one for every index, and one for the directions of a tangent."""

    indices: tuple[Symbol, ...]

    @property
    def along(self) -> tuple[Symbol, ...]:
        """The indices without that of the directions."""
        return tuple(index for index in self.indices if index != DIRECTION)

    @property
    def is_tangent(self) -> bool:
        """Whether it has directions."""
        return DIRECTION in self.indices


@dataclass(frozen=True)
class Domain(Axes):
    """Indices over which a quantity is computed: none, one with its range, or all pairs; a tangent
    has its directions as a last axis."""

    indices: tuple[Symbol, ...] = ()
    low: int = 0
    high: int = -1

    @property
    def count(self) -> int:
        """Length along one axis."""
        return int(self.high - self.low + 1)

    def same_range(self, other: Domain) -> bool:
        """Whether both run over equally many axes from the same first to the same last index."""
        if len(self.indices) != len(other.indices):
            return False
        return not self.along or (self.low, self.high) == (other.low, other.high)

    def extend(self, low: int, high: int) -> Domain:
        """Domain with the same axes, over a range that also includes low to high."""
        return Domain(self.indices, min(self.low, low), max(self.high, high))


SCALAR = Domain()
# What a function gives, by name: over which indices, and as which expression.
Outputs = dict[str, tuple[Domain, Expr]]


@dataclass(frozen=True)
class Element(Axes):
    """Element of an array: base[index + offset], base[offset] or, for a pair, all of a matrix."""

    base: str
    indices: tuple[Symbol, ...]
    offset: int

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
        """Element that a symbol stands for, or None."""
        return self._of.get(symbol)


@dataclass
class Statement:
    """One quantity of a function; kind says how it comes about.

    value: expr over the domain; cases: expr over the inner domain and ends at single positions;
    prefix, suffix, total: running sums of ``terms``, a statement of its own.
    ``code`` and ``end_codes`` (by position in the array) are the texts, once they are written.
    """

    name: str
    kind: str
    domain: Domain
    expr: Expr
    ends: dict[int, Expr] = field(default_factory=dict)
    inner: Domain = SCALAR
    terms: Statement | None = None
    code: str = ""
    end_codes: list[tuple[int, str]] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Length of the array."""
        return self.domain.count

    @property
    def is_law(self) -> bool:
        """Whether it is a law of the scene, which may give any value, not-a-number too."""
        return isinstance(self.expr, LawFunction)

    def parts(self) -> Iterator[tuple[Expr, Domain]]:
        """Every expression with the domain over which it is computed."""
        if self.kind != CASES:
            yield self.expr, self.domain
            return
        if self.inner.count > 0:
            yield self.expr, self.inner
        for value in self.ends.values():
            yield value, SCALAR

    def replace_symbols(self, change: dict[Expr, Expr]) -> None:
        """Replace symbols in all expressions."""
        self.expr = self.expr.xreplace(change)
        self.ends = {at: e.xreplace(change) for at, e in self.ends.items()}

    def operations(self) -> int:
        """Operations over all indices: sums, products, powers and functions."""
        each = 1 if self.kind in SUMS else int(self.expr.count_ops())
        over = self.inner if self.kind == CASES else self.domain
        values: int = max(over.count, 0) ** len(over.along)
        return values * each + sum(int(e.count_ops()) for e in self.ends.values())


@dataclass(frozen=True)
class Constant:
    """An array that depends on indices alone: computed once, when the module is loaded."""

    name: str
    domain: Domain
    code: str


@dataclass(frozen=True)
class Program:
    """Statements of a function in order, its outputs, and the names that it reads.

    phases: the statements again, cut where a system has to be solved before the next can be
    computed; a function that solves none has one phase.
    """

    statements: list[Statement]
    outputs: tuple[str, ...]
    reads: frozenset[str]
    operations: int
    phases: tuple[tuple[Statement, ...], ...] = ()

    def __contains__(self, name: str) -> bool:
        return any(st.name == name for st in self.statements)

    @property
    def has_laws(self) -> bool:
        """Whether any statement is a law of the scene, which may name the time."""
        return any(st.is_law for st in self.statements)


class Tangents:
    """Differentiation of statements, which adds their tangents to them."""

    def __init__(
        self,
        statements: dict[str, Statement],
        elements: Elements,
        by: Collection[str] | None = None,
    ):
        """by: names of the numbers that are differentiated by, None for the state."""
        self._statements, self._elements, self._by = statements, elements, by
        self._known: dict[str, bool] = {}

    def __call__(self, name: str, fixed: Iterable[str] = ()) -> str | None:
        """Name of the tangent of a quantity, or None where it follows nothing that is
        differentiated by; ``fixed``: what else it is not differentiated by."""
        if name not in self._known:
            if self._is_start(name):
                self._known[name] = True
            elif name not in self._statements:
                self._known[name] = False
            else:
                self._known[name] = self._differentiate(self._statements[name], frozenset(fixed))
        return f"d_{name}" if self._known[name] else None

    def _is_start(self, name: str) -> bool:
        """Whether a tangent may start from a quantity, whatever that follows."""
        if self._by is not None:
            return name in self._by or name in SOLVED
        return name in OF_STATE or name in SOLVED or name.startswith(STATE)

    def _differentiate(self, st: Statement, fixed: frozenset[str]) -> bool:
        """Add the tangent of a statement; False where it is zero."""
        name, domain = f"d_{st.name}", self._with_directions(st.domain)
        if st.kind in SUMS:
            assert st.terms is not None
            if self(st.terms.name, fixed) is None:
                return False
            terms = self._statements[f"d_{st.terms.name}"]
            read = self._elements.tangent(st.expr, terms.name)
            self._statements[name] = Statement(name, st.kind, domain, read, terms=terms)
            return True
        if st.kind == CASES:
            inside = self._partial(st.expr, fixed)
            ends = {at: self._partial(e, fixed) for at, e in st.ends.items()}
            if inside == 0 and not any(ends.values()):
                return False
            inner = self._with_directions(st.inner)
            self._statements[name] = Statement(name, CASES, domain, inside, ends, inner)
            return True
        expr = self._root_tangent(st, fixed) or self._partial(st.expr, fixed)
        if expr == 0:
            return False
        self._statements[name] = Statement(name, VALUE, domain, expr)
        return True

    def _with_directions(self, domain: Domain) -> Domain:
        return Domain((*domain.indices, DIRECTION), domain.low, domain.high)

    def _partial(self, expr: Expr, fixed: frozenset[str]) -> Expr:
        """Sum of the partial derivatives times the tangents."""
        parts = []
        for symbol in sorted(expr.free_symbols, key=str):
            element = self._elements.get(symbol)
            base = element.base if element is not None else str(symbol)
            if base in fixed:
                continue
            tangent = self(base)
            if tangent is None:
                continue
            change = (
                Symbol(tangent, real=True)
                if element is None
                else self._elements.tangent(symbol, tangent)
            )
            parts.append(expr.diff(symbol) * change)
        return Add(*parts)

    def _root_tangent(self, st: Statement, fixed: frozenset[str]) -> Expr | None:
        """Tangent of a root that is replaced where it vanishes, divided by the replaced value,
        which is not zero; None for other statements."""
        if not isinstance(st.expr, Piecewise) or len(st.expr.args) != 2:
            return None
        (root, _), (other, _) = st.expr.args
        if not (root.is_Pow and root.exp == S.Half and other.is_number):
            return None
        (index,) = st.domain.indices
        return self._partial(root.base, fixed) / (2 * self._elements.symbol(st.name, index))
