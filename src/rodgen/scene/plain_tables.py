"""Reading of scenes from TOML files, conversion of Python and NumPy values to plain ones, and the
immutable lists and dictionaries of scenes.

Limits on size and depth are checked before anything is parsed.
"""

from __future__ import annotations

import re
import stat
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn, TypeGuard

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError, ShownText

PLAIN = float, int, str  # passed over in lists, which may hold a million of them
DEEPEST = 50  # tables and lists, each in the one before
MOST_KEYS = 10**5  # of all tables together, with what lists hold beside plain values
MOST_VALUES = 5 * 10**5  # in lists of a file
LONGEST = 2 * 10**6  # values of a list
LARGEST = 16_000_000  # bytes of a file
AROUND = 40  # characters to either side of what the parser cannot read
# Kinds of files: a key that each has, one that it lacks, and the command that takes it.
SCENE, STUDY = "scene", "study"
FILES = {SCENE: ("rod", "vary", "run"), STUDY: ("vary", "rod", "study")}
# Text in which brackets, dots and commas do not count. No part is read twice, so that time grows
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
IN_LIST = re.compile(r"(?<=[\[,\s])[+-]?[0-9]++(?:\.[0-9]++)?(?:[eE][+-]?[0-9]++)?(?=[ \t]*+[],])")
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

AGAIN = 'Make another: scene.replace({"rod.length": 3.0}), by the dotted name of the key'
OF_LISTS = "append clear extend insert pop remove reverse sort __iadd__ __imul__"
OF_DICTS = "clear pop popitem setdefault update __ior__"
OF_BOTH = "__setitem__ __delitem__"


def get_at(table: Any, *keys: str) -> Any:
    """Value at keys of nested tables and lists."""
    for key in keys:
        if isinstance(table, list):
            table = table[int(key)]
        else:
            table = table[key] if isinstance(table, dict) else getattr(table, key)
    return table


def set_at(table: Any, keys: Sequence[str], value: Any) -> None:
    """Set a value at keys of nested tables and lists."""
    *outer, last = keys
    inner = get_at(table, *outer)
    inner[int(last) if isinstance(inner, list) else last] = value


