"""What the thesis claims, encoded as printed, and the verdict that follows from comparing it.

A verdict is computed, by judge.judge(claim): nobody types it in. What is typed in is the printed
form, its readings where the text allows several, the corrected form, and a hypothesis about how
the slip arose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from sympy import Expr, Symbol

LINKS = range(1, 7)  # numbers of links for which every claim is compared

# The entries that a claim is about, for n links, in a fixed order.
Entries = Callable[[int], Sequence[Expr]]

# The entry of a reading for which the thesis prints nothing, though it is needed.
NOT_PRINTED: Expr = Symbol("nothing")


class Verdict(StrEnum):
    """What a comparison can end in."""

    EXACT = "exact"
    MISPRINT = "misprint"  # differs, and the corrected form does not
    SIGN = "sign conflict"  # right but for a sign: of the whole, of entries
    INCOMPLETE = "incomplete"  # what is there is right; terms or entries are left out
    MISSING = "missing"  # nothing is printed for what is needed
    AMBIGUOUS = "ambiguous"  # several readings, of which some are right and some are not


@dataclass(frozen=True)
class Claim:
    """One equation or method of the thesis.

    number: "2.26", or "Java 189-212"; title: what it is, in a few words; readings: the printed
    form by the name of its reading ("as printed", where there is one only), none where nothing is
    printed; truth: the derived entries; corrected: the printed form put right; links: the n
    compared; repairs: what was mended in the text before it was read, each in words; note: a
    hypothesis, or what a reader should know.
    """

    number: str
    title: str
    readings: dict[str, Entries]
    truth: Entries
    corrected: Entries | None = None
    links: Sequence[int] = LINKS
    repairs: tuple[str, ...] = ()
    note: str = ""
    printed: str = ""  # the text as printed, LaTeX or Java, the repairs made
    correction: str = ""  # the corrected form in words or LaTeX
    label: Callable[[int, int], str] | None = None  # the name of an entry, from n and its number


@dataclass(frozen=True)
class Finding:
    """A claim with its verdict; remains: by reading, the first entry that differs at the smallest
    n at which one does, as (n, entry, printed - truth), or NOT_PRINTED; detail: what the verdict
    rests on (which sign, which reading), computed too."""

    claim: Claim
    verdict: Verdict
    remains: dict[str, tuple[int, int, Expr]] = field(default_factory=dict)
    detail: str = ""
