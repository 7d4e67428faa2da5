"""Quantities that follow from a motion: a row each, with its name, unit, words, and what shows it.

The functions that compute them stand in integrate/quantity_formulas.py, by the names of the rows.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from rodgen.model.rod import Boundary
from rodgen.model.term import typeset

# Who holds a quantity: files and datasets, datasets alone, or none but what is asked for it.
FILE, DATASET, SHOWN = "file", "dataset", "shown"
# What there is a quantity for each of.
WORKS, POWERS, FORCES, LOADS, ADDED = "works", "powers", "forces", "loads", "added states"
CONTACTS, JOINT_CONTACTS = "contacts", "contacts in joints"
IN_AIR = "points that the air pushes"
FLOW = "airspeed", "attack"  # before the name of a load
OWN = "own"  # the kind of expressions that somebody types
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
Index = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity that follows from states and parameters at every time.

    name: of a variable in a file, with {} for a load; unit: with powers as in "kg m^2"; words: what
    it is; dimensions: beside the time; numbers: labels in plots of its single numbers by their
    names, in the order of its last dimension where that is none along the rod, with {} for the
    number of a link or joint, or for a load; kind: what they can be shown together with, by default
    their name without {}; kept: who holds it; each: what there is one for each of; watched: whether
    events can watch it; only: what a boundary must be for its rods to have it, by the name of a
    property of Boundary.
    """

    name: str
    unit: str
    words: str
    dimensions: tuple[str, ...] = ()
    numbers: Mapping[str, str] = field(default_factory=dict)
    kind: str = ""
    kept: str = FILE
    each: str = ""
    watched: bool = False
    only: str = ""

    def kind_of(self, number: str) -> str:
        """The kind of one of its numbers."""
        return self.kind or number.replace("_{}", "")


def _point(name: str, of: str, letters: str = "xy") -> dict[str, str]:
    """Both coordinates of a point, or of its velocity."""
    return {f"{name}x": f"{letters[0]} of {of}", f"{name}y": f"{letters[1]} of {of}"}


def _energy(name: str, words: str, kept: str = FILE) -> Quantity:
    name, label = f"{name}_energy", f"{name} energy"
    return Quantity(name, "J", words, (), {name: label}, "energy", kept, watched=True)


def _inertia(name: str, words: str, label: str) -> Quantity:
    return Quantity(name, "kg m^2", words, (), {name: label}, "inertia", watched=True)


AXIS, LINK, JOINT, SPRING = ("axis",), ("link",), ("joint",), ("spring",)
SECTION = ("section",)  # joints that pass a force on to a moving link
SUPPORTED = ("supported",)  # links with a support
TAIL, CENTRE = "the tail", "the centre of gravity"
_CENTRE = _point("centre_of_gravity_", CENTRE)
_JOINTS = {"joint_{}_x": "x{}", "joint_{}_y": "y{}"}
_PRINCIPAL = {
    "principal_moment_1": "smaller principal moment I₁",
    "principal_moment_2": "larger principal moment I₂",
}

