"""A rod of a metre and a kilogram, as a scene in tables, and what a scene is refused for."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import takewhile
from typing import Any, NamedTuple

import pytest

from rodgen.scene import Scene, SceneError
from rodgen.scene.errors import Missing

ROD = {"links": 5, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}
TOML = 'name = "a"\n[rod]\n' + "".join(f"{key} = {value}\n" for key, value in ROD.items())
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


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


class Refusal(NamedTuple):
    """What is refused, the class in place of a value that is missing, and what is allowed."""

    field: str
    value: object
    allowed: str

    @property
    def numbers(self) -> list[float]:
        """Those which are named in what is allowed."""
        return [float(number) for number in NUMBER.findall(self.allowed)]


def refused(make: Callable[..., object], *given: Any, **named: Any) -> Refusal:
    """Why a thing cannot be made, which is said in one line that begins with the field and is not
    endless."""
    try:
        made = make(*given, **named)
    except SceneError as error:
        told = error
    else:
        pytest.fail(f"{given or named} is taken: {made!r}")
    message = str(told)
    assert len(message.splitlines()) == 1, message
    assert len(message) < 1000, message
    assert message.startswith("".join(takewhile(str.isprintable, told.field[:100]))), message
    value = Missing if isinstance(told.value, Missing) else told.value
    return Refusal(told.field, value, told.allowed)
