"""The audit as a page of Markdown: docs/audit.md."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rodgen.thesis.audit.claim import NOT_PRINTED, Claim, Finding, Verdict
from rodgen.thesis.audit.java import Order
from rodgen.view.audit_text import (
    EQUATIONS,
    INTRODUCTION,
    MEANING,
    STEPPERS,
    TITLE,
    as_latex,
    counts,
    links,
    parts,
    where,
)

REPAIR = "Repair of the text: "
LONGEST = 200  # characters of a difference


def markdown(findings: Sequence[Finding], orders: Sequence[Order]) -> str:
    """The verdicts, what was mended or belongs to what is exact, and the rest explained."""
    lines = [f"# {TITLE}", "", *_paragraphs(INTRODUCTION)]
    lines.append(
        "`rodgen audit` does all of it anew, and writes a page with every printed form, tables and "
        "JSON."
    )
    lines += ["", "## Verdicts", "", *_counts(findings)]
    for part, some in parts(findings).items():
        lines += ["", f"## {part}"]
        exact = [f.claim for f in some if f.verdict is Verdict.EXACT]
        lines += ["", f"Exact: {'; '.join(claim.number for claim in exact)}."]
        lines += ["", "What belongs to these:", "", *_remarks(exact)]
        for finding in some:
            if finding.verdict is not Verdict.EXACT:
                lines += ["", *_finding(finding, math=part == EQUATIONS)]
    lines += ["", "## Orders of the steppers", "", *_paragraphs([STEPPERS]), *_steppers(orders)]
    return "\n".join(lines) + "\n"


def _paragraphs(texts: Sequence[str]) -> Iterator[str]:
    for text in texts:
        yield text
        yield ""


def _counts(findings: Sequence[Finding]) -> Iterator[str]:
    groups = parts(findings)
    yield f"| verdict | meaning | {' | '.join(part.lower() for part in groups)} |"
    yield f"|---|---|{'---:|' * len(groups)}"
    for verdict, meaning in MEANING.items():
        numbers = " | ".join(str(counts(some)[verdict]) for some in groups.values())
        yield f"| {verdict} | {meaning} | {numbers} |"


def _remarks(claims: Sequence[Claim]) -> Iterator[str]:
    """Repairs and notes, each with all the claims that it belongs to."""
    numbers: dict[str, list[str]] = {}
    for claim in claims:
        for remark in (*(REPAIR + text for text in claim.repairs), claim.note):
            numbers.setdefault(remark, []).append(claim.number)
    yield from (f"- {'; '.join(some)}: {remark}" for remark, some in numbers.items() if remark)


def _finding(finding: Finding, math: bool) -> Iterator[str]:
    claim = finding.claim
    yield f"### {claim.number}, {claim.title}: {finding.verdict}"
    yield ""
    if finding.detail:
        yield f"- Why: {finding.detail}."
    for reading, (n, at, value) in finding.remains.items():
        if value == NOT_PRINTED:
            continue  # the line before has said so
        read = "" if reading == "as printed" else f" ({reading})"
        shown = f"$`{as_latex(value)}`$" if math else f"`{value}`"
        if len(str(value)) > LONGEST:
            shown = "long, see the page"
        yield f"- Printed less true{read}, {where(finding, n, at)}: {shown}"
    if claim.correction:
        shown = f"$`{claim.correction}`$" if math else f"`{claim.correction}`"
        yield f"- Put right: {shown}"
    for repair in claim.repairs:
        yield f"- {REPAIR}{repair}"
    if claim.note:
        yield f"- {claim.note}"
    yield f"- Compared for {links(finding)}."


def _steppers(orders: Sequence[Order]) -> Iterator[str]:
    yield "| method | lines | read or put right | loads | claimed | measured | verdict |"
    yield "|---|---|---|---|---:|---:|---|"
    for o in orders:
        row = (o.name, o.lines, o.reading, o.loads, o.nominal, measured(o), o.verdict)
        yield f"| {' | '.join(map(str, row))} |"


def measured(order: Order) -> str:
    """To one digit: what does not depend on the machine's rounding."""
    return f"{round(order.measured, 1) + 0.0:.1f}"
