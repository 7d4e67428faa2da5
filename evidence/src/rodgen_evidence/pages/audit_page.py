"""The audit as an HTML page that needs no network, with CSV, JSON and Markdown beside it."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup
from pandas import DataFrame
from sympy import Expr, Symbol, latex
from sympy.printing.mathml import mathml

from rodgen.loading.cache import write_whole
from rodgen_evidence.page_tables import Cell, Shown
from rodgen_evidence.pages.folder import anchor, render
from rodgen_evidence.thesis.audit.claim import LINKS, NOT_PRINTED, Finding, Verdict, entry_name
from rodgen_evidence.thesis.audit.java_steppers import Order

INTRODUCTION = (
    "This page compares J. Masek, Modelling of free beam loaded by follower load, Brno 2014, with "
    "what rodgen derives. Every numbered equation from 2.1 to 2.65 and every method of the Java "
    "listing is written down as it is printed, with the printed limits, factors, indices and "
    "signs. It is compared with the equations of a chain of n rigid links by Lagrange's method, "
    "and with their loads by virtual work. The Gauss elimination that getSolution calls is not "
    "compared, because its library is not printed. Unless stated otherwise, n goes from "
    f"{LINKS[0]} to {LINKS[-1]}.",
    "Every verdict is computed. Two expressions are equal if their normal forms are equal: "
    "polynomials with rational coefficients in the letters and in the cosines and sines of the "
    "angles, in which no sine is squared. Floating point decides no equality. Some parts are "
    "written by hand: the printed form, its readings if the text allows several, the corrected "
    "form, and the notes. The corrected form must equal the derived one. A note says so if it is "
    "a hypothesis.",
)
MEANING = {
    Verdict.EXACT: "equal to the derived form",
    Verdict.MISPRINT: "differs from the derived form; the corrected form is equal to it",
    Verdict.SIGN: "right except for a sign, of the whole or of some entries",
    Verdict.INCOMPLETE: "the printed part is right, but terms or entries are left out",
    Verdict.MISSING: "something that is needed is not printed",
    Verdict.AMBIGUOUS: "can be read in several ways, some of them right and some wrong",
}
STEPPERS = (
    "The listing's steppers, as printed, run in floating point on a rod of three links. DOP853 on "
    "the derived equations is the reference. The order is the power of the step with which the "
    "error falls, fitted over several steps. It is exact if it is within 0.2 of the claimed order."
)
FINDINGS = (
    *("number", "title", "verdict", "why", "reading", "n", "entry", "difference"),
    *("put_right", "repairs", "note"),
)
EQUATIONS, LISTING = "Equations", "Java listing"
REPAIR = "Repair of the text: "
LONGEST = 400  # characters of a difference that is shown as a formula too
# Letters of the audit that are more than a name and an index, in LaTeX and in Unicode.
_DOTTED = {"omegadot": (r"\dot{\omega}", "\u03c9\u0307"), "vdot": (r"\dot{v}", "v\u0307")}


def write_audit(folder: Path, findings: Sequence[Finding], orders: Sequence[Order]) -> Path:
    """Write index.html, findings.csv, steppers.csv, audit.json and audit.md; returns the page."""
    page = folder / "index.html"
    told = json_object(findings, orders)
    write_whole(folder / "audit.json", json.dumps(told, indent=1, ensure_ascii=False) + "\n")
    write_whole(folder / "findings.csv", csv_text(findings))
    write_whole(folder / "steppers.csv", steppers_csv(told["steppers"]))
    write_whole(folder / "audit.md", markdown(findings, orders))
    write_whole(page, html(findings, orders))
    return page


def html(findings: Sequence[Finding], orders: Sequence[Order]) -> str:
    """The page."""
    return render("audit.html.jinja", **_content(findings, orders))


def markdown(findings: Sequence[Finding], orders: Sequence[Order]) -> str:
    """The verdicts, what was mended or belongs to what is exact, and the rest explained: the page
    docs/audit.md."""
    return render("audit.md.jinja", **_content(findings, orders))


def parts(findings: Sequence[Finding]) -> dict[str, list[Finding]]:
    """Findings on the equations and on the listing."""
    of_listing = [f for f in findings if f.claim.number.startswith("Java")]
    return {EQUATIONS: [f for f in findings if f not in of_listing], LISTING: of_listing}


def counts(findings: Sequence[Finding]) -> Counter[Verdict]:
    """Count the findings of each verdict."""
    return Counter(f.verdict for f in findings)


# Tables ------------------------------------------------------------------------------------------


def json_object(findings: Sequence[Finding], orders: Sequence[Order]) -> dict[str, Any]:
    """Everything the page shows."""
    return {
        "verdicts": {
            part.lower(): {verdict.value: counts(some)[verdict] for verdict in Verdict}
            for part, some in parts(findings).items()
        },
        "findings": [_told(finding) for finding in findings],
        "steppers": [
            {
                "name": order.name,
                "lines": order.lines,
                "reading": order.reading,
                "loads": order.loads,
                "claimed": order.nominal,
                "measured": order.slope,
                "verdict": order.verdict.value,
                "steps": list(order.steps),
                "errors": list(order.errors),
            }
            for order in orders
        ],
    }


def _told(finding: Finding) -> dict[str, Any]:
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


def csv_text(findings: Sequence[Finding]) -> str:
    """One line for every reading that differs; one for a claim of which none does."""
    lines = [
        told
        | rest
        | {"repairs": "; ".join(told["repairs"]), "difference": _in_words(rest["difference"])}
        for told in map(_told, findings)
        for rest in told["remains"] or [dict.fromkeys(("reading", "n", "entry", "difference"), "")]
    ]
    rows = DataFrame(lines, columns=[*FINDINGS], dtype=object)
    return str(rows.to_csv(index=False, header=[name.replace("_", " ") for name in FINDINGS]))


def steppers_csv(steppers: Sequence[dict[str, Any]]) -> str:
    """One line for every step of every stepper."""
    rows = DataFrame(steppers).explode(["steps", "errors"])
    for key, spec in ("measured", "{:.3f}"), ("errors", "{:.6e}"):
        rows[key] = rows[key].map(spec.format)
    rows = rows.rename(columns={"name": "method", "steps": "step", "errors": "error"})
    return str(rows.to_csv(index=False))


def _in_words(difference: str | None) -> str:
    """Printed minus derived."""
    return "nothing is printed" if difference is None else difference


# What the templates are filled with --------------------------------------------------------------


def _content(findings: Sequence[Finding], orders: Sequence[Order]) -> dict[str, Any]:
    groups = parts(findings)
    verdicts = [
        [
            _badge(verdict),
            Cell(meaning),
            *(Cell(str(counts(some)[verdict]), "number") for some in groups.values()),
        ]
        for verdict, meaning in MEANING.items()
    ]
    # To one digit: what does not depend on the machine's rounding.
    steppers = [
        [
            *map(Cell, (o.name, o.lines, o.reading, o.loads)),
            Cell(str(o.nominal), "number"),
            Cell(f"{round(o.slope, 1) + 0.0:.1f}", "number"),
            _badge(o.verdict),
        ]
        for o in orders
    ]
    head = ["method", "lines", "read or put right", "loads", "claimed", "measured", "verdict"]
    return {
        "introduction": INTRODUCTION,
        "counts": Shown("", ["verdict", "meaning", *map(str.lower, groups)], verdicts),
        "parts": [_part(title, some) for title, some in groups.items()],
        "stepper_note": STEPPERS,
        "steppers": Shown("", head, steppers),
        "repair": REPAIR,
    }


def _badge(verdict: Verdict) -> Cell:
    return Cell(verdict.value, mark=verdict.value.replace(" ", "-"))


def _part(title: str, findings: Sequence[Finding]) -> dict[str, Any]:
    """Claims, and the remarks on exact ones, each with all the claims that it belongs to."""
    remarks: dict[str, list[str]] = {}
    for claim in (f.claim for f in findings if f.verdict is Verdict.EXACT):
        for remark in (*(REPAIR + text for text in claim.repairs), claim.note):
            if remark:
                remarks.setdefault(remark, []).append(claim.number)
    return {
        "title": title,
        "anchor": anchor(title),
        "formulas": title == EQUATIONS,
        "claims": [_shown(finding) for finding in findings],
        "remarks": remarks,
    }


def _shown(finding: Finding) -> dict[str, Any]:
    """Entries of a finding on the page, with its differences as formulas."""
    told, links = _told(finding), finding.claim.links
    values = (value for _, _, value in finding.remains.values())
    for row, value in zip(told["remains"], values, strict=True):
        row["where"] = f"n = {row['n']}, {row['entry']}"
        row["text"] = _in_words(row["difference"])
        row["mathml"], row["latex"] = _mathml(value), _latex(value)
    span = f"n = {links[0]}" if len(links) == 1 else f"n = {links[0]} to {links[-1]}"
    return told | {"anchor": anchor(told["number"]), "compared": span}


def _mathml(value: Expr) -> Markup | None:
    """SymPy's presentation of a difference, where it is not too long to be read."""
    if value == NOT_PRINTED or len(str(value)) > LONGEST:
        return None
    names = _names(value, "{base}_{index}", 1)
    letters = {s: Symbol(names.get(s, str(s))) for s in value.free_symbols}
    # Of SymPy's own making: names are escaped by its XML writer.
    return Markup(mathml(value.xreplace(letters), printer="presentation"))


def _latex(value: Expr) -> str:
    """LaTeX with the thesis's letters."""
    names = _names(value, "{base}_{{{index}}}", 0)
    return str(latex(value, symbol_names=names)).replace(r"\phi", r"\varphi")


def _names(value: Expr, form: str, writing: int) -> dict[Expr, str]:
    """Letters that are more than a name and an index, as they are written."""
    names = {}
    for symbol in value.free_symbols:
        base, _, index = str(symbol).partition("_")
        if base in _DOTTED:
            names[symbol] = form.format(base=_DOTTED[base][writing], index=index)
        if base in ("vx0", "vy0"):
            names[symbol] = form.format(base="v", index=base[1:])
    return names
