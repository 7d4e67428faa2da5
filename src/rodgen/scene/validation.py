"""Conversion of pydantic's errors to InputError, with the field, the value and what is allowed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, get_origin

from pydantic import BaseModel, ValidationError

from rodgen.errors import InputError, Missing, did_you_mean, unknown_key_message


def to_input_error(
    error: ValidationError, table: dict[str, Any], scene: type[BaseModel]
) -> InputError:
    """Convert a ValidationError to an InputError on the first thing that is wrong."""
    details = error.errors()
    # A key that is not known comes first: a misspelt key is also one that is missing.
    unknown = [d for d in details if d["type"] == "extra_forbidden"]
    first = (unknown or details)[0]
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        return cause
    names = _all_keys(table)
    path = _key_path(first, names)
    if first["type"] == "extra_forbidden":
        return _unknown_key_error(scene, path, first["input"], first["loc"])
    # A value that may be of several types has a finding for each: those that went deepest count.
    paths = [(_key_path(d, names), d) for d in details]
    deepest = max((p for p, _ in paths if p[: len(path)] == path), key=len)
    same = [d for p, d in paths if p == deepest]
    if same[0]["type"] == "missing":
        return InputError(".".join([*deepest, str(same[0]["loc"][-1])]), Missing(), "given")
    allowed = " or ".join(
        dict.fromkeys(_allowed_values(d, _field_at(scene, deepest)) for d in same)
    )
    return InputError(".".join(deepest) or "scene", same[0]["input"], allowed)


def _key_path(detail: Any, names: set[str]) -> list[str]:
    """Keys and positions of a finding, without the names of types that pydantic puts between."""
    keys = detail["loc"][: -1 if detail["type"] == "missing" else None]
    return [str(p) for p in keys if isinstance(p, int) or str(p) in names]


def _all_keys(table: Any) -> set[str]:
    """Keys of a table and of those in it."""
    if isinstance(table, list):
        return set().union(*(_all_keys(one) for one in table if isinstance(one, dict)))
    if isinstance(table, dict):
        return set(map(str, table)) | set().union(*map(_all_keys, table.values()), set())
    return set()


def check_key_exists(scene: type[BaseModel], keys: Sequence[str]) -> None:
    """Raise InputError for a key that no scene has, from the outermost table in."""
    for count, key in enumerate(keys, start=1):
        known = _known_keys(scene, keys[:count])
        if known and key not in known and not key.isdigit():  # the number of one of a list
            raise _unknown_key_error(scene, keys[:count], None, keys[:count])


def _unknown_key_error(
    scene: type[BaseModel], path: Sequence[str], value: object, location: Sequence[Any]
) -> InputError:
    """Error for a key that its table does not have, with the table that has it, if any."""
    key, known = location[-1], _known_keys(scene, location)
    there = "" if did_you_mean(key, known) else next(_find_key(scene, str(key)), "")
    hint = f"; did you mean {there}?" if there else ""
    return InputError(".".join(path), value, unknown_key_message(key, known, hint))


def _find_key(model: type[BaseModel], key: str) -> Iterator[str]:
    """Dotted names of a key in the tables of a scene."""
    tables = []
    for name, field in _fields(model):
        if (field.alias or name) == key:
            yield key
        if (inner := _table_of(field)) is not None:
            tables.append((field.alias or name, inner))
    for name, inner in tables:
        yield from (f"{name}.{rest}" for rest in _find_key(inner, key))


def _known_keys(model: type[BaseModel], location: Sequence[Any]) -> list[str]:
    """Keys of the table around a location; empty for one that takes any."""
    inner = _table_at(model, location[:-1])
    return [] if inner is None else [field.alias or name for name, field in _fields(inner)]


def _field_at(model: type[BaseModel], path: Sequence[str]) -> Any:
    """Field at a path; None where the key is a name or an index of the user's."""
    inner = _table_at(model, path[:-1])
    fields = {} if inner is None else {one.alias or name: one for name, one in _fields(inner)}
    return fields.get(path[-1]) if path else None


def _table_at(model: type[BaseModel], location: Sequence[Any]) -> type[BaseModel] | None:
    """Class of the table at a location; None where that takes any key."""
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
    """Class of the table that a field may hold, if any."""
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


def _allowed_values(detail: Any, field: Any) -> str:
    """Words on what a field allows, for one finding."""
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
