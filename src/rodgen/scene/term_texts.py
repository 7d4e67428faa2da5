"""Texts of terms, `follower@6+1/10`, and checks of the words and numbers of a structure."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import chain, combinations

from rodgen.errors import InputError, did_you_mean
from rodgen.model.rod import (
    BOUNDARIES,
    Boundary,
)
from rodgen.model.term import BASE
from rodgen.model.terms import (
    BASE_ROWS,
    TERMS,
    THESIS_TERMS,
)

MOST_LINKS = 10**6
PLACE = re.compile(r"(0|[1-9][0-9]{0,6})(?:\+([1-9][0-9]{0,30}/[1-9][0-9]{0,30}))?")


def parse_terms(text: str) -> tuple[str, ...]:
    """Terms from `all` (the thesis's four), `none` or a list with commas; raises InputError."""
    if text == "all":
        return THESIS_TERMS
    if text in ("none", "conservative"):
        return ()
    names = [name.strip() for name in text.split(",")]
    kinds = [name.partition("@")[0] for name in names]
    for kind in kinds:
        check_choice("terms", kind, TERMS if "," in text else (*TERMS, "all", "none"))
    if any(kinds.count(kind) > 1 and not TERMS[kind].is_several for kind in kinds):
        raise InputError("terms", text, "each term once, but for those that stand at a place")
    return sort_terms(tuple(names))


def sort_terms(terms: tuple[str, ...]) -> tuple[str, ...]:
    """Terms in the order of the vocabulary; a term without a place is kept once."""
    found = []
    for kind, term in TERMS.items():
        same = [text for text in terms if text.partition("@")[0] == kind]
        found += same if term.is_several else same[:1]
    return tuple(found)


def check_term(text: str, links: int, boundary: Boundary) -> None:
    """Raise InputError for a term that is unknown or not of this boundary, at a place that it
    cannot have, or with a parameter that is not an optional one."""
    kind, at, place = text.partition("@")
    check_choice("terms", kind, TERMS)
    if TERMS[kind].kind == BASE:
        keys = base_keys(boundary)
        check_choice("terms", text, [f"{kind}@{'+'.join(some)}" for some in _choices(keys)])
        return
    if not at:
        return
    term, where = TERMS[kind], without_options(place)
    given = place.removeprefix(where).removeprefix("+" if where else "")
    if term.options and (given or not term.placed):
        some = ["+".join(keys) for keys in _choices(term.options)]
        if given not in some:
            place = f"{where or 'LINK'}+" * term.placed
            check_choice("terms", text, [kind, *(f"{kind}@{place}{keys}" for keys in some)])
        if not where:
            return
    if not term.placed:
        raise InputError("terms", text, f"{kind}, which has no place")
    springs = boundary.spring_joints(links)
    if term.at_joints and not (where.isdecimal() and int(where) in springs):
        allowed = f"{kind}@joint, a joint with a spring, {springs.start} to {springs.stop - 1}"
        raise InputError("terms", text, allowed)
    allowed = f"{kind}@link or {kind}@link+share, of a load at a point of one of {links} links"
    if not _is_place(where, links):
        raise InputError("terms", text, allowed)


def without_options(place: str) -> str:
    """A place of a load without the keys of optional parameters behind it."""
    parts = place.split("+")
    return "+".join(part for part in parts if not part[:1].isalpha())


def check_place(place: str, links: int, field: str) -> None:
    """Raise InputError for a place that is not one of a link, as 6+1/10, or of the tail, as ""."""
    if place and not _is_place(place, links):
        raise InputError(field, place, f"link or link+share, of a point of one of {links} links")


def _is_place(place: str, links: int) -> bool:
    """Whether a text is a point of a link before its end."""
    found = PLACE.fullmatch(place)
    return bool(found and int(found[1]) < links and Fraction(found[2] or 0) < 1)


def _choices(keys: Sequence[str]) -> Iterable[tuple[str, ...]]:
    """One or several of some keys, in their order."""
    return chain.from_iterable(combinations(keys, count + 1) for count in range(len(keys)))


def base_keys(boundary: Boundary) -> tuple[str, ...]:
    """Keys of the motion that what holds the start of a rod may have; none of one that is free."""
    keys = (one.key for one in BASE_ROWS if boundary.is_clamped or not one.is_angle)
    return tuple(keys) if boundary.is_held else ()


def check_choice(field_name: str, value: object, allowed: Iterable[str]) -> None:
    """Raise InputError unless the value is one of those allowed."""
    allowed = tuple(allowed)
    if value not in allowed:
        raise InputError(
            field_name, value, f"one of {', '.join(allowed)}{did_you_mean(value, allowed)}"
        )


def check_links(links: object, boundary: str, field_name: str = "links") -> None:
    """Raise InputError for a number of links that the boundary does not allow."""
    least = BOUNDARIES[boundary].min_links
    whole = links if isinstance(links, int) and not isinstance(links, bool) else -1
    if not least <= whole <= MOST_LINKS:
        held = "" if least == 1 else f" for boundary {boundary}"
        raise InputError(field_name, links, f"a whole number from {least} to {MOST_LINKS}{held}")
