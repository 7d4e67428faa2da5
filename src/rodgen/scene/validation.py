"""Conversion of pydantic's errors to InputError, with the field, the value and what is allowed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from typing import Any, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from rodgen.errors import InputError, Missing, did_you_mean, unknown_key_message
from rodgen.scene.number_text import NumberText, to_texts


def to_input_error(error: ValidationError, model: type[BaseModel]) -> InputError:
    """Convert a ValidationError of a model to an InputError on the first thing that is wrong."""
    # That a default could not be made follows from what is wrong elsewhere.
    details = [d for d in error.errors() if d["type"] != "default_factory_not_called"]
    # A key that is not known comes first: a misspelt key is also one that is missing.
    unknown = [d for d in details if d["type"] == "extra_forbidden"]
    first = (unknown or details)[0]
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        return cause
    if unknown:
        return _unknown_key_error(model, first["loc"], first["input"])
    path = _key_path(model, first)
    # A value that may be of several types has a finding for each: those that went deepest count.
    paths = [(_key_path(model, d), d) for d in details]
    deepest = max((p for p, _ in paths if p[: len(path)] == path), key=len)
    same = [d for p, d in paths if p == deepest]
    for cause in (d.get("ctx", {}).get("error") for d in same):
        if isinstance(cause, InputError):  # of a table in a list, whose place this knows
            key = ".".join([*deepest, cause.field.rpartition(".")[2]])
            return InputError(key, cause.value, cause.allowed)
    # Of a text that is a number, what that number may be.
    same = [d for d in same if isinstance(d["input"], NumberText)] or same
    if same[0]["type"] == "missing":
        return InputError(".".join([*deepest, str(same[0]["loc"][-1])]), Missing(), "given")
    field = _fields_around(model, deepest).get(deepest[-1]) if deepest else None
    allowed = " or ".join(dict.fromkeys(_allowed_values(d, field) for d in same))
    return InputError(".".join(deepest) or "scene", to_texts(same[0]["input"]), allowed)


def _key_path(model: type[BaseModel], detail: Any) -> list[str]:
    """Keys and indices of a finding, without the key that is missing."""
    return _walk(model, detail["loc"][: -1 if detail["type"] == "missing" else None])[0]


def check_key_exists(model: type[BaseModel], keys: Sequence[str]) -> None:
    """Raise InputError for a key that no scene has, from the outermost table in."""
    for count, key in enumerate(keys, start=1):
        known = _fields_around(model, keys[:count])
        if known and key not in known and not key.isdigit():  # the number of one of a list
            raise _unknown_key_error(model, keys[:count], None)


def _unknown_key_error(
    model: type[BaseModel], location: Sequence[int | str], value: object
) -> InputError:
    """Error for a key that its table does not have, with the table that has it, if any."""
    key = str(location[-1])
    known = _fields_around(model, location)
    there = (f"{table}{key}" for table, fields in fields_of_tables(model).items() if key in fields)
    found = "" if did_you_mean(key, known) else next(there, "")
    hint = f"; did you mean {found}?" if found else ""
    path = [*_walk(model, location[:-1])[0], key]
    return InputError(".".join(path), value, unknown_key_message(key, known, hint))


Fields = dict[str, FieldInfo]


@cache
def fields_of_tables(model: type[BaseModel]) -> dict[str, Fields]:
    """Fields by key of a model, under "", and of the tables in it, under the beginning of their
    dotted names, such as "loads.follower.", without names and indices."""
    own = {field.alias or name: field for name, field in model.model_fields.items()}
    found = {"": own}
    for key, field in own.items():
        for option in getattr(field.annotation, "__args__", (field.annotation,)):
            if isinstance(option, type) and issubclass(option, BaseModel):
                found |= {f"{key}.{table}": of for table, of in fields_of_tables(option).items()}
    return found


def goes_by_names(field: FieldInfo) -> bool:
    """Whether a field holds values by names of their own, or by indices."""
    return get_origin(field.annotation) in (dict, list)


def _walk(model: type[BaseModel], location: Sequence[int | str]) -> tuple[list[str], Fields]:
    """Keys and indices of a location, without the names of types that pydantic puts between, and
    the fields of the table there; none where that takes any key."""
    tables, path, table, named = fields_of_tables(model), list[str](), "", False
    for key in location:
        field = None if named else tables[table].get(str(key))
        if field or named or str(key).isdigit():
            path.append(str(key))
        named = field is not None and goes_by_names(field)
        if field and f"{table}{key}." in tables:
            table += f"{key}."
    return path, {} if named else tables[table]


def _fields_around(model: type[BaseModel], location: Sequence[int | str]) -> Fields:
    """Fields of the table that has the key at a location."""
    return _walk(model, location[:-1])[1]


FORM = re.compile(r"`(\[[^`]*\])`")  # of a list, in the description of its key
PLAIN = {
    "int_type": "a whole number",
    "float_type": "a number",
    "string_type": "text",
    "list_type": "a list",
    "tuple_type": "a list",
    "bool_type": "true or false",
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
        case "string_pattern_mismatch":
            return str(field.description)
    return PLAIN.get(detail["type"], str(detail["msg"]))