def is_number(value: object) -> TypeGuard[int | float]:
    """Whether a plain value is a number; True and False are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def to_plain(value: Any, place: str = "scene") -> Any:
    """Convert tuples, NumPy arrays and NumPy scalars in a value to lists and numbers.

    place: where it stands, for messages. Raises InputError for an array of what are no numbers,
    and for tables and lists that are larger or deeper than any scene.
    """
    return _PlainConverter(place).convert(value, place, 0)


class _PlainConverter:
    """Converter that counts the values it has passed."""

    def __init__(self, place: str):
        self.place, self.count = place, 0

    def convert(self, value: Any, place: str, depth: int) -> Any:
        if isinstance(value, np.ndarray | np.generic):
            return _from_numpy(value, place)
        if not isinstance(value, dict | list | tuple):
            return value
        if depth > DEEPEST:
            raise InputError(place, _type_name(value), f"at most {DEEPEST} tables and lists deep")
        if isinstance(value, dict):
            at = "" if place == "scene" else f"{place}."
            self._add_count(value, len(value))
            return {str(k): self.convert(v, f"{at}{k}", depth + 1) for k, v in value.items()}
        if len(value) > LONGEST:
            raise InputError(place, _type_name(value), f"a list of at most {LONGEST} values")
        if {*map(type, value)} <= {*PLAIN}:  # as most are, a hundred thousand numbers among them
            return list(value)
        self._add_count(value, sum(type(inner) not in PLAIN for inner in value))
        return [
            inner if type(inner) in PLAIN else self.convert(inner, f"{place}[{i}]", depth + 1)
            for i, inner in enumerate(value)
        ]

    def _add_count(self, value: Any, count: int) -> None:
        self.count += count
        if self.count > MOST_KEYS:
            raise InputError(self.place, _type_name(value), f"at most {MOST_KEYS} keys and values")


def _type_name(value: Any) -> ShownText:
    """Name of the type of a value that is too large to show."""
    return ShownText(f"({type(value).__name__})")


def _from_numpy(array: NDArray[Any] | np.generic, place: str) -> Any:
    """Convert a NumPy scalar, or an array without dimensions, to a number, others to lists."""
    if array.size > LONGEST:
        raise InputError(place, _type_name(array), f"at most {LONGEST} numbers")
    if array.dtype.kind == "f":
        return array.astype(float).tolist()  # of a long double, too
    # Booleans are refused where they stand, as those of a file are; text of a name stays text.
    if array.dtype.kind in "iub" or (array.dtype.kind == "U" and not array.ndim):
        return array.tolist()
    raise InputError(place, array, f"real numbers (not an array of {array.dtype})")


def read_toml(path: Path, kind: str = SCENE) -> dict[str, Any]:
    """Read the tables of a TOML file; kind: a key of FILES. Raises InputError for a file that
    cannot be read, is no TOML, is of another kind, or is beyond the limits."""
    try:
        mode = path.stat().st_mode
        if other := next((name for is_one, name in KINDS.items() if is_one(mode)), None):
            raise InputError(kind, str(path), f"a file (this is {other})")  # it may never end
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(kind, str(path), f"a file that can be read ({reason})") from None
    return parse_toml(content, str(path), kind)


def parse_toml(content: bytes, shown: str, kind: str = SCENE) -> dict[str, Any]:
    """Parse the bytes of a TOML file; kind: a key of FILES; shown: what messages call it. Raises
    InputError."""
    if len(content) > LARGEST:
        raise InputError(kind, shown, f"a file of at most {LARGEST // 10**6} MB")
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        raise InputError(kind, shown, "a file that can be read (not UTF-8 text)") from None
    if allowed := _hidden_character_message(text) or _size_message(text):
        raise InputError(kind, shown, allowed)
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        allowed = f"valid TOML ({error}{_error_context(str(error), text)})"
        raise InputError(kind, shown, allowed) from None
    for other, (has, lacks, command) in FILES.items():
        if other != kind and has in table and lacks not in table:
            raise InputError(kind, shown, f"a {kind} (this is a {other}, for rodgen {command})")
    return table


def _error_context(message: str, text: str) -> str:
    """Text near the place that a message of the parser names."""
    found = re.search(r"at line (\d+), column (\d+)", message)
    if found is None:
        return ""
    line, column = text.split("\n")[int(found[1]) - 1].rstrip("\r"), int(found[2])
    return f": {line[max(0, column - AROUND) : column + AROUND].strip()!r}"


def _hidden_character_message(text: str) -> str:
    """Message on a character that editors do not show; empty where there is none."""
    if found := re.search("|".join(HIDDEN), text):
        what = next(name for pattern, name in HIDDEN.items() if re.match(pattern, found[0]))
        line = text.count("\n", 0, found.start()) + 1
        return f"valid TOML (without {what}, as in line {line})"
    return ""


def _size_message(text: str) -> str:
    """Message on a text that would take the parser minutes or too deep; empty for any other."""
    bare = IN_LIST.sub("0", TEXT.sub("x", text))
    marks = np.frombuffer(bare.encode(), np.uint8)

    def is_one_of(characters: bytes) -> NDArray[np.bool_]:
        return np.isin(marks, np.frombuffer(characters, np.uint8))

    opened = is_one_of(b"[{")
    if (
        max((is_one_of(b"=") | opened).sum(), is_one_of(b".").sum()) > MOST_KEYS
        or is_one_of(b",").sum() > MOST_VALUES
    ):
        return f"a file of at most {MOST_KEYS} keys and {MOST_VALUES} values"
    depth = np.cumsum(opened.astype(np.int32) - is_one_of(b"]}"))
    if depth.max(initial=0) > DEEPEST or DOTTED.search(bare):
        return f"a file of tables and lists at most {DEEPEST} deep"
    return ""


def _refuse(self: object, *_: object, **__: object) -> NoReturn:
    kind = "list" if isinstance(self, list) else "dictionary"
    raise TypeError(f"a {kind} of a scene cannot be changed: scenes do not change. {AGAIN}")


class FrozenList(list[Any]):
    """A list that raises TypeError when it is to be changed; copies by `list` can be."""

    vars().update(dict.fromkeys(f"{OF_LISTS} {OF_BOTH}".split(), _refuse))

    def __reduce__(self) -> tuple[Any, ...]:  # else it would be unpickled item by item
        return FrozenList, (list(self),)

    # Lists have no hash, as they change; this one does not.
    def __hash__(self) -> int:  # type: ignore[override]
        return hash(tuple(self))


class FrozenDict(dict[str, Any]):
    """A dictionary that raises TypeError when it is to be changed; copies by `dict` can be."""

    vars().update(dict.fromkeys(f"{OF_DICTS} {OF_BOTH}".split(), _refuse))

    def __reduce__(self) -> tuple[Any, ...]:
        return FrozenDict, (dict(self),)

    # Dictionaries have no hash, as they change; this one does not.
    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))


def make_immutable(value: Any) -> Any:
    """Make a list or a dictionary immutable; anything else is returned as it is."""
    if isinstance(value, list):
        return FrozenList(value)
    return FrozenDict(value) if isinstance(value, dict) else value
