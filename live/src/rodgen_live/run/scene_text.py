"""Texts of scenes: read from a folder, edited where values differ, so that comments stay; the line
of a refusal."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import MutableMapping
from pathlib import Path
from typing import Any, TypeGuard

import tomlkit
from tomlkit.exceptions import TOMLKitError

from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen.scene.plain_tables import parse_toml
from rodgen.scene.scene_files import read_table_files
from rodgen.scene.units import has_units

MOST_SCENES = 500  # of a folder
LINE = re.compile(r"\bline (\d+)|at end of document")  # of what is no TOML, in its refusal
HEAD = re.compile(r"\s*(\[\[?)\s*([\w.-]+)\s*\]")  # of a table, or of one of several
PART = re.compile(r"[^.\[\]]+")  # of a dotted name such as bodies[1].mass


def edited_text(text: str, before: Scene, after: Scene) -> str:
    """Edit the text of a scene to that of another: keys whose values are the same stay as they are
    written. What comes of it is still to be read: text may name a table that another scene lacks.

    before: the scene of the text.
    """
    try:
        document = tomlkit.parse(text)
        if has_units(document.unwrap()):  # which its numbers have, and those of scenes have not
            return after.to_toml()
        _edit(document, before.to_dict(), after.to_dict())
        return tomlkit.dumps(document).rstrip() + "\n"
    except (TOMLKitError, LookupError, TypeError, AttributeError):  # a form that it cannot edit
        return after.to_toml()


def _edit(table: MutableMapping[str, Any], before: dict[str, Any], after: dict[str, Any]) -> None:
    for key in before.keys() - after.keys():
        table.pop(key, None)
    for key, new in after.items():
        old, written = before.get(key), table.get(key)
        if new == old:
            continue
        if new in ([], {}):
            table.pop(key, None)
        elif isinstance(new, dict):
            known = old if isinstance(old, dict) else {}
            if isinstance(written, MutableMapping):
                _edit(written, known, new)
            else:
                table[key] = _made_table(known, new)
        elif _is_tables(new) and _is_tables(old) and isinstance(written, list):
            for inner, *both in zip(written, old, new, strict=False):
                _edit(inner, *both)
            del written[len(new) :]
            for one in new[len(old) :]:
                written.append(_made_table({}, one))
        else:
            table[key] = [_made_table({}, one) for one in new] if _is_tables(new) else new


def _is_tables(value: Any) -> TypeGuard[list[dict[str, Any]]]:
    return isinstance(value, list) and bool(value) and all(isinstance(one, dict) for one in value)


def _made_table(before: dict[str, Any], after: dict[str, Any]) -> tomlkit.items.Table:
    """Make a table of what differs, with a blank line below it."""
    made = tomlkit.table()
    _edit(made, before, after)
    return made.add(tomlkit.nl())


def refused_line(text: str, error: InputError) -> int | None:
    """Line of a text that an error is about, from 1 on: of its key, or of the innermost table that
    is there; None where there is none."""
    if error.field == "scene" and (found := LINE.search(error.allowed)):
        return int(found[1] or text.rstrip().count("\n") + 1)
    field, table, counts = PART.findall(error.field), "", Counter[str]()
    line, most = None, 0
    for number, written in enumerate(text.split("\n"), 1):
        if head := HEAD.match(written):
            table = head[2]
            if head[1] == "[[":
                counts[table] += 1
                table += f"[{counts[head[2]] - 1}]"
        name = PART.findall(table if head else f"{table}.{written.partition('=')[0].strip()}")
        known = min(len(name), len(field))
        if name[:known] == field[:known] and known > most:
            line, most = number, known
    return line


class SceneFolder:
    """Scenes of a folder; nothing outside of it, and nothing but its own files, is opened."""

    def __init__(self, path: Path):
        self._path = path.resolve()

    def names(self) -> list[str]:
        """File names of the scenes, without the ending."""
        try:
            found = sorted(p.stem for p in self._path.glob("*.toml") if self._inside(p))
        except OSError:
            return []
        return found[:MOST_SCENES]

    def scene(self, name: str) -> Scene:
        """Read one of the scenes. Raises InputError."""
        return self.parse(self.text(name))

    def text(self, name: str) -> str:
        """Text of one of the scenes. Raises InputError."""
        if name not in self.names():
            raise InputError("scene", name, f"one of the folder: {', '.join(self.names())}")
        try:
            return (self._path / f"{name}.toml").read_text("utf-8")
        except (OSError, ValueError) as error:
            raise InputError("scene", name, f"a file of UTF-8 text ({error})") from None

    def parse(self, text: str) -> Scene:
        """Make the scene of a text, as of a file of the folder. Raises InputError."""
        table = parse_toml(text.encode(), "this text")
        return Scene.from_dict(read_table_files(table, self._path))

    def _inside(self, path: Path) -> bool:
        """Whether a file is in the folder itself, not a link that leads out of it."""
        return path.is_file() and path.resolve().parent == self._path
