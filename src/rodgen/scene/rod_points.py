"""Points of the rod: the link on which one lies, and the share of that before it."""

from __future__ import annotations

from fractions import Fraction

JOINED = Fraction(1, 10**9)  # of a link, within which a point is that of a joint


def link_and_share(s: float, links: int) -> tuple[int, float]:
    """The link on which s lies and the share of that before it: the link that begins at a joint, at
    the tail the last."""
    link, share = _exact_link_and_share(s, links)
    return link, float(share)


def place_text(s: float, links: int) -> str:
    """A point as a structure names it, 6+1/10; "" at the tail."""
    link, share = _exact_link_and_share(s, links)
    if share == 1:
        return ""
    return f"{link}+{share}" if share else str(link)


def parse_place(text: str, links: int) -> tuple[int, float]:
    """Link and share of a point as a structure names it."""
    link, _, share = text.partition("+")
    return (int(link), float(Fraction(share or 0))) if text else (links - 1, 1.0)


def _exact_link_and_share(s: float, links: int) -> tuple[int, Fraction]:
    at = Fraction(repr(float(s))) * links
    joint = round(at)
    at = Fraction(joint) if abs(at - joint) < JOINED else at
    link = min(int(at), links - 1)
    return link, at - link
