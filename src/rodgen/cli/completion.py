"""What shells complete: words of a vocabulary, and keys of scenes."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rodgen.scene import Scene
from rodgen.scene.keys import keys_of

Complete = Callable[[str], list[str]]


def words(known: Iterable[str]) -> Complete:
    """A completion to one of these words."""
    listed = list(known)
    return lambda incomplete: [word for word in listed if word.startswith(incomplete)]


def listed_words(known: Iterable[str]) -> Complete:
    """A completion of the last word of a list with commas."""
    one = words(known)

    def complete(incomplete: str) -> list[str]:
        before, comma, last = incomplete.rpartition(",")
        return [f"{before}{comma}{word}" for word in one(last)]

    return complete


def keys(incomplete: str) -> list[str]:
    """A completion to keys of scenes by their dotted names."""
    return words(keys_of(Scene))(incomplete)
