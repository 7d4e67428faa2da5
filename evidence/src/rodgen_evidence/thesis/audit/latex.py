"""Printed formulas as expressions: the LaTeX of an equation, read for a number of links.

What is read is what is shown, so that no formula stands twice. A sum goes to the end of its term,
as in print; an index that a sum runs over is another letter than the one outside.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any

from sympy import Expr, Integer, Max, S, cos, integrate, sin

from rodgen.derive.symbols import k, l, m, vx0, vy0
from rodgen_evidence.thesis.audit.claim import READ, Claim, Entries
from rodgen_evidence.thesis.audit.truth import ax0, ay0, domega, omega, phi, r

Names = Mapping[str, Expr]  # letters and indices, by their names
Form = Callable[[Names], Expr]

TOKEN = re.compile(r"\\dot\{\\?[a-z]+\}|\\[a-z]+|\\[{}]|\d+|dr|[A-Za-z]|\S")
IGNORED = {r"\left", r"\right"}
BRACKETS = {"[": "(", r"\{": "(", "]": ")", r"\}": ")"}
ENDS = {"+", "-", ")", "}", ","}  # of a term
FUNCTIONS: dict[str, Callable[..., Expr]] = {r"\cos": cos, r"\sin": sin, r"\max": Max}
INDEXED = {r"\omega": omega, r"\varphi": phi, r"\dot{\omega}": domega}
LETTERS: Names = {
    "m": m,
    "l": l,
    "k": k,
    "r": r,
    r"\rho": m / l,  # called density of the element: mass per length
    "dr": S.One,  # of an element; entries are per length
    "v_x0": vx0,
    "v_y0": vy0,
    r"\dot{v}_x0": ax0,
    r"\dot{v}_y0": ay0,
}


def read(
    text: str,
    over: Callable[[int], Iterable[int]] = lambda n: (0,),
    letters: Names = MappingProxyType({}),
    last: bool = False,
) -> Entries:
    """Right sides of equations that commas and \\quad part, for every s of a range.

    letters: others than LETTERS; last: of several right sides of an equation, the last alone.
    """
    sides = [part.split(" = ")[1:] for part in text.split(r", \quad ")]
    forms = [_Reader(side).whole() for parts in sides for side in (parts[-1:] if last else parts)]

    def entries(n: int) -> list[Expr]:
        known = {**LETTERS, **letters, "n": Integer(n)}
        return [form({**known, "s": Integer(s)}) for s in over(n) for form in forms]

    return entries


def equation(
    number: str,
    title: str,
    text: str,
    true: Entries,
    over: Callable[[int], Iterable[int]] = lambda n: (0,),
    letters: Names = MappingProxyType({}),
    last: bool = False,
    as_read: tuple[str, str, str] = (READ, "", ""),
    put_right: tuple[str, str, str] = ("", "", ""),
    **more: Any,
) -> Claim:
    """Claim of a printed equation, as it is read, for every s of a range.

    as_read: the name of the reading, a part of the text, and what it is read as; put_right: where
    the wrong part begins, which goes to the last brace, the right one, and what it replaces.
    """
    reading, given, instead = as_read
    start, right, replaced = put_right
    if start:
        more["corrected"] = read(text[: text.index(start)] + right + r"\right\}", over)
        more["correction"] = rf"{right}\text{{ in place of {replaced}"
    form = read(text.replace(given, instead) if given else text, over, letters, last)
    return Claim(number, title, {reading: form}, true, printed=text, **more)


class _Reader:
    """Recursive descent over the tokens of a formula."""

    def __init__(self, text: str) -> None:
        kept = (token for token in TOKEN.findall(text) if token not in IGNORED)
        self.tokens: list[str] = [BRACKETS.get(token, token) for token in kept]

    def whole(self) -> Form:
        form = self.expression()
        if self.tokens:
            raise ValueError(f"not read: {' '.join(self.tokens)}")
        return form

    def next(self) -> str:
        return self.tokens[0] if self.tokens else ")"

    def take(self, *expected: str) -> str:
        token = self.tokens.pop(0)
        if expected and token not in expected:
            raise ValueError(f"{token} where {' or '.join(expected)} is due")
        return token

    def expression(self) -> Form:
        terms: list[tuple[int, Form]] = []
        while not terms or self.next() in "+-":
            sign = -1 if self.next() in "+-" and self.take() == "-" else 1
            terms.append((sign, self.term()))
        return lambda names: sum((sign * form(names) for sign, form in terms), S.Zero)

    def term(self, end: str = "") -> Form:
        factors = [self.power()]
        while self.next() not in ENDS and self.next() != end:
            factors.append(self.power())

        def product(names: Names) -> Expr:
            out: Expr = S.One
            for factor in factors:
                out *= factor(names)
            return out

        return product

    def power(self) -> Form:
        base = self.factor()
        if self.next() != "^":
            return base
        self.take()
        exponent = self.group()
        return lambda names: base(names) ** exponent(names)

    def group(self) -> Form:
        """In braces, or a single token."""
        if self.next() != "{":
            return self.factor()
        self.take()
        form = self.expression()
        self.take("}")
        return form

    def arguments(self) -> list[Form]:
        forms = [self.expression()]
        while self.take(",", ")") == ",":
            forms.append(self.expression())
        return forms

    def factor(self) -> Form:
        token = self.take()
        if token.isdigit():
            return lambda names: Integer(token)
        if token == "(":
            (form,) = self.arguments()
            return form
        if token == r"\frac":
            over, under = self.group(), self.group()
            return lambda names: over(names) / under(names)
        if token == r"\sum":
            return self.sum()
        if token == r"\int":
            return self.integral()
        if token in FUNCTIONS:
            self.take("(")
            arguments = self.arguments()
            return lambda names: FUNCTIONS[token](*(form(names) for form in arguments))
        return self.letter(token)

    def letter(self, token: str) -> Form:
        if self.next() != "_":
            return lambda names: names[token]
        self.take()
        if token in INDEXED:
            index = self.group()
            return lambda names: INDEXED[token][int(index(names))]
        name = f"{token}_{self.take()}"
        if name.endswith("{"):
            name = name[:-1]
            while (part := self.take()) != "}":
                name += part
        return lambda names: names[name]

    def sum(self) -> Form:
        """Sum from a limit to another, or over all links but one."""
        self.take("_")
        self.take("{")
        index, relation = self.take(), self.take("=", r"\ne")
        low = self.expression()
        self.take("}")
        if relation == "=":
            self.take("^")
            high = self.group()
        body = self.term()

        def total(names: Names) -> Expr:
            at = int(low(names))
            if relation == "=":
                values = [*range(at, int(high(names)) + 1)]
            else:
                values = [i for i in range(int(names["n"])) if i != at]
            return sum((body({**names, index: Integer(i)}) for i in values), S.Zero)

        return total

    def integral(self) -> Form:
        """Over the length of a link."""
        for token in ("_", "0", "^", "l"):
            self.take(token)
        body = self.term(end="dr")
        self.take("dr")
        return lambda names: integrate(body(names).expand(), (r, 0, l))
