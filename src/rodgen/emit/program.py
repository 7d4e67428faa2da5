"""Equations to loops: what a generated function computes, statement by statement.

The derivation gives indexed expressions with sums over links and joints. Here sums become
running sums (prefix, suffix, total), common subexpressions of everything that shares an index
are taken out together, what depends on indices alone becomes a constant of the module, and the
statements are put in an order in which each uses only what stands before it. No mechanics.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from sympy import (
    Eq,
    Expr,
    Indexed,
    IndexedBase,
    Piecewise,
    Sum,
    Symbol,
    cos,
    cse,
    expand_trig,
    factor_terms,
    sin,
)

from rodgen.derive.general import Array, joint
from rodgen.derive.symbols import discretisation, i, j, later, n, phi, s
from rodgen.emit.printer import NumpyPrinter, operations

INDICES = (i, j, joint, s)
COS, SIN = IndexedBase("cos_phi", real=True), IndexedBase("sin_phi", real=True)
# What a function may read of the state y.
INPUTS = ("x0", "y0", "phi", "vx0", "vy0", "omega")
# A dense pair of links is the axes (i, j); `later` numbers the later of them.
PAIR = (i, j)
SUMS = ("prefix", "suffix", "total")


@dataclass(frozen=True)
class Domain:
    """Over which indices a quantity is computed: none, one with its range, or all pairs."""

    indices: tuple[Symbol, ...] = ()
    low: int = 0
    high: int = -1

    @property
    def count(self) -> int:
        return int(self.high - self.low + 1)

    def same_range(self, other: Domain) -> bool:
        """Whether both run over equally many axes from the same first to the same last index."""
        if len(self.indices) != len(other.indices):
            return False
        return not self.indices or (self.low, self.high) == (other.low, other.high)

    def union(self, other: Domain) -> Domain:
        return Domain(self.indices, min(self.low, other.low), max(self.high, other.high))


SCALAR = Domain()


@dataclass
class Statement:
    """One quantity. kind says how it comes about; ``code`` is what is computed, as text.

    value: code; cases: code inside, ends as (position, code); prefix, suffix, total: running
    sums of the array ``code``.
    """

    name: str
    kind: str
    domain: Domain
    expr: Expr
    ends: dict[int, Expr] = field(default_factory=dict)
    inner: Domain = SCALAR
    code: str = ""
    end_codes: list[tuple[int, str]] = field(default_factory=list)

    @property
    def count(self) -> int:
        return self.domain.count


@dataclass(frozen=True)
class Constant:
    """An array that depends on indices alone: computed once, when the module is loaded."""

    name: str
    domain: Domain
    code: str


@dataclass(frozen=True)
class Program:
    """Statements of a function in order, the names of its outputs, and what it reads."""

    statements: list[Statement]
    outputs: tuple[str, ...]
    parameters: list[str]
    arrays: set[str]
    inputs: list[str]
    operations: int

    def __contains__(self, name: str) -> bool:
        return name in self.outputs


class Compiler:
    """Compiles functions of one structure; constants are shared by all of them."""

    def __init__(self, links: int, first: int, arrays: Mapping[IndexedBase, Array]):
        self.links, self.first, self.arrays = links, first, arrays
        self.constants: dict[Expr, Constant] = {}

    def domain(self, index: Symbol | tuple[Symbol, ...], low: Expr, high: Expr) -> Domain:
        indices = index if isinstance(index, tuple) else (index,)
        return Domain(indices, int(low), int(high.subs(n, self.links)))

    @property
    def link(self) -> Domain:
        """The moving links."""
        return Domain((i,), self.first, self.links - 1)

    @property
    def pair(self) -> Domain:
        return Domain(PAIR, self.first, self.links - 1)

    @property
    def spring(self) -> Domain:
        """The inner joints."""
        return Domain((s,), 1, self.links - 1)

    def compile(self, outputs: Mapping[str, tuple[Domain, Expr]], batch: bool = False) -> Program:
        """The program that computes the outputs; batch: for states along leading axes."""
        return _Function(self, batch).compile(outputs)


@dataclass(frozen=True)
class _Access:
    """How a symbol stands for an element of an array: base[index + offset] or base[position]."""

    base: str
    index: Symbol | None
    offset: int


class _Function:
    def __init__(self, compiler: Compiler, batch: bool):
        self.compiler, self.batch, self.n = compiler, batch, compiler.links
        self.accesses: dict[Symbol, _Access] = {}
        self.statements: dict[str, Statement] = {}
        self.sums: dict[Sum, Expr] = {}
        self.sum_names: list[str] = []
        self.shared: set[Symbol] = set()
        self.pair_symbols: set[Symbol] = set()
        self.from_state: set[str] = set()  # scalars that differ from state to state
        self.inputs: set[str] = set()

    # Taking the equations apart ---------------------------------------------------------------

    def compile(self, outputs: Mapping[str, tuple[Domain, Expr]]) -> Program:
        for name, (domain, expr) in outputs.items():
            self._add(name, domain, expr)
        self._define_links()
        self._share()
        ordered = list(self._ordered(outputs))
        self._mark_scalars(ordered)
        for statement in ordered:
            self._write(statement)
        summed = {self._terms(st).name for st in ordered if st.kind in SUMS}
        ordered = [st for st in ordered if st.name not in summed]
        used = set().union(*(self._uses(st) for st in self.statements.values()))
        made = {*self.statements, *self._constant_names(), "fin_factor"}
        parameters = sorted(used - made - set(INPUTS))
        inputs = [name for name in INPUTS if name in used]
        cost = sum(self._cost(st) for st in self.statements.values())
        return Program(ordered, tuple(outputs), parameters, used, inputs, cost)

    def _cost(self, statement: Statement) -> int:
        """Operations of a statement, over all its indices."""
        over = statement.inner if statement.kind == "cases" else statement.domain
        values: int = max(over.count, 0) ** len(over.indices)
        each = 1 if statement.kind in SUMS else operations(statement.expr)
        return values * each + sum(map(operations, statement.ends.values()))

    def _constant_names(self) -> set[str]:
        return {constant.name for constant in self.compiler.constants.values()}

    def _add(self, name: str, domain: Domain, expr: Expr) -> None:
        """Register a quantity after taking sums, arrays and cases out of it."""
        expr = expr.subs(n, self.n)
        if set(domain.indices) == set(PAIR):
            expr = factor_terms(expand_trig(expr))
        if isinstance(expr, Sum):
            self._new_sum(name, expr, domain)
            return
        expr = self._extract_sums(name, expr, domain)
        if isinstance(expr, Piecewise) and expr.has(Eq) and domain.indices:
            self._add_cases(name, domain, expr)
            return
        flat = self._constants(self._flatten(expr), domain)
        self.statements[name] = Statement(name, "value", domain, flat)

    def _define_links(self) -> None:
        """Mass, length and spring stiffness of a link, where they are used."""
        used = set().union(*(e.free_symbols for e in self._expressions()))
        for symbol, value in discretisation().items():
            if symbol in used:
                self._add(str(symbol), SCALAR, value)

    def _expressions(self) -> Iterator[Expr]:
        for statement in self.statements.values():
            yield statement.expr
            yield from statement.ends.values()

    def _add_cases(self, name: str, domain: Domain, expr: Piecewise) -> None:
        """A quantity that differs at single positions of its index."""
        (index,) = domain.indices
        equalities = expr.atoms(Eq)
        special = sorted({int(e.rhs) for e in equalities} & {domain.low, domain.high})
        ends = {}
        for position in special:
            value = expr.subs(index, position)
            ends[position] = self._flatten(value)
        low = domain.low + (domain.low in special)
        high = domain.high - (domain.high in special)
        inner = self._flatten(expr.args[-1].expr)
        self.statements[name] = Statement(
            name, "cases", domain, inner, ends, Domain(domain.indices, low, high)
        )

    def _extract_sums(self, parent: str, expr: Expr, domain: Domain) -> Expr:
        found = sorted(expr.atoms(Sum), key=lambda e: e.sort_key())
        return expr.xreplace({total: self._sum(parent, total, domain) for total in found})

    def _sum(self, parent: str, total: Sum, domain: Domain) -> Expr:
        """The symbol that stands for a sum inside an expression."""
        if total not in self.sums:
            made = [name for name in self.sum_names if name.startswith(f"{parent}_sum")]
            name = f"{parent}_sum{len(made) + 1 if made else ''}"
            self.sum_names.append(name)
            self.sums[total] = self._new_sum(name, total, domain)
        return self.sums[total]

    def _new_sum(self, name: str, total: Sum, domain: Domain) -> Expr:
        """A running sum: its terms as one statement, the sum as another."""
        index, low, high = total.limits[0]
        if not (low.free_symbols | high.free_symbols):
            kind, span, result = "total", Domain((index,), int(low), int(high)), SCALAR
        elif high.free_symbols:  # from the start up to the index
            kind, span, result = "prefix", Domain((index,), int(low), domain.high - 1), domain
        else:  # from behind the index to the end
            kind, span = "suffix", Domain((index,), domain.low + 1, int(high))
            result = Domain(domain.indices, domain.low, int(high) - 1)
        self._add(f"{name}_terms", span, total.function)
        terms = self._array(f"{name}_terms", span, index, 0)
        self.statements[name] = Statement(name, kind, result, terms)
        return (
            self._array(name, result, result.indices[0], 0)
            if result.indices
            else Symbol(name, real=True)
        )

    def _array(self, base: str, domain: Domain, index: Symbol, offset: int) -> Symbol:
        symbol = Symbol(f"{base}[{index}{offset:+d}]" if offset else f"{base}[{index}]", real=True)
        self.accesses[symbol] = _Access(base, index, offset)
        return symbol

    def _flatten(self, expr: Expr) -> Expr:
        """Elements of arrays become plain symbols, and the arrays statements of their own."""
        trig = {
            f(a): base[a.indices[0]]
            for f, base in ((cos, COS), (sin, SIN))
            for a in expr.atoms(Indexed)
            if a.base == phi and expr.has(f(a))
        }
        expr = expr.xreplace(trig)
        elements = sorted(expr.atoms(Indexed), key=lambda e: e.sort_key())
        return expr.xreplace({element: self._element(element) for element in elements})

    def _element(self, element: Indexed) -> Symbol:
        base, (at,) = element.base, element.indices
        name = str(base)
        if at.free_symbols:
            (index,) = at.free_symbols
            offset = int(at - index)
            symbol = self._array(name, SCALAR, index, offset)
        else:
            symbol = Symbol(f"{name}[{at}]", real=True)
            self.accesses[symbol] = _Access(name, None, int(at))
        self._define(base)
        return symbol

    def _define(self, base: IndexedBase) -> None:
        name = str(base)
        if name in self.statements or name in self.inputs:
            return
        if base in self.compiler.arrays:
            array = self.compiler.arrays[base]
            self._add(name, self.compiler.domain(array.index, array.low, array.high), array.value)
        elif base in (COS, SIN):
            function = cos if base == COS else sin
            domain = Domain((i,), self.n, -1)  # grows with what is read of it
            angle = self._element(phi[i])
            self.statements[name] = Statement(name, "value", domain, function(angle))
        else:
            self.inputs.add(name)

    def _constants(self, expr: Expr, domain: Domain) -> Expr:
        """Factors and terms that depend on indices alone, as arrays made beforehand."""
        indices = {i, j, later, joint, s}
        if expr.free_symbols and expr.free_symbols <= indices:
            return self._constant(expr, domain)
        if not expr.args:
            return expr
        return expr.func(*(self._constants(arg, domain) for arg in expr.args))

    def _constant(self, expr: Expr, domain: Domain) -> Symbol:
        constants = self.compiler.constants
        over = self.compiler.pair if later in expr.free_symbols else domain
        key = (expr, over)
        if key not in constants:
            name = f"WEIGHT_{len(constants)}"
            code = NumpyPrinter(str, lambda _: 1)(expr)
            constants[key] = Constant(name, over, code)
        constant = constants[key]
        if later in expr.free_symbols:
            symbol = Symbol(f"{constant.name}[i,j]", positive=True)
            self.accesses[symbol] = _Access(constant.name, None, 0)
            self.pair_symbols.add(symbol)
            return symbol
        return self._array(constant.name, over, over.indices[0], 0)

    # Sharing ----------------------------------------------------------------------------------

    def _share(self) -> None:
        """Take out common subexpressions of all statements together."""
        slots: list[tuple[Statement, int | None]] = []
        for statement in self.statements.values():
            slots.append((statement, None))
            slots += [(statement, position) for position in statement.ends]
        exprs = [st.expr if at is None else st.ends[at] for st, at in slots]
        names = (Symbol(f"a{k}", real=True) for k in range(10**6))
        shared, reduced = cse(exprs, symbols=names, order="canonical", list=False)
        for (statement, at), expr in zip(slots, reduced, strict=True):
            if at is None:
                statement.expr = expr
            else:
                statement.ends[at] = expr
        self.shared = {symbol for symbol, _ in shared}
        for symbol, expr in shared:
            self.statements[str(symbol)] = Statement(str(symbol), "value", SCALAR, expr)
        self._place(dict(shared))
        self._grow()
        self._unalias()

    def _unalias(self) -> None:
        """A shared quantity that is an output as it stands takes the name of the output."""
        summed = {self._terms(st).name for st in self.statements.values() if st.kind in SUMS}
        for name, statement in list(self.statements.items()):
            symbol = statement.expr
            if statement.kind != "value" or not isinstance(symbol, Symbol):
                continue
            target = self.statements.get(str(symbol))
            if target is None or symbol not in self.shared or name in summed:
                continue
            if not statement.domain.same_range(target.domain):
                continue
            new = Symbol(name, real=True)
            del self.statements[str(symbol)]
            self.statements[name] = Statement(name, "value", target.domain, target.expr)
            for other in self.statements.values():
                other.expr = other.expr.xreplace({symbol: new})
                other.ends = {at: e.xreplace({symbol: new}) for at, e in other.ends.items()}

    def _indices(self, expr: Expr) -> set[Symbol]:
        """Which axes the value of an expression runs along."""
        found: set[Symbol] = set()
        for symbol in expr.free_symbols:
            if symbol in self.pair_symbols:
                found |= set(PAIR)
            elif symbol in self.accesses:
                index = self.accesses[symbol].index
                found |= {index} if index is not None else set()
            elif str(symbol) in self.statements:
                found |= set(self.statements[str(symbol)].domain.indices)
        return found

    def _place(self, shared: Mapping[Symbol, Expr]) -> None:
        """Give every shared quantity its axes; later its range, from who uses it."""
        for symbol, expr in shared.items():
            indices = tuple(x for x in INDICES if x in self._indices(expr))
            self.statements[str(symbol)].domain = Domain(indices, self.n, -1)

    def _grow(self) -> None:
        """Ranges of shared quantities and of trigonometry: all that their users read."""
        growing = {
            name
            for name, st in self.statements.items()
            if st.domain.indices and st.domain.low > st.domain.high
        }
        for name in self._users_first():
            statement = self.statements[name]
            for expr, over in self._parts(statement):
                for symbol in expr.free_symbols:
                    read = self._reads(symbol, over)
                    if read and read[0] in growing:
                        target = self.statements[read[0]]
                        target.domain = target.domain.union(
                            Domain(target.domain.indices, read[1], read[2])
                        )

    def _parts(self, statement: Statement) -> Iterator[tuple[Expr, Domain]]:
        if statement.kind == "cases":
            if statement.inner.count > 0:
                yield statement.expr, statement.inner
            for value in statement.ends.values():
                yield value, SCALAR
        else:
            yield statement.expr, statement.domain

    def _reads(self, symbol: Symbol, over: Domain) -> tuple[str, int, int] | None:
        """Name and range of the array that a symbol reads, if it reads one."""
        if symbol in self.accesses:
            access = self.accesses[symbol]
            if access.index is None:
                return access.base, access.offset, access.offset
            return access.base, over.low + access.offset, over.high + access.offset
        if str(symbol) in self.statements:
            return str(symbol), over.low, over.high
        return None

    def _uses(self, statement: Statement) -> set[str]:
        names = set()
        for expr, _ in self._parts(statement):
            for symbol in expr.free_symbols:
                names.add(self.accesses[symbol].base if symbol in self.accesses else str(symbol))
        return names

    def _users_first(self) -> list[str]:
        order: list[str] = []
        seen: set[str] = set()

        def visit(name: str) -> None:
            if name in seen or name not in self.statements:
                return
            seen.add(name)
            for used in sorted(self._uses(self.statements[name])):
                visit(used)
            order.append(name)

        for name in list(self.statements):
            visit(name)
        return order[::-1]

    def _ordered(self, outputs: Mapping[str, object]) -> Iterator[Statement]:
        done: set[str] = set()

        def visit(name: str) -> Iterator[Statement]:
            if name in done or name not in self.statements:
                return
            done.add(name)
            statement = self.statements[name]
            for used in sorted(self._uses(statement), key=_natural):
                yield from visit(used)
            yield statement

        for name in outputs:
            yield from visit(name)

    # Writing ----------------------------------------------------------------------------------

    def _mark_scalars(self, ordered: list[Statement]) -> None:
        self.from_state |= {"x0", "y0", "vx0", "vy0", "t"}
        for statement in ordered:
            if statement.domain.indices:
                continue
            depends = statement.kind == "total" or any(
                str(x) in self.from_state or x in self.accesses for x in statement.expr.free_symbols
            )
            if depends:
                self.from_state.add(statement.name)

    def _write(self, statement: Statement) -> None:
        parts = {"value": statement.domain, "cases": statement.inner}
        over = parts.get(statement.kind, statement.domain)
        if statement.kind in ("prefix", "suffix", "total"):
            terms = self._terms(statement)
            statement.code = self._text(terms.expr, terms.domain)
            return
        if statement.kind == "value" or over.count > 0:
            statement.code = self._text(statement.expr, over)
        statement.end_codes = [
            (position - statement.domain.low, self._text(value, SCALAR))
            for position, value in statement.ends.items()
        ]

    def _terms(self, total: Statement) -> Statement:
        (symbol,) = total.expr.free_symbols
        return self.statements[self.accesses[symbol].base]

    def _text(self, expr: Expr, over: Domain) -> str:
        def rank(symbol: Symbol) -> int:
            return len(self._indices(symbol))

        return NumpyPrinter(lambda symbol: self._name(symbol, over), rank)(expr)

    def _name(self, symbol: Symbol, over: Domain) -> str:
        if symbol in self.pair_symbols:
            return self.accesses[symbol].base
        read = self._reads(symbol, over)
        if read is None or not (symbol in self.accesses or self._indices(symbol)):
            spread = self.batch and over.indices and str(symbol) in self.from_state
            return f"{symbol}[..., None]" if spread else str(symbol)
        base, low, high = read
        start, count = self._extent(base)
        lead = "..., " if self.batch and self._has_states(base) else ""
        access = self.accesses.get(symbol)
        if access is not None and access.index is None:
            position = f"{base}[{lead}{low - start}]"
            if self.batch and over.indices:
                return f"{base}[{lead}{low - start}, None]"
            return position
        if set(over.indices) == set(PAIR):
            axes = self._indices(symbol)
            if axes == {i}:
                return f"{self._slice(base, low, high, start, count, lead)}[:, None]"
            return self._slice(base, low, high, start, count, lead)
        return self._slice(base, low, high, start, count, lead)

    def _slice(self, base: str, low: int, high: int, start: int, count: int, lead: str) -> str:
        if (low, high - low + 1) == (start, count):
            return base
        left = "" if low == start else str(low - start)
        right = "" if high == start + count - 1 else str(high - start + 1)
        return f"{base}[{lead}{left}:{right}]"

    def _extent(self, base: str) -> tuple[int, int]:
        """First index and length of an array."""
        if base in self.statements:
            domain = self.statements[base].domain
            return domain.low, domain.count
        for constant in self.compiler.constants.values():
            if constant.name == base:
                return constant.domain.low, constant.domain.count
        return 0, {"fin_factor": self.n + 1}.get(base, self.n)

    def _has_states(self, base: str) -> bool:
        return base not in self._constant_names() and base != "fin_factor"


def _natural(name: str) -> tuple[str, int, str]:
    head = name.rstrip("0123456789")
    return head, int(name[len(head) :] or -1), name
