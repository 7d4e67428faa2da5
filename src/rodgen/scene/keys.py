"""Keys of a scene by their dotted names, such as loads.follower.force or bodies.payload.mass."""

from __future__ import annotations

from typing import Any

from rodgen.scene.errors import SceneError
from rodgen.scene.plain import entry, put
from rodgen.scene.scene import Scene


def with_value(scene: Scene, name: str, value: Any, field: str = "vary") -> Scene:
    """The scene with another value of a key. Raises SceneError."""
    table = scene.model_dump(exclude_none=True)
    put(table, key_place(table, name, field), value)
    return Scene.from_dict(table)


def key_place(scene: dict[str, Any], name: str, field: str = "vary") -> tuple[str, ...]:
    """Where a dotted name stands in the tables of a scene. Raises SceneError for one that does not
    stand in any, or that is no single value, with the field that is named."""
    *outer, last = name.split(".")
    found_at: list[str] = []
    for key in [*outer, last]:
        inner = entry(scene, *found_at)
        if isinstance(inner, list):
            names = [one.get("name") if isinstance(one, dict) else None for one in inner]
            key = str(names.index(key)) if key in names else key
            known = [str(n or at) for at, n in enumerate(names)]
            there = key.isascii() and key.isdigit() and int(key) < len(inner)
        else:
            known = list(inner) if isinstance(inner, dict) else []
            # What a table may have beside what it has, the scene itself tells when it is made.
            there = key in known or (isinstance(inner, dict) and bool(outer) and key is last)
        if not there:
            at = ".".join(found_at) or "the scene"
            allowed = f"a key of the scene ({at} has {', '.join(known) or 'none'})"
            raise SceneError(field, name, allowed)
        found_at.append(key)
    found = entry(scene, *found_at[:-1])
    value = found[int(found_at[-1])] if isinstance(found, list) else found.get(found_at[-1])
    if isinstance(value, dict | list) or found_at == ["name"]:
        inside = f", such as {name}.{next(iter(value), 0)}" if isinstance(value, dict) else ""
        inside = f", such as {name}.0" if isinstance(value, list) else inside
        raise SceneError(field, name, f"a key that has one value{inside}")
    return tuple(found_at)