# In the order in which files hold them: name, unit, words, dimensions, numbers, kind, kept, each.
# fmt: off
QUANTITIES = (
    Quantity("phi", "rad", "angles of the links", LINK, {"phi_{}": "φ{}"}),
    Quantity("omega", "rad/s", "rates of the links", LINK, {"omega_{}": "ω{}"}),
    Quantity("joints", "m", "positions of the joints", JOINT + AXIS, _JOINTS, watched=True),
    Quantity("centre_of_gravity", "m", "centre of gravity", AXIS, _CENTRE, "centre", watched=True),
    _energy("kinetic", "kinetic energy"),
    _energy("spring", "energy of the springs"),
    _energy("gravity", "energy in gravity and couples"),
    Quantity("energy_balance", "J", "energy gained less work done", (),
        {"energy_balance": "balance error"}),
    _inertia("inertia_x", "moment of inertia about x", "I about x"),
    _inertia("inertia_y", "moment of inertia about y", "I about y"),
    _inertia("product_xy", "product of inertia", "product I of x, y"),
    Quantity("work_{}", "J", "work of {}", (), {"work_{}": "work of {}"}, each=WORKS),
    Quantity("force_{}", "N", "force of {} on the joints", JOINT + AXIS, kept=DATASET, each=FORCES),
    Quantity("bending_moments", "N m", "bending moments in the joints", JOINT,
        {"bending_moment_{}": "M{}"}, kept=DATASET),
    Quantity("tip", "m", "position of the tail", AXIS,
        _point("tip_", TAIL), "tip", DATASET, watched=True),
    _energy("total", "energy", DATASET),
    Quantity("principal_angle", "rad", "axis of the smaller moment of inertia", (),
        {"principal_angle": "angle of the principal axis"}, kept=DATASET),
    Quantity("principal_moments", "kg m^2", "principal moments of inertia", ("principal",),
        _PRINCIPAL, "principal_moment", DATASET),
    Quantity("t", "s", "time", (), {"t": "t"}, kept=SHOWN),
    Quantity("tip_velocity", "m/s", "velocity of the tail", AXIS,
        _point("tip_v", TAIL, "ẋẏ"), "tip_velocity", SHOWN),
    Quantity("centre_velocity", "m/s", f"velocity of {CENTRE}", AXIS,
        _point("centre_of_gravity_v", CENTRE, "ẋẏ"), "centre_velocity", SHOWN),
    Quantity("tail_deflection", "m", "distance of the tail from the line of the clamp, or of the "
        "first link where there is none, positive to its left", (),
        {"tail_deflection": "tail across the start"}, kept=SHOWN),
    Quantity("tail_deflection_rate", "m/s", "rate of the distance of the tail from that line", (),
        {"tail_deflection_rate": "rate of the tail across the start"}, kept=SHOWN),
    Quantity("power_{}", "W", "power of {}", (), {"power_{}": "power of {}"},
        kept=SHOWN, each=POWERS),
    Quantity("{}", "N", "{}", (), {"{}": "{}"}, "load", SHOWN, LOADS),
    Quantity("{}", "", "{}", (), {"{}": "{}"}, "state", SHOWN, ADDED),
    Quantity("base", "m", "position of joint 0", AXIS,
        {"x0": "x₀", "y0": "y₀"}, "base", SHOWN, only="translates"),
    Quantity("base_velocity", "m/s", "velocity of joint 0", AXIS,
        {"vx0": "ẋ₀", "vy0": "ẏ₀"}, "base_velocity", SHOWN, only="translates"),
    Quantity("bend", "rad", "angles between neighbouring links", SPRING,
        {"bend_{}": "Δφ{}"}, kept=SHOWN),
    Quantity("bend_rate", "rad/s", "rates between neighbouring links", SPRING,
        {"bend_rate_{}": "Δω{}"}, kept=SHOWN),
    Quantity("curvature", "1/m", "curvatures at the springs", SPRING,
        {"curvature_{}": "κ{}"}, kept=SHOWN),
    Quantity("axial_force", "N", "axial forces, tension > 0", SECTION,
        {"axial_force_{}": "N{}"}, kept=SHOWN),
    Quantity("shear_force", "N", "shear forces", SECTION, {"shear_force_{}": "Q{}"}, kept=SHOWN),
    Quantity("reaction", "N", "force of what holds the rod", AXIS,
        _point("reaction_", "the reaction"), "reaction", SHOWN, only="is_held"),
    Quantity("reaction_moment", "N m", "moment of what holds the rod", (),
        {"reaction_moment": "moment of the reaction"}, kept=SHOWN, only="is_clamped"),
    Quantity("support_force", "N", "forces of the supports on the links", SUPPORTED + AXIS,
        {"support_force_{}_x": "support{} x", "support_force_{}_y": "support{} y"}, kept=SHOWN),
    Quantity("support_moment", "N m", "moments of the supports on the links", SUPPORTED,
        {"support_moment_{}": "support{} moment"}, kept=SHOWN),
    Quantity("depth_{}", "m", "depth by which {} is pressed, negative while it is apart", (),
        {"depth_{}": "depth of {}"}, kept=SHOWN, each=CONTACTS),
    Quantity("push_{}", "N", "force with which {} pushes", (), {"push_{}": "push of {}"},
        kept=SHOWN, each=CONTACTS),
    Quantity("depth_{}", "rad", "bend by which {} is pressed, negative while it is apart", (),
        {"depth_{}": "depth of {}"}, "joint_depth", SHOWN, JOINT_CONTACTS),
    Quantity("push_{}", "N m", "moment with which {} pushes", (), {"push_{}": "moment of {}"},
        "joint_push", SHOWN, JOINT_CONTACTS),
    Quantity("airspeed_{}", "m/s", "speed against the air of the point of {}", (),
        {"airspeed_{}": "airspeed of {}"}, kept=SHOWN, each=IN_AIR),
    Quantity("attack_{}", "rad",
        "angle of attack of {}, from the way of its link towards the nose to its velocity against "
        "the air", (), {"attack_{}": "angle of attack of {}"}, kept=SHOWN, each=IN_AIR),
    Quantity("momentum", "N s", "momentum", AXIS,
        _point("momentum_", "the momentum"), "momentum", SHOWN),
    Quantity("angular_momentum", "N m s",
        f"angular momentum about {CENTRE}, of a held rod about the joint that holds it", (),
        {"angular_momentum": "angular momentum"}, kept=SHOWN),
)
# fmt: on


