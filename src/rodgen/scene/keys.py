"""Keys of a scene by their dotted names, such as loads.follower.force or bodies.payload.mass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rodgen.scene.errors import SceneError, meant, short
from rodgen.scene.plain import entry, put

if TYPE_CHECKING:
    from rodgen.scene.scene import Scene


def with_value(scene: Scene, name: str, value: Any, field: str = "vary") -> Scene:
    """The scene with another value of a key. Raises SceneError."""
    table = scene.model_dump(exclude_none=True)
    put(table, key_place(table, name, field), value)
    return scene.from_dict(table)


def put_values(scene: dict[str, Any], values: Mapping[str, Any]) -> None:
    """Put values into the tables of a scene by their dotted names, which may be new to them; None
    takes away what is there. Raises SceneError for a name that leads to no table or list."""
    for name, value in values.items():
        *outer, last = name.split(".")
        table: Any = scene
        for depth, key in enumerate(outer):
            at = _key_in(table, key, name, outer[:depth])
            table = table[at] if isinstance(table, list) else table.setdefault(at, {})
        at = _key_in(table, last, name, outer)
        if value is not None:
            table[at] = value
        elif isinstance(table, list) or at in table:
            del table[at]


def _key_in(table: Any, key: str, name: str, outer: Sequence[str], field: str = "key") -> Any:
    """What stands for a part of a dotted name: a key of a table, the number of one of a list, which
    may be told by its name. outer: the parts before. Raises SceneError."""
    if isinstance(table, dict):
        return key
    at = ".".join(outer)
    if not isinstance(table, list):
        raise SceneError(field, name, f"a key of the scene ({at} is {short(table)})")
    names = [one.get("name") if isinstance(one, dict) else None for one in table]
    if key in names:
        return names.index(key)
    if key.isascii() and key.isdigit() and int(key) < len(table):
        return int(key)
    known = ", ".join(str(n or number) for number, n in enumerate(names)) or "none"
    hint = meant(key, [n for n in names if n])
    raise SceneError(field, name, f"a key of the scene ({at} has {known}){hint}")


def key_place(scene: dict[str, Any], name: str, field: str = "vary") -> tuple[str, ...]:
    """Where a dotted name stands in the tables of a scene. Raises SceneError for one that does not
    stand in any, or that is no single value, with the field that is named."""
    *outer, last = name.split(".")
    found_at: list[str] = []
    for key in [*outer, last]:
        inner = entry(scene, *found_at)
        if isinstance(inner, list):
            found_at.append(str(_key_in(inner, key, name, found_at, field)))
            continue
        known = list(inner) if isinstance(inner, dict) else []
        # What a table may have beside what it has, the scene itself tells when it is made.
        if not (key in known or (isinstance(inner, dict) and bool(outer) and key is last)):
            at = ".".join(found_at) or "the scene"
            has = f"({at} has {', '.join(known) or 'none'})"
            allowed = f"a key of the scene {has}{meant(key, known)}"
            raise SceneError(field, name, allowed)
        found_at.append(key)
    found = entry(scene, *found_at[:-1])
    value = found[int(found_at[-1])] if isinstance(found, list) else found.get(found_at[-1])
    if isinstance(value, dict | list) or found_at == ["name"]:
        inside = f", such as {name}.{next(iter(value), 0)}" if isinstance(value, dict) else ""
        inside = f", such as {name}.0" if isinstance(value, list) else inside
        raise SceneError(field, name, f"a key that has one value{inside}")
    return tuple(found_at)
