"""Parameters of what is fixed or added to a rod in a scene: bodies, supports, a foundation, states;
the module has them in another form, as numbers of links, of joints or of states."""

from __future__ import annotations

from dataclasses import replace

from rodgen.model.parameter import ANY, NOT_NEGATIVE, POSITIVE, Parameter


def _row(name: str, label: str, unit: str, rule: str = NOT_NEGATIVE) -> Parameter:
    """A number that is zero where a scene does not give it."""
    return Parameter(name, name, label, "", unit, f"{label} []", rule=rule, default=0.0)


def _pair(key: str, one: Parameter) -> tuple[Parameter, Parameter]:
    """Both numbers of a key that has two, in x and in y."""
    x, y = (
        replace(one, name=f"{one.name}{axis}", key=key, label=f"{one.label} {axis}", part=part)
        for part, axis in enumerate("xy")
    )
    return x, y


# Where on the rod something is.
# fmt: off
AT = Parameter("at", "at", "place s", "", "", "from 0 at the start (nose or root) to 1 at the tail",
    rule=NOT_NEGATIVE, first=1.0, most=1.0)
# fmt: on
# Of a force the place is part of the module.
AT_IN_MODULE = replace(AT, fixed=True)

BODY_MASS = Parameter(
    "body_mass", "mass", "mass", "", "kg", "of a body []", rule=POSITIVE, decades=True
)
OFFSET = (
    replace(_row("along", "centre along the link", "m", ANY), key="offset", part=0),
    replace(_row("across", "centre across the link", "m", ANY), key="offset", part=1),
)
BODY = (BODY_MASS, _row("inertia", "moment of inertia", "kg m^2"), AT, *OFFSET)
TANK = (*BODY[:2], AT_IN_MODULE, *OFFSET)  # a body whose mass changes with time

SUPPORT = (
    AT,
    *_pair("to", replace(_row("", "fixed point in", "m", ANY), default=None)),
    *_pair("stiffness", replace(_row("stiffness_", "stiffness in", "N/m"), first=10.0)),
    *_pair("damping", _row("damping_", "damping in", "N s/m")),
    _row("rotation", "stiffness against turning", "N m/rad"),
    _row("rotation_damping", "damping of turning", "N m s/rad"),
)
SHARE = _row("share", "share of the link before the point", "1")  # what becomes of AT
FOUNDATION = (
    replace(_row("stiffness", "stiffness of the foundation", "N/m^2"), first=10.0),
    _row("damping", "damping of the foundation", "N s/m^2"),
)
STATE = (Parameter("rate", "rate", "rate", "", "", "per second", timed=True),)
STATE_AT_START = _row("initial", "at the start", "", ANY)
