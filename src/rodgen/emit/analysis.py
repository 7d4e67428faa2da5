"""Translation of equations into statements.

The derivation gives indexed expressions with sums over links and joints. Here sums become running
sums, common subexpressions of everything that shares an index are taken out together, parts that
depend on indices alone become constants of the module, and the statements are put in an order in
which each uses only earlier ones. No mechanics.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

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

from rodgen.derive.symbols import Array, discretisation, i, j, joint, later, n, other, phi, s
from rodgen.emit.printer import NUMPY, Printer
from rodgen.emit.statements import (
    CASES,
    DIRECTION,
    PAIR,
    PREFIX,
    SCALAR,
    SUFFIX,
    TOTAL,
    VALUE,
    Constant,
    Domain,
    Element,
    Elements,
    Statement,
    Tangents,
)

INDICES = (i, j, joint, s, other, DIRECTION)
# Cosine and sine of every angle are computed once, whoever uses them.
TRIGONOMETRY = {
    IndexedBase("cos_phi", real=True): cos,
    IndexedBase("sin_phi", real=True): sin,
}
SHARED = "a"  # names of shared subexpressions: a0, a1, ...


class Analysis:
    """The statements of one function.

    n_links: their number; arrays: quantities along the chain that outputs may refer to; constants:
    those of the module, which grow with every function; parameters: those that are several numbers,
    with their ranges; numbers: expressions of named numbers, which are defined where they are read.
    """

    def __init__(
        self,
        n_links: int,
        moving: Domain,
        arrays: Mapping[IndexedBase, Array],
        constants: dict[tuple[Expr, Domain], Constant],
        parameters: Mapping[str, Domain],
        numbers: Mapping[Symbol, Expr],
    ):
        self.n_links, self.moving = n_links, moving
        self.numbers = {**discretisation(), **numbers}
        self.arrays, self.constants, self.parameters = arrays, constants, parameters
        self.elements = Elements()
        self.statements: dict[str, Statement] = {}
        self._sums: dict[Sum, Expr] = {}
        self._names: list[str] = []

    def run(
        self,
        outputs: Mapping[str, tuple[Domain, Expr]],
        tangents: Mapping[str, frozenset[str]],
        values: Iterable[str],
        by: Collection[str] | None = None,
    ) -> list[Statement]:
        """The statements that compute the values of some outputs, then the tangents of some.

        tangents: outputs whose tangent is wanted, each with what it is not differentiated by; by:
        numbers that are differentiated by, None for the state.
        """
        for name, (domain, expr) in outputs.items():
            self._add(name, domain, expr)
        self._define_numbers()
        wanted = list(values)
        differentiate = Tangents(self.statements, self.elements, by)
        for name, fixed in tangents.items():
            wanted += [d for d in (differentiate(name, fixed),) if d is not None]
        self._define_numbers()
        self._share(wanted)
        return self._sort(wanted)

    def constant(self, name: str) -> Constant | None:
        """A constant of the module by name."""
        return next((c for c in self.constants.values() if c.name == name), None)

    # Taking the equations apart ---------------------------------------------------------------

    def _add(self, name: str, domain: Domain, expr: Expr) -> None:
        """Register a quantity after taking sums, arrays and cases out of it."""
        expr = expr.subs(n, self.n_links)
        if domain.indices == PAIR:
            expr = factor_terms(expand_trig(expr))
        if isinstance(expr, Sum):
            self._add_sum(name, expr, domain)
            return
        found = sorted(expr.atoms(Sum), key=lambda e: e.sort_key())
        expr = expr.xreplace({total: self._sum(name, total, domain) for total in found})
        if isinstance(expr, Piecewise) and expr.has(Eq):
            self._add_cases(name, domain, expr)
            return
        flat = self._hoist(self._flatten(expr), domain)
        self.statements[name] = Statement(name, VALUE, domain, flat)

    def _add_cases(self, name: str, domain: Domain, expr: Piecewise) -> None:
        """Register a quantity that differs at single positions; its inner range excludes ends."""
        (index,) = domain.indices
        named = {int(equality.rhs) for equality in expr.atoms(Eq)}
        special = {at for at in named if domain.low <= at <= domain.high}
        ends = {at: self._flatten(expr.subs(index, at)) for at in sorted(special)}
        low = domain.low + (domain.low in special)
        high = domain.high - (domain.high in special)
        inside = self._flatten(expr.args[-1].expr)
        inner = Domain(domain.indices, low, high)
        self.statements[name] = Statement(name, CASES, domain, inside, ends, inner)

    def _sum(self, parent: str, total: Sum, domain: Domain) -> Expr:
        """The symbol that stands for a sum inside an expression."""
        if total not in self._sums:
            count = sum(name.startswith(f"{parent}_sum") for name in self._names)
            self._names.append(f"{parent}_sum{count + 1 if count else ''}")
            self._sums[total] = self._add_sum(self._names[-1], total, domain)
        return self._sums[total]

    def _add_sum(self, name: str, total: Sum, domain: Domain) -> Expr:
        """Register a running sum and its terms as statements; return the symbol that reads it."""
        index, low, high = total.limits[0]
        if not (low.free_symbols | high.free_symbols):
            kind, span, result = TOTAL, Domain((index,), int(low), int(high)), SCALAR
        elif high.free_symbols:  # from the start up to the index
            kind, span, result = PREFIX, Domain((index,), int(low), domain.high - 1), domain
        else:  # from behind the index, which may be one of a pair, to the end
            kind, span = SUFFIX, Domain((index,), domain.low + 1, int(high))
            result = Domain(tuple(low.free_symbols), domain.low, domain.high)
        self._add(f"{name}_terms", span, total.function)
        terms = self.statements[f"{name}_terms"]
        read = self.elements.symbol(terms.name, index)
        self.statements[name] = Statement(name, kind, result, read, terms=terms)
        if not result.indices:
            return Symbol(name, real=True)
        return self.elements.symbol(name, result.indices[0])

    def _flatten(self, expr: Expr) -> Expr:
        """Replace elements of arrays by plain symbols, and define the arrays as statements."""
        trigonometry = {
            function(angle): base[angle.indices[0]]
            for base, function in TRIGONOMETRY.items()
            for angle in expr.atoms(Indexed)
            if angle.base == phi and expr.has(function(angle))
        }
        expr = expr.xreplace(trigonometry)
        found = sorted(expr.atoms(Indexed), key=lambda e: e.sort_key())
        for element in found:
            self._define(element.base)
        symbols = {e: self.elements.symbol(str(e.base), e.indices[0]) for e in found}
        return expr.xreplace(symbols)

    def _define(self, base: IndexedBase) -> None:
        """Define an array that is read, unless it is given from outside."""
        name = str(base)
        if name in self.statements:
            return
        if base in self.arrays:
            array = self.arrays[base]
            high = int(array.high.subs(n, self.n_links))
            self._add(name, Domain((array.index,), int(array.low), high), array.value)
        elif base in TRIGONOMETRY:
            angle = self._flatten(phi[i])
            domain = self._empty_domain((i,))
            self.statements[name] = Statement(name, VALUE, domain, TRIGONOMETRY[base](angle))

    def _define_numbers(self) -> None:
        """Define what is used of mass, length and spring stiffness of a link, sensors and laws."""
        while True:
            expressions = [e for st in self.statements.values() for e, _ in st.parts()]
            used = set().union(*(e.free_symbols for e in expressions))
            new = {s: e for s, e in self.numbers.items() if s in used}
            new = {s: e for s, e in new.items() if str(s) not in self.statements}
            for symbol, value in new.items():
                self._add(str(symbol), SCALAR, value)
            if not new:
                return

    def _hoist(self, expr: Expr, domain: Domain) -> Expr:
        """Replace factors and terms that depend on indices alone by constants of the module."""
        if expr.free_symbols and expr.free_symbols <= {*INDICES, later}:
            return self._constant(expr, domain)
        if not expr.args:
            return expr
        return expr.func(*(self._hoist(arg, domain) for arg in expr.args))

    def _constant(self, expr: Expr, domain: Domain) -> Symbol:
        pairwise = later in expr.free_symbols
        over = Domain(PAIR, self.moving.low, self.moving.high) if pairwise else domain
        if (expr, over) not in self.constants:
            code = Printer(NUMPY, str, lambda _: 1)(expr)
            constant = Constant(f"WEIGHT_{len(self.constants)}", over, code)
            self.constants[expr, over] = constant
        name = self.constants[expr, over].name
        if pairwise:
            return self.elements.matrix(name, PAIR)
        return self.elements.symbol(name, over.indices[0])

    # Sharing ----------------------------------------------------------------------------------

    def _share(self, wanted: Iterable[str]) -> None:
        """Take common subexpressions out of all statements that are needed, together."""
        statements = self._sort(wanted)
        self.statements = {st.name: st for st in self.statements.values() if st in statements}
        for st in [st.terms for st in statements if st.terms is not None]:
            self.statements[st.name] = st
            if st not in statements:
                statements.append(st)
        exprs = [e for st in statements for e in (st.expr, *st.ends.values())]
        names = (Symbol(f"{SHARED}{at}", real=True) for at in range(10**6))
        shared, reduced = cse(exprs, symbols=names, order="canonical", list=False)
        rest = iter(reduced)
        for statement in statements:
            statement.expr = next(rest)
            statement.ends = {at: next(rest) for at in statement.ends}
        for symbol, expr in shared:
            axes = tuple(index for index in INDICES if index in self.axes(expr))
            self.statements[str(symbol)] = Statement(
                str(symbol), VALUE, self._empty_domain(axes), expr
            )
        self._grow()
        self._merge_aliases({symbol for symbol, _ in shared})

    def axes(self, expr: Expr) -> set[Symbol]:
        """Indices over which the value of an expression runs."""
        found: set[Symbol] = set()
        for symbol in expr.free_symbols:
            element = self.elements.get(symbol)
            if element is not None:
                found |= set(element.indices)
            elif str(symbol) in self.statements:
                found |= set(self.statements[str(symbol)].domain.indices)
        return found

    def read(self, symbol: Symbol) -> Element | None:
        """The array that a symbol reads: an element, or a shared quantity at the same index."""
        element = self.elements.get(symbol)
        if element is None and str(symbol) in self.statements:
            indices = self.statements[str(symbol)].domain.indices
            element = Element(str(symbol), indices, 0) if indices else None
        return element

    def _empty_domain(self, indices: tuple[Symbol, ...]) -> Domain:
        """An empty domain, which `_grow` extends to all that is read of it."""
        return Domain(indices, self.n_links, -1)

    def _grow(self) -> None:
        """Extend ranges of shared quantities and of trigonometry to all that is read of them."""
        growing = {
            st.name
            for st in self.statements.values()
            if st.domain.along and st.domain == self._empty_domain(st.domain.indices)
        }
        for statement in reversed(self._sort(self.statements)):
            for expr, over in statement.parts():
                for symbol in expr.free_symbols:
                    element = self.read(symbol)
                    if element is not None and element.base in growing:
                        target = self.statements[element.base]
                        target.domain = target.domain.extend(*element.span(over))

    def _merge_aliases(self, shared: set[Symbol]) -> None:
        """Give a shared quantity that is an output as it stands the name of the output."""
        summed = {st.terms.name for st in self.statements.values() if st.terms}
        for name, statement in list(self.statements.items()):
            symbol = statement.expr
            if statement.kind != VALUE or symbol not in shared or name in summed:
                continue
            target = self.statements.get(str(symbol))
            if target is None or not statement.domain.same_range(target.domain):
                continue
            del self.statements[target.name]
            self.statements[name] = Statement(name, VALUE, target.domain, target.expr)
            for reader in self.statements.values():
                reader.replace_symbols({symbol: Symbol(name, real=True)})

    # Order ------------------------------------------------------------------------------------

    def uses(self, statement: Statement) -> set[str]:
        """Names that a statement reads."""
        symbols = {symbol for expr, _ in statement.parts() for symbol in expr.free_symbols}
        elements = {symbol: self.elements.get(symbol) for symbol in symbols}
        return {e.base if e is not None else str(symbol) for symbol, e in elements.items()}

    def _sort(self, names: Iterable[str]) -> list[Statement]:
        """Statements that some names need, each after all that it uses."""
        done: dict[str, Statement] = {}

        def visit(name: str) -> None:
            if name in done or name not in self.statements:
                return
            for used in sorted(self.uses(self.statements[name]), key=_natural_key):
                visit(used)
            done[name] = self.statements[name]

        for name in names:
            visit(name)
        return list(done.values())


def _natural_key(name: str) -> tuple[str, int, str]:
    """Sort key that puts a2 before a10."""
    head = name.rstrip("0123456789")
    return head, int(name[len(head) :] or -1), name
