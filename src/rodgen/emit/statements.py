"""What a generated function is made of: statements over domains, in an order."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from sympy import Expr, Symbol

from rodgen.derive.symbols import i, j

# Every pair of links, for a matrix.
PAIR = (i, j)
# The axis of a tangent: the directions in which is differentiated.
DIRECTION = Symbol("direction", integer=True)
VALUE, CASES, PREFIX, SUFFIX, TOTAL = "value", "cases", "prefix", "suffix", "total"
SUMS = (PREFIX, SUFFIX, TOTAL)


@dataclass(frozen=True)
class Domain:
    """Over which indices a quantity is computed: none, one with its range, or all pairs; a
    tangent has its directions as a last axis."""

    indices: tuple[Symbol, ...] = ()
    low: int = 0
    high: int = -1

    @property
    def along(self) -> tuple[Symbol, ...]:
        """The indices without that of the directions."""
        return tuple(index for index in self.indices if index != DIRECTION)

    @property
    def tangent(self) -> bool:
        """Whether a value has directions."""
        return DIRECTION in self.indices

    @property
    def count(self) -> int:
        """Length along one axis."""
        return int(self.high - self.low + 1)

    def same_range(self, other: Domain) -> bool:
        """Whether both run over equally many axes from the same first to the same last index."""
        if len(self.indices) != len(other.indices):
            return False
        return not self.along or (self.low, self.high) == (other.low, other.high)

    def including(self, low: int, high: int) -> Domain:
        """The same axes over a range that includes another."""
        return Domain(self.indices, min(self.low, low), max(self.high, high))


SCALAR = Domain()
# What a function gives, by name: over which indices, and as which expression.
Outputs = dict[str, tuple[Domain, Expr]]


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

    def parts(self) -> Iterator[tuple[Expr, Domain]]:
        """Every expression with the domain over which it is computed."""
        if self.kind != CASES:
            yield self.expr, self.domain
            return
        if self.inner.count > 0:
            yield self.expr, self.inner
        for value in self.ends.values():
            yield value, SCALAR

    def map(self, change: dict[Expr, Expr]) -> None:
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
