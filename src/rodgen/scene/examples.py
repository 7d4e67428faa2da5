"""The scenes that come with rodgen, to start from: the files of scenes/."""

from __future__ import annotations

import re
from importlib.resources import files
from itertools import takewhile
from operator import methodcaller
from pathlib import Path

from rodgen.scene.errors import SceneError, meant

NAME = re.compile(r'^name = "\w+"$', re.MULTILINE)  # the first line of its kind: that of the scene
# A full stop after a capital belongs to a name.
SENTENCE = re.compile(r".+?(?:(?<![A-Z])[.?!](?=\s|$)|$)")
COMMENT = methodcaller("startswith", "#")


def folder() -> Path:
    """Where the files lie; those of studies lie in its folder `studies`."""
    return Path(str(files("rodgen.scenes")))


def examples(inside: str = "") -> dict[str, Path]:
    """The files by the names of their scenes; inside: of a folder in theirs, such as studies."""
    return {path.stem: path for path in sorted((folder() / inside).glob("*.toml"))}


def example(name: str) -> Path:
    """The file of a scene. Raises SceneError for a name that none has."""
    known = examples()
    if name not in known:
        raise SceneError("example", name, f"one of {', '.join(known)}{meant(name, known)}")
    return known[name]


def about(path: Path) -> str:
    """The first sentence of the comment at the top of a file."""
    text = path.read_text(encoding="utf-8")
    comment = " ".join(line[1:].strip() for line in takewhile(COMMENT, text.splitlines()))
    found = SENTENCE.match(comment)
    return found[0] if found else ""


def renamed(name: str, new: str) -> str:
    """The text of a scene under another name, with its comments. Raises SceneError."""
    return NAME.sub(f'name = "{new}"', example(name).read_text(encoding="utf-8"), count=1)
