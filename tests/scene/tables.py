"""A rod of a metre and a kilogram, as a scene in tables."""

from __future__ import annotations

from typing import Any

from rodgen.scene import Scene

ROD = {"links": 5, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}
TOML = 'name = "a"\n[rod]\n' + "".join(f"{key} = {value}\n" for key, value in ROD.items())


def table_of(**tables: Any) -> dict[str, Any]:
    """The rod with other tables, and with other keys of [rod]."""
    return {"name": "test", **tables, "rod": ROD | tables.get("rod", {})}


def scene_of(**tables: Any) -> Scene:
    """The scene of such tables."""
    return Scene.from_dict(table_of(**tables))


def put(table: dict[str, Any], field: str, value: Any) -> None:
    """A value at a field such as loads.tip.x; None takes it away."""
    *path, key = field.split(".")
    for name in path:
        table = table.setdefault(name, {})
    table[key] = value
    if value is None:
        del table[key]
