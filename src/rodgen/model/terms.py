"""The terms: loads and damping that a scene may have, and the parameters of each.

A load is a row here and its law in derive/loads/. Of a placed one a scene may have several: the
second and further are called after the first with a number, follower_2, and so are their
parameters, follower_2_force.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

from rodgen.model.palette import series_pair
from rodgen.model.rod import (
    BODY,
    BOUNDARIES,
    CLAMP_ANGLE,
    FOUNDATION,
    MASS_PER_LENGTH,
    NONUNIFORM,
    REST_CURVATURE,
    ROD,
    SHARE,
    STEADY,
    SUPPORT,
    Boundary,
)
from rodgen.model.term import (
    AIR,
    ANCHOR,
    AT_LEAST_ONE,
    BASE,
    BY_HEIGHT,
    CONTACT,
    COUPLE,
    DAMPER,
    DRAG,
    FORCE,
    JOINTS,
    LINKS,
    NOT_NEGATIVE,
    POSITIVE,
    SIDE,
    SPREAD,
    WEIGHT,
    NumberedRows,
    Parameter,
    Term,
)


# fmt: off
def _law(name: str, unit: str, per_length: bool = False) -> tuple[Parameter, ...]:
    """Parameters of the law of a contact, k d^e max(0, 1 + c d'), by the unit of its depth d; e is
    1 of one per length of rod."""
    words = name.replace("_", " ")
    force, power = "N m" if unit == "rad" else "N", "d^e"
    stiffness, per = f"{force}/{unit}", ""
    if per_length:
        stiffness, per, power = "N/m^2", " per length of rod", "d"
    exponent = Parameter(f"{name}_exponent", "exponent", f"exponent of the {words}", "e", "",
        "e: the push grows as this power of the depth, of two spheres 1.5; `stiffness` is over "
        f"that power of {unit}; without it 1", rule=AT_LEAST_ONE, optional=True)
    return (
        Parameter(f"{name}_stiffness", "stiffness", f"stiffness of the {words}", "k", stiffness,
            f"k: push over the depth d{per} []", rule=POSITIVE, first=1000.0, decades=True),
        *(() if per_length else (exponent,)),
        Parameter(f"{name}_damping", "damping", f"damping of the {words}", "c", f"s/{unit}",
            f"c: the push is k {power} max(0, 1 + c d') with the rate d' of its depth []; "
            "without it 0", rule=NOT_NEGATIVE, optional=True),
    )


# What the air is: the table [air], shared by all that it pushes.
AIR_ROWS = (
    Parameter("air_density", "density", "density of the air", "ρ", "kg/m^3",
        "density []: a number, an expression in t and in `y`, the height of the point that the air "
        'pushes, or `"isa"`, that of the standard atmosphere',
        rule=NOT_NEGATIVE, first=1.225, timed=True, table="air", unless=f"density{BY_HEIGHT}"),
    *(Parameter(f"air_wind_{axis}", "wind", f"wind of the air, {axis}", "", "m/s",
        f"velocity of the air along {axis} []: likewise; without it still", part=part, timed=True,
        optional=True, table="air", unless=f"wind{BY_HEIGHT}") for part, axis in enumerate("xy")),
    Parameter("air_stall_angle", "stall_angle", "stall angle", "α_s", "rad",
        "a: the force across the rod grows as tanh(sin(α)/a) with the angle of attack α [], which "
        "is an angle at which fins stall", rule=POSITIVE, default=0.2617993877991494, table="air"),
)


def _air(name: str, words: str, stalls: bool = True) -> tuple[Parameter, ...]:
    """Parameters of the air around a load: those that all share, and its own by its height."""
    own = (
        replace(one, name=one.name.replace("air", name, 1), label=f"{one.label}, at the {words}",
            by_height=True, optional=True, unless="", first=None)
        for one in AIR_ROWS if one.timed)
    return (*(one for one in AIR_ROWS if stalls or one.timed), *own)


def _area(name: str) -> Parameter:
    """Area to which the coefficients of a load refer."""
    return Parameter(f"{name}_area", "area", "reference area", "A", "m^2",
        "area A to which the coefficient refers []; without it that of a circle of `rod.diameter`",
        rule=NOT_NEGATIVE, first=0.01, computed=True)


# Terms: name, table, label, symbol, kind, words. Parameters: name, key, label, symbol, unit, words.
ROWS = (
    Term("follower", "follower", "follower force", "P", FORCE,
        "thrust along a link, at the tail the last",
        colours=series_pair(2), follows=True, thesis=True, placed=True, parameters=(
        Parameter("follower_force", "force", "follower force", "P", "N",
            "thrust P at the tail [], compressive for P > 0", first=0.0, timed=True, scales=True),
        Parameter("follower_angle", "angle", "follower angle", "ν", "rad",
            "angle nu between thrust and last link []", default=0.0, timed=True),
    )),
    Term("gravity", "gravity", "gravity", "M g", WEIGHT, "weight of every mass",
        colours=series_pair(7), thesis=True, parameters=(
        Parameter("gravity", "g", "gravity", "g", "m/s^2",
            "acceleration g [], downwards",
            default=9.81, timed=True, scales=True, unless="acceleration"),
        Parameter("gravity_x", "acceleration", "gravity, x", "", "m/s^2",
            "acceleration of free fall along x [], in place of `g`",
            part=0, timed=True, scales=True, optional=True),
        Parameter("gravity_y", "acceleration", "gravity, y", "", "m/s^2",
            "acceleration of free fall along y [], in place of `g`",
            part=1, timed=True, scales=True, optional=True),
    )),
    Term("internal_damping", "internal_damping", "internal damping", "", DAMPER,
        "viscous moment across inner joints, and twice that in the root of `clamped`",
        thesis=True, parameters=(
        Parameter("internal_damping", "coefficient", "internal damping", "c_int", "m^2/s",
            "c_int []", rule=NOT_NEGATIVE, first=0.01, links_power=2, by_mass=True),
    )),
    Term("external_damping", "external_damping", "external damping", "", DRAG,
        "force at the joints, across the rod",
        colours=series_pair(3), thesis=True, kinked=True, parameters=(
        Parameter("external_damping", "coefficient", "external damping", "c_ext", "1/s",
            "c_ext []", rule=NOT_NEGATIVE, first=0.5, by_mass=True),
        Parameter("fin_factor", "fin_factor", "fin factor", "s", "",
            "s at every joint, nose to tail",
            rule=NOT_NEGATIVE, default=1.0, each=JOINTS, links_power=1),
    )),
    Term("tip_load", "tip", "tip load", "F", FORCE,
        "dead force at the tail: it keeps its direction", colours=series_pair(4), parameters=(
        Parameter("tip_force_x", "x", "tip force x", "", "N",
            "x component of the dead force at the tail []", default=0.0, timed=True, scales=True),
        Parameter("tip_force_y", "y", "tip force y", "", "N",
            "y component of the dead force at the tail []",
            default=0.0, first=-1.0, timed=True, scales=True),
    )),
    Term("material_damping", "material_damping", "material damping", "", DAMPER,
        "Kelvin-Voigt moment across every joint with a spring, for any number of links",
        parameters=(
        Parameter("material_damping_time", "time", "material damping time", "τ", "s",
            "tau, over which the moment is as large as that of the springs []",
            rule=NOT_NEGATIVE, first=0.001, decades=True),
    )),
    Term("distributed_follower", "distributed_follower", "distributed follower force", "Q", SPREAD,
        "thrust along every link, in its middle",
        colours=series_pair(5), follows=True, parameters=(
        Parameter("distributed_follower", "force_per_length", "distributed follower force", "q",
            "N/m", "thrust per length q [], compressive for q > 0",
            first=0.0, timed=True, each=LINKS, scales=True),
        Parameter("distributed_follower_angle", "angle", "distributed follower angle", "ν_q", "rad",
            "angle nu between thrust and every link [], at pi/2 a pressure to the right, at -pi/2 "
            "to the left", default=0.0, timed=True, optional=True),
    )),
    Term("foundation", "foundation", "foundation", "", ANCHOR,
        "springs and dampers all along the rod, across the straight rod",
        given=FOUNDATION, parameters=(
        Parameter("foundation_angle", "angle", "angle of the foundation", "", "rad",
            "of the axis across which it acts []", default=0.0),
        Parameter("foundation_stiffness", "stiffness", "stiffness of the foundation", "", "N/m",
            "of every joint across the straight rod []",
            rule=NOT_NEGATIVE, default=0.0, each=JOINTS),
        Parameter("foundation_damping", "damping", "damping of the foundation", "", "N s/m",
            "of every joint across the straight rod []",
            rule=NOT_NEGATIVE, default=0.0, each=JOINTS),
        Parameter("foundation_offset", "through", "offset of the foundation", "", "m",
            "of its axis from the origin, to the left of its direction []", optional=True),
    )),
    Term("supports", "supports", "supports", "", ANCHOR,
        "springs and dampers from points of the rod to fixed points",
        given=SUPPORT, array=True, parameters=(
        Parameter("support_angle", "angle", "angle of the supports", "", "rad",
            "of a link that its support does not turn []", default=0.0),
        *(Parameter(f"support_{one.name}", one.name, f"{one.label} of a support", "", one.unit,
            f"{one.label} of the support of every link []",
            rule=one.rule, default=0.0, each=LINKS) for one in (SHARE, *SUPPORT[1:])),
    )),
    Term("drag", "drag", "drag", "", DRAG,
        "force at the joints against a medium with a wind, by the square of the speed",
        colours=series_pair(6), parameters=(
        Parameter("drag_normal", "normal", "drag across", "c_n", "kg/m^2",
            "across the rod, over its length and the square of the speed []",
            rule=NOT_NEGATIVE, default=0.0, first=0.5),
        Parameter("drag_tangential", "tangential", "drag along", "c_t", "kg/m^2",
            "along the rod, likewise []", rule=NOT_NEGATIVE, default=0.0),
        Parameter("wind_x", "wind", "wind, x", "", "m/s",
            "velocity of the medium along x []", part=0, default=0.0, timed=True),
        Parameter("wind_y", "wind", "wind, y", "", "m/s",
            "velocity of the medium along y []", part=1, default=0.0, timed=True),
    )),
    Term("viscous_drag", "viscous_drag", "viscous drag", "", DRAG,
        "force at the joints against a medium with a wind, in proportion to the speed",
        colours=series_pair(8), parameters=(
        Parameter("viscous_drag_normal", "normal", "viscous drag across", "c_n", "kg/(m s)",
            "across the rod, over its length and the speed []",
            rule=NOT_NEGATIVE, default=0.0, first=0.5),
        Parameter("viscous_drag_tangential", "tangential", "viscous drag along", "c_t", "kg/(m s)",
            "along the rod, likewise []", rule=NOT_NEGATIVE, default=0.0),
        Parameter("viscous_drag_wind_x", "wind", "wind of viscous drag, x", "", "m/s",
            "velocity of the medium along x []", part=0, default=0.0, timed=True),
        Parameter("viscous_drag_wind_y", "wind", "wind of viscous drag, y", "", "m/s",
            "velocity of the medium along y []", part=1, default=0.0, timed=True),
    )),
    Term("moment", "moment", "couple", "M", COUPLE, "couple on a link, at the tail the last",
        colours=series_pair(1), placed=True, parameters=(
        Parameter("moment_size", "moment", "couple", "M", "N m",
            "moment M [], positive to the left", first=0.0, timed=True, scales=True),
    )),
    Term("base", "base", "moving base", "", BASE, "motion of what holds the start of the rod",
        parameters=(
        Parameter("base_x", "x", "base x", "", "m",
            "place of joint 0 along x []", first=0.0, timed=True, optional=True),
        Parameter("base_y", "y", "base y", "", "m",
            "place of joint 0 along y []", timed=True, optional=True),
        Parameter("base_angle", "angle", "base angle", "", "rad",
            "angle of the clamp, added to `clamp_angle` []", timed=True, optional=True),
    )),
    Term("joint_friction", "joint_friction", "joint friction", "", DAMPER,
        "moment m_f tanh(rate/rate_s) against the rate at which a joint bends, in every joint with "
        "a spring", parameters=(
        Parameter("joint_friction_moment", "moment_per_joint", "friction of a joint", "", "N m",
            "m_f, the moment of every joint []",
            rule=NOT_NEGATIVE, first=0.01, unless="moment_per_length"),
        Parameter("joint_friction_per_length", "moment_per_length", "joint friction per length",
            "", "N", "in its place the moment over the length that bends in a joint []",
            rule=NOT_NEGATIVE, optional=True),
        Parameter("joint_friction_rate", "rate", "rate of joint friction", "", "rad/s",
            "rate_s, below which the moment falls to zero: a joint under a moment M creeps at "
            "rate_s atanh(M/m_f) []", rule=POSITIVE, first=0.001, decades=True),
    )),
    Term("fins", "fins", "fins", "F_f", AIR, "force of the air across the rod on a set of fins",
        colours=series_pair(6), placed=True, parameters=(
        Parameter("fins_normal_slope", "normal_slope", "slope of normal force, fins", "C_Nα", "",
            "C_Nα, slope of the coefficient of normal force over the angle of attack; or "
            "`geometry`",
            first=8.0, computed=True),
        _area("fins"), *_air("fins", "fins"),
    )),
    Term("nose", "nose", "nose", "F_n", AIR,
        "force of the air across the rod on a nose, shoulder or boat tail",
        colours=series_pair(6), placed=True, parameters=(
        Parameter("nose_normal_slope", "normal_slope", "slope of normal force, nose", "C_Nα", "",
            "C_Nα, likewise: of a slender nose 2 with the area of its base", default=2.0),
        _area("nose"), *_air("nose", "nose"),
    )),
    Term("axial_drag", "axial_drag", "axial drag", "F_d", AIR,
        "force of the air along the link at a point", colours=series_pair(6), placed=True,
        parameters=(
        Parameter("axial_drag_coefficient", "coefficient", "axial drag coefficient", "C_A", "",
            "C_A: force along the link over half the density, the area and the square of the speed",
            rule=NOT_NEGATIVE, first=0.5),
        _area("axial_drag"), *_air("axial_drag", "point of axial drag", stalls=False),
    )),
    Term("stop", "stops", "stop", "", CONTACT,
        "something that a point of the rod runs against", placed=True, array=True, parameters=(
        Parameter("stop_direction", "direction", "direction of the stop", "", "rad",
            "of the way of the point towards the stop []", first=1.57),
        Parameter("stop_gap", "gap", "gap of the stop", "", "m",
            "way in that direction until it touches []", default=0.0, first=0.1),
        Parameter("stop_x", "to", "stop, x", "", "m",
            "place from which the way is counted []; without it that of the rod without load",
            part=0, default=0.0, computed=True),
        Parameter("stop_y", "to", "stop, y", "", "m",
            "place from which the way is counted []; without it that of the rod without load",
            part=1, default=0.0, computed=True),
        *_law("stop", "m"),
    )),
    Term("joint_stop", "joint_stops", "joint stop", "", CONTACT,
        "limit of the bend of a joint", placed=True, at_joints=True, array=True, parameters=(
        Parameter("joint_stop_direction", "direction", "side of the joint stop", "", "",
            "side to which the joint bends until it touches: 1 left, -1 right",
            rule=SIDE, first=1.0),
        Parameter("joint_stop_gap", "gap", "gap of the joint stop", "", "rad",
            "bend to that side from its rest until it touches []", first=0.1),
        *_law("joint_stop", "rad"),
    )),
    Term("wall", "walls", "wall", "", CONTACT,
        "half plane that the joints run against, with friction along it", array=True, parameters=(
        Parameter("wall_normal", "normal", "normal of the wall", "", "rad",
            "direction away from the wall []", first=1.57),
        Parameter("wall_x", "point", "wall, x", "", "m", "a point of its surface []", part=0,
            default=0.0),
        Parameter("wall_y", "point", "wall, y", "", "m", "a point of its surface []", part=1,
            default=0.0),
        Parameter("wall_edge", "edge", "edge of the wall", "", "m",
            "its end, so far to the right of the normal from `point`, where it goes on at a right "
            "angle []; without it none", optional=True),
        *_law("wall", "m", per_length=True),
        Parameter("wall_friction", "friction", "friction of the wall", "μ", "",
            "mu: force of friction over the push", rule=NOT_NEGATIVE, optional=True),
        Parameter("wall_friction_speed", "friction_speed", "speed of friction", "", "m/s",
            "v_s, below which friction falls to zero, mu N tanh(v/v_s) []", rule=POSITIVE,
            optional=True, beside="friction"),
    )),
)
# fmt: on


@lru_cache(maxsize=1024)  # of the many that a scene may have, which are asked for often
def _numbered_term(name: str, number: int, rest: str) -> Term | None:
    term = next((term for term in ROWS if term.name == name and term.is_several), None)
    return None if term is None or rest else term.with_number(number)


# The rows by name, in the order in which names list them.
TERMS: NumberedRows[Term] = NumberedRows({term.name: term for term in ROWS}, _numbered_term)
# What the masses that change with time do, where works and powers are listed by term.
EMPTYING = "emptying"


def describe(name: str) -> str:
    """Words for a term, or for another source of work."""
    return name if name == EMPTYING else TERMS[name].words


(_BASE_TERM,) = (term for term in ROWS if term.kind == BASE)
MOVING_BASE, BASE_ROWS = _BASE_TERM.name, _BASE_TERM.parameters
(BASE_ANGLE,) = (one.name for one in BASE_ROWS if one.is_angle)
THESIS_TERMS = tuple(term.name for term in ROWS if term.thesis)


def _all_parameters() -> tuple[Parameter, ...]:
    """All parameters in the order in which p holds them; those that are many numbers come last."""
    first, later = (
        [one for term in ROWS if term.thesis is thesis for one in term.parameters]
        for thesis in (True, False)
    )
    nonuniform = (one for way in NONUNIFORM.values() for one in way.parameters)
    every = (*ROD, *first, CLAMP_ANGLE, *later, *nonuniform, *STEADY.values())
    return tuple(sorted(every, key=lambda one: one.is_array))


@lru_cache(maxsize=4096)
def _parameter(name: str, number: int, rest: str) -> Parameter | None:
    term = _numbered_term(name, number, "")
    rows = term.parameters if term else ()
    return next((one for one in rows if one.name == f"{name}_{number}_{rest}"), None)


def load_places(terms: Iterable[str]) -> dict[str, str]:
    """Names of the loads of a structure, each with its place: "" at the tail, else a link by its
    number, and the share of it before the point where that is not its start: 6+1/10. Of a load
    without a place, the keys of the optional parameters that it has: x+angle."""
    counts: Counter[str] = Counter()
    found = {}
    for text in terms:
        kind, _, place = text.partition("@")
        counts[kind] += 1
        found[kind if counts[kind] == 1 else f"{kind}_{counts[kind]}"] = place
    return found


def boundary_of(name: str, terms: Iterable[str]) -> Boundary:
    """Boundary of a rod with these terms, which a moving base moves."""
    found = BOUNDARIES[name]
    moves = any(text.partition("@")[0] == MOVING_BASE for text in terms)
    return replace(found, moves=True) if moves else found


def rows_of(terms: Iterable[str]) -> dict[str, Term]:
    """Rows of the loads of a structure, by name, with the parameters that its module has."""
    rows = ((TERMS[name], place) for name, place in load_places(terms).items())
    return {row.name: replace(row, parameters=row.parameters_with(place)) for row, place in rows}


PARAMETERS: NumberedRows[Parameter] = NumberedRows(
    {one.name: one for one in _all_parameters()}, _parameter
)
# Where a scene has a parameter of its module: the keys of tables, from the outermost in.
PLACES: dict[str, tuple[str, ...]] = {
    **{one.name: ("rod", one.key) for one in (*ROD, CLAMP_ANGLE)},
    **{
        one.name: (one.table, *one.key_path) if one.table else ("loads", term.table, *one.key_path)
        for term in ROWS
        if term.is_load
        for one in term.parameters
        if not one.by_height
    },
    **{one.name: ("base", one.key) for one in BASE_ROWS},
}


# Numbers of a scene that reach its module as others: rows, by table, and what one of several tables
# is called.
CONVERTED: dict[str, tuple[tuple[Parameter, ...], str]] = {
    "rod": ((MASS_PER_LENGTH, REST_CURVATURE), ""),
    "bodies": (BODY, "body"),
    "foundation": (FOUNDATION, ""),
    "supports": (SUPPORT, "support"),
    **{term.table: (term.parameters, term.label) for term in ROWS if term.kind == CONTACT},
}
CONTACTS = tuple(term for term in ROWS if term.kind == CONTACT)


# Labels of numbers of a scene that no row has.
OTHER_LABELS = {
    "rod.links": "number of links",
    "initial.position.0": "x at the start [m]",
    "initial.position.1": "y at the start [m]",
    "initial.velocity.0": "velocity along x at the start [m/s]",
    "initial.velocity.1": "velocity along y at the start [m/s]",
    "initial.phi": "angle at the start [rad]",
    "initial.angle": "angle of link 0 at the start [rad]",
    "initial.omega": "rate of the angle at the start [rad/s]",
}


def axis_label(key: str) -> str:
    """Axis label of a number of a scene, such as follower force [N] of loads.follower.force; of a
    parameter of the scene its name; of what has no label, such as integrate.rtol, its last word."""
    one, of = _find_row(key)
    if one is None:
        return OTHER_LABELS.get(key) or _describe_key(key)
    return f"{one.label}{of} [{one.display_unit}]" if one.unit else f"{one.label}{of}"


def _describe_key(key: str) -> str:
    """Last word of a key; of one in a list also the list."""
    *words, last = key.replace("_", " ").split(".")
    if not last.isdigit():
        return last
    if label := OTHER_LABELS.get(".".join(words)):
        return label.replace("angle", f"angle of link {last}", 1)
    return " ".join((*words[-1:], last))


def _find_row(key: str) -> tuple[Parameter | None, str]:
    """The row of a number of a scene, and of which of several things it is."""
    for name, path in PLACES.items():
        if ".".join(path) == key:
            return PARAMETERS[name], ""
    table, *keys = key.split(".")
    rows, called = CONVERTED.get(table, ((), ""))
    of = f" of {called} {int(keys.pop(0)) + 1}" if called and keys and keys[0].isdigit() else ""
    return next((one for one in rows if one.key_path == tuple(keys)), None), of
