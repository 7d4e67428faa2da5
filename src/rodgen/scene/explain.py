"""Pydantic's findings in the words of rodgen: field, value, and what is allowed."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ValidationError

from rodgen.scene.errors import SceneError


def explain(error: ValidationError, table: dict[str, Any], scene: type[BaseModel]) -> SceneError:
    """The first thing that is wrong, as field, value and what is allowed."""
    details = error.errors()
    first = details[0]
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, SceneError):
        return cause
    # A value that may be of several types has one entry for each: name the field once.
    path = [str(p) for p in first["loc"] if str(p) in _names(table) or isinstance(p, int)]
    missing = first["type"] == "missing"
    field = ".".join([*path, str(first["loc"][-1])] if missing else path) or "scene"
    if missing:
        return SceneError(field, _Missing(), "given")
    if first["type"] == "extra_forbidden":
        known = ", ".join(_known(scene, first["loc"]))
        return SceneError(field, first["input"], f"absent: not a known key (known: {known})")
    same = [d for d in details if d["loc"][: len(path)] == first["loc"][: len(path)]]
    allowed = " or ".join(dict.fromkeys(_plain(d) for d in same))
    return SceneError(field, first["input"], allowed)


class _Missing:
    def __repr__(self) -> str:
        return "(missing)"


def _names(table: Any) -> set[str]:
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
        case "too_short" | "too_long":
            return "a list of 2 numbers"
    return PLAIN.get(detail["type"], str(detail["msg"]))
