"""Shell completion: words of a vocabulary, and keys of scenes."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rodgen.scene import Scene
from rodgen.scene.keys import keys_of

Complete = Callable[[str], list[str]]


def complete_words(known: Iterable[str]) -> Complete:
    """Completion to one of these words."""
    listed = list(known)
    return lambda incomplete: [word for word in listed if word.startswith(incomplete)]


def complete_list(known: Iterable[str]) -> Complete:
    """Completion of the last word of a list with commas."""
    one = complete_words(known)

    def complete(incomplete: str) -> list[str]:
        before, comma, last = incomplete.rpartition(",")
        return [f"{before}{comma}{word}" for word in one(last)]

    return complete


def complete_keys(incomplete: str) -> list[str]:
    """Complete the dotted name of a key of scenes."""
    return complete_words(keys_of(Scene))(incomplete)
