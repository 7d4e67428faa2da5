"""Every claim of the thesis judged: the equations of chapter 2 and the methods of the listing."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from .claim import Claim, Finding
from .judge import judge

# Each has CLAIMS.
EQUATIONS = ("definitions", "energy", "motion", "matrices", "loads", "medium")


def equation_claims() -> list[Claim]:
    """Equations 2.1 to 2.65, in their order."""
    modules = [import_module(f"{__package__}.equations_{name}") for name in EQUATIONS]
    claims = [claim for module in modules for claim in module.CLAIMS]
    return sorted(claims, key=lambda claim: int(claim.number.split(".")[1]))


def listing_claims() -> list[Claim]:
    """The methods of the Java listing."""
    return list(import_module(f"{__package__}.java").CLAIMS)


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
