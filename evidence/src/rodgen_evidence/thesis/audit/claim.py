"""A claim of the thesis, what is found of it, and how it is told."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property

from sympy import Expr, Symbol

from rodgen_evidence.thesis.audit.zero import is_part, is_zero, readable

READ = "as printed"  # the reading of what can be read in one way only
LINKS = range(1, 7)  # numbers of links for which every claim is compared

# The entries that a claim is about, for n links, in a fixed order.
Entries = Callable[[int], Sequence[Expr]]

# The entry of a reading for which the thesis prints nothing, though it is needed.
NOT_PRINTED: Expr = Symbol("nothing")


class Verdict(StrEnum):
    """Verdict of a comparison."""

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


Decided = tuple[Verdict, str]


class JudgementError(ValueError):
    """A claim that cannot be judged: what is encoded beside the printed form is wrong."""


@dataclass(frozen=True)
class Pair:
    """One entry of a form beside that of the truth, for n links."""

    n: int
    at: int
    entry: Expr
    true: Expr

    @property
    def is_printed(self) -> bool:
        return not self.entry.has(NOT_PRINTED)

    @cached_property
    def same(self) -> bool:
        return self.is_printed and is_zero(self.entry - self.true)

    @cached_property
    def opposite(self) -> bool:
        return self.is_printed and is_zero(self.entry + self.true)

    @property
    def difference(self) -> Expr:
        return readable(self.entry - self.true) if self.is_printed else NOT_PRINTED


def judge(claim: Claim) -> Finding:
    """The verdict on a claim, with what remains of every reading that is not the truth.

    Raises JudgementError where the corrected form is not the truth, where a misprint has none,
    and where a form has another number of entries than the truth.
    """
    forms = {name: list(_pairs(claim, form)) for name, form in claim.readings.items()}
    wrong = {name: first for name, pairs in forms.items() if (first := _first_wrong(pairs))}
    verdict, detail = _verdict(claim, forms, wrong)
    if claim.corrected and (first := _first_wrong(_pairs(claim, claim.corrected))):
        where = f"{entry_name(claim, first.n, first.at)} at n = {first.n}: {first.difference}"
        raise JudgementError(f"{claim.number}: the corrected form differs in {where}")
    if verdict is Verdict.MISPRINT and not claim.corrected:
        raise JudgementError(f"{claim.number} differs from the truth and has no corrected form")
    remains = {name: (p.n, p.at, p.difference) for name, p in wrong.items()}
    return Finding(claim, verdict, remains, detail)


def _pairs(claim: Claim, form: Entries) -> Iterator[Pair]:
    for n in claim.links:
        entries, truth = form(n), claim.truth(n)
        if len(entries) != len(truth):
            counted = f"{len(entries)} entries, not {len(truth)}, at n = {n}"
            raise JudgementError(f"{claim.number}: {counted}")
        for at, (entry, true) in enumerate(zip(entries, truth, strict=True)):
            yield Pair(n, at, entry, true)


def _first_wrong(pairs: Iterator[Pair] | list[Pair]) -> Pair | None:
    return next((pair for pair in pairs if not pair.same), None)


def _verdict(claim: Claim, forms: dict[str, list[Pair]], wrong: dict[str, Pair]) -> Decided:
    if not forms:
        return Verdict.MISSING, "nothing is printed"
    if not wrong:
        return Verdict.EXACT, ""
    right = [name for name in forms if name not in wrong]
    if right:
        return Verdict.AMBIGUOUS, f"right if read: {'; '.join(right)}"
    for verdict, judgement in (
        (Verdict.SIGN, _sign),
        (Verdict.MISSING, _missing),
        (Verdict.INCOMPLETE, _incomplete),
    ):
        reasons = {name: judgement(claim, pairs) for name, pairs in forms.items()}
        if any(reasons.values()):
            return verdict, _told(reasons)
    return Verdict.MISPRINT, ""


def _told(reasons: dict[str, str | None]) -> str:
    """The reason, or the reasons by their readings where there are several readings."""
    several = len(reasons) > 1
    return "; ".join(f"{n}: {why}" if several else why for n, why in reasons.items() if why)


def _sign(claim: Claim, pairs: list[Pair]) -> str | None:
    """Right with the other sign of the whole, or of some entries."""
    turned = [pair for pair in pairs if not pair.same]
    if not all(pair.opposite for pair in turned):
        return None
    if all(pair in turned or is_zero(pair.true) for pair in pairs):
        return "right with the other sign of the whole"
    return f"right with the other sign of {_names(claim, turned)}"


def _missing(claim: Claim, pairs: list[Pair]) -> str | None:
    """Nothing is printed for any entry."""
    if any(pair.is_printed for pair in pairs):
        return None
    return f"nothing is printed for {_names(claim, pairs)}"


def _incomplete(claim: Claim, pairs: list[Pair]) -> str | None:
    """Describe a claim that is right in what is printed, with terms or whole entries left out."""
    printed = [pair for pair in pairs if pair.is_printed]
    if not all(pair.same or is_part(pair.entry, pair.true) for pair in printed):
        return None
    if len(printed) == len(pairs):
        return "every printed term is right, terms are left out"
    some = {pair.n for pair in printed}
    lacking = [pair for pair in pairs if pair.n in some and not pair.is_printed]
    return f"what is printed is right, nothing is printed for {_names(claim, lacking)}"


def _names(claim: Claim, pairs: list[Pair]) -> str:
    """Names of the entries for the smallest n among them."""
    n = pairs[0].n
    names = ", ".join(entry_name(claim, n, pair.at) for pair in pairs if pair.n == n)
    return f"{names} (n = {n})"


def entry_name(claim: Claim, n: int, at: int) -> str:
    """Name of an entry: its label, or its number."""
    return claim.label(n, at) if claim.label else f"entry {at + 1}"
