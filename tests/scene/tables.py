"""A rod of a metre and a kilogram, as a scene in tables."""

from __future__ import annotations

from typing import Any

ROD = {"links": 5, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}


def table_of(**tables: Any) -> dict[str, Any]:
    """The rod with other tables, and with other keys of [rod]."""
    return {"name": "test", **tables, "rod": ROD | tables.get("rod", {})}
