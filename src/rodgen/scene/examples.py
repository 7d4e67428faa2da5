"""The scenes and studies that come with rodgen, to start from: the files of scenes/."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.resources import files
from itertools import takewhile
from operator import methodcaller
from pathlib import Path

from rodgen.errors import InputError, did_you_mean

STUDIES = "studies"  # their folder in that of the scenes
NAME = re.compile(r'^name = "\w+"$', re.MULTILINE)  # the first line of its kind: that of the file
SCENE = re.compile(r'^scene = "(.+)"$', re.MULTILINE)  # the file of a study's scene
# A full stop after a capital belongs to a name.
SENTENCE = re.compile(r".+?(?:(?<![A-Z])[.?!](?=\s|$)|$)")
COMMENT = methodcaller("startswith", "#")


def examples_folder() -> Path:
    """Folder of the scenes; the studies lie in its folder `studies`."""
    return Path(str(files("rodgen.scenes")))


def examples() -> dict[str, Path]:
    """Files of the scenes, by their names."""
    return {path.stem: path for path in sorted(examples_folder().glob("*.toml"))}


def studies() -> dict[str, Path]:
    """Files of the studies, by their names with the folder, such as studies/mesh."""
    return {
        f"{STUDIES}/{path.stem}": path
        for path in sorted((examples_folder() / STUDIES).glob("*.toml"))
    }


def find_example(name: str, known: Mapping[str, Path] | None = None) -> Path:
    """File of an example, by default a scene. Raises InputError for a name that none has."""
    known = examples() if known is None else known
    if name not in known:
        raise InputError("example", name, f"one of {', '.join(known)}{did_you_mean(name, known)}")
    return known[name]


def first_sentence(text: str) -> str:
    """The first sentence of the comment at the top of a file's text."""
    comment = " ".join(line[1:].strip() for line in takewhile(COMMENT, text.splitlines()))
    found = SENTENCE.match(comment)
    return found[0] if found else ""


def copy_texts(path: Path, new: str) -> dict[str, str]:
    """Texts, by file name, of a copy of a scene or study under another name; a scene in a file of
    its own comes before its study. Raises InputError where the new name is that of this scene."""
    text, made = path.read_text(encoding="utf-8"), {}
    if found := SCENE.search(text):
        scene = path.parent / found[1]
        made[scene.name] = scene.read_text(encoding="utf-8")
        text = SCENE.sub(f'scene = "{scene.name}"', text, count=1)
    if f"{new}.toml" in made:
        raise InputError("NAME", new, "another: the scene of the study has it")
    return made | {f"{new}.toml": NAME.sub(f'name = "{new}"', text, count=1)}
