"""The audit of equations 2.1 to 2.65: its verdicts, its notes, its pages."""

from __future__ import annotations

import csv
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from sympy import (
    Expr,
    Integer,
    cos,
    diff,
    sin,
)
from typer.testing import CliRunner

from rodgen.cli.app import make_app
from rodgen.derive.symbols import k, l, m, vx0
from rodgen_evidence.pages.audit_page import csv_text, html, json_object, markdown, write_audit
from rodgen_evidence.thesis.audit import thesis_claims
from rodgen_evidence.thesis.audit.claim import Claim, Entries, Finding, Verdict, judge
from rodgen_evidence.thesis.audit.java_steppers import stepper_orders
from rodgen_evidence.thesis.audit.latex import read
from rodgen_evidence.thesis.audit.thesis_claims import equation_claims
from rodgen_evidence.thesis.audit.truth import D_x, domega, omega, phi, truth
from rodgen_evidence.thesis.audit.zero import is_zero

DOCS = Path(__file__).parents[3] / "docs" / "audit.md"

# What the comparison of the thesis's text with the derivation comes to.
NOT_EXACT = {
    "2.16": Verdict.MISPRINT,  # pairs of links counted twice
    "2.17": Verdict.MISPRINT,  # the same, and the last sum
    "2.26": Verdict.MISPRINT,  # weights of the other links
    "2.29": Verdict.MISPRINT,  # weights, signs, a loose index
    "2.31": Verdict.MISPRINT,  # weights
    "2.37": Verdict.MISSING,  # x0 for y0
    "2.43": Verdict.MISSING,  # the mass matrix
    "2.44": Verdict.MISPRINT,  # m, and the weights of the last column and row
    "2.47": Verdict.AMBIGUOUS,  # F_x
    "2.56": Verdict.INCOMPLETE,  # joints 0 and n
    "2.57": Verdict.AMBIGUOUS,  # quadrant
    "2.64": Verdict.SIGN,  # force against moments
    "2.65": Verdict.MISPRINT,  # omega behind the wrong damping
}


def claim(number: str) -> Claim:
    return next(c for c in equation_claims() if c.number == number)


def form(number: str) -> Entries:
    """The only reading of an equation."""
    (only,) = claim(number).readings.values()
    return only


# How the print is read --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        (r"x = 2m l^2 - \frac{1}{2} k", 2 * m * l**2 - k / 2),
        (r"x = \sum_{i=0}^{n-1} \omega_i + m", omega[0] + omega[1] + m),
        (r"x = - l \sin(\varphi_{n-1} - \varphi_0) k^2", -l * k**2 * sin(phi[1] - phi[0])),
        (r"x = k \left[\sum_{k=2}^{1} \omega_k - \{1 + m\} \right]", -k * (1 + m)),
        (r"x = \sum_{i \ne s} \max(i,s) \dot{\omega}_i v_{x0}", domega[1] * vx0),
        (r"x = \frac{1}{l} \int_0^l 2 r m dr", m * l),
    ],
)
def test_print_is_read_as_it_stands(text: str, value: Expr) -> None:
    """A sum ends with its term, and its index hides a letter; an empty sum is zero."""
    (entry,) = read(text)(2)
    assert is_zero(entry - value)


@pytest.mark.parametrize("text", [r"x = (m", r"x = m )", r"x = \sum m"])
def test_what_cannot_be_read_is_refused(text: str) -> None:
    with pytest.raises((ValueError, IndexError)):
        read(text)


# The audit --------------------------------------------------------------------------------------


def test_every_numbered_equation_is_judged_once() -> None:
    numbers = [c.number for c in equation_claims()]
    assert numbers == [f"2.{i}" for i in range(1, 66)]


def test_verdicts(findings: list[Finding]) -> None:
    equations = {f.claim.number: f.verdict for f in findings if f.claim.number.startswith("2.")}
    assert {n: v for n, v in equations.items() if v is not Verdict.EXACT} == NOT_EXACT


def test_what_is_not_exact_shows_a_difference_and_is_put_right(findings: list[Finding]) -> None:
    for f in findings:
        if f.claim.number in NOT_EXACT:
            assert f.remains or not f.claim.readings, f.claim.number
            assert f.claim.corrected, f.claim.number
            assert f.claim.correction, f.claim.number


@pytest.mark.parametrize(
    ("number", "n", "entry", "difference"),
    [
        # worked out by hand from the printed sums
        ("2.16", 5, 4, m * l**2 * omega[1] * omega[2] * cos(phi[1] - phi[2])),
        ("2.26", 1, 0, m * l**2 * omega[0] / 2),
        ("2.31", 3, 0, m * l**2 * omega[0] * omega[1] * sin(phi[0] - phi[1]) / 2),
        ("2.65", 1, 0, (D_x[0] + D_x[1]) * (vx0 - 1)),
    ],
)
def test_differences(number: str, n: int, entry: int, difference: Expr) -> None:
    ((size, at, value),) = judge(claim(number)).remains.values()
    assert (size, at) == (n, entry)
    assert is_zero(value - difference)


