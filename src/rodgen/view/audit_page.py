"""The audit as one HTML page that needs no network, with CSV, JSON and Markdown beside it."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from sympy import Expr, Symbol
from sympy.printing.mathml import mathml

from rodgen.loading.cache import write_whole
from rodgen.thesis.audit.claim import NOT_PRINTED, Finding
from rodgen.thesis.audit.java import Order
from rodgen.view.audit_markdown import markdown, measured
from rodgen.view.audit_text import (
    INTRODUCTION,
    MEANING,
    STEPPERS,
    counts,
    csv_text,
    difference,
    json_object,
    links,
    parts,
    steppers_csv,
    where,
)

TEMPLATE = "pages/audit.html.jinja"
LONGEST = 400  # characters of a difference that is shown as a formula too
_DOTTED = {"omegadot": "\u03c9\u0307", "vdot": "v\u0307"}


def write_audit(folder: Path, findings: Sequence[Finding], orders: Sequence[Order]) -> Path:
    """Write index.html, findings.csv, steppers.csv, audit.json and audit.md; returns the page."""
    page = folder / "index.html"
    text = json.dumps(json_object(findings, orders), indent=1, ensure_ascii=False)
    write_whole(folder / "audit.json", text + "\n")
    write_whole(folder / "findings.csv", csv_text(findings))
    write_whole(folder / "steppers.csv", steppers_csv(orders))
    write_whole(folder / "audit.md", markdown(findings, orders))
    write_whole(page, html(findings, orders))
    return page


def html(findings: Sequence[Finding], orders: Sequence[Order]) -> str:
    """The page."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    source = files("rodgen.templates").joinpath(TEMPLATE).read_text(encoding="utf-8")
    groups = parts(findings)
    return environment.from_string(source).render(
        introduction=INTRODUCTION,
        counts=[
            {
                "verdict": verdict.value,
                "meaning": meaning,
                "counts": [counts(some)[verdict] for some in groups.values()],
            }
            for verdict, meaning in MEANING.items()
        ],
        parts=[
            {"title": part, "anchor": _anchor(part), "claims": [_claim(f) for f in some]}
            for part, some in groups.items()
        ],
        stepper_note=STEPPERS,
        steppers=[_stepper(order) for order in orders],
    )


def _claim(finding: Finding) -> dict[str, Any]:
    claim = finding.claim
    return {
        "number": claim.number,
        "anchor": _anchor(claim.number),
        "title": claim.title,
        "verdict": finding.verdict.value,
        "detail": finding.detail,
        "printed": claim.printed,
        "correction": claim.correction,
        "repairs": claim.repairs,
        "note": claim.note,
        "links": links(finding),
        "remains": [
            {
                "reading": reading,
                "where": where(finding, n, at),
                "text": difference(value),
                "mathml": _mathml(value),
            }
            for reading, (n, at, value) in finding.remains.items()
        ],
    }


def _stepper(order: Order) -> dict[str, Any]:
    return {
        "name": order.name,
        "lines": order.lines,
        "reading": order.reading,
        "loads": order.loads,
        "nominal": order.nominal,
        "measured": measured(order),
        "verdict": order.verdict.value,
    }


def _mathml(value: Expr) -> Markup | None:
    """SymPy's presentation of a difference, where it is not too long to be read."""
    if value == NOT_PRINTED or len(str(value)) > LONGEST:
        return None
    letters = {s: Symbol(_letter(str(s))) for s in value.free_symbols}
    # Of SymPy's own making: names are escaped by its XML writer.
    return Markup(mathml(value.xreplace(letters), printer="presentation"))


def _letter(name: str) -> str:
    """A name as SymPy sets it: with an index, and a dot for a rate."""
    base, _, index = name.partition("_")
    if base in ("vx0", "vy0"):
        return f"v_{base[1:]}"
    return f"{_DOTTED[base]}_{index}" if base in _DOTTED else name


def _anchor(name: str) -> str:
    return re.sub(r"\W+", "-", name.lower()).strip("-")
