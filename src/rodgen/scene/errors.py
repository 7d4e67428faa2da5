"""Errors of the user's input: each names the field, the value and what is allowed."""

from __future__ import annotations

import pickle
import re
from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches
from typing import Any, get_origin

from pydantic import BaseModel, ValidationError

LONGEST = 200  # characters of a field in a message
UNKNOWN = "absent: not a known key"  # how a key is refused
VERSIONS = "version", "format", "schema"  # keys by which files tell of which version they are


class SceneError(ValueError):
    """A field of a scene, an option or a file cannot be used.

    Examples
    --------
    >>> import rodgen
    >>> try:
    ...     rodgen.Scene.example("missile").replace({"rod.mass": -1})
    ... except rodgen.SceneError as error:
    ...     print(error)
    rod.mass = -1: must be greater than 0
    """

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


def unknown_key(key: object, known: Iterable[str], hint: str = "") -> str:
    """What is said of a key that a table does not have; hint: where it may belong, else the known
    key that is next to it."""
    known = list(known)
    if key in VERSIONS:
        hint = "; is the file of a newer rodgen? Files of this one name no version"
    return f"{UNKNOWN} (known: {', '.join(known)}){hint or meant(key, known)}"


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
        return _unknown(scene, path, first["input"], first["loc"])
    # A value that may be of several types has a finding for each: those that went deepest count.
    paths = [(_path(d, names), d) for d in details]
    deepest = max((p for p, _ in paths if p[: len(path)] == path), key=len)
    same = [d for p, d in paths if p == deepest]
    if same[0]["type"] == "missing":
        return SceneError(".".join([*deepest, str(same[0]["loc"][-1])]), Missing(), "given")
    allowed = " or ".join(dict.fromkeys(_plain(d, _field(scene, deepest)) for d in same))
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


def check_known(scene: type[BaseModel], keys: Sequence[str]) -> None:
    """Raise SceneError for a key that no scene has, from the outermost table in."""
    for count, key in enumerate(keys, start=1):
        known = _known(scene, keys[:count])
        if known and key not in known and not key.isdigit():  # the number of one of a list
            raise _unknown(scene, keys[:count], None, keys[:count])


def _unknown(
    scene: type[BaseModel], path: Sequence[str], value: object, location: Sequence[Any]
) -> SceneError:
    """The error for a key that its table does not have; another may have it."""
    key, known = location[-1], _known(scene, location)
    there = "" if meant(key, known) else next(_places(scene, str(key)), "")
    hint = f"; did you mean {there}?" if there else ""
    return SceneError(".".join(path), value, unknown_key(key, known, hint))


def _places(model: type[BaseModel], key: str) -> Iterator[str]:
    """Dotted names of a key in the tables of a scene."""
    tables = []
    for name, field in _fields(model):
        if (field.alias or name) == key:
            yield key
        if (inner := _table_of(field)) is not None:
            tables.append((field.alias or name, inner))
    for name, inner in tables:
        yield from (f"{name}.{rest}" for rest in _places(inner, key))


def _known(model: type[BaseModel], location: Sequence[Any]) -> list[str]:
    """Keys of the table that a location is in; none of one that takes any."""
    inner = _table(model, location[:-1])
    return [] if inner is None else [field.alias or name for name, field in _fields(inner)]


def _field(model: type[BaseModel], path: Sequence[str]) -> Any:
    """The key of a path, None of one that has a name or a number of its own."""
    inner = _table(model, path[:-1])
    fields = {} if inner is None else {one.alias or name: one for name, one in _fields(inner)}
    return fields.get(path[-1]) if path else None


def _table(model: type[BaseModel], location: Sequence[Any]) -> type[BaseModel] | None:
    """The table at a location; None where that takes any key."""
    named = False  # whether what stands there goes by names, or numbers, of its own
    for key in location:
        fields = {} if named else {one.alias or name: one for name, one in _fields(model)}
        field = fields.get(str(key))
        named = field is not None and get_origin(field.annotation) in (dict, list)
        if field is None:
            continue
        model = _table_of(field) or model
    return None if named else model


def _table_of(field: Any) -> type[BaseModel] | None:
    """The table that a key may have as its value."""
    for option in getattr(field.annotation, "__args__", (field.annotation,)):
        if isinstance(option, type) and issubclass(option, BaseModel):
            return option
    return None


def _fields(model: type[BaseModel]) -> Iterable[tuple[str, Any]]:
    return model.model_fields.items()


FORM = re.compile(r"`(\[[^`]*\])`")  # of a list, in the description of its key
PLAIN = {
    "int_type": "a whole number",
    "float_type": "a number",
    "string_type": "text",
    "list_type": "a list",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "finite_number": "a finite number",
}


def _plain(detail: Any, field: Any) -> str:
    """What is allowed, in the words of the field."""
    form = FORM.search(getattr(field, "description", None) or "")
    if form and detail["type"] in ("list_type", "too_short", "too_long"):
        return f"a list of {form[1].count(',') + 1} numbers, {form[1]}"
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
