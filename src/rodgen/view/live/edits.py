"""A scene with another value in it, and which values of it can be moved while it runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from rodgen.scene import Scene
from rodgen.scene.tables import PLACES, FinFactor

Path = tuple[str, ...]  # keys of tables, from the outermost in

# Names in words, units, and whether a slider moves over decades.
ROD = {
    "mass": ("mass M", "kg", True),
    "length": ("length L", "m", True),
    "bending_stiffness": ("bending stiffness EI", "N m²", True),
    "clamp_angle": ("clamp angle", "rad", False),
}
LOADS = {
    "follower_force": ("follower force P", "N"),
    "follower_angle": ("follower angle ν", "rad"),
    "gravity": ("gravity g", "m/s²"),
    "internal_damping": ("internal damping c_int", "m²/s"),
    "external_damping": ("external damping c_ext", "1/s"),
    "tip_force_x": ("tip force x", "N"),
    "tip_force_y": ("tip force y", "N"),
}
SIGNED = {"follower_force", "follower_angle", "gravity", "tip_force_x", "tip_force_y"}
ANGLES = {"follower_angle", "clamp_angle"}
# How far a slider goes where the value itself says nothing of its size.
TYPICAL = {"gravity": 9.81, "internal_damping": 0.1, "external_damping": 1.0}
MOST_FINS = 12  # of a list of them that can be moved one by one
PI = 3.141592653589793


@dataclass(frozen=True)
class Field:
    """A value that can be moved: where it stands, what it is in words, its unit; whether a slider
    moves over decades; value: None where it is an expression of time, given as text."""

    path: Path
    label: str
    unit: str
    value: float | None
    text: str = ""
    decades: bool = False
    signed: bool = False

    @property
    def key(self) -> str:
        """The path as one word."""
        return ".".join(self.path)

    def reach(self, scale: float) -> tuple[float, float]:
        """From where to where a slider goes, when the value is of such a size."""
        if self.path[-1] in ("angle", "clamp_angle"):
            return -PI, PI
        if self.decades:
            return scale / 100, scale * 100
        return (-3 * scale if self.signed else 0.0), 3 * scale


def movable(scene: Scene) -> Iterator[Field]:
    """All values that are arguments of the scene's module, and loads that are expressions; of a
    long list of fin factors the first and the last."""
    names = scene.structure.parameters
    for name, (label, unit, decades) in ROD.items():
        if name in names:
            value = getattr(scene.rod, name) or 0.0
            yield Field(("rod", name), label, unit, value, decades=decades and value > 0)
    for name, (label, unit) in LOADS.items():
        if name in scene.loads.parameters:
            value, signed = scene.loads.value(name), name in SIGNED
            path = ("loads", *PLACES[name])
            if isinstance(value, str):
                yield Field(path, label, unit, None, value, signed=signed)
            else:
                yield Field(path, label, unit, float(value), signed=signed)
    if "fin_factor" in names:
        yield from _fins(scene)


def _fins(scene: Scene) -> Iterator[Field]:
    fins = scene.loads.value("fin_factor")
    path = ("loads", *PLACES["fin_factor"])
    if isinstance(fins, FinFactor):
        for part in ("nose", "body", "tail"):
            yield Field((*path, part), f"fin factor, {part}", "", float(getattr(fins, part)))
    else:
        last = len(fins) - 1
        for joint in range(len(fins)) if last < MOST_FINS else (0, last):  # the ends count most
            value = float(fins[joint])
            yield Field((*path, str(joint)), f"fin factor, joint {joint}", "", value)


def scale_of(field: Field) -> float:
    """The size of a value, for its slider."""
    return abs(field.value or 0.0) or TYPICAL.get(field.path[1], 1.0)


def edited(scene: Scene, changes: Sequence[tuple[Path, Any]]) -> Scene:
    """The scene with other values at some places; None takes away what is there. Raises
    SceneError."""
    table = scene.model_dump(exclude_none=True)
    for path, value in changes:
        _put(table, path, value)
    return Scene.from_dict(table)


def _put(table: Any, path: Path, value: Any) -> None:
    *outer, last = path
    for key in outer:
        table = table[int(key)] if isinstance(table, list) else table.setdefault(key, {})
    if isinstance(table, list):
        table[int(last)] = value
    elif value is None:
        table.pop(last, None)
    else:
        table[last] = value