# What the notes say -----------------------------------------------------------------------------


def rate(expression: Expr, n: int) -> Expr:
    """Time derivative in letters."""
    t = truth(n)
    moving = zip(t.positions + t.rates, t.rates + t.accelerations, strict=True)
    return sum((diff(expression, q) * u for q, u in moving), Integer(0))


@pytest.mark.parametrize("n", [2, 3, 4])
def test_2_29_has_three_signs_that_do_not_follow_from_2_26(n: int) -> None:
    from_2_26 = [rate(e, n) for e in form("2.26")(n)]
    tail = n - 1
    for s, (given, due) in enumerate(zip(form("2.29")(n), from_2_26, strict=True)):
        sines = [sin(phi[s] - phi[i]) * omega[i] ** 2 for i in range(s)]
        last = omega[tail] * (omega[s] - omega[tail]) * sin(phi[tail] - phi[s])
        turned = m / 2 * l**2 * (4 * sum(sines) + 2 * last)
        assert is_zero(given + turned - due)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_2_31_has_the_pairs_of_the_last_link_alone(n: int) -> None:
    last = form("2.16")(n)[-1]
    for s, given in enumerate(form("2.31")(n)):
        pairs = diff(last, phi[s])
        for i in range(n):
            if i != s:
                assert is_zero(diff(given - pairs, omega[s], omega[i]))


# The pages --------------------------------------------------------------------------------------


class Page(HTMLParser):
    """Anchors, links, and elements that are left open."""

    VOID = {"meta", "link", "img", "br"}

    def __init__(self, text: str):
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.ids += [value for key, value in given.items() if key == "id" and value]
        self.links += [value for key, value in given.items() if key in ("href", "src") and value]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.nightly
def test_page_is_whole_and_needs_no_network(findings: list[Finding]) -> None:
    text = html(findings, stepper_orders())
    page = Page(text)
    assert page.open == []
    assert len(set(page.ids)) == len(page.ids)
    assert {link.removeprefix("#") for link in page.links} <= set(page.ids)
    assert len(page.ids) == len(findings) + 3
    assert not re.search(r"https?:|<script|@import|url\(", text)
    assert text.count("<math>") >= len(NOT_EXACT) - 3
    assert "for (l=0; l&lt;=i; l++)" in text  # what was printed is escaped


@pytest.mark.nightly
def test_tables_hold_every_finding(findings: list[Finding], tmp_path: Path) -> None:
    rows = list(csv.DictReader(io.StringIO(csv_text(findings))))
    assert {row["number"] for row in rows} == {f.claim.number for f in findings}
    told = json_object(findings, stepper_orders())
    assert [f["verdict"] for f in told["findings"]] == [f.verdict for f in findings]
    assert sum(told["verdicts"]["equations"].values()) == 65
    assert len(told["findings"]) == len(findings)
    page = write_audit(tmp_path / "audit", findings, stepper_orders())
    names = {"index.html", "findings.csv", "steppers.csv", "audit.json", "audit.md"}
    assert {file.name for file in page.parent.iterdir()} == names
    assert json.loads((page.parent / "audit.json").read_text()) == told


def test_command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Of a few claims, one of them of the listing."""
    some = {"2.1": "exact", "2.37": "missing", "2.64": "sign conflict", "Java 120-124": "exact"}
    claims = thesis_claims.equation_claims() + thesis_claims.listing_claims()
    *of_text, of_listing = (c for c in claims if c.number in some)
    monkeypatch.setattr(thesis_claims, "equation_claims", lambda: of_text)
    monkeypatch.setattr(thesis_claims, "listing_claims", lambda: [of_listing])
    result = CliRunner().invoke(make_app(), ["audit", "--out", str(tmp_path), "--json"])
    assert result.exit_code == 0
    told = json.loads(result.stdout)
    assert {f["number"]: f["verdict"] for f in told["findings"]} == some
    assert (tmp_path / "index.html").exists()


def test_every_repair_and_note_is_told(findings: list[Finding]) -> None:
    text = markdown(findings, [])
    for c in (finding.claim for finding in findings):
        assert all(repair in text for repair in c.repairs), c.number
        assert c.note in text, c.number


def test_docs_are_up_to_date(findings: list[Finding], request: pytest.FixtureRequest) -> None:
    """pytest tests/thesis/test_audit_equations.py --update writes them anew."""
    text = markdown(findings, stepper_orders())
    if request.config.getoption("--update"):
        DOCS.write_text(text, encoding="utf-8")
    assert DOCS.read_text(encoding="utf-8") == text
