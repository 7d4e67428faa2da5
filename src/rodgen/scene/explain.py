"""Pydantic's findings in the words of rodgen: field, value, and what is allowed."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ValidationError

from rodgen.scene.errors import SceneError


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
    if first["type"] == "missing":
        return SceneError(".".join([*path, str(first["loc"][-1])]), _Missing(), "given")
    if first["type"] == "extra_forbidden":
        known = ", ".join(_known(scene, first["loc"]))
        allowed = f"absent: not a known key (known: {known})"
        return SceneError(".".join(path), first["input"], allowed)
    # A value that may be of several types has a finding for each: those that went deepest count.
    paths = [(_path(d, names), d) for d in details]
    deepest = max((p for p, _ in paths if p[: len(path)] == path), key=len)
    same = [d for p, d in paths if p == deepest]
    allowed = " or ".join(dict.fromkeys(_plain(d) for d in same))
    return SceneError(".".join(deepest) or "scene", same[0]["input"], allowed)


def _path(detail: Any, names: set[str]) -> list[str]:
    """Keys and positions of a finding, without the names of types that pydantic puts between."""
    return [str(p) for p in detail["loc"] if isinstance(p, int) or str(p) in names]


class _Missing:
    def __repr__(self) -> str:
        return "(missing)"


def _names(table: Any) -> set[str]:
    """Keys of a table and of those in it."""
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
    return list(model.model_fields)


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
            return "a list of 2 numbers"
    return PLAIN.get(detail["type"], str(detail["msg"]))
