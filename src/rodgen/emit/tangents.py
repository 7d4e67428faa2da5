"""Tangents of statements: derivatives of each quantity along many directions of the state.

Forward differentiation, statement by statement; the partial derivatives are SymPy's.
"""

from __future__ import annotations

from collections.abc import Iterable

from sympy import Add, Expr, Piecewise, S, Symbol

from rodgen.emit.laws import STATE
from rodgen.emit.statements import CASES, DIRECTION, SUMS, VALUE, Domain, Elements, Statement

# What a tangent may start from: the state, and unknowns of a system that is solved in between.
ACTIVE = ("x0", "y0", "phi", "omega", "vx0", "vy0", "lambda_x", "lambda_y", "tension")


class Tangents:
    """Differentiation of statements, which adds their tangents to them."""

    def __init__(self, statements: dict[str, Statement], elements: Elements):
        self._statements, self._elements = statements, elements
        self._known: dict[str, bool] = {}

    def __call__(self, name: str, fixed: Iterable[str] = ()) -> str | None:
        """Name of the tangent of a quantity, or None where it does not follow the state; ``fixed``:
        what it is not differentiated by."""
        if name not in self._known:
            if name not in self._statements:
                self._known[name] = name in ACTIVE or name.startswith(STATE)
            else:
                self._known[name] = self._differentiate(self._statements[name], frozenset(fixed))
        return f"d_{name}" if self._known[name] else None

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
