"""Every claim of the thesis judged: the equations of chapter 2 and the methods of the listing."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from rodgen_evidence.thesis.audit.claim import Claim, Finding, judge

# Modules with CLAIMS.
EQUATIONS = tuple(f"equations_{name}" for name in ("energy", "motion", "matrices", "loads"))
LISTING = ("java_state_claims", "java_equation_claims", "java_schemes")


def _claims(modules: tuple[str, ...]) -> list[Claim]:
    loaded = (import_module(f"{__package__}.{name}") for name in modules)
    return [claim for module in loaded for claim in module.CLAIMS]


def equation_claims() -> list[Claim]:
    """Equations 2.1 to 2.65, in their order."""
    return sorted(_claims(EQUATIONS), key=lambda claim: int(claim.number.split(".")[1]))


def listing_claims() -> list[Claim]:
    """The methods of the Java listing."""
    return _claims(LISTING)


def audit(progress: Callable[[str], None] | None = None) -> list[Finding]:
    """The verdict on every claim; progress is told the number of each that is judged.

    Takes about ten seconds. Raises JudgementError where what is encoded beside a printed form is
    wrong, and UndecidedError where a comparison cannot be decided.
    """
    findings = []
    for claim in equation_claims() + listing_claims():
        findings.append(judge(claim))
        if progress:
            progress(claim.number)
    return findings
