"""All that can be shown of a rod: names, labels and units, and the group that has each."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rodgen.view.live.quantities.source import Source

SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


class Quantity(NamedTuple):
    """Something that can be shown: kind is what it can be shown together with."""

    name: str
    label: str
    unit: str
    kind: str


class Kind(NamedTuple):
    """Quantities of one unit: what they are, in words, the symbol of their axis, their unit."""

    title: str
    symbol: str
    unit: str


class Place(NamedTuple):
    """Where the values of a quantity are: a group and a column of it."""

    group: str
    column: int


KINDS = {
    "t": Kind("time", "t", "s"),
    "tip": Kind("position of the tail", "x, y of the tail", "m"),
    "tip_velocity": Kind("velocity of the tail", "velocity of the tail", "m/s"),
    "centre": Kind("centre of gravity", "x, y of the centre of gravity", "m"),
    "centre_velocity": Kind(
        "velocity of the centre of gravity", "velocity of the centre of gravity", "m/s"
    ),
    "energy": Kind("energies", "energy", "J"),
    "energy_balance": Kind("error of the energy balance", "balance error", "J"),
    "work": Kind("work of the loads", "work", "J"),
    "power": Kind("power of the loads", "power", "W"),
    "load": Kind("loads", "force", "N"),
    "inertia": Kind("moments and product of inertia", "moment of inertia", "kg m²"),
    "principal_moment": Kind("principal moments of inertia", "moment of inertia", "kg m²"),
    "principal_angle": Kind("angle of the principal axis", "angle", "rad"),
    "base": Kind("position of joint 0", "x₀, y₀", "m"),
    "base_velocity": Kind("velocity of joint 0", "ẋ₀, ẏ₀", "m/s"),
    "phi": Kind("angles of the links", "φ", "rad"),
    "omega": Kind("rates of the links", "ω", "rad/s"),
    "bend": Kind("angles between neighbouring links", "Δφ", "rad"),
    "bend_rate": Kind("rates between neighbouring links", "Δω", "rad/s"),
    "bending_moment": Kind("bending moments", "bending moment", "N m"),
    "joint_x": Kind("x of the joints", "x", "m"),
    "joint_y": Kind("y of the joints", "y", "m"),
}
# One at a time: name, label, kind, group, column.
DERIVED = (
    ("t", "t", "t", "t", 0),
    ("tip_x", "x of the tail", "tip", "joints", -2),
    ("tip_y", "y of the tail", "tip", "joints", -1),
    ("tip_vx", "ẋ of the tail", "tip_velocity", "tip_velocity", 0),
    ("tip_vy", "ẏ of the tail", "tip_velocity", "tip_velocity", 1),
    ("centre_of_gravity_x", "x of the centre of gravity", "centre", "centre", 0),
    ("centre_of_gravity_y", "y of the centre of gravity", "centre", "centre", 1),
    ("centre_of_gravity_vx", "ẋ of the centre of gravity", "centre_velocity", "centre_velocity", 0),
    ("centre_of_gravity_vy", "ẏ of the centre of gravity", "centre_velocity", "centre_velocity", 1),
    ("kinetic_energy", "kinetic energy", "energy", "energy", 0),
    ("spring_energy", "spring energy", "energy", "energy", 1),
    ("gravity_energy", "gravity energy", "energy", "energy", 2),
    ("total_energy", "total energy", "energy", "energy", 3),
    ("energy_balance", "balance error", "energy_balance", "balance", 0),
    ("inertia_x", "I about x", "inertia", "inertia", 0),
    ("inertia_y", "I about y", "inertia", "inertia", 1),
    ("product_xy", "product I of x, y", "inertia", "inertia", 2),
    ("principal_moment_1", "smaller principal moment I₁", "principal_moment", "principal", 1),
    ("principal_moment_2", "larger principal moment I₂", "principal_moment", "principal", 2),
    ("principal_angle", "angle of the principal axis", "principal_angle", "principal", 0),
)
BASE = (
    ("x0", "x₀", "base", "base", 0),
    ("y0", "y₀", "base", "base", 1),
    ("vx0", "ẋ₀", "base_velocity", "base", 2),
    ("vy0", "ẏ₀", "base_velocity", "base", 3),
)
PERIODS = {"principal_angle": 3.141592653589793}  # an axis has no direction: the angle jumps by it


def subscript(number: int) -> str:
    """A number in subscript digits."""
    return str(number).translate(SUBSCRIPTS)


def named(source: Source) -> Iterator[tuple[Quantity, Place]]:
    """All quantities of a rod in the order in which they are offered."""
    yield from map(_single, DERIVED)
    for group, kind in (("work", "work"), ("power", "power"), ("loads", "load")):
        terms = source.loads if kind == "load" else source.works
        for column, term in enumerate(terms):
            words = term.replace("_", " ")
            label = words if kind == "load" else f"{kind} of {words}"
            name = term if kind == "load" else f"{kind}_{term}"
            yield _single((name, label, kind, group, column))
    if source.hold.translates:
        yield from map(_single, BASE)
    for kind, numbers in numbered(source).items():
        yield from _family(kind, numbers)


def numbered(source: Source) -> dict[str, range]:
    """Kinds that go along the rod, with the numbers of their links or joints."""
    links = range(source.links)
    springs = range(0 if source.hold.root_spring else 1, source.links)
    joints = range(source.links + 1)
    return {
        "phi": links,
        "omega": links,
        "bend": springs,
        "bend_rate": springs,
        "bending_moment": range(source.hold.first, source.links + 1),  # 0 at a free end, or a pin
        "joint_x": joints,
        "joint_y": joints,
    }


def _single(row: tuple[str, str, str, str, int]) -> tuple[Quantity, Place]:
    name, label, kind, group, column = row
    return Quantity(name, label, KINDS[kind].unit, kind), Place(group, column)


def _family(kind: str, numbers: range) -> Iterator[tuple[Quantity, Place]]:
    unit = KINDS[kind].unit
    symbol = "M" if kind == "bending_moment" else KINDS[kind].symbol
    for s in numbers:
        match kind:
            case "joint_x" | "joint_y":
                name, place = f"joint_{s}_{kind[-1]}", Place("joints", 2 * s + "xy".index(kind[-1]))
            case "bending_moment":
                name, place = f"{kind}_{s}", Place("moments", s)
            case _:
                name, place = f"{kind}_{s}", Place(kind, s - numbers.start)
        yield Quantity(name, symbol + subscript(s), unit, kind), place
