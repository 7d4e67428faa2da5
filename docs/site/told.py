"""What docstrings tell of names: lists such as "t: times [s], (T,); y: states", and sections."""

from __future__ import annotations

import re
from collections.abc import Iterator

TOLD = r"(?:\w+(?: \([^)]*\))?, )*\w+(?: \([^)]*\))?: "  # a name or several, with shapes
BEGIN = re.compile(rf"(?:^|[;.] )(?={TOLD})")
SECTION = re.compile(r"^(\w+)\n-{3,}\n", re.MULTILINE)
ENTRY = re.compile(r"^(\S.*)\n((?:(?:    .*)?(?:\n|$))*)", re.MULTILINE)


def listed(paragraph: str) -> list[tuple[str, str]]:
    """Names as they stand, several with commas between them, each with what is told of them; none
    of a paragraph that is no list."""
    if not re.match(TOLD, paragraph):
        return []
    told = filter(None, BEGIN.split(" ".join(paragraph.split())))
    pairs = (one.rstrip(";. ").partition(": ") for one in told)
    return [(names, text) for names, _, text in pairs]


def sections(text: str) -> dict[str, str]:
    """The sections of a docstring in numpydoc's form; what stands before them under ""."""
    first, *rest = SECTION.split(text)
    return {"": first, **dict(zip(rest[::2], rest[1::2], strict=True))}


def told(text: str) -> dict[str, str]:
    """What a docstring tells of every name, of those in lists and of those among Parameters."""
    parts = sections(text)
    pairs = [pair for one in parts[""].split("\n\n") for pair in listed(one.strip())]
    pairs += ENTRY.findall(parts.get("Parameters", ""))
    return dict(_single(pairs))


def _single(pairs: list[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    for names, text in pairs:
        for name in re.sub(r"\([^)]*\)", "", names).split(","):
            yield name.strip(" *"), " ".join(text.split())
