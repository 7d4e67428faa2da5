"""The audit in words: Markdown for docs/audit.md, CSV and JSON."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from typing import Any

from sympy import Expr, Symbol, latex

from rodgen.thesis.audit.claim import LINKS, NOT_PRINTED, Finding, Verdict
from rodgen.thesis.audit.java import Order
from rodgen.thesis.audit.judge import entry_name

TITLE = "The thesis's equations and listing, audited"
INTRODUCTION = (
    "J. Masek, Modelling of free beam loaded by follower load, Brno 2014: every numbered equation "
    "from 2.1 to 2.65 and every method of the Java listing is written down as it is printed, with "
    "the printed limits, factors, indices and signs, and compared with what rodgen derives: the "
    "equations of a chain of n rigid links by Lagrange's method, their loads by virtual work. Left "
    "out is the Gauss elimination that getSolution calls, of a library that is not printed. "
    f"If nothing else is said, n goes from {LINKS[0]} to {LINKS[-1]}.",
    "Every verdict is computed. Two expressions are equal if their normal forms are: polynomials "
    "with rational coefficients in the letters and in the cosines and sines of the angles, in "
    "which no sine is squared. No equality rests on floating point. What is written by hand is the "
    "printed form, its readings where the text allows several, the form put right, which must "
    "equal the truth, and the notes; what is a hypothesis is called one.",
)
MEANING = {
    Verdict.EXACT: "equal to what is derived",
    Verdict.MISPRINT: "differs; the form put right does not",
    Verdict.SIGN: "right but for a sign: of the whole, or of some entries",
    Verdict.INCOMPLETE: "what is printed is right, terms or entries are left out",
    Verdict.MISSING: "nothing is printed for what is needed",
    Verdict.AMBIGUOUS: "can be read in several ways, of which some are right and some are not",
}
STEPPERS = (
    "The listing's steppers, as printed, run in floating point on a rod of three links, beside "
    "DOP853 on the derived equations. The order is the power of the step with which the error "
    "falls, fitted over several steps; it is exact where it is within 0.2 of the claimed one."
)
EQUATIONS, LISTING = "Equations", "Java listing"

# Letters of the audit that are more than a name and an index.
_DOTTED = {"omegadot": r"\dot{\omega}", "vdot": r"\dot{v}"}


def parts(findings: Sequence[Finding]) -> dict[str, list[Finding]]:
    """Findings on the equations and on the listing."""
    of_listing = [f for f in findings if f.claim.number.startswith("Java")]
    return {EQUATIONS: [f for f in findings if f not in of_listing], LISTING: of_listing}


def counts(findings: Sequence[Finding]) -> Counter[Verdict]:
    """How many findings there are of each verdict."""
    return Counter(f.verdict for f in findings)


def links(finding: Finding) -> str:
    """The n that were compared, in words."""
    compared = finding.claim.links
    span = f"n = {compared[0]}"
    return span if len(compared) == 1 else f"{span} to {compared[-1]}"


def where(finding: Finding, n: int, at: int) -> str:
    """The entry that differs."""
    return f"n = {n}, {entry_name(finding.claim, n, at)}"


def difference(value: Expr) -> str:
    """Printed less true, in words."""
    return "nothing is printed" if value == NOT_PRINTED else str(value)


def _latex_name(symbol: Symbol) -> str | None:
    name, _, index = str(symbol).partition("_")
    if name in _DOTTED:
        return f"{_DOTTED[name]}_{{{index}}}"
    if name in ("vx0", "vy0"):
        return f"v_{{{name[1:]}}}"
    return None


def as_latex(value: Expr) -> str:
    """LaTeX with the thesis's letters."""
    names = {s: name for s in value.free_symbols if (name := _latex_name(s))}
    return str(latex(value, symbol_names=names)).replace(r"\phi", r"\varphi")


# Tables ------------------------------------------------------------------------------------------


def csv_text(findings: Sequence[Finding]) -> str:
    """One line for every reading that differs; one for a claim of which none does."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    head = ("number", "title", "verdict", "why", "reading", "n", "entry", "difference", "put right")
    writer.writerow((*head, "repairs", "note"))
    for finding in findings:
        claim = finding.claim
        rows: list[tuple[object, ...]] = [
            (reading, n, entry_name(claim, n, at), difference(value))
            for reading, (n, at, value) in finding.remains.items()
        ]
        for row in rows or [("", "", "", "")]:
            start = claim.number, claim.title, finding.verdict, finding.detail
            writer.writerow((*start, *row, claim.correction, "; ".join(claim.repairs), claim.note))
    return out.getvalue()


def steppers_csv(orders: Sequence[Order]) -> str:
    """One line for every step of every stepper."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    head = ("method", "lines", "reading", "loads", "claimed", "measured", "verdict")
    writer.writerow((*head, "step", "error"))
    for order in orders:
        row = (order.name, order.lines, order.reading, order.loads, order.nominal)
        for step, error in zip(order.steps, order.errors, strict=True):
            writer.writerow((*row, f"{order.measured:.3f}", order.verdict, step, f"{error:.6e}"))
    return out.getvalue()


def json_object(findings: Sequence[Finding], orders: Sequence[Order]) -> dict[str, Any]:
    """Everything the page shows."""
    return {
        "verdicts": {
            part.lower(): {verdict.value: counts(some)[verdict] for verdict in Verdict}
            for part, some in parts(findings).items()
        },
        "findings": [_json_finding(finding) for finding in findings],
        "steppers": [
            {
                "name": order.name,
                "lines": order.lines,
                "reading": order.reading,
                "loads": order.loads,
                "claimed": order.nominal,
                "measured": order.measured,
                "verdict": order.verdict.value,
                "steps": list(order.steps),
                "errors": list(order.errors),
            }
            for order in orders
        ],
    }


def _json_finding(finding: Finding) -> dict[str, Any]:
    claim = finding.claim
    return {
        "number": claim.number,
        "title": claim.title,
        "verdict": finding.verdict.value,
        "why": finding.detail,
        "links": list(claim.links),
        "remains": [
            {
                "reading": reading,
                "n": n,
                "entry": entry_name(claim, n, at),
                "difference": None if value == NOT_PRINTED else str(value),
            }
            for reading, (n, at, value) in finding.remains.items()
        ],
        "printed": claim.printed,
        "put_right": claim.correction,
        "repairs": list(claim.repairs),
        "note": claim.note,
    }
