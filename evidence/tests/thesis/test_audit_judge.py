"""The judge of the audit: every verdict, what follows from a change, what is zero."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import pytest
from sympy import (
    Expr,
    Rational,
    S,
    cos,
    sin,
)

from rodgen.derive import link_properties
from rodgen.derive.loads import LOADS
from rodgen.derive.loads.follower import Follower
from rodgen_evidence.thesis.audit.claim import (
    NOT_PRINTED,
    Claim,
    Entries,
    JudgementError,
    Verdict,
    judge,
)
from rodgen_evidence.thesis.audit.equations_energy import matrix_rows
from rodgen_evidence.thesis.audit.thesis_claims import equation_claims
from rodgen_evidence.thesis.audit.truth import (
    D_x,
    TrueEquations,
    domega,
    nu,
    omega,
    phi,
    product,
    truth,
)
from rodgen_evidence.thesis.audit.zero import is_zero


@pytest.fixture
def other_truth() -> Iterator[None]:
    """For a test that changes what derive/ says."""
    truth.cache_clear()
    yield
    truth.cache_clear()


def claim(number: str) -> Claim:
    return next(c for c in equation_claims() if c.number == number)


Spoil = Callable[[list[Expr]], list[Expr]]


def spoilt(number: str, spoil: Spoil, **more: Any) -> Claim:
    """An exact claim with its printed form changed, and itself as the correction."""
    exact = claim(number)
    (form,) = exact.readings.values()
    return replace(
        exact, readings={"spoilt": lambda n: spoil(list(form(n)))}, corrected=form, **more
    )


@pytest.mark.parametrize(
    ("spoil", "verdict", "why"),
    [
        (lambda rows: rows, Verdict.EXACT, ""),
        (lambda rows: [2 * e for e in rows], Verdict.MISPRINT, ""),
        (lambda rows: [e.subs(phi[0], -phi[0]) for e in rows], Verdict.MISPRINT, ""),
        (lambda rows: [-e for e in rows], Verdict.SIGN, "of the whole"),
        (lambda rows: [rows[0], -rows[1], *rows[2:]], Verdict.SIGN, "of row y0"),
        (lambda rows: [e.expand().subs(D_x[1], 0) for e in rows], Verdict.INCOMPLETE, "left out"),
        (lambda rows: [*rows[:-1], NOT_PRINTED], Verdict.INCOMPLETE, "for row phi_0 (n = 1)"),
        (lambda rows: [NOT_PRINTED for _ in rows], Verdict.MISSING, "for row x0, row y0"),
        (lambda rows: [NOT_PRINTED, *rows[1:-1], 2 * rows[-1]], Verdict.MISPRINT, ""),
    ],
)
def test_a_spoilt_claim_gets_the_verdict_it_deserves(
    spoil: Spoil, verdict: Verdict, why: str
) -> None:
    finding = judge(spoilt("2.60", spoil))
    assert finding.verdict is verdict
    assert why in finding.detail
    assert bool(finding.remains) is (verdict is not Verdict.EXACT)


@pytest.mark.parametrize(
    ("factor", "verdict"),
    [(1, Verdict.EXACT), (-1, Verdict.MISPRINT), (0, Verdict.INCOMPLETE), (2, Verdict.MISPRINT)],
)
@pytest.mark.parametrize("number", ["2.45", "2.51", "2.53", "2.61"])
def test_a_load_is_as_printed_or_it_is_not_exact(
    number: str, factor: int, verdict: Verdict
) -> None:
    """With the other sign, left out, or twice."""
    exact = claim(number)
    (form,) = exact.readings.values()

    def other(n: int) -> list[Expr]:
        pairs = zip(matrix_rows(n), form(n), strict=True)
        return [row + factor * (loaded - row) for row, loaded in pairs]

    assert judge(replace(exact, readings={"": other}, corrected=form)).verdict is verdict


@pytest.mark.parametrize(
    ("number", "term"), [("2.45", "follower"), ("2.51", "internal_damping"), ("2.61", "gravity")]
)
def test_a_load_has_two_routes(
    number: str, term: str, monkeypatch: pytest.MonkeyPatch, other_truth: None
) -> None:
    """Twice the virtual work does not agree with virtual power."""
    load = type(LOADS[term])
    kept = load.explicit_forces
    monkeypatch.setattr(
        load,
        "explicit_forces",
        lambda self, chain: [[2 * e for e in row] for row in kept(self, chain)],
    )
    assert judge(replace(claim(number), corrected=claim(number).truth)).verdict is Verdict.MISPRINT


@pytest.mark.parametrize("at", [-1, -3, 0])
def test_every_line_of_2_41_counts(at: int) -> None:
    """Its rates, and its first row."""

    def turn(rows: list[Expr]) -> list[Expr]:
        rows[at] = -rows[at]
        return rows

    assert judge(spoilt("2.41", turn)).verdict is Verdict.SIGN


def test_2_41_with_another_sign_of_a_matrix() -> None:
    exact = claim("2.41")
    (form,) = exact.readings.values()

    def turned(term: Callable[[TrueEquations], list[Expr]]) -> Entries:
        def rows(n: int) -> list[Expr]:
            terms = [*term(truth(n)), *[S.Zero] * (n + 2)]
            return [row + 2 * e for row, e in zip(form(n), terms, strict=True)]

        return rows

    terms: list[Callable[[TrueEquations], list[Expr]]] = [
        lambda t: product(t.Q, [w**2 for w in omega[: t.n]]),
        lambda t: [-e for e in product(t.K, list(phi[: t.n]))],
    ]
    for term in terms:
        other = replace(exact, readings={"": turned(term)}, corrected=form)
        assert judge(other).verdict is Verdict.MISPRINT


def test_readings_and_what_is_not_printed() -> None:
    exact = claim("2.60")
    (form,) = exact.readings.values()
    wrong = spoilt("2.60", lambda rows: [2 * e for e in rows]).readings["spoilt"]
    both = replace(exact, readings={"one": form, "two": wrong})
    assert judge(both).verdict is Verdict.AMBIGUOUS
    assert list(judge(both).remains) == ["two"]
    assert "one" in judge(both).detail
    assert judge(replace(exact, readings={})).verdict is Verdict.MISSING


def test_what_cannot_be_judged_is_refused() -> None:
    double = spoilt("2.60", lambda rows: [2 * e for e in rows])
    with pytest.raises(JudgementError, match=r"^2\.60\b"):
        judge(replace(double, corrected=None))
    with pytest.raises(JudgementError, match=r"\bx0\b.* n = 1\b"):
        judge(replace(double, corrected=double.readings["spoilt"]))
    with pytest.raises(JudgementError, match=r"^2\.60: 2 .* 3\b.* n = 1$"):
        judge(spoilt("2.60", lambda rows: rows[1:]))


def test_verdicts_follow_the_truth(monkeypatch: pytest.MonkeyPatch, other_truth: None) -> None:
    """With a force that pulls, 2.46 counts along it, and no reading of 2.47 is right any more."""

    def pull(self: Follower, angle: Expr) -> tuple[Expr, Expr]:
        x, y = pushed(self, angle)
        return -x, -y

    pushed = Follower.force
    monkeypatch.setattr(Follower, "force", pull)
    assert judge(claim("2.46")).verdict is Verdict.SIGN
    assert judge(replace(claim("2.47"), corrected=None)).verdict is Verdict.SIGN


def test_another_inertia_is_noticed(monkeypatch: pytest.MonkeyPatch, other_truth: None) -> None:
    """With half the mass of a link at each end, 1/3 is wrong, and what has no 1/3 stays right."""
    monkeypatch.setitem(link_properties.INERTIAS, "uniform", link_properties.INERTIAS["lumped"])
    for number in ("2.10", "2.13", "2.15"):
        with pytest.raises(JudgementError, match="differs"):
            judge(claim(number))
    for number in ("2.24", "2.28", "2.32", "2.42"):
        assert judge(claim(number)).verdict is Verdict.EXACT


@pytest.mark.parametrize(
    ("expression", "zero"),
    [
        (cos(phi[0] - phi[1]) - cos(phi[1] - phi[0]), True),
        (sin(phi[0] + nu) ** 2 + cos(phi[0] + nu) ** 2 - 1, True),
        (sin(phi[0] + nu) ** 2 - cos(phi[0] + nu) ** 2 - 1, False),
        (phi[0] * sin(phi[0]) ** 2 - phi[0] + phi[0] * cos(phi[0]) ** 2, True),
        (cos(phi[0] / 2) ** 2 - (1 + cos(phi[0])) / 2, True),  # angles that depend on each other
        (cos(phi[0] / 2) ** 2 - cos(phi[0]) / 2, False),
        (1 / (1 + domega[0]) - domega[0] / (domega[0] + domega[0] ** 2), True),
        (abs(omega[0]) - omega[0], False),
        (Rational(1, 10**40) * omega[0], False),
    ],
)
def test_zero(expression: Expr, zero: bool) -> None:
    assert is_zero(expression) is zero