class Kind(NamedTuple):
    """Kind of quantities that can be shown together: title, symbol of its axis, and unit."""

    title: str
    symbol: str
    unit: str


def _kind(name: str, symbol: str, title: str = "") -> tuple[str, Kind]:
    """Name and row of a kind, by default titled as the quantity that it consists of."""
    of = next(row for row in QUANTITIES if name in map(row.kind_of, row.numbers))
    return name, Kind(title or of.words, symbol, typeset(of.unit))


# In the order in which they are offered.
KINDS = dict(
    (
        _kind("t", "t"),
        _kind("tip", "x, y of the tail"),
        _kind("tip_velocity", "velocity of the tail"),
        _kind("tail_deflection", "deflection of the tail", "deflection of the tail"),
        _kind("tail_deflection_rate", "rate of the deflection", "rate of the tail's deflection"),
        _kind("centre", "x, y of the centre of gravity"),
        _kind("centre_velocity", "velocity of the centre of gravity"),
        _kind("energy", "energy", "energies"),
        _kind("energy_balance", "balance error", "error of the energy balance"),
        _kind("inertia", "moment of inertia", "moments and product of inertia"),
        _kind("principal_moment", "moment of inertia"),
        _kind("principal_angle", "angle", "angle of the principal axis"),
        _kind("work", "work", "work of the loads"),
        _kind("power", "power", "power of the loads"),
        _kind("load", "force", "loads"),
        ("state", Kind("states that are added", "state", "")),
        (OWN, Kind("expressions of quantities", "value", "")),
        _kind("momentum", "momentum"),
        _kind("angular_momentum", "angular momentum"),
        _kind("base", "x₀, y₀"),
        _kind("base_velocity", "ẋ₀, ẏ₀"),
        _kind("phi", "φ"),
        _kind("omega", "ω"),
        _kind("bend", "Δφ"),
        _kind("bend_rate", "Δω"),
        _kind("curvature", "κ"),
        _kind("bending_moment", "bending moment", "bending moments"),
        _kind("axial_force", "N"),
        _kind("shear_force", "Q"),
        _kind("reaction", "reaction"),
        _kind("reaction_moment", "moment of the reaction"),
        _kind("support_force_x", "force x", "x of the forces of the supports"),
        _kind("support_force_y", "force y", "y of the forces of the supports"),
        _kind("support_moment", "moment", "moments of the supports"),
        _kind("depth", "depth", "depths of contacts"),
        _kind("push", "push", "forces of contacts"),
        _kind("joint_depth", "depth", "depths of stops in joints"),
        _kind("joint_push", "moment", "moments of stops in joints"),
        _kind("airspeed", "airspeed", "speeds against the air"),
        _kind("attack", "angle of attack", "angles of attack"),
        _kind("joint_x", "x", "x of the joints"),
        _kind("joint_y", "y", "y of the joints"),
    )
)
PERIODS = {"principal_angle": 3.141592653589793}  # an axis has no direction: the angle jumps by it
TURNS = {"phi": 6.283185307179586}  # by kind, of absolute angles: a whole turn


