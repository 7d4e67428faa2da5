"""Errors of the user's input: each names the field, the value and what is allowed."""

from __future__ import annotations

import pickle
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

from pydantic import BaseModel, ValidationError

LONGEST = 200  # characters of a field in a message


class SceneError(ValueError):
    """A field of a scene, an option or a file that cannot be used as it is."""

    def __init__(self, field: str, value: object, allowed: str):
        self.field, self.value, self.allowed = field, value, allowed
        shown = field if len(field) <= LONGEST else field[:LONGEST] + "..."
        super().__init__(_one_line(f"{shown} = {short(value)}: must be {allowed}"))

    def __reduce__(self) -> tuple[Any, ...]:
        # What reaches another process is the error, whatever the value was.
        return type(self), (self.field, _portable(self.value), self.allowed)


class _Shown(str):
    """A value that cannot be pickled, as it is shown in a message."""

    __slots__ = ()
    __repr__ = str.__str__


def _portable(value: object) -> object:
    """The value, or what is shown of it where it cannot be pickled."""
    try:
        pickle.dumps(value)
    except Exception:  # a value of any class, whose pickling may raise anything
        return _Shown(short(value))
    return value


def check_type(name: str, value: object, *kinds: type, see: str = "") -> None:
    """Raise TypeError unless the argument of this name is of one of these classes; see: what makes
    one."""
    if not isinstance(value, kinds):
        wanted = " or a ".join(kind.__name__ for kind in kinds)
        hint = f" (see {see})" if see else ""
        raise TypeError(f"{name} must be a {wanted}{hint}, not {type(value).__name__}")


def short(value: object, longest: int = 80) -> str:
    """A value as it is shown in a message."""
    try:
        text = repr(value)
    except ValueError:  # Python does not write whole numbers of thousands of digits
        text = "(a number of thousands of digits)"
    return text if len(text) <= longest else text[: longest - 3] + "..."


def meant(word: object, known: Iterable[str]) -> str:
    """What may have been meant by a word that is not known, to end a message with; else nothing."""
    found = get_close_matches(str(word), list(known), 1)
    return f"; did you mean {found[0]}?" if found else ""


def _one_line(text: str) -> str:
    """Control characters, which a key of a file may hold, as escapes."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def explain(error: ValidationError, table: dict[str, Any], scene: type[BaseModel]) -> SceneError:
    """The first thing that is wrong, as field, value and what is allowed."""
    details = error.errors()
    # A key that is not known comes first: a misspelt key is also one that is missing.
    unknown = [d for d in details if d["type"] == "extra_forbidden"]
    first = (unknown or details)[0]
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, SceneError):
        return cause
    names = _names(table)
    path = _path(first, names)
    if first["type"] == "extra_forbidden":
        known = _known(scene, first["loc"])
        hint = meant(first["loc"][-1], known)
        allowed = f"absent: not a known key (known: {', '.join(known)}){hint}"
        return SceneError(".".join(path), first["input"], allowed)
    # A value that may be of several types has a finding for each: those that went deepest count.
    paths = [(_path(d, names), d) for d in details]
    deepest = max((p for p, _ in paths if p[: len(path)] == path), key=len)
    same = [d for p, d in paths if p == deepest]
    if same[0]["type"] == "missing":
        return SceneError(".".join([*deepest, str(same[0]["loc"][-1])]), Missing(), "given")
    allowed = " or ".join(dict.fromkeys(_plain(d) for d in same))
    return SceneError(".".join(deepest) or "scene", same[0]["input"], allowed)


def _path(detail: Any, names: set[str]) -> list[str]:
    """Keys and positions of a finding, without the names of types that pydantic puts between."""
    keys = detail["loc"][: -1 if detail["type"] == "missing" else None]
    return [str(p) for p in keys if isinstance(p, int) or str(p) in names]


class Missing:
    """What stands for a value that is not there."""

    def __repr__(self) -> str:
        return "(missing)"


def _names(table: Any) -> set[str]:
    """Keys of a table and of those in it."""
    if isinstance(table, list):
        return set().union(*(_names(one) for one in table if isinstance(one, dict)))
    if isinstance(table, dict):
        return set(map(str, table)) | set().union(*map(_names, table.values()), set())
    return set()


def _known(model: type[BaseModel], location: tuple[Any, ...]) -> list[str]:
    """Keys of the table that a location is in."""
    for key in location[:-1]:
        field = model.model_fields.get(str(key))
        if field is None:
            continue
        options = getattr(field.annotation, "__args__", (field.annotation,))
        for option in options:
            if isinstance(option, type) and issubclass(option, BaseModel):
                model = option
                break
    return [field.alias or name for name, field in model.model_fields.items()]


PLAIN = {
    "int_type": "a whole number",
    "float_type": "a number",
    "string_type": "text",
    "list_type": "a list",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "finite_number": "a finite number",
}


def _plain(detail: Any) -> str:
    """What is allowed, in the words of the field."""
    context = detail.get("ctx", {})
    match detail["type"]:
        case "greater_than":
            return f"greater than {context['gt']:g}"
        case "greater_than_equal":
            return f"at least {context['ge']:g}"
        case "less_than_equal":
            return f"at most {context['le']:g}"
        case "too_short" | "too_long":
            most = context.get("max_length", 2)
            return "a list of 2 numbers" if most == 2 else f"a list of at most {most} tables"
    return PLAIN.get(detail["type"], str(detail["msg"]))
