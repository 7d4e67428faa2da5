"""Shared by the tests of the audit: the whole audit, once."""

from __future__ import annotations

import pytest

from rodgen_evidence.thesis.audit.claim import Finding
from rodgen_evidence.thesis.audit.thesis_claims import audit


@pytest.fixture(scope="session")
def findings() -> list[Finding]:
    """The verdict on every claim."""
    told: list[str] = []
    found: list[Finding] = audit(told.append)
    assert told == [f.claim.number for f in found]  # progress hears of every claim
    return found