class Number(NamedTuple):
    """A single number of a quantity: its name, its label in plots, its kind, where it is in the
    dimensions, and how far along the rod, in links from joint 0, if anywhere."""

    name: str
    label: str
    kind: str
    at: Index = ()
    along: float | None = None


def numbers(
    quantity: Quantity, boundary: Boundary, links: int, supported: Sequence[int] = ()
) -> Iterator[Number]:
    """All numbers of a quantity of a rod; supported: its links that supports may be on."""
    if quantity.only and not getattr(boundary, quantity.only):
        return
    first, *rest = quantity.dimensions or ("",)
    ranges = {
        "link": range(links),
        "joint": range(links + 1),
        "spring": boundary.spring_joints(links),
        "section": range(boundary.first_force, links),
        "supported": supported,
    }
    starts = {"spring": boundary.spring_joints(links).start, "section": boundary.first_force}
    middle = 0.5 if first == "link" else 0.0
    for last, (name, label) in enumerate(quantity.numbers.items()):
        kind = quantity.kind_of(name)
        if first not in ranges:
            yield Number(name, label, kind, (last,) if first else ())
            continue
        for number in ranges[first]:
            # No spring bends a link that is held, nor does the start of the next one.
            if kind != "bending_moment" or number >= boundary.first:
                at = (number - starts.get(first, 0), *((last,) if rest else ()))
                shown = label.format(str(number).translate(SUBSCRIPTS))
                # Supports are single points: nothing goes along the rod from one to the next.
                along = None if first == "supported" else number + middle
                yield Number(name.format(number), shown, kind, at, along)


def describe_number(name: str) -> str:
    """Label of a single number of a quantity, such as "x of the tail" of tip_x; its name in words
    where its label holds the name of a load."""
    for quantity in QUANTITIES:
        for template, label in () if quantity.each else quantity.numbers.items():
            number = parse_number(name, template)
            if number is not None:
                return label.format(str(number).translate(SUBSCRIPTS))
    return name.replace("_", " ")


def watchable_names(boundary: Boundary, links: int) -> Iterator[tuple[str, range]]:
    """Name templates of all quantities that events can watch, each with the numbers of the links or
    joints that {} stands for: those that move."""
    once, moving = range(1), range(boundary.first, links)
    yield from ((name, once) for name in ("x0", "y0") if boundary.translates)
    yield "phi_{}", moving
    yield from ((name, once) for name in ("vx0", "vy0") if boundary.translates)
    yield "omega_{}", moving
    for quantity in QUANTITIES:
        if quantity.watched:
            span = (
                range(boundary.first_joint, links + 1) if "joint" in quantity.dimensions else once
            )
            yield from ((name, span) for name in quantity.numbers)


def parse_number(name: str, template: str) -> int | None:
    """Number in place of {} in a name, 0 for a template without {}; None if they do not match."""
    found = re.search(r"[0-9]{1,7}", name) if "{}" in template else None
    number = int(found[0]) if found else 0
    return number if name == template.format(number) else None


def find_quantity(name: str) -> tuple[Quantity, Index]:
    """Quantity with a number of this name, and its index. Raises KeyError."""
    for quantity in QUANTITIES:
        others = quantity.each or quantity.dimensions[:1] in (SPRING, SECTION, SUPPORTED)
        for last, template in enumerate(() if others else quantity.numbers):
            number = parse_number(name, template)
            if number is not None:
                along = (number,) if "{}" in template else ()
                beside = len(quantity.dimensions) > len(along)
                return quantity, (*along, *((last,) if beside else ()))
    raise KeyError(name)
