"""Rows of the text panel about the rod and its loads."""

from __future__ import annotations

from collections.abc import Iterator

from rodgen.scene import Scene
from rodgen.view.live.quantities.now import Entry, Now, parameter
from rodgen.view.live.quantities.numbers import NOTHING, WIDTH, five, fixed, padded, whole
from rodgen.view.live.quantities.present import Row

# Label and unit of the parameters of loads; that of fin factors stands for each of their rows.
LOADS = {
    "follower_force": ("follower force", "N"),
    "follower_angle": ("angle of the follower force", "rad"),
    "gravity": ("gravity", "m/s²"),
    "internal_damping": ("internal damping", "m²/s"),
    "external_damping": ("external damping", "1/s"),
    "tip_force_x": ("tip force, x", "N"),
    "tip_force_y": ("tip force, y", "N"),
    "fin_factor": ("fin factor", ""),
}


def rod(scene: Scene) -> Iterator[Entry]:
    yield parameter("length", "length", "m")
    yield parameter("mass", "mass", "kg")
    yield parameter("bending_stiffness", "bending stiffness", "N m²")
    if "clamp_angle" in scene.structure.parameters:
        yield parameter("clamp_angle", "angle of the clamp", "rad")
    yield Row("links", "links", ""), lambda now: whole(now.scene.rod.links)
    yield Row("link_length", "length of a link", "m"), lambda now: five(now.per_link.length)
    yield Row("link_mass", "mass of a link", "kg"), lambda now: five(now.per_link.mass)
    if scene.rod.links > 1:
        row = Row("spring_stiffness", "stiffness of a spring", "N m/rad")
        yield row, lambda now: five(float(now.per_link.stiffness[-2]))
    if scene.hold.root_spring:
        row = Row("root_stiffness", "stiffness of the root spring", "N m/rad")
        yield row, lambda now: five(float(now.per_link.stiffness[0]))


def loads(scene: Scene) -> Iterator[Entry]:
    for name in scene.loads.parameters:
        label, unit = LOADS[name]
        if name == "fin_factor":
            yield Row("fin_factor_nose", f"{label}, nose", unit), lambda now: five(now.fins[0])
            if scene.rod.links > 1:
                yield Row("fin_factor_body", f"{label}, body", unit), _body
            yield Row("fin_factor_tail", f"{label}, tail", unit), lambda now: five(now.fins[-1])
        else:
            timed = ", at present" if name in scene.timed else ""
            yield parameter(name, label + timed, unit)


def _body(now: Now) -> str:
    """Of the joints between: one value, or the range of all."""
    low, high = float(now.fins[1:-1].min()), float(now.fins[1:-1].max())
    return five(low) if low == high else f"{five(low).strip()} to {five(high).strip()}"


def critical(scene: Scene) -> Iterator[Entry]:
    if "follower" not in scene.loads.terms:
        return
    yield parameter("follower_force", "follower force", "N")
    yield Row("critical_force", "critical force", "N"), _critical_force
    yield Row("critical_why", "", ""), _critical_why
    yield Row("critical_ratio", "force over critical force", "%"), _critical_ratio
    yield Row("critical_distance", "distance to the critical force", "N"), _critical_distance


def _critical_force(now: Now) -> str:
    found = now.present.critical
    if isinstance(found, str):
        return padded(NOTHING if _long(found) else found)
    return _known(found)


def _critical_why(now: Now) -> str:
    found = now.present.critical
    return found if isinstance(found, str) and _long(found) else ""


def _long(words: str) -> bool:
    """Whether they need a row of their own."""
    return len(words) > WIDTH


def _critical_ratio(now: Now) -> str:
    found = now.present.critical
    if not isinstance(found, float | int) or not found:
        return padded(NOTHING)
    return fixed(100 * now.parameter("follower_force") / found, 2)


def _critical_distance(now: Now) -> str:
    found = now.present.critical
    if not isinstance(found, float | int):
        return padded(NOTHING)
    return five(found - now.parameter("follower_force"))


def _known(value: float | None) -> str:
    return padded(NOTHING) if value is None else five(value)
