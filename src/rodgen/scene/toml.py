"""Scene files: bytes to tables, within limits that are looked at before anything is parsed."""

from __future__ import annotations

import re
import stat
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.scene.errors import SceneError
from rodgen.scene.plain import DEEPEST, MOST_KEYS

LARGEST = 10_000_000  # bytes of a scene file
# What brackets, dots and commas do not count in. No part of it is read twice, so that time grows
# with the length of the text alone, whatever it is.
TEXT = re.compile(
    r"""
    \"{3} (?: [^"\\]++ | \\. | "(?!"") )*+ (?: \"{3} )?
    | \'{3} (?: [^']++ | '(?!'') )*+ (?: \'{3} )?
    | " (?: [^"\\\n]++ | \\[^\n] )*+ "?
    | ' [^'\n]*+ '?
    | \# [^\n]*+
    """,
    re.DOTALL | re.VERBOSE,
)
DOTTED = re.compile(rf"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}")
HIDDEN = {
    "\\A\ufeff": "a byte order mark",
    "\0": "a NUL",
    "\r(?!\n)": "a carriage return that no line feed follows",
}
KINDS = {
    stat.S_ISDIR: "a folder",
    stat.S_ISFIFO: "a pipe",
    stat.S_ISSOCK: "a socket",
    stat.S_ISCHR: "a device",
    stat.S_ISBLK: "a device",
}


def read_table(path: Path) -> dict[str, Any]:
    """The tables of a TOML file; raises SceneError for what is none, or beyond the limits."""
    try:
        mode = path.stat().st_mode
        if kind := next((name for is_one, name in KINDS.items() if is_one(mode)), None):
            raise SceneError("scene", str(path), f"a file (this is {kind})")  # it may never end
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise SceneError("scene", str(path), f"a file that can be read ({reason})") from None
    return read_text(content, str(path))


def read_text(content: bytes, shown: str) -> dict[str, Any]:
    """The tables in the bytes of a TOML file; shown: what messages call it. Raises SceneError."""
    if len(content) > LARGEST:
        raise SceneError("scene", shown, f"a file of at most {LARGEST // 10**6} MB")
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        raise SceneError("scene", shown, "a file that can be read (not UTF-8 text)") from None
    _check_characters(text, shown)
    _check_size(text, shown)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError("scene", shown, f"valid TOML ({error})") from None


def _check_characters(text: str, shown: str) -> None:
    """Say what an editor does not show."""
    if found := re.search("|".join(HIDDEN), text):
        what = next(name for pattern, name in HIDDEN.items() if re.match(pattern, found[0]))
        line = text.count("\n", 0, found.start()) + 1
        raise SceneError("scene", shown, f"valid TOML (without {what}, as in line {line})")


def _check_size(text: str, shown: str) -> None:
    """Refuse what would take the parser minutes, or deeper than Python calls."""
    bare = TEXT.sub("x", text)
    marks = np.frombuffer(bare.encode(), np.uint8)

    def at(characters: bytes) -> NDArray[np.bool_]:
        return np.isin(marks, np.frombuffer(characters, np.uint8))

    opened = at(b"[{")
    if max((at(b"=,") | opened).sum(), at(b".").sum()) > MOST_KEYS:
        raise SceneError("scene", shown, f"a file of at most {MOST_KEYS} keys and values")
    depth = np.cumsum(opened.astype(np.int32) - at(b"]}"))
    if depth.max(initial=0) > DEEPEST or DOTTED.search(bare):
        raise SceneError("scene", shown, f"a file of tables and lists at most {DEEPEST} deep")
